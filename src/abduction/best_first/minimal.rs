//! The simplest candidates found.

use crate::abduction::search::BYTES_OF_DSTATE;
use crate::abduction::{Assignment, Candidate, Simplicity};
use std::collections::BTreeSet;

/// The simplest candidates found.
#[derive(Clone, Debug, Default)]
pub(in crate::abduction) struct Minimal {
    simplicity: Option<Simplicity>,
    candidates: BTreeSet<Vec<Assignment>>,
    cut: bool,
}

impl Minimal {
    /// How simple they are.
    pub(in crate::abduction) fn simplicity(&self) -> Option<Simplicity> {
        self.simplicity
    }

    /// Their assignments, in order.
    pub(in crate::abduction) fn candidates(&self) -> &BTreeSet<Vec<Assignment>> {
        &self.candidates
    }

    /// Whether some as simple were left out.
    pub(in crate::abduction) fn is_cut(&self) -> bool {
        self.cut
    }

    /// Whether none of them is known, or they are no simpler than a bound.
    pub(in crate::abduction) fn allows(&self, bound: Simplicity) -> bool {
        self.simplicity.is_none_or(|least| bound <= least)
    }

    /// Bytes of them as assignments and, on a walk of so many dstates, as maps that share nothing, at most.
    pub(in crate::abduction) fn bytes(&self, dstates: usize) -> usize {
        let visits = self.candidates.first().map_or(0, Vec::len);
        let map = size_of::<Candidate>() + dstates * BYTES_OF_DSTATE;
        self.candidates.len() * (2 * visits * size_of::<Assignment>() + map)
    }

    /// Keeps a candidate if no simpler one is known; of more than the limit the first.
    pub(in crate::abduction) fn keep(
        &mut self,
        simplicity: Simplicity,
        assignments: Vec<Assignment>,
        limit: Option<usize>,
    ) {
        if self.simplicity.is_none_or(|least| simplicity < least) {
            *self = Minimal { simplicity: Some(simplicity), ..Minimal::default() };
        }
        if self.simplicity == Some(simplicity) {
            self.candidates.insert(assignments);
        }
        if limit.is_some_and(|limit| self.candidates.len() > limit) {
            self.cut = true;
            self.candidates.pop_last();
        }
    }
}
