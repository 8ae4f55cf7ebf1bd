//! The measured axioms against a slow reference: every chain there is, derivatives by differences, and the definitions.

use crate::engine::{names, stories};
use crate::reference::Story;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Matrix3xX, Vector3};
use proptest::prelude::*;
use topostar::abduction::{
    Abduction, Assignment, AxiomId, AxiomSet, Limits, Profile, REGISTRY, Visit, judge,
};
use topostar::geometry::{Pose, wrap_angle};
use topostar::map::PlaceId;
use topostar::metric::{Measurements, MetricParameters};
use topostar::trace::{Event, Experience, Sighting, write_trace};
use topostar::worlds::{Drift, corridor_grid, covering_walk, drifting_trace};

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
    seen: &'a [Sighting],
    story: &'a [(usize, usize)],
    bounds: MetricParameters,
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

/// All errors of a story estimated at once, with spread one each: three a travel of its own, then three a visit of
/// where in its place it is, then three of odometry that are the same on all travels. Loops are observations of them.
struct Estimate<'a> {
    told: &'a Told<'a>,
    /// The displacement, what its own errors do, and what common ones do.
    legs: Vec<(Pose, Matrix3<f64>, Matrix3<f64>)>,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl<'a> Estimate<'a> {
    /// By the loops among so many visits.
    fn new(told: &'a Told<'a>, assigned: usize) -> Estimate<'a> {
        let legs: Vec<_> = (1..=told.latest())
            .map(|to| {
                let (odometry, stay) = told.covariances(to);
                let leg = told.travel(to, &Vector3::zeros(), &Vector3::zeros());
                (leg, root(&(odometry + stay)), root(&odometry))
            })
            .collect();
        let size = 6 * told.story.len() + 3;
        let (mean, covariance) = (DVector::zeros(size), DMatrix::identity(size, size));
        let mut estimate = Estimate { told, legs, mean, covariance };
        let loops: Vec<usize> =
            (0..assigned).filter(|&visit| told.first(told.story[visit].0) < visit).collect();
        for _ in 0..12 {
            let mut information = DMatrix::identity(size, size);
            let mut pull = DVector::zeros(size);
            let weight = told.astray().try_inverse().unwrap();
            for &visit in &loops {
                let (off, slope) = estimate.linearised(|errors| estimate.off(visit, errors));
                information += slope.transpose() * weight * &slope;
                pull += slope.transpose() * weight * (&slope * &estimate.mean - off);
            }
            estimate.covariance = information.try_inverse().unwrap();
            estimate.mean = &estimate.covariance * pull;
        }
        estimate
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

    /// What the derivatives leave out from one visit to another.
    fn slack(&self, from: usize, to: usize, gate: f64) -> f64 {
        (from + 1..=to)
            .map(|visit| {
                let leg = &self.legs[visit - 1].0;
                leg.x.hypot(leg.y) * gate * gate * self.pose(from, visit - 1).1.m33 / 2.0
            })
            .sum()
    }
}

fn loops_close(told: &Told<'_>) -> bool {
    if told.is_new() {
        return true;
    }
    let latest = told.latest();
    let gate = told.bounds.pose_gate.sqrt();
    let estimate = Estimate::new(told, latest);
    let (off, slope) = estimate.linearised(|errors| estimate.off(latest, errors));
    let covariance = &slope * &estimate.covariance * slope.transpose() + told.astray();
    let slack = estimate.slack(told.first(told.story[latest].0), latest, gate);
    let size = gate * (covariance.m11 + covariance.m22).sqrt();
    let disc = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)) * (slack / gate).powi(2);
    let widened = match slack > 0.0 {
        true => covariance * (1.0 + slack / size) + disc * (1.0 + size / slack),
        false => covariance,
    };
    off.dot(&(widened.try_inverse().unwrap() * off)) <= told.bounds.pose_gate
}

