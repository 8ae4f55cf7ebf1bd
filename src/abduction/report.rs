//! What an abduction has found.

use crate::abduction::{
    Assertion, AxiomId, AxiomSet, Candidate, Refutations, Settlement, Simplicity, Strategy, Word,
};
use crate::map::CanonicalMap;
use std::collections::BTreeSet;
use std::fmt;

/// The name, beside those of the axioms, under which the operator's word refutes.
pub const OPERATOR: &str = "operator";

/// The findings after some observations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// How many candidates explain all observations.
    pub candidates: Count,
    /// How many candidates explained all observations up to each.
    pub candidates_per_observation: Vec<Count>,
    /// How many maps were made: that of the first place, and each that a branch made and no axiom refuted. Travel
    /// over a known path segment makes none.
    pub maps_created: Count,
    /// How many candidates each axiom refuted, at least where the search is not complete.
    pub refuted: Refutations,
    /// The same for each observation.
    pub refuted_per_observation: Vec<Refutations>,
    /// The simplest candidates, all that are equally simple, by visits.
    pub minimal: Vec<Candidate>,
    /// How simple they are.
    pub simplicity: Option<Simplicity>,
    /// Whether one candidate is known to be simpler than all others.
    pub unique: bool,
    /// Whether no consistent map is known to be simpler than the minimal ones, or to tie with them unlisted.
    pub proven: bool,
    /// How candidates were searched.
    pub strategy: Strategy,
    /// How far the search for the simplest candidates came, under the strategy that has one.
    pub settlement: Option<Settlement>,
    /// The axioms asked for.
    pub asked: AxiomSet,
    /// The axioms in force: those asked for, without measured ones where nothing was measured.
    pub in_force: AxiomSet,
    /// Whether every candidate there is was kept.
    pub complete: bool,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// The operator's word in force.
    pub word: Word,
    /// What refuted the last candidates, if none is left.
    pub extinction: Option<Extinction>,
}

/// A count that says whether it is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Count {
    /// The number counted.
    pub value: u64,
    /// How it compares with the true one.
    pub relation: Relation,
}

/// How the true count compares with the number counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Relation {
    /// It is equal.
    Equal,
    /// It is equal or greater, as a limit cut the search.
    AtLeast,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopReason {
    /// All candidates were followed to the last observation.
    Exhausted,
    /// The simplest candidates are proven to be that; no others were followed.
    MinimumProven,
    /// The limit on steps ended the search for the simplest candidates.
    StepLimit,
    /// It was told to stop.
    Interrupted,
    /// The limit on candidates cut the search.
    CandidateLimit {
        /// The first observation at which it did; by the strategy that does not go by observations, the latest.
        observation: usize,
    },
    /// The limit on memory cut the search.
    MemoryLimit {
        /// The first observation at which it did; by the strategy that does not go by observations, the latest.
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
    /// The axioms that refuted the last candidates; none if the operator's word did.
    pub axioms: Vec<AxiomId>,
    /// The assertions that did, if the operator's word did: those that contradict each other, if some do, or else
    /// all in force.
    pub assertions: Vec<Assertion>,
}

impl Report {
    /// The number of different maps among the minimal ones, where the numbers of places and the visits do not
    /// count: two candidates may tell different stories of one map. Quadratic in the dstates of each.
    pub fn minimal_maps(&self) -> usize {
        let maps: BTreeSet<CanonicalMap> =
            self.minimal.iter().map(|candidate| CanonicalMap::of(&candidate.map)).collect();
        maps.len()
    }
}

impl StopReason {
    /// The observation it names.
    pub fn observation(self) -> Option<usize> {
        match self {
            StopReason::CandidateLimit { observation }
            | StopReason::MemoryLimit { observation }
            | StopReason::Inconsistent { observation } => Some(observation),
            _ => None,
        }
    }
}

impl Extinction {
    /// What refuted the last candidates, by the names used outside: axioms, or `operator`.
    pub fn names(&self) -> Vec<&'static str> {
        match self.assertions.is_empty() {
            true => self.axioms.iter().map(|axiom| axiom.name()).collect(),
            false => vec![OPERATOR],
        }
    }
}

impl fmt::Display for Extinction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.names().join(", ");
        write!(f, "observation {}; the last candidates were refuted by {names}", self.observation)?;
        if !self.assertions.is_empty() {
            let ids: Vec<String> = self.assertions.iter().map(|assertion| assertion.id.to_string()).collect();
            write!(f, ": retract one of the asserts with seq {}", ids.join(", "))?;
        }
        Ok(())
    }
}

impl Count {
    pub(super) fn new(value: u64, exact: bool) -> Count {
        Count { value, relation: if exact { Relation::Equal } else { Relation::AtLeast } }
    }
}
