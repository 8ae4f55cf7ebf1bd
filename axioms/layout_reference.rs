//! The axioms of loops and spots, slowly: all errors of a story as unknowns, derivatives by differences, and the
//! definitions.

use crate::floor_reference::obstacles;
use crate::measured_reference::Told;
use crate::profile_reference::Profile;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Matrix3xX, Vector2, Vector3};
use std::f64::consts::TAU;
use std::sync::LazyLock;
use topostar::geometry::{Pose, wrap_angle};
use topostar::metric::MetricParameters;

/// How much of the variance of a heading error may be the same on all travels, and how much may not.
pub(crate) type Share = (f64, f64);

/// A range of shares, all of them together, then the other ranges.
pub(crate) const SHARES: [Share; 5] = [(0.75, 0.5), (1.0, 1.0), (0.5, 0.75), (1.0, 0.25), (0.25, 1.0)];

/// Whether an axiom is broken whatever the share is, given where it is broken.
fn broken(by: impl Fn(Share) -> bool) -> bool {
    by(SHARES[0]) && (by(SHARES[1]) || SHARES[2..].iter().all(|&share| by(share)))
}

/// For twice as many degrees of freedom, what chi-square exceeds as rarely as five standard deviations: the density
/// summed from far out.
pub(crate) static QUANTILES: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let quantile = |half: u32| {
        let factorial: f64 = (1..half).map(f64::from).product();
        let step = 1e-3;
        let mut tail = 0.0;
        let mut at = 300.0;
        while tail < 5.733e-7 {
            at -= step;
            let middle: f64 = (at + step / 2.0) / 2.0;
            tail += middle.powi(half as i32 - 1) * (-middle).exp() / factorial * step / 2.0;
        }
        at
    };
    (0..80).map(|half| if half == 0 { 0.0 } else { quantile(half) }).collect()
});

