//! The search finds all maps and only these, one observation at a time.

use crate::engine::{affordable, axiom_sets, explain, names, stories, story};
use crate::reference::{self, DEFAULT, PAPER, Story};
use crate::strategies::{grid_walks, lies, relist, relistings, tangled_walks};
use proptest::prelude::*;
use std::collections::BTreeSet;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Relation, StopReason, Visit, VisitError};
use topostar::map::DstateId;
use topostar::star::SlotIndex;

fn agrees_with_the_reference(visits: &[Visit]) -> Result<(), TestCaseError> {
    for axioms in axiom_sets() {
        let visits = affordable(visits, axioms);
        let found = explain(visits, axioms);
        prop_assert_eq!(stories(&found), reference::explanations(visits, &names(axioms), true));
        for candidate in found.candidates() {
            let end = |dstate: DstateId| (dstate.place.index(), dstate.slot.0 as usize);
            let segments = candidate.map.segments().into_iter().map(|it| (end(it.ends[0]), end(it.ends[1])));
            let segments: BTreeSet<_> = segments.collect();
            prop_assert_eq!(segments, reference::segments(visits, &story(&candidate)));
        }
    }
    Ok(())
}

#[test]
fn profiles_are_those_of_the_reference() {
    assert_eq!(names(AxiomSet::of(Profile::Paper)), PAPER);
    assert_eq!(names(AxiomSet::of(Profile::Default)), DEFAULT);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn candidates_are_those_of_the_reference(walk in tangled_walks(8), lies in lies(8)) {
        agrees_with_the_reference(&walk.visits)?;
        agrees_with_the_reference(&lies)?;
    }

    #[test]
    fn candidates_on_grids_are_those_of_the_reference(walk in grid_walks(14)) {
        for profile in Profile::ALL {
            let axioms = AxiomSet::of(profile);
            let visits = affordable(&walk.visits, axioms);
            let expected = reference::explanations(visits, &names(axioms), true);
            prop_assert_eq!(stories(&explain(visits, axioms)), expected);
        }
    }

    #[test]
    fn pruning_changes_nothing(walk in tangled_walks(3), lies in lies(4)) {
        for visits in [walk.visits, lies] {
            let all = reference::explanations(&visits, &DEFAULT, false);
            prop_assert_eq!(all, reference::explanations(&visits, &DEFAULT, true));
        }
    }

    #[test]
    fn the_truth_is_a_candidate_if_it_obeys(tangled in tangled_walks(8), grid in grid_walks(16)) {
        let axioms = AxiomSet::of(Profile::Default);
        for walk in [tangled, grid.clone()] {
            let visits = affordable(&walk.visits, axioms);
            let truth: Story = walk.truth[..visits.len()].to_vec();
            let obeys = DEFAULT.iter().all(|law| reference::obeys(visits, &truth, law));
            prop_assert_eq!(stories(&explain(visits, axioms)).contains(&truth), obeys);
        }
        prop_assert!(DEFAULT.iter().all(|law| reference::obeys(&grid.visits, &grid.truth, law)));
    }

    #[test]
    fn candidates_extend_candidates(walk in tangled_walks(8), lies in lies(8)) {
        for axioms in axiom_sets() {
            for visits in [affordable(&walk.visits, axioms), affordable(&lies, axioms)] {
                let mut abduction = Abduction::new(axioms, Limits::default());
                let mut before: Vec<Story> = vec![vec![]];
                for (index, visit) in visits.iter().enumerate() {
                    let snapshot = abduction.clone();
                    abduction.observe(visit).unwrap();
                    let now = stories(&abduction);
                    prop_assert!(now.is_sorted());
                    prop_assert!(now.iter().all(|story| before.contains(&story[..index].to_vec())));
                    // A snapshot stays as it was, and what was observed bit by bit is as if at once.
                    prop_assert_eq!(snapshot.report(), explain(&visits[..index], axioms).report());
                    before = now;
                }
            }
        }
    }

    #[test]
    fn the_listing_of_stars_changes_rotations_only(walk in tangled_walks(8), by in relistings()) {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let relisted = |story: Story| -> Story {
            let first = |place| story.iter().position(|visit| visit.0 == place).unwrap();
            let turn = |(k, &(place, rotation)): (usize, &(usize, usize))| {
                let size = visits[k].star.size();
                (place, (rotation + by[k] + size - by[first(place)] % size) % size)
            };
            story.iter().enumerate().map(turn).collect()
        };
        let expected: BTreeSet<Story> = stories(&explain(visits, axioms)).into_iter().map(relisted).collect();
        let found = stories(&explain(&relist(visits, &by), axioms));
        prop_assert_eq!(found.into_iter().collect::<BTreeSet<Story>>(), expected);
    }

    #[test]
    fn limits_cut_honestly(walk in tangled_walks(7), limit in 1..12usize) {
        let axioms = AxiomSet::of(Profile::Paper);
        let visits = affordable(&walk.visits, axioms);
        let exact = explain(visits, axioms).report();
        let mut abduction = Abduction::new(axioms, Limits { max_candidates: Some(limit), ..Limits::default() });
        visits.iter().for_each(|visit| abduction.observe(visit).unwrap());
        let report = abduction.report();
        let counts = report.candidates_per_observation.iter().zip(&exact.candidates_per_observation);
        for (found, exact) in counts {
            prop_assert!(found.value <= limit as u64 && found.value <= exact.value);
            prop_assert!(found.relation == Relation::AtLeast || found.value == exact.value);
        }
        let most = exact.candidates_per_observation.iter().map(|count| count.value).max().unwrap();
        prop_assert_eq!(report.complete, most <= limit as u64);
        let all: BTreeSet<Story> = exact_stories(visits, axioms);
        prop_assert!(stories(&abduction).iter().all(|story| all.contains(story)));
        if report.complete {
            prop_assert_eq!(report, exact);
        } else {
            prop_assert!(!report.proven && !report.unique);
            let cut = matches!(report.stop_reason, StopReason::CandidateLimit { .. });
            prop_assert!(cut && report.candidates.relation == Relation::AtLeast);
        }
    }

    #[test]
    fn what_nothing_explains_is_reported_once_and_for_all(lies in lies(8)) {
        let axioms = AxiomSet::of(Profile::Default);
        let report = explain(affordable(&lies, axioms), axioms).report();
        let gone = report.candidates_per_observation.iter().position(|count| count.value == 0);
        prop_assert_eq!(report.extinction.as_ref().map(|end| end.observation), gone);
        if let (Some(observation), Some(end)) = (gone, report.extinction) {
            prop_assert_eq!(report.stop_reason, StopReason::Inconsistent { observation });
            prop_assert!(!end.axioms.is_empty() && report.minimal.is_empty() && !report.unique);
            let refuted = report.refuted_per_observation[observation].total();
            prop_assert!(refuted >= report.candidates_per_observation[observation - 1].value);
        }
    }

    #[test]
    fn a_refused_visit_changes_nothing(walk in tangled_walks(4)) {
        let mut abduction = explain(&walk.visits, AxiomSet::of(Profile::Paper));
        let before = abduction.report();
        let good = walk.visits[0].clone();
        let far = Some(SlotIndex(200));
        let refused = [
            (Visit { departure: None, ..good.clone() }, VisitError::NoDeparture),
            (Visit { arrival: SlotIndex(200), ..good.clone() },
                VisitError::UnknownArrival { slot: 200, size: good.star.size() }),
            (Visit { departure: far, ..good },
                VisitError::UnknownDeparture { slot: 200, size: walk.visits.last().unwrap().star.size() }),
        ];
        for (visit, error) in refused {
            prop_assert_eq!(abduction.observe(&visit), Err(error));
            prop_assert_eq!(abduction.report(), before.clone());
        }
    }
}

fn exact_stories(visits: &[Visit], axioms: AxiomSet) -> BTreeSet<Story> {
    stories(&explain(visits, axioms)).into_iter().collect()
}
