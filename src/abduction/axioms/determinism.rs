//! Axiom `determinism`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Clash, Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Determinism,
    name: "determinism",
    statement: "The same travel leads from the same dstate to the same dstate: a gateway has one far end, \
                another gateway, and travelling back through that one returns.",
    source: "seed, section 3.1; Remolina and Kuipers, IJCAI-01: causal schemas are deterministic",
    profiles: STAR_PROFILES,
    switchable: false,
    check: Check::Symbols { holds, clash },
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.map().far_end(to).is_none(),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, map) = (proposal.branch, proposal.branch.map());
    let (Outcome::Closure { to }, from) = (proposal.outcome, branch.from()) else { return Clash::default() };
    let far = map.far_end(to).unwrap_or(to);
    let places = vec![from.place, to.place, far.place];
    Clash {
        observations: branch.observations_of(&places),
        words: format!("gateway {to} is known to lead to {far}, so it cannot lead to {from} too"),
        segments: vec![[to, far], [from, to]],
        places,
    }
}
