//! What a search has found.

use crate::abduction::{Count, Relation};
use crate::classic::canonical::canonical;
use crate::classic::{AxiomId, Candidate, Refutations, Simplicity};
use std::collections::BTreeSet;

/// What a search has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// How many candidates explain all observations.
    pub candidates: Count,
    /// How many candidates explained the observations up to each.
    pub candidates_per_observation: Vec<Count>,
    /// How many maps were made, each by one step of branching, the first map among them.
    pub maps_created: Count,
    /// How many of them were made to explain each observation.
    pub created_per_observation: Vec<Count>,
    /// How many maps each axiom refuted, at least where the search is not complete.
    pub refuted: Refutations,
    /// The simplest candidates found, by assignment.
    pub minimal: Vec<Candidate>,
    /// How simple they are.
    pub simplicity: Option<Simplicity>,
    /// Whether one candidate is known to be simpler than all others.
    pub unique: bool,
    /// Whether no consistent map is known to be simpler than the minimal ones.
    pub proven: bool,
    /// Whether every candidate there is was followed.
    pub complete: bool,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// What refuted the last candidates, if there is none.
    pub extinction: Option<Extinction>,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopReason {
    /// All candidates were followed to the last observation.
    Exhausted,
    /// A map was found that explains everything; others were not followed.
    Found,
    /// The simplest maps are proven to be that; others were not followed.
    MinimumProven,
    /// The limit cut the search.
    Limit {
        /// The first observation at which it did.
        observation: usize,
    },
    /// No candidate was left, and none had been cut: the axioms do not allow the trace.
    Inconsistent {
        /// The observation that nothing explains.
        observation: usize,
    },
}

/// The end of all candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extinction {
    /// The observation that nothing explains.
    pub observation: usize,
    /// The axioms that refuted the last candidates.
    pub axioms: Vec<AxiomId>,
}

impl Report {
    /// The number of different maps among the minimal ones, where the numbers of dstates do not count. Quadratic in
    /// the dstates of each.
    pub fn minimal_maps(&self) -> usize {
        self.minimal.iter().map(|candidate| canonical(&candidate.map)).collect::<BTreeSet<_>>().len()
    }
}

/// What a search counts for one observation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// Candidates that explain all up to it.
    pub(super) candidates: u64,
    /// Maps made to explain it.
    pub(super) made: u64,
    /// Maps refuted by it.
    pub(super) refuted: Refutations,
}

/// A number that is the true one, or no more than it.
pub(super) fn count(value: u64, exact: bool) -> Count {
    Count { value, relation: if exact { Relation::Equal } else { Relation::AtLeast } }
}

impl Report {
    /// From the counts of a search whose numbers are true up to the first inexact observation. `unique` and
    /// `proven` are those of a search that followed all it should.
    pub(super) fn new(tallies: &[Tally], exact: &dyn Fn(usize) -> bool, minimal: Vec<Candidate>) -> Report {
        let complete = (0..tallies.len()).all(exact);
        let counts = |value: fn(&Tally) -> u64| {
            let numbered = tallies.iter().enumerate();
            numbered.map(|(observation, tally)| count(value(tally), exact(observation))).collect()
        };
        let last = tallies.last().map_or(0, |tally| tally.candidates);
        let gone = tallies.iter().position(|tally| tally.candidates == 0).filter(|_| complete);
        Report {
            candidates: count(last, complete),
            candidates_per_observation: counts(|tally| tally.candidates),
            maps_created: count(tallies.iter().map(|tally| tally.made).sum(), complete),
            created_per_observation: counts(|tally| tally.made),
            refuted: tallies.iter().map(|tally| tally.refuted).sum(),
            simplicity: minimal.first().map(|candidate| candidate.map.simplicity()),
            unique: complete && minimal.len() == 1,
            proven: complete,
            minimal,
            complete,
            stop_reason: match gone {
                Some(observation) => StopReason::Inconsistent { observation },
                None => StopReason::Exhausted,
            },
            extinction: gone.map(|observation| Extinction {
                observation,
                axioms: tallies[observation].refuted.iter().map(|(axiom, _)| axiom).collect(),
            }),
        }
    }
}
