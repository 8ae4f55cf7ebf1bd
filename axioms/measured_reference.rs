//! The measured axioms, slowly: every chain there is, all errors as unknowns, derivatives by differences, and the
//! definitions.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Matrix3xX, Vector2, Vector3};
use std::cell::Cell;
use std::f64::consts::TAU;
use std::sync::LazyLock;
use topostar::abduction::AxiomId;
use topostar::geometry::{Pose, wrap_angle};
use topostar::metric::MetricParameters;
use topostar::trace::Sighting;

/// A law on what the latest observation of a story is taken for.
pub(crate) type Law = fn(&Told<'_>) -> bool;

/// The reference of each measured axiom.
pub(crate) const LAWS: &[(AxiomId, Law)] = &[
    (AxiomId::Distance, lengths_of_a_segment_meet),
    (AxiomId::Angle, directions_agree),
    (AxiomId::Closure, loops_close),
    (AxiomId::Apart, places_are_apart),
];

/// A story up to some observation, and what was measured.
pub(crate) struct Told<'a> {
    pub(crate) seen: &'a [Sighting],
    pub(crate) story: &'a [(usize, usize)],
    pub(crate) bounds: MetricParameters,
}

/// A step of a chain: a travel to a visit, or the way from a place to a visit; either may be gone back.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Travel { to: usize, back: bool },
    Arrive { visit: usize, back: bool },
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Frame {
    Visit(usize),
    Place(usize),
}

