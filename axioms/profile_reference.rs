//! The profile of chi-square, slowly: of all errors with which visits lie at least so far apart the likeliest.
//!
//! All errors are unknowns of one function, whole poses and no tangents: their own chi-square, that of the loops, and a
//! penalty for what lacks to the distance, which grows until nothing lacks (Courant 1943). Its derivatives are
//! differences, its steps are damped and never uphill (Levenberg 1944, Marquardt 1963), and they start towards every side.

use crate::floor_reference::Obstacle;
use crate::layout_reference::Estimate;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use std::f64::consts::TAU;
use topostar::geometry::Pose;

/// Chi-square as a function of the errors of a story, pairs of its visits, and what is not to be in each other's way.
pub(crate) struct Profile<'a> {
    estimate: &'a Estimate<'a>,
    pairs: Vec<(usize, usize)>,
    obstacles: Vec<Obstacle>,
    /// Which errors bear on anything.
    unknowns: Vec<usize>,
    /// The least chi-square wherever the two visits lie, and its errors.
    least: f64,
    rest: DVector<f64>,
}

/// The likeliest errors found with which all pairs lie apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rise {
    /// How much more chi-square they take than the least.
    pub(crate) by: f64,
    /// Whether the steps that led there came to rest.
    pub(crate) rests: bool,
}

/// What is made of where visits lie.
type Lacks<'a> = dyn Fn(&[Pose]) -> Vec<f64> + 'a;

/// Sides towards which the search starts.
const STARTS: usize = 8;
/// What a metre that lacks to the distance counts, one after the other.
const PENALTIES: [f64; 3] = [1e1, 1e3, 1e6];
/// What is asked beyond the distance, so that it is reached: metres.
const BEYOND: f64 = 1e-4;

/// How much may lack for ways to be clear, metres: what the last penalty leaves.
const LACKING: f64 = 1e-3;

/// Where a search starts: with one pair towards a side, or one obstacle out of the way.
#[derive(Clone, Copy, Debug)]
enum Start {
    Pair(usize, usize),
    Obstacle(usize, usize),
}

