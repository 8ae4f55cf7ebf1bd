//! Axiom `path-order`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Clash, Outcome, Proposal};
use crate::map::{PlaceId, path_from_end};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::PathOrder,
    name: "path-order",
    statement: "The places on a path are strictly ordered: no place is twice on a path, no path is closed, \
                and two path fragments of a place are never on one path.",
    source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: order along a path",
    profiles: STAR_PROFILES,
    switchable: true,
    check: Check::Symbols { holds, clash },
};

fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.paths_apart(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, map) = (proposal.branch, proposal.branch.map());
    let (Outcome::Closure { to }, from) = (proposal.outcome, branch.from()) else { return Clash::default() };
    let mut come: Vec<PlaceId> = path_from_end(map, from).collect();
    come.reverse();
    let on: Vec<PlaceId> = path_from_end(map, to).collect();
    let twice: Vec<PlaceId> = come.iter().copied().filter(|place| on.contains(place)).collect();
    let [first, second] =
        [&come, &on].map(|places| places.iter().map(PlaceId::to_string).collect::<Vec<String>>().join(" - "));
    let again = twice.first().copied().unwrap_or(to.place);
    Clash {
        observations: branch.observations_of(&[come.as_slice(), on.as_slice()].concat()),
        segments: vec![[from, to]],
        words: format!(
            "the path {first} would go on as {second}, so that place {again} would be on it twice"
        ),
        places: twice,
    }
}
