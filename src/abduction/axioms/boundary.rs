//! Axiom `boundary`, held hard. Held soft it refutes nothing and ranks: see [`crate::abduction::Simplicity`].

use crate::abduction::axiom::{Axiom, AxiomId, Check};
use crate::abduction::{Clash, Outcome, Proposal};
use crate::map::{Paths, Regions};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Boundary,
    name: "boundary",
    statement: "A path divides what is right of it from what is left: no place is on both sides, or on it and \
                beside it.",
    source: "Remolina and Kuipers, IJCAI-01: boundary regions, there a default",
    profiles: &[],
    switchable: true,
    check: Check::Symbols { holds, clash },
};

/// A new place cannot break what held before: it is on one path with the place left, which crosses every other path
/// once at most, or that path would have places beside it and on it; and on no path that has another place.
fn holds(proposal: &Proposal<'_>) -> bool {
    match proposal.outcome {
        Outcome::Closure { to } => proposal.branch.boundaries_kept(to),
        Outcome::Known { .. } | Outcome::NewPlace => true,
    }
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, map) = (proposal.branch, proposal.branch.map());
    let Outcome::Closure { to } = proposal.outcome else { return Clash::default() };
    let joined = map.joined(branch.from(), to);
    let Some(conflict) = Regions::of(&joined).conflicts().next() else { return Clash::default() };
    let paths = Paths::of(&joined);
    let on: Vec<String> = paths
        .iter()
        .filter(|path| path.id == conflict.path)
        .flat_map(|path| path.places())
        .map(|place| place.to_string())
        .collect();
    let crossings: Vec<_> = [Some(conflict.beside), conflict.right].into_iter().flatten().collect();
    let places = crossings.iter().map(|crossing| crossing.at).chain([conflict.place]).collect::<Vec<_>>();
    let sides = if conflict.right.is_some() { "left and right of" } else { "beside and on" };
    Clash {
        observations: branch.observations_of(&places),
        segments: vec![[branch.from(), to]],
        words: format!("place {} would be {sides} the path {}", conflict.place, on.join(" - ")),
        places,
    }
}
