//! A candidate map.

use crate::classic::{ClassicMap, DstateId};

/// An assignment of all observations to dstates under which the axioms hold, and the map it makes. Two candidates
/// are the same if and only if they make the same assignment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The map.
    pub map: ClassicMap,
    /// The dstate of each observation.
    pub dstates: Vec<DstateId>,
}

impl Candidate {
    /// The number of the place of each observation; places are numbered by first visit.
    pub fn places(&self) -> Vec<usize> {
        let first: Vec<DstateId> = self.map.ids().filter(|&id| self.map.dstate(id).place == id).collect();
        let number = |id: &DstateId| first.partition_point(|name| *name < self.map.dstate(*id).place);
        self.dstates.iter().map(number).collect()
    }
}
