//! Planarity: the engine's one face against Euler's count of all faces.

use crate::topology::refutes_what_breaks_it;
use proptest::prelude::*;
use topostar::abduction::{AxiomId, Visit};

pub(crate) fn places_and_faces_are_two_more_than_segments(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::Planarity, visits)
}
