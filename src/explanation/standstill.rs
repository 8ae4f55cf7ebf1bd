//! Why no candidate goes on at an observation.

use crate::abduction::{Abduction, Assignment, AxiomId, Refutation, proposed};
use crate::explanation::travels::first_visit;
use crate::star::{LargeScaleStar, SlotIndex, StarDifference};

/// What an observation could have been taken for, and what refutes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dissent {
    /// What it was taken for.
    pub assignment: Assignment,
    /// Why it cannot be that.
    pub refutation: Refutation,
    /// Where a known segment led to a place that looked otherwise: the slots, by observation, of which one must have
    /// been read wrongly if it is the place. Empty for other refutations.
    pub slots: Vec<(usize, SlotIndex)>,
}

/// Everything that the search proposed for the observation after a beginning and an axiom refuted, in the order of
/// assignments. As long as judging the beginning and each proposal.
pub fn standstill(abduction: &Abduction, beginning: &[Assignment]) -> Vec<Dissent> {
    let found = proposed(abduction.visits(), abduction.evidence(), abduction.axioms(), beginning);
    let dissent = |proposed: crate::abduction::Proposed| {
        let refutation = proposed.refutation?;
        let slots = match refutation.axiom {
            AxiomId::StarMatch => misread(abduction, beginning, proposed.assignment),
            _ => Vec::new(),
        };
        Some(Dissent { assignment: proposed.assignment, refutation, slots })
    };
    found.unwrap_or_default().into_iter().filter_map(dissent).collect()
}

/// The slots that differ first under an assignment, on the first visit to the place and at the observation; all of
/// both where their number differs.
fn misread(
    abduction: &Abduction,
    beginning: &[Assignment],
    Assignment { place, rotation }: Assignment,
) -> Vec<(usize, SlotIndex)> {
    let seen = beginning.len();
    let visits = abduction.visits();
    let (Some(first), Some(visit)) = (first_visit(beginning, place), visits.get(seen)) else {
        return Vec::new();
    };
    let (here, there) = (&visits[first].star, &visit.star);
    let all = |visit: usize, star: &LargeScaleStar| {
        (0..star.size()).map(move |slot| (visit, SlotIndex(slot as u8))).collect::<Vec<_>>()
    };
    match here.difference(there, rotation) {
        Some(StarDifference::Slot { slot, .. }) => {
            let n = here.size();
            let turned = (usize::from(slot.0) + n - usize::from(rotation) % n) % n;
            vec![(first, slot), (seen, SlotIndex(turned as u8))]
        }
        Some(StarDifference::Size { .. }) => [all(first, here), all(seen, there)].concat(),
        None => Vec::new(),
    }
}
