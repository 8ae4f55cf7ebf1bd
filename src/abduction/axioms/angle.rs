//! Axiom `angle`: its name and statement; what measurements say of it is judged behind [`crate::abduction::Evidence`].

use crate::abduction::axiom::{Axiom, AxiomId, Check, Profile};

pub(super) const AXIOM: Axiom = Axiom {
    id: AxiomId::Angle,
    name: "angle",
    statement: "Measured directions around one place agree within their bounds, and headings close around every loop.",
    source: "seed, section 3.2: local radial angles between paths at a place",
    profiles: &[Profile::Default],
    switchable: true,
    check: Check::Measures,
};
