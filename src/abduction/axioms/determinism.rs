//! Axiom `determinism`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Determinism,
    name: "determinism",
    statement: "The same travel leads from the same dstate to the same dstate: a gateway has one far end, \
                another gateway, and travelling back through that one returns.",
    source: "seed, section 3.1; Remolina and Kuipers, IJCAI-01: causal schemas are deterministic",
    profiles: STAR_PROFILES,
    switchable: false,
    check: Check::Symbols(holds),
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.map().far_end(to).is_none(),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}
