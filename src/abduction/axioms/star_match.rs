//! Axiom `star-match`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Clash, Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::StarMatch,
    name: "star-match",
    statement: "Two visits are to one place only under a rotation that lays one star onto the other with \
                order, pairing, control laws and navigability kept; a known path segment fixes the rotation.",
    source: "seed, sections 4.3 and 4.4",
    profiles: STAR_PROFILES,
    switchable: false,
    check: Check::Symbols { holds, clash },
};

fn holds(proposal: &Proposal<'_>) -> bool {
    !matches!(proposal.outcome, Outcome::Known { matches: false, .. })
}

fn clash(proposal: &Proposal<'_>) -> Clash {
    let (branch, map) = (proposal.branch, proposal.branch.map());
    let Outcome::Known { to, .. } = proposal.outcome else { return Clash::default() };
    let difference = map.star(to.place).difference(branch.seen(), proposal.assignment.rotation);
    let what = difference.map_or_else(String::new, |difference| format!(": {difference}"));
    Clash {
        observations: branch.observations_of(&[branch.from().place, to.place]),
        places: vec![to.place],
        segments: vec![[branch.from(), to]],
        words: format!(
            "gateway {} is known to lead to {to}, but what was seen is not place {}{what}",
            branch.from(),
            to.place
        ),
    }
}
