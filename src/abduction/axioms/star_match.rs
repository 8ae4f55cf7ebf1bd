//! Axiom `star-match`.

use crate::abduction::axiom::{Axiom, AxiomId, Check, STAR_PROFILES};
use crate::abduction::{Outcome, Proposal};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::StarMatch,
    name: "star-match",
    statement: "Two visits are to one place only under a rotation that lays one star onto the other with \
                order, pairing, control laws and navigability kept; a known path segment fixes the rotation.",
    source: "seed, sections 4.3 and 4.4",
    profiles: STAR_PROFILES,
    switchable: false,
    check: Check::Symbols(holds),
};

fn holds(proposal: &Proposal<'_>) -> bool {
    !matches!(proposal.outcome, Outcome::Known { matches: false, .. })
}
