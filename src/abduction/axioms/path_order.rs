//! Axiom `path-order`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::PathOrder,
    name: "path-order",
    statement: "The places on a path are strictly ordered: no place is twice on a path, no path is closed, \
                and two path fragments of a place are never on one path.",
    source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: order along a path",
    profiles: STAR_PROFILES,
    switchable: true,
    check: Check::Symbols(holds),
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.paths_apart(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}