impl Told<'_> {
    fn latest(&self) -> usize {
        self.story.len() - 1
    }

    fn is_new(&self) -> bool {
        self.story[..self.latest()].iter().all(|visit| visit.0 != self.story[self.latest()].0)
    }

    fn first(&self, place: usize) -> usize {
        self.story.iter().position(|visit| visit.0 == place).unwrap()
    }

    fn on_place(&self, visit: usize, slot: usize) -> usize {
        (slot + self.story[visit].1) % self.seen[visit].star.slots().len()
    }

    fn ends(&self, to: usize) -> [(usize, usize); 2] {
        let (left, came) =
            (self.seen[to].departure.unwrap(), self.seen[to].star.opposite(self.seen[to].arrival));
        let from = (self.story[to - 1].0, self.on_place(to - 1, left.0 as usize));
        let mut ends = [from, (self.story[to].0, self.on_place(to, came.0 as usize))];
        ends.sort_unstable();
        ends
    }

    fn bearings(&self, visit: usize) -> Vec<(usize, f64)> {
        let slots = self.seen[visit].star.slots().iter().enumerate();
        slots.filter_map(|(slot, of)| Some((self.on_place(visit, slot), of.bearing?))).collect()
    }

    /// How far the bearings of a visit are to be turned onto those of the first: the circular mean.
    fn turn(&self, visit: usize) -> f64 {
        let first = self.bearings(self.first(self.story[visit].0));
        let turns = self.bearings(visit).into_iter().flat_map(|(slot, seen)| {
            first.iter().filter(move |(other, _)| *other == slot).map(move |(_, own)| own - seen)
        });
        let turns: Vec<f64> = turns.collect();
        let about = turns[0];
        about + turns.iter().map(|turn| wrap_angle(turn - about)).sum::<f64>() / turns.len() as f64
    }

    /// The frame of a visit in that of the one before, with errors of odometry and of the start added.
    fn travel(&self, to: usize, error: &Vector3<f64>, astray: &Vector3<f64>) -> Pose {
        let (before, now) = (&self.seen[to - 1], &self.seen[to]);
        let motion = now.motion.unwrap();
        let start = Pose::new(
            motion.start.x - before.middle.x + astray.x,
            motion.start.y - before.middle.y + astray.y,
            motion.heading.unwrap() + astray.z,
        );
        let gone = motion.odometry;
        let gone = Pose::new(gone.x + error.x, gone.y + error.y, gone.theta + error.z);
        let arrived = now.robot_pose;
        let arrived = Pose::new(arrived.x - now.middle.x, arrived.y - now.middle.y, arrived.theta);
        start.compose(&gone).compose(&arrived.inverse())
    }

    /// Covariances of the displacement of a travel, by odometry and by where in the place it starts.
    fn covariances(&self, to: usize) -> (Matrix3<f64>, Matrix3<f64>) {
        let motion = self.seen[to].motion.unwrap();
        let none = Vector3::zeros();
        let by_error = derivative(|e| self.travel(to, e, &none));
        let by_start = derivative(|w| self.travel(to, &none, w));
        let start = if motion.start_given { Matrix3::zeros() } else { self.astray() };
        let odometry = Matrix3::from_row_slice(&motion.covariance);
        (by_error * odometry * by_error.transpose(), by_start * start * by_start.transpose())
    }

    fn astray(&self) -> Matrix3<f64> {
        let MetricParameters { extent_sigma, bearing_sigma, .. } = self.bounds;
        Matrix3::from_diagonal(&Vector3::new(extent_sigma, extent_sigma, bearing_sigma).map(|s| s * s))
    }

    /// Odometry's covariance and the other one of a step.
    fn step_covariances(&self, step: Step) -> (Matrix3<f64>, Matrix3<f64>) {
        match step {
            Step::Travel { to, .. } => self.covariances(to),
            Step::Arrive { .. } => (Matrix3::zeros(), self.astray()),
        }
    }

    /// A chain composed, with errors added to the displacement of each step.
    fn compose(&self, chain: &[Step], errors: &[Vector3<f64>]) -> Pose {
        let none = Vector3::zeros();
        chain.iter().zip(errors).fold(Pose::IDENTITY, |pose, (step, error)| {
            let (leg, back) = match *step {
                Step::Travel { to, back } => (self.travel(to, &none, &none), back),
                Step::Arrive { visit, back } => (Pose::new(0.0, 0.0, self.turn(visit)), back),
            };
            let leg = Pose::new(leg.x + error.x, leg.y + error.y, leg.theta + error.z);
            pose.compose(&if back { leg.inverse() } else { leg })
        })
    }

    /// Of all chains from the visit before the latest to a frame, which meet no frame twice, the one of least weight.
    fn chain(&self, goal: Frame) -> Option<Vec<Step>> {
        let start = Frame::Visit(self.latest() - 1);
        let mut best: Option<(f64, Vec<Step>)> = None;
        self.walk(&mut vec![start], &mut Vec::new(), goal, &mut best);
        best.map(|(_, chain)| chain)
    }

    fn walk(
        &self,
        met: &mut Vec<Frame>,
        steps: &mut Vec<Step>,
        goal: Frame,
        best: &mut Option<(f64, Vec<Step>)>,
    ) {
        let weight: f64 = steps.iter().map(|step| self.weight(*step)).sum();
        if best.as_ref().is_some_and(|(least, _)| weight >= *least) {
            return;
        }
        let at = met[met.len() - 1];
        if at == goal {
            *best = Some((weight, steps.clone()));
            return;
        }
        for (next, step) in self.steps(at) {
            if !met.contains(&next) {
                met.push(next);
                steps.push(step);
                self.walk(met, steps, goal, best);
                met.pop();
                steps.pop();
            }
        }
    }

    fn steps(&self, at: Frame) -> Vec<(Frame, Step)> {
        match at {
            Frame::Place(place) => (0..self.latest())
                .filter(|&visit| self.story[visit].0 == place)
                .map(|visit| (Frame::Visit(visit), Step::Arrive { visit, back: false }))
                .collect(),
            Frame::Visit(visit) => {
                let mut steps = vec![(Frame::Place(self.story[visit].0), Step::Arrive { visit, back: true })];
                if visit + 1 < self.latest() {
                    steps.push((Frame::Visit(visit + 1), Step::Travel { to: visit + 1, back: false }));
                }
                if visit > 0 {
                    steps.push((Frame::Visit(visit - 1), Step::Travel { to: visit, back: true }));
                }
                steps
            }
        }
    }

    fn weight(&self, step: Step) -> f64 {
        let (odometry, other) = self.step_covariances(step);
        let all = odometry + other;
        all.m11 + all.m22 + all.m33 * self.bounds.lever * self.bounds.lever
    }
}