/// All errors of a story estimated at once, with spread one each: three a travel of its own, then three a visit of
/// where in its place it is, then three of odometry that are the same on all travels. Loops are observations of them.
pub(crate) struct Estimate<'a> {
    pub(crate) told: &'a Told<'a>,
    /// The displacement, what its own errors do, and what common ones do.
    legs: Vec<(Pose, Matrix3<f64>, Matrix3<f64>)>,
    /// The visits that come to a known place.
    pub(crate) loops: Vec<usize>,
    /// How far each visit is turned in its place.
    turns: Vec<f64>,
    /// The errors estimated.
    pub(crate) mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl<'a> Estimate<'a> {
    /// By the loops among so many visits.
    pub(crate) fn new(told: &'a Told<'a>, assigned: usize, (common, alone): Share) -> Estimate<'a> {
        let legs: Vec<_> = (1..=told.latest())
            .map(|to| {
                let (odometry, stay) = told.covariances(to);
                let leg = told.travel(to, &Vector3::zeros(), &Vector3::zeros());
                let (mut own, mut same) = (root(&odometry), root(&odometry));
                own.column_mut(2).scale_mut(f64::sqrt(alone));
                same.column_mut(2).scale_mut(f64::sqrt(common));
                (leg, root(&(own * own.transpose() + stay)), same)
            })
            .collect();
        let size = 6 * told.story.len() + 3;
        let (mean, covariance) = (DVector::zeros(size), DMatrix::identity(size, size));
        let loops = (0..assigned).filter(|&visit| told.first(told.story[visit].0) < visit).collect();
        let turns = (0..told.story.len()).map(|visit| told.turn(visit)).collect();
        let mut estimate = Estimate { told, legs, loops, turns, mean, covariance };
        for _ in 0..12 {
            let mut information = DMatrix::identity(size, size);
            let mut pull = DVector::zeros(size);
            let weight = told.astray().try_inverse().unwrap();
            for &visit in &estimate.loops {
                let (off, slope) = estimate.linearised(|errors| estimate.off(visit, errors));
                information += slope.transpose() * weight * &slope;
                pull += slope.transpose() * weight * (&slope * &estimate.mean - off);
            }
            estimate.covariance = information.try_inverse().unwrap();
            estimate.mean = &estimate.covariance * pull;
        }
        estimate
    }

    /// The sum of the squares of all errors.
    fn chi_square(&self) -> f64 {
        let weight = self.told.astray().try_inverse().unwrap();
        let left = |&visit: &usize| {
            let off = self.off(visit, &self.mean);
            off.dot(&(weight * off))
        };
        self.mean.norm_squared() + self.loops.iter().map(left).sum::<f64>()
    }

    /// What is left to so many more degrees of freedom.
    pub(crate) fn left(&self, degrees: usize) -> f64 {
        QUANTILES[(3 * self.loops.len() + degrees).div_ceil(2)] - self.chi_square()
    }

    pub(crate) fn agrees(&self) -> bool {
        self.loops.is_empty() || self.left(0) >= 0.0
    }

    pub(crate) fn poses(&self, errors: &DVector<f64>) -> Vec<Pose> {
        let common = errors.fixed_rows::<3>(6 * self.told.story.len()).into_owned();
        let mut poses = vec![Pose::IDENTITY];
        for (at, (leg, own, same)) in self.legs.iter().enumerate() {
            let error = own * errors.fixed_rows::<3>(3 * at) + same * common;
            let leg = Pose::new(leg.x - error.x, leg.y - error.y, leg.theta - error.z);
            poses.push(poses[at].compose(&leg));
        }
        poses
    }

    /// Errors that lead to these frames: of what is the same on all travels and of where in their places the first visits are
    /// those that leave least to all others.
    pub(crate) fn errors_to(&self, poses: &[Pose]) -> DVector<f64> {
        let (told, visits) = (self.told, self.told.story.len());
        let gone = |at: usize| {
            let (leg, own, same) = &self.legs[at];
            let to = poses[at].inverse().compose(&poses[at + 1]);
            let error = Vector3::new(leg.x - to.x, leg.y - to.y, wrap_angle(leg.theta - to.theta));
            let back = own.try_inverse().unwrap();
            (back * error, back * same)
        };
        let gone: Vec<_> = (0..self.legs.len()).map(gone).collect();
        let (mut information, mut pull) = (Matrix3::identity(), Vector3::zeros());
        for (error, same) in &gone {
            information += same.transpose() * same;
            pull += same.transpose() * error;
        }
        let common = information.try_inverse().unwrap() * pull;
        let mut errors = DVector::zeros(self.mean.len());
        for (at, (error, same)) in gone.iter().enumerate() {
            errors.fixed_rows_mut::<3>(3 * at).copy_from(&(error - same * common));
        }
        errors.fixed_rows_mut::<3>(6 * visits).copy_from(&common);
        let sigma = told.astray().diagonal().map(f64::sqrt);
        for first in 0..visits {
            let loops = self.loops.iter().filter(|&&visit| told.first(told.story[visit].0) == first);
            let offs: Vec<Vector3<f64>> = loops.map(|&visit| self.off_among(poses, visit, &errors)).collect();
            let mean = offs.iter().sum::<Vector3<f64>>() / (offs.len() as f64 + 1.0);
            errors.fixed_rows_mut::<3>(3 * (visits + first)).copy_from(&mean.component_div(&sigma));
        }
        errors
    }

    /// The frame of a visit, in that of an earlier one.
    fn seen(&self, from: usize, to: usize, errors: &DVector<f64>) -> Pose {
        let poses = self.poses(errors);
        poses[from].inverse().compose(&poses[to])
    }

    /// How far a visit is from the middle of its place, which the first visit to it is off as well.
    fn off(&self, visit: usize, errors: &DVector<f64>) -> Vector3<f64> {
        self.off_among(&self.poses(errors), visit, errors)
    }

    /// The same, by the frames of all visits under these errors.
    pub(crate) fn off_among(&self, poses: &[Pose], visit: usize, errors: &DVector<f64>) -> Vector3<f64> {
        let (told, first) = (self.told, self.told.first(self.told.story[visit].0));
        let seen = poses[first].inverse().compose(&poses[visit]);
        let bounds = &told.bounds;
        let astray = errors.fixed_rows::<3>(3 * (told.story.len() + first)).component_mul(&Vector3::new(
            bounds.extent_sigma,
            bounds.extent_sigma,
            bounds.bearing_sigma,
        ));
        let place = Pose::new(astray.x, astray.y, astray.z);
        let off = place.inverse().compose(&seen);
        Vector3::new(off.x, off.y, wrap_angle(off.theta - self.turns[visit]))
    }

    /// A function of errors where they are, and its derivative by differences.
    fn linearised(&self, of: impl Fn(&DVector<f64>) -> Vector3<f64>) -> (Vector3<f64>, Matrix3xX<f64>) {
        let step = 1e-4;
        let mut slope = Matrix3xX::zeros(self.mean.len());
        for at in 0..self.mean.len() {
            let (mut more, mut less) = (self.mean.clone(), self.mean.clone());
            more[at] += step;
            less[at] -= step;
            let change = of(&more) - of(&less);
            let change = Vector3::new(change.x, change.y, wrap_angle(change.z));
            slope.set_column(at, &(change / (2.0 * step)));
        }
        (of(&self.mean), slope)
    }

    pub(crate) fn pose(&self, from: usize, to: usize) -> (Vector3<f64>, Matrix3<f64>) {
        let (at, slope) = self.linearised(|errors| {
            let pose = self.seen(from, to, errors);
            Vector3::new(pose.x, pose.y, pose.theta)
        });
        (at, &slope * &self.covariance * slope.transpose())
    }

    /// What the derivatives leave out from one visit to another, on the way on which that is least.
    fn slack(&self, from: usize, to: usize, gate: f64) -> f64 {
        let swing = |visit: usize| {
            let leg = &self.legs[visit - 1].0;
            let heading = match from < visit {
                true => self.pose(from, visit - 1),
                false => self.pose(visit - 1, from),
            };
            leg.x.hypot(leg.y) * gate * gate * heading.1.m33 / 2.0
        };
        let mut steps: Vec<(usize, usize, f64)> =
            (1..self.told.story.len()).map(|visit| (visit - 1, visit, swing(visit))).collect();
        steps.extend(self.loops.iter().map(|&visit| (self.told.first(self.told.story[visit].0), visit, 0.0)));
        let mut least = vec![f64::INFINITY; self.told.story.len()];
        least[from] = 0.0;
        for _ in 0..least.len() {
            for &(a, b, by) in &steps {
                least[b] = least[b].min(least[a] + by);
                least[a] = least[a].min(least[b] + by);
            }
        }
        least[to]
    }
}

