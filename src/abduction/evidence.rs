//! What was measured, as far as the logic asks for it.

use crate::abduction::{AxiomId, Clash, Proposal};
use std::fmt::Debug;

/// The measurements of a trace, from its first observation to the latest, and how they judge.
///
/// Laws: what is said of a proposal depends on the proposal, the assignments of its branch, and the measurements up
/// to the observation proposed for, on nothing else; so it is the same for every order of search. An axiom speaks
/// of one travel at a time: what a candidate was once found to obey it is not asked for again.
pub trait Evidence: Debug + Send + Sync {
    /// Whether a measured axiom holds of a child.
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool;

    /// Why a measured axiom does not hold of a child; asked for only where it does not.
    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash;
}