impl<'a> Profile<'a> {
    pub(crate) fn new(
        estimate: &'a Estimate<'a>,
        pairs: &[(usize, usize)],
        obstacles: Vec<Obstacle>,
    ) -> Profile<'a> {
        let told = estimate.told;
        let travels = 0..3 * told.latest();
        let firsts = estimate.loops.iter().map(|&visit| told.first(told.story[visit].0));
        let astray = firsts.flat_map(|first| (0..3).map(move |axis| 3 * (told.story.len() + first) + axis));
        let common = 6 * told.story.len()..6 * told.story.len() + 3;
        let mut unknowns: Vec<usize> = travels.chain(astray).chain(common).collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let mut profile = Profile {
            estimate,
            pairs: pairs.to_vec(),
            obstacles,
            unknowns,
            least: 0.0,
            rest: estimate.mean.clone(),
        };
        (profile.rest, _) = profile.descend(&profile.rest, &|_| Vec::new());
        profile.least = profile.chi_square(&profile.rest);
        profile
    }

    /// How much chi-square grows at least for all pairs to lie so far apart and all to be out of each other's way, from every
    /// start; none if no start leads there. Starts are those with one pair at the distance, towards each side, or with one
    /// obstacle out of the way, in each way.
    pub(crate) fn rise(&self, distance: f64) -> Option<Rise> {
        let rises = self.starts(distance).into_iter().filter_map(|start| self.rise_from(start, distance));
        rises.min_by(|a, b| a.by.total_cmp(&b.by))
    }

    /// Whether no errors that take at most so much more chi-square were found with which they lie so far apart.
    pub(crate) fn rises_beyond(&self, gate: f64, distance: f64) -> bool {
        let rise = |start| self.rise_from(start, distance);
        self.starts(distance).into_iter().all(|start| rise(start).is_none_or(|rise| rise.by > gate))
    }

    /// From the pairs that are nearer than they are to be, to all sides, and from what is in each other's way.
    fn starts(&self, distance: f64) -> Vec<Start> {
        let poses = self.estimate.poses(&self.rest);
        let near = self.between(&poses).into_iter().enumerate().filter(|(_, at)| at.norm() < distance);
        let sides = near.flat_map(|(pair, _)| (0..STARTS).map(move |side| Start::Pair(pair, side)));
        let blocked = self.obstacles.iter().enumerate().filter(|(_, one)| one.lacks(&poses) > 0.0);
        sides.chain(blocked.flat_map(|(one, _)| (0..4).map(move |way| Start::Obstacle(one, way)))).collect()
    }

    fn rise_from(&self, start: Start, distance: f64) -> Option<Rise> {
        let asked = distance + BEYOND;
        let (mut errors, _) = match start {
            Start::Pair(pair, side) => {
                let angle = side as f64 / STARTS as f64 * TAU;
                let goal = asked * Vector2::new(angle.cos(), angle.sin());
                let off = |poses: &[Pose]| (self.between(poses)[pair] - goal).iter().copied().collect();
                self.descend(&self.rest, &off)
            }
            Start::Obstacle(one, way) => {
                self.descend(&self.rest, &|poses| vec![30.0 * self.obstacles[one].lacks_on(way, poses)])
            }
        };
        let mut rests = false;
        for penalty in PENALTIES {
            let lack = |at: &Vector2<f64>| f64::sqrt(penalty) * (at.norm() - asked).min(0.0);
            let lacks = |poses: &[Pose]| {
                let near = self.between(poses).iter().map(lack).collect::<Vec<f64>>();
                let blocked = self.obstacles.iter().map(|one| f64::sqrt(penalty) * one.lacks(poses));
                near.into_iter().chain(blocked).collect()
            };
            (errors, rests) = self.descend(&errors, &lacks);
        }
        let poses = self.estimate.poses(&errors);
        let clear = self.obstacles.iter().all(|one| one.lacks(&poses) < LACKING);
        let reached = clear && self.between(&poses).iter().all(|at| at.norm() >= distance);
        reached.then(|| Rise { by: self.chi_square(&errors) - self.least, rests })
    }

    /// How much more chi-square than the least errors take that lead to these frames of all visits.
    pub(crate) fn takes(&self, poses: &[Pose]) -> f64 {
        self.chi_square(&self.estimate.errors_to(poses)) - self.least
    }

    /// Where the later visit of each pair lies, seen from the earlier one.
    fn between(&self, poses: &[Pose]) -> Vec<Vector2<f64>> {
        let seen = |&(from, to): &(usize, usize)| {
            let seen = poses[from].inverse().compose(&poses[to]);
            Vector2::new(seen.x, seen.y)
        };
        self.pairs.iter().map(seen).collect()
    }

    fn chi_square(&self, errors: &DVector<f64>) -> f64 {
        errors.norm_squared() + self.residuals(errors, &|_| Vec::new()).norm_squared()
    }

    /// What loops leave open, in standard deviations, and what more is made of where visits lie.
    fn residuals(&self, errors: &DVector<f64>, more: &Lacks<'_>) -> DVector<f64> {
        let (estimate, bounds) = (self.estimate, &self.estimate.told.bounds);
        let sigma = Vector3::new(bounds.extent_sigma, bounds.extent_sigma, bounds.bearing_sigma);
        let poses = estimate.poses(errors);
        let off = |&visit: &usize| estimate.off_among(&poses, visit, errors).component_div(&sigma);
        let mut all: Vec<f64> = estimate.loops.iter().flat_map(|visit| off(visit).data.0[0]).collect();
        all.extend(more(&poses));
        DVector::from_vec(all)
    }

    /// Errors with a lesser sum of squares, theirs among them, and whether they came to rest.
    fn descend(&self, start: &DVector<f64>, more: &Lacks<'_>) -> (DVector<f64>, bool) {
        let sum = |errors: &DVector<f64>| errors.norm_squared() + self.residuals(errors, more).norm_squared();
        let (mut errors, mut damping) = (start.clone(), 1e-3);
        let mut least = sum(&errors);
        for _ in 0..100 {
            let left = self.residuals(&errors, more);
            let slope = self.slope(&errors, more);
            let downhill = slope.tr_mul(&left) + &errors;
            loop {
                let next = &errors - damped(&slope, &downhill, 1.0 + damping);
                let now = sum(&next);
                if now < least {
                    let gained = least - now;
                    (errors, least, damping) = (next, now, f64::max(damping / 10.0, 1e-9));
                    if gained < 1e-6 * (1.0 + least) {
                        return (errors, true);
                    }
                    break;
                }
                damping *= 10.0;
                if damping > 1e9 {
                    return (errors, true);
                }
            }
        }
        (errors, false)
    }

    fn slope(&self, errors: &DVector<f64>, more: &Lacks<'_>) -> DMatrix<f64> {
        let step = 1e-4;
        let rows = self.residuals(errors, more).len();
        let mut slope = DMatrix::zeros(rows, errors.len());
        let mut moved = errors.clone();
        for &unknown in &self.unknowns {
            let at = moved[unknown];
            moved[unknown] = at + step;
            let ahead = self.residuals(&moved, more);
            moved[unknown] = at - step;
            let behind = self.residuals(&moved, more);
            moved[unknown] = at;
            slope.set_column(unknown, &((ahead - behind) / (2.0 * step)));
        }
        slope
    }
}

/// `(w + S'S)^-1 g`, by as many equations as `S` has rows (Woodbury 1950).
fn damped(slope: &DMatrix<f64>, downhill: &DVector<f64>, weight: f64) -> DVector<f64> {
    // What lacks nothing changes by no error.
    let bears = |&row: &usize| slope.row(row).iter().any(|entry| *entry != 0.0);
    let slope = &slope.select_rows(&(0..slope.nrows()).filter(bears).collect::<Vec<usize>>());
    let small = slope * slope.transpose() + DMatrix::identity(slope.nrows(), slope.nrows()) * weight;
    let pulled = small.cholesky().unwrap().solve(&(slope * downhill));
    (downhill - slope.tr_mul(&pulled)) / weight
}