pub(crate) fn loops_close(told: &Told<'_>) -> bool {
    let open = |share| is_open(told, &Estimate::new(told, told.latest(), share));
    let unlikely = |share| takes_too_much(told, share);
    told.is_new() || !(broken(open) || broken(unlikely))
}

/// Whether chi-square grows by more than its gate, or than all loops together may have, when the last loop closes.
fn takes_too_much(told: &Told<'_>, share: Share) -> bool {
    let [before, after] = [0, 1].map(|more| Estimate::new(told, told.latest() + more, share));
    let all = QUANTILES[(3 * after.loops.len()).div_ceil(2)];
    let gate = told.bounds.pose_gate.min(all - before.chi_square());
    after.chi_square() - before.chi_square() > gate
}

fn is_open(told: &Told<'_>, estimate: &Estimate<'_>) -> bool {
    let latest = told.latest();
    let gate = estimate.left(3).clamp(0.0, told.bounds.pose_gate).sqrt();
    let (off, slope) = estimate.linearised(|errors| estimate.off(latest, errors));
    let covariance = &slope * &estimate.covariance * slope.transpose() + told.astray();
    let slack = estimate.slack(told.first(told.story[latest].0), latest, gate);
    let size = gate * (covariance.m11 + covariance.m22).sqrt();
    let disc = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)) * (slack / gate).powi(2);
    let widened = match slack > 0.0 {
        true => covariance * (1.0 + slack / size) + disc * (1.0 + size / slack),
        false => covariance,
    };
    !estimate.agrees() || off.dot(&(widened.try_inverse().unwrap() * off)) > gate * gate
}

/// What a share of errors says of places on one spot.
#[derive(PartialEq)]
enum Verdict {
    Apart,
    OneSpot,
    /// It does not close the loops.
    Unlikely,
}

pub(crate) fn places_are_apart(told: &Told<'_>) -> bool {
    let assigned = if told.is_new() { told.latest() } else { told.latest() + 1 };
    let verdict = |share: Share| {
        let estimate = Estimate::new(told, assigned, share);
        match (estimate.agrees(), shares_a_spot(told, &estimate) || is_crowded(told, &estimate)) {
            (false, _) => Verdict::Unlikely,
            (true, true) => Verdict::OneSpot,
            (true, false) => Verdict::Apart,
        }
    };
    let first = verdict(SHARES[0]);
    if first == Verdict::Apart {
        return true;
    }
    match verdict(SHARES[1]) {
        Verdict::OneSpot => false,
        Verdict::Unlikely => true,
        Verdict::Apart => {
            let rest: Vec<Verdict> = SHARES[2..].iter().map(|&share| verdict(share)).collect();
            let all = || rest.iter().chain([&first]);
            all().any(|verdict| *verdict == Verdict::Apart)
                || all().all(|verdict| *verdict == Verdict::Unlikely)
        }
    }
}

