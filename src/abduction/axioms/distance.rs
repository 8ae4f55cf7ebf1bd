//! Axiom `distance`: its name and statement; what measurements say of it is judged behind [`crate::abduction::Evidence`].

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Distance,
    name: "distance",
    statement: "Measured travel lengths along one path segment agree within their bounds.",
    source: "seed, section 3.2: bounds on the path distances between places",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Measures,
};
