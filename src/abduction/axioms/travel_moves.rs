//! Axiom `travel-moves`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Clash, Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::TravelMoves,
    name: "travel-moves",
    statement: "A travel leads to another place.",
    source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: travel goes along a path to a later place",
    profiles: STAR_PROFILES,
    switchable: true,
    check: Check::Symbols { holds, clash },
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => to.place != proposal.branch.from().place,
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, place) = (proposal.branch, proposal.assignment.place);
    let now = branch.visits().len();
    Clash {
        observations: (now.saturating_sub(1)..=now).collect(),
        places: vec![place],
        segments: Vec::new(),
        words: format!("the travel by gateway {} would end at place {place}, where it began", branch.from()),
    }
}
