//! Axiom `travel-moves`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::TravelMoves,
    name: "travel-moves",
    statement: "A travel leads to another place.",
    source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: travel goes along a path to a later place",
    profiles: STAR_PROFILES,
    switchable: true,
    check: Check::Symbols(holds),
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => to.place != proposal.branch.from().place,
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}
