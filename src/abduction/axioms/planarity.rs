//! Axiom `planarity`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Planarity,
    name: "planarity",
    statement: "The rotation system of travelled path segments has genus 0.",
    source: "Savelli and Kuipers, IROS 2004",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Symbols(holds),
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.one_face(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}
