//! How many candidates each axiom refuted.

use crate::abduction::{AxiomId, REGISTRY};

/// Refuted candidates, counted by the axiom that refuted them: the first in the order of the registry that does
/// not hold.
///
/// `star-match` is counted only where a known path segment leads to a star that does not match. Closures to places
/// whose stars have no alignment with the one observed are never proposed, so never refuted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refutations {
    counts: [u64; REGISTRY.len()],
    operator: u64,
}

impl Refutations {
    /// How many this axiom refuted.
    pub fn by(&self, id: AxiomId) -> u64 {
        self.counts[id as usize]
    }

    /// How many the operator's word refuted, which is no axiom.
    pub fn by_operator(&self) -> u64 {
        self.operator
    }

    /// All axioms that refuted a candidate, and how many each, in the order of the registry.
    pub fn iter(&self) -> impl Iterator<Item = (AxiomId, u64)> {
        REGISTRY.iter().map(|axiom| (axiom.id, self.by(axiom.id))).filter(|&(_, count)| count > 0)
    }

    /// How many in all, by axioms and the operator's word.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum::<u64>() + self.operator
    }

    /// One refutation.
    pub(super) fn of(id: AxiomId) -> Refutations {
        let mut refuted = Refutations::default();
        refuted.count(id);
        refuted
    }

    pub(super) fn count(&mut self, id: AxiomId) {
        self.counts[id as usize] += 1;
    }

    pub(super) fn count_operator(&mut self, count: u64) {
        self.operator += count;
    }
}

impl std::iter::Sum for Refutations {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Refutations::default(), |mut sum, one| {
            sum.operator += one.operator;
            sum.counts.iter_mut().zip(one.counts).for_each(|(total, count)| *total += count);
            sum
        })
    }
}
