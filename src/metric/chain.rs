//! Chains of measurements between frames, and the least uncertain ones.
//!
//! The nodes are the frames of the visits before the latest and those of the places. A measured travel joins two
//! visits in a row; a visit is joined to its place. The weight of either is the variance of the position it leads
//! to, the heading's at [`MetricParameters::lever`] metres. What a chain is made of does not bear on whether it is
//! sound: one that is chosen badly refutes less.
//!
//! [`MetricParameters::lever`]: crate::metric::MetricParameters::lever

use crate::geometry::Pose;
use crate::metric::frames::Story;
use crate::metric::leg::Leg;
use nalgebra::Matrix3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Frame {
    /// Of a visit.
    Visit(usize),
    /// Of a place.
    Place(usize),
}

/// A step from one frame to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    /// The displacement as measured.
    pub(super) leg: Leg,
    /// Whether it is gone against the direction in which it was measured.
    pub(super) back: bool,
    /// The visit to which the travel led, unless it is a step between a visit and its place.
    pub(super) travel: Option<usize>,
}

/// The least uncertain chains from one visit to all frames.
#[derive(Debug)]
pub(super) struct Chains<'a> {
    story: &'a Story<'a>,
    start: Frame,
    /// The frame before each, and how it was reached; visits first, then places.
    before: Vec<Option<(Frame, Step)>>,
}

impl<'a> Chains<'a> {
    /// The chains from the visit before the latest (Dijkstra 1959). About the visits times their logarithm.
    pub(super) fn new(story: &'a Story<'a>) -> Self {
        let start = Frame::Visit(story.latest() - 1);
        let mut chains = Chains { story, start, before: Vec::new() };
        let nodes = story.latest() + story.places();
        chains.before = vec![None; nodes];
        let mut visits_of = vec![Vec::new(); story.places()];
        (0..story.latest()).for_each(|visit| visits_of[story.place(visit)].push(visit));
        let mut best = vec![f64::INFINITY; nodes];
        best[chains.index(start)] = 0.0;
        // Numbers that are not negative are in the order of their bits.
        let mut agenda = BinaryHeap::from([Reverse((0_u64, start))]);
        while let Some(Reverse((bits, frame))) = agenda.pop() {
            let weight = f64::from_bits(bits);
            if weight > best[chains.index(frame)] {
                continue;
            }
            for (next, step) in steps(story, frame, &visits_of) {
                let (total, at) = (weight + chains.weight(&step), chains.index(next));
                if total < best[at] {
                    best[at] = total;
                    chains.before[at] = Some((frame, step));
                    agenda.push(Reverse((total.to_bits(), next)));
                }
            }
        }
        chains
    }

    /// The steps of the chain to a frame, first one first; `None` where nothing measured leads there.
    pub(super) fn to(&self, frame: Frame) -> Option<Vec<Step>> {
        let mut steps = Vec::new();
        let mut at = frame;
        while at != self.start {
            let (from, step) = self.before[self.index(at)]?;
            steps.push(step);
            at = from;
        }
        steps.reverse();
        Some(steps)
    }

    fn index(&self, frame: Frame) -> usize {
        match frame {
            Frame::Visit(visit) => visit,
            Frame::Place(place) => self.story.latest() + place,
        }
    }

    fn weight(&self, step: &Step) -> f64 {
        let variances = (step.leg.odometry + step.leg.stay).diagonal();
        variances.x + variances.y + variances.z * self.story.parameters.lever.powi(2)
    }
}

/// The steps from a frame to others.
fn steps(story: &Story<'_>, frame: Frame, visits_of: &[Vec<usize>]) -> Vec<(Frame, Step)> {
    match frame {
        Frame::Place(place) => {
            let joined = |&visit: &usize| {
                Some((Frame::Visit(visit), Step { leg: link(story, visit)?, back: false, travel: None }))
            };
            visits_of[place].iter().filter_map(joined).collect()
        }
        Frame::Visit(visit) => {
            let travelled = |travel: usize, next: usize, back: bool| {
                let leg = story.stays[travel].travelled?.leg?;
                Some((Frame::Visit(next), Step { leg, back, travel: Some(travel) }))
            };
            let place = Frame::Place(story.place(visit));
            let joined = link(story, visit).map(|leg| (place, Step { leg, back: true, travel: None }));
            let backward = visit.checked_sub(1).and_then(|before| travelled(visit, before, true));
            // The travel to the latest visit is not in the chains.
            let ahead = Some(visit + 1).filter(|next| *next < story.latest());
            let forward = ahead.and_then(|next| travelled(next, next, false));
            joined.into_iter().chain(backward).chain(forward).collect()
        }
    }
}

/// The frame of a visit in that of its place, where bearings tell its direction.
pub(super) fn link(story: &Story<'_>, visit: usize) -> Option<Leg> {
    let (extent, bearing) = (story.parameters.extent_sigma.powi(2), story.parameters.bearing_sigma.powi(2));
    let stay = Matrix3::from_diagonal(&nalgebra::Vector3::new(extent, extent, bearing));
    let pose = Pose::new(0.0, 0.0, story.turn(visit)?);
    Some(Leg { pose, odometry: Matrix3::zeros(), causes: Matrix3::zeros(), stay })
}
