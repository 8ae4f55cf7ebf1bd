//! Refutations found again: one example for each axiom, and what ended a branch that was refuted late.

use crate::abduction::{Abduction, Assignment, AxiomId, Refutation, proposed};
use std::collections::{BTreeMap, VecDeque};

/// The most beginnings looked at.
const BEGINNINGS: usize = 2000;

/// What refuted the last of all that came of a beginning, which obeys the axioms itself. None if something of it has
/// come to the last observation, or if there is more of it than is looked at. Linear as [`examples`].
pub(super) fn last_refutation(abduction: &Abduction, beginning: Vec<Assignment>) -> Option<Refutation> {
    let mut last: Option<Refutation> = None;
    let mut open = vec![beginning];
    for _ in 0..BEGINNINGS {
        let Some(beginning) = open.pop() else { return last };
        if beginning.len() == abduction.observations() {
            return None;
        }
        let children = proposed(abduction.visits(), abduction.evidence(), abduction.axioms(), &beginning);
        for child in children.unwrap_or_default() {
            match child.refutation {
                Some(refutation) => {
                    if last.as_ref().is_none_or(|last| last.observation < refutation.observation) {
                        last = Some(refutation);
                    }
                }
                None => open.push([beginning.as_slice(), &[child.assignment]].concat()),
            }
        }
    }
    None
}

/// For axioms that refuted something, one refutation each, as near to the candidate at a position as can be: along it,
/// or else along what branched off it, breadth-first, also where no candidate is left of that. Beyond a bound of
/// beginnings nothing is looked at, so that an axiom may have none. Linear in the proposals of so many beginnings,
/// times observations and map.
pub fn examples(abduction: &Abduction, candidate: usize) -> BTreeMap<AxiomId, Refutation> {
    let mut found = BTreeMap::new();
    let Some(own) = abduction.candidate(candidate) else { return found };
    let wanted = abduction.report().refuted.iter().count();
    let along = 1..own.visits.len();
    let mut open: VecDeque<Vec<Assignment>> = along.map(|seen| own.visits[..seen].to_vec()).collect();
    for _ in 0..BEGINNINGS {
        let Some(beginning) = open.pop_front().filter(|_| found.len() < wanted) else { break };
        let children = proposed(abduction.visits(), abduction.evidence(), abduction.axioms(), &beginning);
        for child in children.unwrap_or_default() {
            let whole = [beginning.as_slice(), &[child.assignment]].concat();
            match child.refutation {
                Some(refutation) => {
                    found.entry(refutation.axiom).or_insert(refutation);
                }
                None if own.visits.starts_with(&whole) => {}
                None => open.push_back(whole),
            }
        }
    }
    found
}