/// How far apart places are at least.
pub(crate) fn separation(told: &Told<'_>) -> f64 {
    let lengths = (1..=told.latest()).map(|to| told.travel(to, &Vector3::zeros(), &Vector3::zeros()));
    lengths.map(|leg| leg.x.hypot(leg.y)).fold(told.bounds.separation, f64::min)
}

/// All pairs of places, by the first visits to them.
pub(crate) fn pairs_of_places(told: &Told<'_>) -> Vec<(usize, usize)> {
    let places: Vec<usize> =
        (0..=told.latest()).filter(|&visit| told.first(told.story[visit].0) == visit).collect();
    let before = |&to: &usize| places.iter().filter(move |&&from| from < to).map(move |&from| (from, to));
    places.iter().flat_map(before).collect()
}

/// Whether no likely errors have all places apart and all ways clear. The engine may not find that out, so that it is never certain that it
/// refutes by it: where gates are wide nothing is crowded. But where even narrow ones leave room, it must not.
fn is_crowded(told: &Told<'_>, estimate: &Estimate<'_>) -> bool {
    let gates = told.bounds.position_gate / MetricParameters::default().position_gate;
    let (pairs, radius) = (pairs_of_places(told), separation(told));
    let off = |&(from, to): &(usize, usize)| estimate.pose(from, to).0.xy().norm();
    let near: Vec<&(usize, usize)> = pairs.iter().filter(|pair| off(pair) < radius).collect();
    let obstacles = obstacles(told, radius);
    let poses = estimate.poses(&estimate.mean);
    let blocked = obstacles.iter().any(|obstacle| obstacle.lacks(&poses) > 0.0);
    let beside = near.iter().any(|(_, to)| !told.is_new() || *to == told.latest());
    if gates > 1.0 || !(beside || blocked) {
        return false;
    }
    let gate = gates * QUANTILES[1].min(estimate.left(2)).max(0.0);
    Profile::new(estimate, &pairs, obstacles).rise(radius).is_none_or(|rise| rise.by > gate)
}

fn shares_a_spot(told: &Told<'_>, estimate: &Estimate<'_>) -> bool {
    let latest = told.latest();
    let separation = separation(told);
    let gate = estimate.left(2).clamp(0.0, told.bounds.position_gate).sqrt();
    let least = if told.is_new() { latest } else { 1 };
    let pairs = (least..=latest).flat_map(|to| (0..to).map(move |from| (from, to)));
    let farthest = |&(from, to): &(usize, usize)| {
        let (at, covariance) = estimate.pose(from, to);
        let position = Matrix2::new(covariance.m11, covariance.m12, covariance.m21, covariance.m22);
        let root = position.cholesky().unwrap().l();
        let around = (0..3600).map(|tenth| f64::from(tenth) / 3600.0 * TAU);
        let farthest = around
            .map(|angle| {
                (Vector2::new(at.x, at.y) + root * Vector2::new(angle.cos(), angle.sin()) * gate).norm()
            })
            .fold(0.0, f64::max);
        (at.xy().norm(), farthest, from, to)
    };
    let apart = |&(from, to): &(usize, usize)| told.story[from].0 != told.story[to].0;
    let pairs: Vec<_> = pairs.filter(apart).map(|pair| farthest(&pair)).collect();
    let near: Vec<_> = pairs.into_iter().filter(|(off, ..)| *off < separation).collect();
    let nearest = near.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    near.iter().any(|&(_, farthest, from, to)| farthest + estimate.slack(from, to, gate) < separation)
        || nearest.is_some_and(|&(_, farthest, from, to)| {
            let stays = || {
                Profile::new(estimate, &[(from, to)], Vec::new())
                    .rises_beyond(gate * gate, separation * told.rim)
            };
            farthest < separation && stays()
        })
}

/// A factor of a covariance, heading first: its columns by cause, length, aside, heading.
fn root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    if covariance.amax() == 0.0 {
        return Matrix3::zeros();
    }
    let order = [2, 0, 1];
    let sorted = Matrix3::from_fn(|row, column| covariance[(order[row], order[column])]);
    let lower = sorted.cholesky().unwrap().l();
    let mut root = Matrix3::zeros();
    for row in 0..3 {
        for column in 0..3 {
            root[(order[row], order[column])] = lower[(row, column)];
        }
    }
    root
}