/// The derivative of a pose by what is added, by differences.
fn derivative(of: impl Fn(&Vector3<f64>) -> Pose) -> Matrix3<f64> {
    let step = 1e-5;
    let mut columns = Matrix3::zeros();
    for axis in 0..3 {
        let mut by = Vector3::zeros();
        by[axis] = step;
        let (more, less) = (of(&by), of(&-by));
        let change = Vector3::new(more.x - less.x, more.y - less.y, wrap_angle(more.theta - less.theta));
        columns.set_column(axis, &(change / (2.0 * step)));
    }
    columns
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

fn lengths_of_a_segment_meet(told: &Told<'_>) -> bool {
    let sigmas = told.bounds.sigmas;
    let interval = |to: usize| {
        let leg = told.travel(to, &Vector3::zeros(), &Vector3::zeros());
        let (odometry, stay) = told.covariances(to);
        let along = Vector3::new(leg.x, leg.y, 0.0).normalize();
        let variance = along.dot(&((odometry + stay) * along)) + 2.0 * told.bounds.extent_sigma.powi(2);
        let length = leg.x.hypot(leg.y);
        (length - sigmas * variance.sqrt(), length + sigmas * variance.sqrt())
    };
    let same = (1..=told.latest()).filter(|&to| told.ends(to) == told.ends(told.latest()));
    let intervals: Vec<(f64, f64)> = same.map(interval).collect();
    let least = intervals.iter().map(|interval| interval.0).fold(f64::MIN, f64::max);
    least <= intervals.iter().map(|interval| interval.1).fold(f64::MAX, f64::min)
}

fn directions_agree(told: &Told<'_>) -> bool {
    told.is_new() || (around_the_place(told) && headings_close(told))
}

/// All differences between slots and visits of the place, tightened until nothing changes (Floyd and Warshall).
fn around_the_place(told: &Told<'_>) -> bool {
    let bound = told.bounds.sigmas * told.bounds.bearing_sigma;
    let place = told.story[told.latest()].0;
    let slots = told.seen[told.latest()].star.slots().len();
    let visits: Vec<usize> = (0..told.story.len()).filter(|&visit| told.story[visit].0 == place).collect();
    let size = slots + visits.len();
    let mut most = vec![vec![f64::INFINITY; size]; size];
    let first = told.bearings(visits[0]);
    for (at, &visit) in visits.iter().enumerate() {
        for (slot, bearing) in told.bearings(visit) {
            let own = first.iter().find(|(other, _)| *other == slot).unwrap().1;
            let off = wrap_angle(bearing + told.turn(visit) - own);
            most[slots + at][slot] = most[slots + at][slot].min(off + bound);
            most[slot][slots + at] = most[slot][slots + at].min(bound - off);
        }
    }
    for by in 0..size {
        for a in 0..size {
            for b in 0..size {
                most[a][b] = most[a][b].min(most[a][by] + most[by][b]);
            }
        }
    }
    (0..size).all(|a| most[a][a] > -1e-7)
}

/// The steps of the loop that the latest travel closes, but that travel.
fn around(told: &Told<'_>) -> Vec<Step> {
    let latest = told.latest();
    let mut chain = told.chain(Frame::Place(told.story[latest].0)).unwrap();
    chain.push(Step::Arrive { visit: latest, back: false });
    chain
}

fn headings_close(told: &Told<'_>) -> bool {
    let chain = around(told);
    let travel = Step::Travel { to: told.latest(), back: false };
    let none = vec![Vector3::zeros(); chain.len()];
    let direct = told.compose(&[travel], &none[..1]);
    let off = wrap_angle(direct.theta - told.compose(&chain, &none).theta);
    let sigma = |step: &Step| {
        let (odometry, other) = told.step_covariances(*step);
        odometry.m33.sqrt() + other.m33.sqrt()
    };
    off.abs() <= told.bounds.sigmas * chain.iter().chain([&travel]).map(sigma).sum::<f64>()
}

/// How much of the variance of a heading error may be the same on all travels, and how much may not.
type Share = (f64, f64);

/// A range of shares, all of them together, then the other ranges.
const SHARES: [Share; 5] = [(0.75, 0.5), (1.0, 1.0), (0.5, 0.75), (1.0, 0.25), (0.25, 1.0)];

/// Whether an axiom is broken whatever the share is, given where it is broken.
fn broken(by: impl Fn(Share) -> bool) -> bool {
    by(SHARES[0]) && (by(SHARES[1]) || SHARES[2..].iter().all(|&share| by(share)))
}

/// For twice as many degrees of freedom, what chi-square exceeds as rarely as five standard deviations: the density
/// summed from far out.
static QUANTILES: LazyLock<Vec<f64>> = LazyLock::new(|| {
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
    (0..40).map(|half| if half == 0 { 0.0 } else { quantile(half) }).collect()
});

thread_local! {
    /// Whether it came to the profile of chi-square since this was last asked for.
    static PROFILED: Cell<bool> = const { Cell::new(false) };
}

/// Whether a law holds of all beginnings of a story; `None` on the brink: where it would be otherwise with gates a
/// twentieth narrower or wider, or where it comes to the profile of chi-square, which two ways of linearising do not
/// follow alike; that has a test of its own.
pub(crate) fn decided(law: Law, seen: &[Sighting], story: &[(usize, usize)]) -> Option<bool> {
    let bounds = MetricParameters::default();
    let gated = |scale: f64| MetricParameters {
        position_gate: bounds.position_gate * scale,
        pose_gate: bounds.pose_gate * scale,
        ..bounds
    };
    let holds = |bounds: MetricParameters| {
        (2..=story.len()).all(|length| law(&Told { seen: &seen[..length], story: &story[..length], bounds }))
    };
    PROFILED.set(false);
    let verdicts = [holds(gated(0.95)), holds(bounds), holds(gated(1.05))];
    (!PROFILED.take() && verdicts.iter().all(|verdict| *verdict == verdicts[1])).then_some(verdicts[1])
}

/// All errors of a story estimated at once, with spread one each: three a travel of its own, then three a visit of
/// where in its place it is, then three of odometry that are the same on all travels. Loops are observations of them.
#[derive(Clone)]
struct Estimate<'a> {
    told: &'a Told<'a>,
    /// The displacement, what its own errors do, and what common ones do.
    legs: Vec<(Pose, Matrix3<f64>, Matrix3<f64>)>,
    loops: Vec<usize>,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl<'a> Estimate<'a> {
    /// By the loops among so many visits.
    fn new(told: &'a Told<'a>, assigned: usize, (common, alone): Share) -> Estimate<'a> {
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
        let mut estimate = Estimate { told, legs, loops, mean, covariance };
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
    fn left(&self, degrees: usize) -> f64 {
        QUANTILES[(3 * self.loops.len() + degrees).div_ceil(2)] - self.chi_square()
    }

    fn agrees(&self) -> bool {
        self.loops.is_empty() || self.left(0) >= 0.0
    }

    fn poses(&self, errors: &DVector<f64>) -> Vec<Pose> {
        let common = errors.fixed_rows::<3>(6 * self.told.story.len()).into_owned();
        let mut poses = vec![Pose::IDENTITY];
        for (at, (leg, own, same)) in self.legs.iter().enumerate() {
            let error = own * errors.fixed_rows::<3>(3 * at) + same * common;
            let leg = Pose::new(leg.x - error.x, leg.y - error.y, leg.theta - error.z);
            poses.push(poses[at].compose(&leg));
        }
        poses
    }

    /// The frame of a visit, in that of an earlier one.
    fn seen(&self, from: usize, to: usize, errors: &DVector<f64>) -> Pose {
        let poses = self.poses(errors);
        poses[from].inverse().compose(&poses[to])
    }

    /// How far a visit is from the middle of its place, which the first visit to it is off as well.
    fn off(&self, visit: usize, errors: &DVector<f64>) -> Vector3<f64> {
        let (told, first) = (self.told, self.told.first(self.told.story[visit].0));
        let seen = self.seen(first, visit, errors);
        let bounds = &told.bounds;
        let astray = errors.fixed_rows::<3>(3 * (told.story.len() + first)).component_mul(&Vector3::new(
            bounds.extent_sigma,
            bounds.extent_sigma,
            bounds.bearing_sigma,
        ));
        let place = Pose::new(astray.x, astray.y, astray.z);
        let off = place.inverse().compose(&seen);
        Vector3::new(off.x, off.y, wrap_angle(off.theta - told.turn(visit)))
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

    fn pose(&self, from: usize, to: usize) -> (Vector3<f64>, Matrix3<f64>) {
        let (at, slope) = self.linearised(|errors| {
            let pose = self.seen(from, to, errors);
            Vector3::new(pose.x, pose.y, pose.theta)
        });
        (at, &slope * &self.covariance * slope.transpose())
    }

    /// Whether chi-square grows by more than the gate for a visit to come to any side of a polygon of 24 sides in the
    /// circle around another.
    fn stays_within(&self, from: usize, to: usize, radius: f64, gate: f64) -> bool {
        PROFILED.set(true);
        (0..24).all(|side| {
            let angle = f64::from(side) / 24.0 * TAU;
            let way = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let beyond = |errors: &DVector<f64>| {
                let seen = self.seen(from, to, errors);
                Vector3::new(seen.x, seen.y, 0.0).dot(&way) - radius * (TAU / 48.0).cos()
            };
            beyond(&self.mean) < 0.0 && self.held(&beyond).is_some_and(|more| more > gate)
        })
    }

    /// How much more chi-square is when a function of errors is held at nought, as if that were observed.
    fn held(&self, function: &dyn Fn(&DVector<f64>) -> f64) -> Option<f64> {
        let size = self.mean.len();
        let (weight, stiff) = (self.told.astray().try_inverse().unwrap(), 1e9);
        let mut held = self.clone();
        let mut last = f64::NAN;
        // Where chi-square does not come to rest within so many rounds, nothing is known.
        for _ in 0..40 {
            let mut information = DMatrix::identity(size, size);
            let mut pull = DVector::zeros(size);
            for &visit in &held.loops {
                let (off, slope) = held.linearised(|errors| held.off(visit, errors));
                information += slope.transpose() * weight * &slope;
                pull += slope.transpose() * weight * (&slope * &held.mean - off);
            }
            let (off, slope) = held.linearised(|errors| Vector3::new(function(errors), 0.0, 0.0));
            information += slope.transpose() * stiff * &slope;
            pull += slope.transpose() * stiff * (&slope * &held.mean - off);
            held.mean = information.cholesky()?.solve(&pull);
            let chi_square = held.chi_square();
            if (chi_square - last).abs() < 0.01 {
                return Some(chi_square - self.chi_square());
            }
            last = chi_square;
        }
        None
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

fn loops_close(told: &Told<'_>) -> bool {
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

fn places_are_apart(told: &Told<'_>) -> bool {
    let assigned = if told.is_new() { told.latest() } else { told.latest() + 1 };
    let verdict = |share: Share| {
        let estimate = Estimate::new(told, assigned, share);
        match (estimate.agrees(), shares_a_spot(told, &estimate)) {
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

fn shares_a_spot(told: &Told<'_>, estimate: &Estimate<'_>) -> bool {
    let latest = told.latest();
    let lengths = (1..=latest).map(|to| told.travel(to, &Vector3::zeros(), &Vector3::zeros()));
    let separation = lengths.map(|leg| leg.x.hypot(leg.y)).fold(told.bounds.separation, f64::min);
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
            farthest < separation && estimate.stays_within(from, to, separation, gate * gate)
        })
}
