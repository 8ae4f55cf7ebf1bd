//! One property for each axiom: it refutes exactly the candidates that break it.

use crate::engine::{explain, names, stories, with_and_without};
use crate::reference::{self, Story};
use crate::strategies::{lies, tangled_walks};
use proptest::prelude::*;
use topostar::abduction::{AxiomId, AxiomSet, REGISTRY, Visit};

/// A property of all traces.
pub(crate) type Property = fn(&[Visit]) -> Result<(), TestCaseError>;

/// The property of each axiom.
pub(crate) const PROPERTIES: &[(AxiomId, Property)] = &[
    (AxiomId::Determinism, a_gateway_has_one_far_end),
    (AxiomId::StarMatch, visits_to_a_place_see_one_star),
    (AxiomId::TravelMoves, a_travel_leads_to_another_place),
    (AxiomId::PathOrder, walking_on_no_place_comes_twice),
    (AxiomId::Planarity, crate::planarity::places_and_faces_are_two_more_than_segments),
    (AxiomId::Boundary, crate::boundary::paths_divide_left_from_right),
];

fn a_gateway_has_one_far_end(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::Determinism, visits)
}

fn visits_to_a_place_see_one_star(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::StarMatch, visits)
}

fn a_travel_leads_to_another_place(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::TravelMoves, visits)
}

fn walking_on_no_place_comes_twice(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::PathOrder, visits)
}

/// With the axiom, exactly those candidates are left that there are without it and that obey it. The engine cannot
/// do without an axiom that is built in; there the reference says what there is without it.
pub(crate) fn refutes_what_breaks_it(id: AxiomId, visits: &[Visit]) -> Result<(), TestCaseError> {
    let (with, without) = with_and_without(id);
    if with == without {
        return refutes_as_the_reference(id, with, visits);
    }
    let obeys = |story: &Story| reference::obeys(visits, story, id.name());
    let expected: Vec<Story> = stories(&explain(visits, without)).into_iter().filter(obeys).collect();
    prop_assert_eq!(stories(&explain(visits, with)), expected);
    Ok(())
}

/// Without the axiom the reference finds many more stories, so that only short traces can be judged.
fn refutes_as_the_reference(id: AxiomId, with: AxiomSet, visits: &[Visit]) -> Result<(), TestCaseError> {
    let visits = &visits[..visits.len().min(4)];
    let others: Vec<&str> = names(with).into_iter().filter(|name| *name != id.name()).collect();
    let all = reference::explanations(visits, &others, true);
    let expected: Vec<Story> =
        all.into_iter().filter(|story| reference::obeys(visits, story, id.name())).collect();
    prop_assert_eq!(stories(&explain(visits, with)), expected);
    Ok(())
}

#[test]
fn every_symbolic_axiom_has_one_property() {
    let ids: Vec<AxiomId> = PROPERTIES.iter().map(|(id, _)| *id).collect();
    let symbolic = REGISTRY.iter().filter(|axiom| !axiom.is_measured());
    assert_eq!(ids, symbolic.map(|axiom| axiom.id).collect::<Vec<_>>());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn axioms_refute_exactly_what_breaks_them(walk in tangled_walks(8), lies in lies(8)) {
        for (_, property) in PROPERTIES {
            property(crate::engine::affordable(&walk.visits, topostar::abduction::AxiomSet::built_in()))?;
            property(crate::engine::affordable(&lies, topostar::abduction::AxiomSet::built_in()))?;
        }
    }
}
