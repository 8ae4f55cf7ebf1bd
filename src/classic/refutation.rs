//! How many maps each axiom refuted.

use crate::classic::{AXIOMS, AxiomId};

/// Refuted maps, counted by the axiom that refuted them: the first in the order of [`AXIOMS`] that does not hold.
///
/// `view` is counted where a known schema leads to a dstate with another view: the map is discarded. A dstate with
/// another view is never proposed for a new schema, so never refuted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refutations {
    counts: [u64; AXIOMS.len()],
}

impl Refutations {
    /// How many this axiom refuted.
    pub fn by(&self, id: AxiomId) -> u64 {
        self.counts[id as usize]
    }

    /// All axioms that refuted a map, and how many each, in the order of [`AXIOMS`].
    pub fn iter(&self) -> impl Iterator<Item = (AxiomId, u64)> {
        AXIOMS.iter().map(|axiom| (axiom.id, self.by(axiom.id))).filter(|&(_, count)| count > 0)
    }

    pub(super) fn count(&mut self, id: AxiomId) {
        self.counts[id as usize] += 1;
    }
}

impl std::iter::Sum for Refutations {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Refutations::default(), |mut sum, one| {
            sum.counts.iter_mut().zip(one.counts).for_each(|(total, count)| *total += count);
            sum
        })
    }
}
