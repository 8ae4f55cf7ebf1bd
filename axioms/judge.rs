//! Judging a given assignment step by step is what the search does with it.

use crate::engine::{affordable, explain, stories};
use crate::strategies::{lies, tangled_walks};
use proptest::prelude::*;
use topostar::abduction::{Assignment, AxiomSet, Candidate, Profile, Visit, judge};
use topostar::map::PlaceId;

fn assignments(drawn: &[(usize, u8)]) -> Vec<Assignment> {
    let assignment = |&(place, rotation)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
    drawn.iter().map(assignment).collect()
}

fn judges_as_the_search(
    visits: &[Visit],
    axioms: AxiomSet,
    assignments: &[Assignment],
) -> Result<(), TestCaseError> {
    let visits = &visits[..visits.len().min(assignments.len())];
    let assignments = &assignments[..visits.len()];
    let found = explain(visits, axioms).candidates().find(|candidate| candidate.visits == assignments);
    match judge(visits, None, axioms, assignments) {
        Ok(judged) => prop_assert_eq!(judged, found),
        Err(refutation) => {
            prop_assert_eq!(found, None);
            let observation = refutation.observation;
            let begun = |candidate: Candidate| candidate.visits == assignments[..observation];
            prop_assert!(observation == 0 || explain(&visits[..observation], axioms).candidates().any(begun));
            let report = explain(&visits[..=observation], axioms).report();
            let counted = report.refuted_per_observation[observation].by(refutation.axiom) > 0;
            prop_assert!(counted || !refutation.axiom.axiom().switchable, "{:?}", refutation);
            prop_assert!(!refutation.clash.words.is_empty());
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn candidates_of_fewer_axioms_are_judged_by_all(walk in tangled_walks(8), lies in lies(8)) {
        for visits in [&walk.visits, &lies] {
            let visits = affordable(visits, AxiomSet::built_in());
            let axioms = AxiomSet::of(Profile::Default);
            let left = stories(&explain(visits, axioms));
            for candidate in explain(visits, AxiomSet::built_in()).candidates() {
                let kept = left.contains(&crate::engine::story(&candidate));
                prop_assert_eq!(judge(visits, None, axioms, &candidate.visits).is_ok(), kept);
                judges_as_the_search(visits, axioms, &candidate.visits)?;
            }
        }
    }

    #[test]
    fn any_assignment_is_judged(
        walk in tangled_walks(6),
        drawn in prop::collection::vec((0usize..4, 0u8..5), 0..6),
        known in 0usize..6,
    ) {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let begun = walk.truth.iter().map(|&(place, rotation)| (place, rotation as u8)).take(known);
        let story: Vec<(usize, u8)> = begun.chain(drawn).collect();
        judges_as_the_search(visits, axioms, &assignments(&story))?;
    }
}
