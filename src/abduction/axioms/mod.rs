//! The registry of axioms: one file an axiom, one line here.

use crate::abduction::{Axiom, AxiomId};

mod angle;
mod apart;
mod boundary;
mod closure;
mod determinism;
mod distance;
mod path_order;
mod planarity;
mod star_match;
mod travel_moves;

/// The axioms, in the order in which they judge: the first that does not hold is the one that refutes. Position
/// is [`AxiomId`]'s order. What is cheap to judge comes first, and symbols before metres.
pub static REGISTRY: [Axiom; 10] = [
    determinism::AXIOM,
    star_match::AXIOM,
    travel_moves::AXIOM,
    path_order::AXIOM,
    planarity::AXIOM,
    boundary::AXIOM,
    distance::AXIOM,
    angle::AXIOM,
    closure::AXIOM,
    apart::AXIOM,
];

impl AxiomId {
    /// The axiom.
    pub fn axiom(self) -> &'static Axiom {
        &REGISTRY[self as usize]
    }

    /// The axiom's name outside.
    pub fn name(self) -> &'static str {
        self.axiom().name
    }
}
