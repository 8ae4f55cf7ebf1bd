//! The measured axioms, slowly: what was measured on a story, every chain there is, derivatives by differences, and the
//! definitions of lengths and directions. What concerns all loops at once is in `layout_reference`.

use crate::layout_reference::{loops_close, places_are_apart};
use nalgebra::{Matrix3, Vector3};
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
#[derive(Clone, Copy)]
pub(crate) struct Told<'a> {
    pub(crate) seen: &'a [Sighting],
    pub(crate) story: &'a [(usize, usize)],
    pub(crate) bounds: MetricParameters,
    /// By how much the circle around a spot is drawn wider, where it comes to the profile of chi-square.
    pub(crate) rim: f64,
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

impl<'a> Told<'a> {
    /// A story under the bounds that serve all data.
    pub(crate) fn new(seen: &'a [Sighting], story: &'a [(usize, usize)]) -> Told<'a> {
        Told { seen, story, bounds: MetricParameters::default(), rim: 1.0 }
    }

    pub(crate) fn latest(&self) -> usize {
        self.story.len() - 1
    }

    pub(crate) fn is_new(&self) -> bool {
        self.story[..self.latest()].iter().all(|visit| visit.0 != self.story[self.latest()].0)
    }

    pub(crate) fn first(&self, place: usize) -> usize {
        self.story.iter().position(|visit| visit.0 == place).unwrap()
    }

    fn on_place(&self, visit: usize, slot: usize) -> usize {
        (slot + self.story[visit].1) % self.seen[visit].star.slots().len()
    }

    pub(crate) fn ends(&self, to: usize) -> [(usize, usize); 2] {
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
    pub(crate) fn turn(&self, visit: usize) -> f64 {
        let first = self.bearings(self.first(self.story[visit].0));
        let turns = self.bearings(visit).into_iter().flat_map(|(slot, seen)| {
            first.iter().filter(move |(other, _)| *other == slot).map(move |(_, own)| own - seen)
        });
        let turns: Vec<f64> = turns.collect();
        let about = turns[0];
        about + turns.iter().map(|turn| wrap_angle(turn - about)).sum::<f64>() / turns.len() as f64
    }

    /// The frame of a visit in that of the one before, with errors of odometry and of the start added.
    pub(crate) fn travel(&self, to: usize, error: &Vector3<f64>, astray: &Vector3<f64>) -> Pose {
        let (before, now) = (&self.seen[to - 1], &self.seen[to]);
        let motion = now.motion.as_ref().unwrap();
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
    pub(crate) fn covariances(&self, to: usize) -> (Matrix3<f64>, Matrix3<f64>) {
        let motion = self.seen[to].motion.as_ref().unwrap();
        let none = Vector3::zeros();
        let by_error = derivative(|e| self.travel(to, e, &none));
        let by_start = derivative(|w| self.travel(to, &none, w));
        let start = if motion.start_given { Matrix3::zeros() } else { self.astray() };
        let odometry = Matrix3::from_row_slice(&motion.covariance);
        (by_error * odometry * by_error.transpose(), by_start * start * by_start.transpose())
    }

    pub(crate) fn astray(&self) -> Matrix3<f64> {
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

/// Whether a law holds of all beginnings of a story; `None` on the brink.
pub(crate) fn decided(law: Law, seen: &[Sighting], story: &[(usize, usize)]) -> Option<bool> {
    within(&|told| {
        let beginning = |length: usize| Told { seen: &seen[..length], story: &story[..length], ..told };
        (2..=story.len()).all(|length| law(&beginning(length)))
    })
}

/// The law that the latest observation of a story breaks first, if it breaks one; `None` on the brink.
pub(crate) fn broken(seen: &[Sighting], story: &[(usize, usize)]) -> Option<Option<AxiomId>> {
    for (axiom, law) in LAWS {
        if !within(&|told| law(&Told { seen, story, ..told }))? {
            return Some(Some(*axiom));
        }
    }
    Some(None)
}

/// What holds under the bounds that serve all data; `None` on the brink: where it would be otherwise with gates a
/// twentieth narrower or wider, and circles that are drawn around spots as polygons with their corners on the rim.
fn within(holds: &dyn Fn(Told<'_>) -> bool) -> Option<bool> {
    let holds = |(gates, rim): (f64, f64)| {
        let plain = MetricParameters::default();
        let bounds = MetricParameters {
            position_gate: plain.position_gate * gates,
            pose_gate: plain.pose_gate * gates,
            ..plain
        };
        holds(Told { bounds, rim, ..Told::new(&[], &[]) })
    };
    let [narrow, plain, wide] = [(0.95, 1.0), (1.0, 1.0), (1.05, POLYGON)].map(holds);
    (narrow == plain && wide == plain).then_some(plain)
}

/// How near the sides of a regular polygon of 24 corners come to its middle, seen from which a corner is at one.
pub(crate) const POLYGON: f64 = 0.991_444_861_373_810_4;