fn places_are_apart(told: &Told<'_>) -> bool {
    let latest = told.latest();
    let lengths = (1..=latest).map(|to| told.travel(to, &Vector3::zeros(), &Vector3::zeros()));
    let separation = lengths.map(|leg| leg.x.hypot(leg.y)).fold(told.bounds.separation, f64::min);
    let gate = told.bounds.position_gate.sqrt();
    let firsts: Vec<usize> = (0..=latest).filter(|&visit| told.first(told.story[visit].0) == visit).collect();
    let (estimate, pairs): (_, Vec<(usize, usize)>) = match told.is_new() {
        true => (Estimate::new(told, latest), (0..latest).map(|from| (from, latest)).collect()),
        false => {
            let pairs = firsts.iter().flat_map(|&to| firsts.iter().map(move |&from| (from, to)));
            (Estimate::new(told, latest + 1), pairs.filter(|(from, to)| from < to).collect())
        }
    };
    pairs.into_iter().all(|(from, to)| {
        let (at, covariance) = estimate.pose(from, to);
        let position = Matrix2::new(covariance.m11, covariance.m12, covariance.m21, covariance.m22);
        let widest = position.svd(false, false).singular_values.max();
        at.x.hypot(at.y) + gate * widest.sqrt() + estimate.slack(from, to, gate) >= separation
    })
}

/// A walk through a grid with odometry of some quality, said to be better than it is.
fn walks() -> impl Strategy<Value = Vec<Sighting>> {
    let drift = prop_oneof![Just(0.05), Just(0.2), Just(1.0)];
    let boast = prop_oneof![3 => Just(1.0), 1 => Just(0.1), 1 => Just(0.001)];
    (any::<u64>(), 2usize..4, 4.0..12.0, drift, boast, 4usize..10).prop_map(
        |(seed, columns, spacing, drift, boast, travels)| {
            let places = corridor_grid(2, columns, spacing);
            let mut walk = covering_walk(&places, seed);
            walk.leave.truncate(travels);
            let trace = drifting_trace(&places, &walk, Drift::WORST.scaled(drift), seed).unwrap();
            let mut seen = sightings(&trace.events);
            for motion in seen.iter_mut().filter_map(|sighting| sighting.motion.as_mut()) {
                motion.covariance = motion.covariance.map(|entry| entry * boast);
                motion.start_given = seed % 3 != 0;
            }
            seen
        },
    )
}

pub(crate) fn sightings(events: &[Event]) -> Vec<Sighting> {
    let mut experience = Experience::new();
    let look = |event| experience.accept(event, &|_, _| unreachable!("bare stars")).unwrap();
    events.iter().filter_map(look).collect()
}

