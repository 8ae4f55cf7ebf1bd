//! Axiom `boundary`, held hard. Held soft it refutes nothing and ranks: see [`crate::abduction::Simplicity`].

use crate::abduction::axiom::{Axiom, AxiomId, Check};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Boundary,
    name: "boundary",
    statement: "A path divides what is right of it from what is left: no place is on both sides, or on it and \
                beside it.",
    source: "Remolina and Kuipers, IJCAI-01: boundary regions, there a default",
    profiles: &[],
    switchable: true,
    check: Check::Symbols(holds),
};

/// A new place cannot break what held before: it is on one path with the place left, which crosses every other path
/// once at most, or that path would have places beside it and on it; and on no path that has another place.
fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.boundaries_kept(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}
