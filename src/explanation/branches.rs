//! The candidates as a tree: what each observation was taken for, and where branches ended.

use crate::abduction::{Abduction, Assertion, Assignment, Refutation, proposed};
use std::ops::Range;

/// A beginning that some candidates have in common. Two nodes are the same exactly if observation and first candidate
/// are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// The last observation of the beginning.
    pub observation: usize,
    /// What that one is taken for.
    pub assignment: Assignment,
    /// The first of the candidates that begin so, by position.
    pub first: usize,
    /// How many candidates begin so.
    pub leaves: usize,
}

/// A child of a node that no candidate descends from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// What it takes the next observation for.
    pub assignment: Assignment,
    /// How it ended.
    pub ending: Ending,
}

/// How a branch ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// An axiom refutes it at this observation.
    Refuted(Refutation),
    /// The operator's word does not allow it: these assertions.
    Forbidden(Vec<Assertion>),
    /// Nothing speaks against it at this observation; what came of it was refuted, forbidden or cut later, or it was
    /// itself cut.
    Later,
}

/// The node that is the beginning of a candidate up to an observation. Logarithmic in the candidates, linear in the
/// observations.
pub fn node(abduction: &Abduction, observation: usize, candidate: usize) -> Option<Node> {
    let visits = abduction.candidate(candidate)?.visits;
    let beginning = visits.get(..=observation)?;
    let candidates = candidates_of(abduction, beginning);
    let assignment = *beginning.last()?;
    Some(Node { observation, assignment, first: candidates.start, leaves: candidates.len() })
}

/// The children of a node that candidates descend from, in the order of these. Every candidate of the node is one of
/// exactly one child's; the last observation has no children.
pub fn children(abduction: &Abduction, parent: &Node) -> Vec<Node> {
    let mut found = Vec::new();
    let mut first = parent.first;
    let end = parent.first + parent.leaves;
    while first < end {
        let Some(child) = node(abduction, parent.observation + 1, first) else { break };
        first = child.first + child.leaves;
        found.push(child);
    }
    found
}

/// The children of a node that the search proposed and that no candidate descends from, in the order of assignments,
/// each with how it ended. Found again on demand: linear in the proposals, times observations and map.
pub fn ended(abduction: &Abduction, parent: &Node) -> Vec<Ended> {
    let Some(candidate) = abduction.candidate(parent.first) else { return Vec::new() };
    let Some(beginning) = candidate.visits.get(..=parent.observation) else { return Vec::new() };
    // Candidates obey the axioms, and so do their beginnings.
    let proposed = proposed(abduction.visits(), abduction.evidence(), abduction.axioms(), beginning);
    let alive = children(abduction, parent);
    let is_alive = |assignment: Assignment| alive.iter().any(|child| child.assignment == assignment);
    let gone = proposed.unwrap_or_default().into_iter().filter(|child| !is_alive(child.assignment));
    let ended = |child: crate::abduction::Proposed| {
        let whole = [beginning, &[child.assignment]].concat();
        let broken = abduction.word().broken_by(&whole);
        let ending = match child.refutation {
            Some(refutation) => Ending::Refuted(refutation),
            None if broken.is_empty() => Ending::Later,
            None => Ending::Forbidden(broken),
        };
        Ended { assignment: child.assignment, ending }
    };
    gone.map(ended).collect()
}

/// The positions of the candidates with a beginning, which are next to each other.
pub(super) fn candidates_of(abduction: &Abduction, beginning: &[Assignment]) -> Range<usize> {
    let before = |index: usize, or_equal: bool| {
        abduction.candidate(index).is_some_and(|candidate| {
            let own = &candidate.visits[..beginning.len().min(candidate.visits.len())];
            own < beginning || or_equal && own == beginning
        })
    };
    let boundary = |or_equal: bool| {
        let (mut low, mut high) = (0, abduction.len());
        while low < high {
            let middle = low.midpoint(high);
            if before(middle, or_equal) { low = middle + 1 } else { high = middle }
        }
        low
    };
    boundary(false)..boundary(true)
}