pub(crate) fn explain(sightings: &[Sighting], axioms: AxiomSet) -> Abduction {
    let mut measured = Measurements::default();
    let mut abduction = Abduction::new(axioms, Limits::default());
    for sighting in sightings {
        measured = measured.with(sighting);
        abduction.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    abduction
}

#[test]
fn every_measured_axiom_has_one_reference() {
    let measured = REGISTRY.iter().filter(|axiom| axiom.is_measured()).map(|axiom| axiom.id);
    assert!(measured.eq(LAWS.iter().map(|(id, _)| *id)));
    assert!(names(AxiomSet::of(Profile::Default)).len() < AxiomSet::of(Profile::Default).iter().count());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// With a measured axiom, exactly those candidates are left that there are without it and that obey it.
    #[test]
    fn measured_axioms_refute_exactly_what_breaks_them(seen in walks()) {
        let symbols = AxiomSet::of(Profile::Default).without_measured();
        let mut few = seen.len();
        while few > 1 && explain(&seen[..few], symbols).len() > 60 {
            few -= 1;
        }
        let seen = &seen[..few];
        let all = stories(&explain(seen, symbols));
        for (id, law) in LAWS {
            let obeys = |story: &Story| (2..=story.len()).all(|length| {
                law(&Told { seen: &seen[..length], story: &story[..length], bounds: MetricParameters::default() })
            });
            let expected: Vec<Story> = all.iter().filter(|story| obeys(story)).cloned().collect();
            prop_assert_eq!(stories(&explain(seen, symbols.with(*id))), expected, "{}", id.name());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// The search for the simplest maps alone prefers, among what was measured too, what the exhaustive one prefers.
    #[test]
    fn best_first_finds_the_simplest_of_what_was_measured(seen in walks()) {
        let axioms = AxiomSet::of(Profile::Default);
        let mut found = Abduction::best_first(axioms, Limits::default());
        let mut measured = Measurements::default();
        for sighting in &seen {
            measured = measured.with(sighting);
            found.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
        }
        found.settle(&|| false);
        let (found, all) = (found.report(), explain(&seen, axioms).report());
        prop_assert!(found.proven);
        prop_assert_eq!(found.minimal, all.minimal);
        prop_assert_eq!(found.simplicity, all.simplicity);
    }
}

pub(crate) fn recorded(name: &str) -> Vec<Sighting> {
    let path = format!("{}/worlds/{name}.ndjson", env!("CARGO_MANIFEST_DIR"));
    let (events, fault) = topostar::trace::read_trace(std::fs::read(path).unwrap().as_slice());
    assert!(fault.is_none());
    sightings(&events)
}

/// Four corners that look alike, ten and thirty metres apart in turn, and no bearings: the ring of three is refuted
/// by lengths alone, those of two and of four repeat them.
#[test]
fn lengths_tell_a_ring_of_three_from_one_of_four() {
    let seen = recorded("ring-10-30");
    let symbols = AxiomSet::of(Profile::Default).without_measured();
    let three = [0, 1, 2, 0, 1, 2, 0, 1, 2, 0];
    let rings = |abduction: &Abduction| {
        abduction
            .candidates()
            .map(|candidate| candidate.places())
            .filter(|places| places[9] < 4)
            .collect::<Vec<_>>()
    };
    let with = explain(&seen, symbols.with(AxiomId::Distance));
    assert!(rings(&explain(&seen, symbols)).contains(&three.to_vec()));
    assert!(!rings(&with).contains(&three.to_vec()));
    assert!(rings(&with).contains(&vec![0, 1, 2, 3, 0, 1, 2, 3, 0, 1]));
    let report = with.report();
    assert!(report.refuted.by(AxiomId::Distance) > 0);
    // All four agree, and say so alone.
    assert!(explain(&seen, AxiomSet::of(Profile::Default)).report().refuted.by(AxiomId::Distance) > 0);
}

/// A grid walked with good odometry.
fn drifting(seed: u64) -> Vec<Event> {
    let places = corridor_grid(4, 4, 10.0);
    drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST.scaled(0.2), seed).unwrap().events
}

/// Each of the other three refutes something in it that those before it leave; `UPDATE_GOLDEN=1` writes the trace anew.
#[test]
fn angle_closure_and_apart_refute_on_a_grid() {
    const NAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/worlds/grid4x4-drift.ndjson");
    let mut written = Vec::new();
    write_trace(&mut written, &drifting(SEED)).unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(NAME, &written).unwrap();
    }
    assert!(std::fs::read(NAME).unwrap() == written, "the simulator no longer walks as recorded");
    let report = explain(&recorded("grid4x4-drift"), AxiomSet::of(Profile::Default)).report();
    for axiom in [AxiomId::Angle, AxiomId::Closure, AxiomId::Apart] {
        assert!(report.refuted.by(axiom) > 0, "{}: {:?}", axiom.name(), report.refuted);
    }
}

/// A walk in which all three refute.
const SEED: u64 = 0;

/// A sample of `cargo xtask evaluate`: no axiom refutes the true map, with odometry as bad as the worst and better.
#[test]
fn the_true_map_is_never_refuted() {
    let mut preferred = 0;
    for (side, seed, by) in (0..12).flat_map(|seed| [(4, seed, 1.0), (6, seed, 1.0), (4, seed, 0.2)]) {
        let places = corridor_grid(side, side, 10.0);
        let walk = covering_walk(&places, 7000 + seed);
        let trace = drifting_trace(&places, &walk, Drift::WORST.scaled(by), 7000 + seed).unwrap();
        let seen = sightings(&trace.events);
        let visits: Vec<Visit> = seen.iter().map(Visit::from).collect();
        let measured = seen.iter().fold(Measurements::default(), |measured, seen| measured.with(seen));
        let truth: Vec<Assignment> = trace
            .truth
            .iter()
            .map(|&(place, rotation)| Assignment { place: PlaceId::new(place).unwrap(), rotation })
            .collect();
        let axioms = AxiomSet::of(Profile::Default);
        let judged = judge(&visits, measured.evidence().as_deref(), axioms, &truth);
        assert!(judged.is_ok(), "{side} {seed} {by}: {judged:?}");
        if side == 4 && by < 1.0 {
            let found = explain(&seen, axioms).report();
            preferred += usize::from(found.minimal.len() == 1 && found.minimal[0].visits == truth);
        }
    }
    assert_eq!(preferred, 12);
}
