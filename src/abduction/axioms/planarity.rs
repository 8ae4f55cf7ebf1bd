//! Axiom `planarity`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};
use crate::abduction::{Clash, Outcome, Proposal};
use crate::map::{DstateId, PlaceId, face_segments};
use std::collections::BTreeSet;

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Planarity,
    name: "planarity",
    statement: "The rotation system of travelled path segments has genus 0.",
    source: "Savelli and Kuipers, IROS 2004",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Symbols { holds, clash },
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.one_face(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, map) = (proposal.branch, proposal.branch.map());
    let (Outcome::Closure { to }, from) = (proposal.outcome, branch.from()) else { return Clash::default() };
    let segments: BTreeSet<[DstateId; 2]> = face_segments(map, from).collect();
    let around: BTreeSet<PlaceId> = segments.iter().flatten().map(|end| end.place).collect();
    let named: Vec<String> = around.iter().map(PlaceId::to_string).collect();
    let around: Vec<PlaceId> = around.into_iter().chain([to.place]).collect();
    let places: BTreeSet<PlaceId> = [from.place, to.place].into();
    Clash {
        observations: branch.observations_of(&around),
        places: places.into_iter().collect(),
        segments: segments.into_iter().chain([[from, to]]).collect(),
        words: format!(
            "gateways {from} and {to} lie in different faces: a travel between them would cross the way around \
             the face of {from}, which is along places {}",
            named.join(", ")
        ),
    }
}
