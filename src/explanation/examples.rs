//! One example of what each axiom refuted.

use crate::abduction::{Abduction, AxiomId, Candidate, Refutation, proposed};
use std::collections::BTreeMap;

/// The most beginnings looked at.
const BEGINNINGS: usize = 2000;

/// For axioms that refuted something, one refutation: the first that is met along the candidate at a position, or else
/// along the others in their order. Branches of which no candidate is left, and those beyond a bound, are not looked
/// at, so that an axiom may have none. Linear in the proposals of so many beginnings, times observations and map.
pub fn examples(abduction: &Abduction, candidate: usize) -> BTreeMap<AxiomId, Refutation> {
    let refuted = abduction.report().refuted;
    let wanted = refuted.iter().count();
    let mut found = BTreeMap::new();
    let mut beginnings = 0;
    let mut before: Option<Candidate> = None;
    for own in abduction.candidate(candidate).into_iter().chain(abduction.candidates()) {
        let shared = before.as_ref().map_or(0, |before| shared(before, &own));
        for observations in shared.max(1)..own.visits.len() {
            if found.len() == wanted || beginnings == BEGINNINGS {
                return found;
            }
            beginnings += 1;
            let beginning = &own.visits[..observations];
            let children = proposed(abduction.visits(), abduction.evidence(), abduction.axioms(), beginning);
            for refutation in children.unwrap_or_default().into_iter().filter_map(|child| child.refutation) {
                found.entry(refutation.axiom).or_insert(refutation);
            }
        }
        before = Some(own);
    }
    found
}

/// How many of their beginnings two candidates share, so that these need not be looked at twice.
fn shared(before: &Candidate, own: &Candidate) -> usize {
    let pairs = before.visits.iter().zip(&own.visits);
    pairs.take_while(|(one, other)| one == other).count() + 1
}
