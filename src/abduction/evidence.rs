//! What was measured, as far as the logic asks for it.

use crate::abduction::{AxiomId, Clash, Proposal};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

/// The measurements of a trace, from its first observation to the latest, and how they judge.
///
/// Laws: what is said of a proposal depends on the proposal, the assignments of its branch, and the measurements up
/// to the observation proposed for, on nothing else; so it is the same for every order of search. What was learned of the branch
/// ([`Branch::learned`](crate::abduction::Branch::learned)) counts among that, as it follows from the same. An axiom speaks
/// of one travel at a time: what a candidate was once found to obey it is not asked for again.
pub trait Evidence: Debug + Send + Sync {
    /// Whether a measured axiom holds of a child.
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool;

    /// Why a measured axiom does not hold of a child; asked for only where it does not.
    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash;

    /// What judging a child has taught that its own children can be judged by: asked for when all axioms hold of it, next after that
    /// was asked.
    fn learned(&self, proposal: &Proposal<'_>) -> Learned {
        let _ = proposal;
        Learned::default()
    }
}

/// What evidence has learned of a candidate, of which the logic knows nothing but whose it is. A clone shares it.
#[derive(Clone, Debug, Default)]
pub struct Learned(Option<Arc<dyn Any + Send + Sync>>);

impl Learned {
    /// Something learned.
    pub fn of<T: Any + Send + Sync>(what: T) -> Learned {
        Learned(Some(Arc::new(what)))
    }

    /// What was learned, if it is of this type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.as_deref()?.downcast_ref()
    }
}
