//! What was measured, as far as the logic asks for it.

use crate::abduction::{AxiomId, Clash, Proposal};
use std::any::Any;
use std::collections::HashSet;
use std::fmt::{self, Debug};
use std::sync::Arc;

/// The measurements of a trace, from its first observation to the latest, and how they judge.
///
/// Laws: what is said of a proposal depends on the proposal, the assignments of its branch, and the measurements up
/// to the observation proposed for, on nothing else; so it is the same for every order of search. What was learned of
/// the branch ([`Branch::learned`](crate::abduction::Branch::learned)) counts among that, as it follows from the same.
/// An axiom speaks of one travel at a time: what a candidate was once found to obey it is not asked for again.
pub trait Evidence: Debug + Send + Sync {
    /// Whether a measured axiom holds of a child.
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool;

    /// Why a measured axiom does not hold of a child; asked for only where it does not.
    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash;

    /// What judging a child has taught that its own children can be judged by; asked for when all axioms hold of it, before
    /// another child is judged.
    fn learned(&self, proposal: &Proposal<'_>) -> Learned {
        let _ = proposal;
        Learned::default()
    }
}

/// Something that evidence has learned.
pub trait Lore: Any + Send + Sync {
    /// The bytes that it takes, beside parts whose addresses were counted before; adds those of its own that may be shared.
    fn bytes(&self, counted: &mut HashSet<usize>) -> usize;
}

/// What evidence has learned of a candidate, of which the logic knows nothing but whose it is. A clone shares it.
#[derive(Clone, Default)]
pub struct Learned(Option<Arc<dyn Lore>>);

impl Learned {
    /// Something learned.
    pub fn of(what: impl Lore) -> Learned {
        Learned(Some(Arc::new(what)))
    }

    /// What was learned, if it is of this type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        let what: &dyn Any = self.0.as_deref()?;
        what.downcast_ref()
    }

    /// The bytes that what was learned of some candidates takes, what they share counted once.
    pub(super) fn bytes(all: &[Learned]) -> usize {
        let mut counted = HashSet::new();
        let shared = all.iter().filter_map(|learned| learned.0.as_ref());
        let of = |what: &Arc<dyn Lore>| match counted.insert(Arc::as_ptr(what).addr()) {
            true => what.bytes(&mut counted),
            false => 0,
        };
        shared.map(of).sum()
    }
}

impl fmt::Debug for Learned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Learned(..)" } else { "Learned" })
    }
}
