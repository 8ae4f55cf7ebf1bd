//! Axiom `apart`: its name and statement; what measurements say of it is judged behind [`crate::abduction::Evidence`].

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Apart,
    name: "apart",
    statement: "Two places do not lie on one spot, path segments meet at places alone, and all have room at once, where their relative positions are known well enough to say so.",
    source: "seed, section 2.1: a place is a neighbourhood with bounds",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Measures,
};
