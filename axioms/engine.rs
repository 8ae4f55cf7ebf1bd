//! The engine under test, in the words of the reference.

use crate::reference::Story;
use topostar::abduction::{Abduction, AxiomId, AxiomSet, Candidate, Limits, Profile, REGISTRY, Visit};

/// All observations of a trace, without limits.
pub(crate) fn explain(visits: &[Visit], axioms: AxiomSet) -> Abduction {
    let mut abduction = Abduction::new(axioms, Limits::default());
    for visit in visits {
        abduction.observe(visit).unwrap();
    }
    abduction
}

pub(crate) fn story(candidate: &Candidate) -> Story {
    candidate.visits.iter().map(|visit| (visit.place.index(), visit.rotation as usize)).collect()
}

pub(crate) fn stories(abduction: &Abduction) -> Vec<Story> {
    abduction.candidates().map(|candidate| story(&candidate)).collect()
}

pub(crate) fn names(axioms: AxiomSet) -> Vec<&'static str> {
    axioms.without_measured().iter().map(|axiom| axiom.name).collect()
}

/// Both profiles, and every axiom that can be switched alone off or added, and alone on.
pub(crate) fn axiom_sets() -> Vec<AxiomSet> {
    let mut sets = vec![AxiomSet::built_in()];
    sets.extend(Profile::ALL.map(AxiomSet::of));
    for axiom in REGISTRY.iter().filter(|axiom| axiom.switchable && !axiom.is_measured()) {
        sets.push(AxiomSet::built_in().with(axiom.id));
        let default = AxiomSet::of(Profile::Default);
        sets.push(if default.contains(axiom.id) {
            default.without(axiom.id).unwrap()
        } else {
            default.with(axiom.id)
        });
    }
    sets
}

/// The longest beginning of a trace that the reference can afford to enumerate.
pub(crate) fn affordable(visits: &[Visit], axioms: AxiomSet) -> &[Visit] {
    let few = |length: &usize| explain(&visits[..*length], axioms).len() <= 120;
    &visits[..(1..=visits.len()).take_while(few).last().unwrap_or(1)]
}

/// Default with the axiom, default without it if that can be.
pub(crate) fn with_and_without(id: AxiomId) -> (AxiomSet, AxiomSet) {
    let with = AxiomSet::of(Profile::Default).with(id);
    (with, with.without(id).unwrap_or(with))
}
