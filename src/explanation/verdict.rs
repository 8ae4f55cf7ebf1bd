//! What became of any assignment: kept, cut, forbidden, or refuted, and then by what.

use crate::abduction::{Abduction, Assertion, Assignment, Refutation, judge};
use crate::explanation::branches::candidates_of;

/// What became of an assignment of all observations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is the candidate at this position.
    Kept(usize),
    /// An axiom refutes it.
    Refuted(Refutation),
    /// The axioms allow it, the operator's word does not: these assertions.
    Forbidden(Vec<Assertion>),
    /// Nothing refutes it: a limit cut it, or a beginning of it.
    Cut,
}

/// What became of an assignment; none unless it assigns every observation. Linear in observations times map.
///
/// Law: it is kept exactly if it is among the candidates, and cut only where the search is not complete.
pub fn verdict(abduction: &Abduction, assignments: &[Assignment]) -> Option<Verdict> {
    if assignments.len() != abduction.observations() || assignments.is_empty() {
        return None;
    }
    let kept = candidates_of(abduction, assignments);
    if !kept.is_empty() {
        return Some(Verdict::Kept(kept.start));
    }
    if let Err(refutation) = judge(abduction.visits(), abduction.evidence(), abduction.axioms(), assignments)
    {
        return Some(Verdict::Refuted(refutation));
    }
    let broken = abduction.word().broken_by(assignments);
    Some(if broken.is_empty() { Verdict::Cut } else { Verdict::Forbidden(broken) })
}
