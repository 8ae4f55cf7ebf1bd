//! The travels of a candidate, and what each of them came to.

use crate::abduction::{Assignment, Candidate, Visit};
use crate::map::{DstateId, PlaceId, TopologicalMap};
use crate::star::SlotIndex;
use std::borrow::Borrow;
use std::collections::BTreeMap;

/// A travel of a candidate. Its number is that of the observation at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Travelled {
    /// The observation at its end.
    pub observation: usize,
    /// The gateway left by.
    pub from: DstateId,
    /// The gateway come in by, seen from within, so that travel away through it leads back.
    pub to: DstateId,
    /// What it came to.
    pub kind: StepKind,
}

/// What a travel came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// It led to a new place.
    NewPlace,
    /// It went into the unknown, and came to a known place.
    Closure,
    /// It went along a path segment that was known since this observation.
    Known {
        /// The observation at the end of the first travel along it.
        since: usize,
    },
}

/// The travels of a candidate, in order: that to observation `k` is at position `k - 1`. Linear in the visits, up to
/// a logarithm.
pub fn travels(visits: &[impl Borrow<Visit>], candidate: &Candidate) -> Vec<Travelled> {
    let mut since: BTreeMap<[DstateId; 2], usize> = BTreeMap::new();
    let mut known = 0;
    let steps = candidate.visits.windows(2).zip(visits.iter().map(Borrow::borrow).skip(1));
    let travel = |(k, (assignments, visit)): (usize, (&[Assignment], &Visit))| {
        let (before, now) = (assignments[0], assignments[1]);
        let observation = k + 1;
        let from = laid(&candidate.map, before, visit.departure?);
        let to = laid(&candidate.map, now, visit.star.slots()[visit.arrival.0 as usize].opposite);
        let first = *since.entry([from.min(to), from.max(to)]).or_insert(observation);
        let is_new = now.place.index() > known;
        known = known.max(now.place.index());
        let kind = match first == observation {
            false => StepKind::Known { since: first },
            true if is_new => StepKind::NewPlace,
            true => StepKind::Closure,
        };
        Some(Travelled { observation, from, to, kind })
    };
    steps.enumerate().map_while(travel).collect()
}

/// The first visit to a place.
pub(super) fn first_visit(assignments: &[Assignment], place: PlaceId) -> Option<usize> {
    assignments.iter().position(|assignment| assignment.place == place)
}

/// The dstate that an assignment lays a slot of its observation onto.
fn laid(map: &TopologicalMap, assignment: Assignment, slot: SlotIndex) -> DstateId {
    let at = DstateId { place: assignment.place, slot };
    clockwise_by(map, at, assignment.rotation)
}

/// The dstate that many slots further clockwise at the same place.
pub(super) fn clockwise_by(map: &TopologicalMap, dstate: DstateId, slots: u8) -> DstateId {
    let size = map.star(dstate.place).size();
    let slot = (dstate.slot.0 as usize + slots as usize) % size;
    // A star's slots are numbered within a byte.
    DstateId { slot: SlotIndex(slot as u8), ..dstate }
}
