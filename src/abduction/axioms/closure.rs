//! Axiom `closure`: its name and statement; what measurements say of it is judged behind [`crate::abduction::Evidence`].

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Closure,
    name: "closure",
    statement: "Displacements composed around a loop of the map return to where they began, within the bound of their accumulated uncertainty.",
    source: "seed, section 2.3: local displacements on the topological map",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Measures,
};
