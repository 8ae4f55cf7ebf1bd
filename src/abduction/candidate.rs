//! A candidate map.

use crate::abduction::{AxiomSet, Simplicity};
use crate::map::{DstateId, PlaceId, TopologicalMap};
use std::sync::Arc;

/// An assignment of all observations to places under which the axioms hold, and the map it makes. Two candidates
/// are the same if and only if they make the same assignment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The map.
    pub map: Arc<TopologicalMap>,
    /// The assignment of each observation.
    pub visits: Vec<Assignment>,
    /// Where the robot is, as it arrived.
    pub robot: DstateId,
}

/// What an observation is taken for. The order is that in which candidates are listed: an assignment to a known
/// place is less than one to a new place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Assignment {
    /// The place visited.
    pub place: PlaceId,
    /// How many slots further on the star of the place each slot of the star observed is.
    pub rotation: u8,
}

impl Candidate {
    /// How simple its map is under these axioms.
    pub fn simplicity(&self, axioms: AxiomSet) -> Simplicity {
        Simplicity::of(&self.map, axioms)
    }

    /// The number of the place of each observation.
    pub fn places(&self) -> Vec<usize> {
        self.visits.iter().map(|visit| visit.place.index()).collect()
    }
}
