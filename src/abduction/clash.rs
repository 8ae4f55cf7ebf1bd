//! What clashes where an axiom does not hold.

use crate::map::{DstateId, PlaceId};

/// What clashes where an axiom does not hold of a candidate.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clash {
    /// The observations that cannot all be explained so, ascending.
    pub observations: Vec<usize>,
    /// The places concerned.
    pub places: Vec<PlaceId>,
    /// The path segments concerned, by their two ends.
    pub segments: Vec<[DstateId; 2]>,
    /// The clash in one sentence, with figures where there are some.
    pub words: String,
}
