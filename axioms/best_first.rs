//! The search for the simplest candidates alone finds what the exhaustive one ranks first.

use crate::engine::{axiom_sets, explain, stories};
use crate::strategies::{grid_walks, lies, tangled_walks};
use crate::traces::visits;
use proptest::prelude::*;
use topostar::abduction::{
    Abduction, Assertion, AxiomSet, Boundary, Limits, Profile, Relation, Report, Simplicity, StopReason,
    Visit, VisitError,
};

fn unsettled(seen: &[Visit], axioms: AxiomSet, limits: Limits) -> Abduction {
    let mut abduction = Abduction::best_first(axioms, limits);
    seen.iter().for_each(|visit| abduction.observe(visit).unwrap());
    abduction
}

fn settled(seen: &[Visit], axioms: AxiomSet) -> Abduction {
    let mut abduction = unsettled(seen, axioms, Limits::default());
    abduction.settle(&|| false);
    abduction
}

/// Both searches prefer the same candidates, and say so in the same way.
fn agree(found: &Abduction, all: &Abduction) -> Result<(), TestCaseError> {
    let (found_report, all_report) = (found.report(), all.report());
    prop_assert_eq!(stories(found), minimal(&all_report));
    prop_assert_eq!(&found_report.minimal, &all_report.minimal);
    prop_assert_eq!(found_report.simplicity, all_report.simplicity);
    prop_assert_eq!(found_report.unique, all_report.unique);
    prop_assert!(found_report.proven);
    prop_assert_eq!(found.settlement().unwrap().bound, all_report.simplicity);
    prop_assert!(found_report.candidates.value <= all_report.candidates.value);
    let expected = if all.is_empty() { Relation::Equal } else { Relation::AtLeast };
    prop_assert_eq!(found_report.candidates.relation, expected);
    Ok(())
}

fn minimal(report: &Report) -> Vec<crate::reference::Story> {
    report.minimal.iter().map(crate::engine::story).collect()
}

fn all_axiom_sets() -> Vec<AxiomSet> {
    let soft = AxiomSet::of(Profile::Paper).with_boundary(Some(Boundary::Soft));
    axiom_sets().into_iter().chain([soft]).collect()
}

/// The longest beginning that all axiom sets explain exhaustively in little time.
fn exhaustible(seen: &[Visit]) -> &[Visit] {
    let few = |length: &usize| explain(&seen[..*length], AxiomSet::built_in()).len() <= 400;
    &seen[..(1..=seen.len()).take_while(few).last().unwrap_or(1)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 768, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_simplest_are_those_of_all(walk in tangled_walks(12), grid in grid_walks(20), lies in lies(10)) {
        for seen in [&walk.visits, &grid.visits, &lies] {
            let seen = exhaustible(seen);
            for axioms in all_axiom_sets() {
                agree(&settled(seen, axioms), &explain(seen, axioms))?;
            }
        }
    }

    /// Longer walks than all axiom sets allow: planarity leaves fewer candidates.
    #[test]
    fn what_planarity_rules_out_early_is_no_minimum(walk in tangled_walks(16), grid in grid_walks(28)) {
        for seen in [&walk.visits, &grid.visits] {
            for axioms in [AxiomSet::of(Profile::Default), AxiomSet::of(Profile::Default).with_boundary(Some(Boundary::Hard))] {
                let few = |length: &usize| explain(&seen[..*length], axioms).len() <= 1000;
                let seen = &seen[..(1..=seen.len()).take_while(few).last().unwrap_or(1)];
                agree(&settled(seen, axioms), &explain(seen, axioms))?;
            }
        }
    }

    #[test]
    fn the_operators_word_is_held(
        walk in tangled_walks(9), said in prop::collection::vec((any::<usize>(), any::<usize>(), any::<bool>()), 1..4)
    ) {
        let seen = exhaustible(&walk.visits);
        let axioms = AxiomSet::of(Profile::Paper);
        let (mut found, mut all) = (unsettled(seen, axioms, Limits::default()), explain(seen, axioms));
        for (id, (a, b, same)) in (0..).zip(said) {
            let assertion = Assertion { id, visits: [a % seen.len(), b % seen.len()], same };
            let taken = all.assert(assertion);
            prop_assert_eq!(&found.assert(assertion), &taken);
        }
        found.settle(&|| false);
        agree(&found, &all)?;
    }

    #[test]
    fn a_search_cut_short_is_honest_and_goes_on(walk in grid_walks(14), most in 1..40u64) {
        let axioms = AxiomSet::of(Profile::Paper);
        let whole = settled(&walk.visits, axioms);
        let least = whole.report().simplicity.unwrap();
        let limits = Limits { max_steps: Some(most), ..Limits::default() };
        let mut cut = unsettled(&walk.visits, axioms, limits);
        cut.settle(&|| false);
        let (settlement, report) = (cut.settlement().unwrap(), cut.report());
        prop_assert!(settlement.bound.unwrap() <= least);
        prop_assert!(report.simplicity.is_none_or(|found| found >= least));
        prop_assert_eq!(settlement.proven, report.stop_reason == StopReason::MinimumProven);
        prop_assert!(settlement.proven || (settlement.steps <= most && !report.unique && !report.proven));
        prop_assert!(settlement.proven || report.stop_reason == StopReason::StepLimit);
        // Interrupted after every step it comes to the same end by the same steps.
        let mut slow = unsettled(&walk.visits, axioms, Limits::default());
        let mut rounds = 0;
        while !slow.settlement().is_some_and(|settlement| settlement.proven) {
            let asked = std::cell::Cell::new(0);
            slow.settle(&|| asked.replace(asked.get() + 1) > 0);
            rounds += 1;
            prop_assert!(rounds <= 1_000_000, "it does not come to an end");
        }
        prop_assert_eq!(slow.report(), whole.report());
    }

    #[test]
    fn it_is_all_the_same_when_it_is_settled(
        walk in tangled_walks(9), grid in grid_walks(16), settled_at in prop::collection::vec(any::<bool>(), 17)
    ) {
        for (seen, axioms) in [(&walk.visits, AxiomSet::built_in()), (&grid.visits, AxiomSet::of(Profile::Default))] {
            let mut often = Abduction::best_first(axioms, Limits::default());
            for (visit, &settle) in seen.iter().zip(&settled_at) {
                often.observe(visit).unwrap();
                if settle {
                    often.settle(&|| false);
                    prop_assert!(often.report().proven);
                }
            }
            often.settle(&|| false);
            prop_assert_eq!(often.report(), settled(&seen[..often.observations()], axioms).report());
        }
    }

    #[test]
    fn memory_cuts_honestly(walk in grid_walks(14), kilobytes in 1..24usize) {
        let axioms = AxiomSet::of(Profile::Paper);
        let limits = Limits { max_memory: Some(kilobytes << 10), ..Limits::default() };
        let mut found = unsettled(&walk.visits, axioms, limits);
        found.settle(&|| false);
        let (report, whole) = (found.report(), settled(&walk.visits, axioms).report());
        match report.proven {
            true => prop_assert_eq!(report, whole),
            false => {
                let observation = walk.visits.len() - 1;
                prop_assert_eq!(report.stop_reason, StopReason::MemoryLimit { observation });
                prop_assert!(!report.unique && report.candidates.relation == Relation::AtLeast);
                prop_assert!(report.simplicity.is_none_or(|found| found >= whole.simplicity.unwrap()));
                prop_assert!(found.settlement().unwrap().bound <= whole.simplicity);
            }
        }
    }

    #[test]
    fn ties_beyond_the_limit_are_cut_honestly(walk in tangled_walks(9), limit in 1..4usize) {
        let axioms = AxiomSet::built_in();
        let seen = exhaustible(&walk.visits);
        let whole = settled(seen, axioms).report();
        let mut found = unsettled(seen, axioms, Limits { max_candidates: Some(limit), ..Limits::default() });
        found.settle(&|| false);
        let report = found.report();
        if whole.minimal.len() <= limit {
            prop_assert_eq!(report, whole);
            return Ok(());
        }
        let cut = StopReason::CandidateLimit { observation: seen.len() - 1 };
        prop_assert_eq!((report.stop_reason, report.proven, report.unique), (cut, false, false));
        prop_assert_eq!(&report.minimal[..], &whole.minimal[..limit]);
        prop_assert_eq!(found.settlement().unwrap().bound, whole.simplicity);
    }

    #[test]
    fn candidates_do_not_depend_on_the_number_of_threads(walk in grid_walks(14), limit in 1..3000usize) {
        let limits = [Limits::default(), Limits { max_candidates: Some(limit), ..Limits::default() }];
        for (axioms, limits) in [AxiomSet::built_in(), AxiomSet::of(Profile::Default)].into_iter().zip(limits) {
            let search = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut abduction = Abduction::new(axioms, limits);
                    walk.visits.iter().for_each(|visit| abduction.observe(visit).unwrap());
                    (abduction.report(), stories(&abduction))
                })
            };
            prop_assert_eq!(search(1), search(3));
        }
    }
}

#[test]
fn recorded_traces() {
    let expected = [
        ("aces-stars", (6, 9), [2, 1]),
        ("grid3x3-16", (5, 7), [3, 1]),
        ("grid4x3-20", (6, 9), [1, 1]),
        ("grid4x4-24", (4, 8), [1, 1]),
        ("grid4x4-28", (4, 8), [3, 1]),
    ];
    for (trace, (paths, places), ties) in expected {
        for (profile, ties) in [Profile::Paper, Profile::Default].into_iter().zip(ties) {
            let report = settled(&visits(trace), AxiomSet::of(profile)).report();
            let simplicity = Simplicity { abnormalities: None, paths, places };
            assert_eq!(report.simplicity, Some(simplicity), "{trace}");
            assert_eq!(
                (report.minimal.len(), report.unique, report.proven),
                (ties, ties == 1, true),
                "{trace}"
            );
            assert_eq!(report.stop_reason, StopReason::MinimumProven);
            assert!(!report.complete);
        }
    }
}

/// A walk of 64 travels whose candidates are too many to be enumerated. What it must find was found by itself: that it is the
/// minimum rests on the searches above, which are compared with exhaustive ones.
#[test]
fn a_walk_too_long_for_exhaustive_search() {
    for (profile, places, ties) in [(Profile::Paper, 16, 4), (Profile::Default, 18, 1)] {
        let report = settled(&visits("grid6x6-64"), AxiomSet::of(profile)).report();
        assert_eq!(report.simplicity, Some(Simplicity { abnormalities: None, paths: 6, places }));
        assert_eq!((report.minimal.len(), report.proven, report.unique), (ties, true, ties == 1));
    }
}

#[test]
fn before_it_is_settled_it_holds_nothing() {
    let mut abduction = unsettled(&visits("aces-stars"), AxiomSet::of(Profile::Paper), Limits::default());
    assert!(abduction.is_empty() && !abduction.report().proven && abduction.settlement().is_none());
    assert_eq!(abduction.report().stop_reason, StopReason::Interrupted);
    abduction.settle(&|| true);
    assert!(!abduction.report().proven);
    // It was interrupted before it looked at anything.
    let settlement = abduction.settlement().unwrap();
    assert_eq!((settlement.steps, settlement.proven, settlement.bound), (0, false, None));
    assert_eq!(abduction.report().stop_reason, StopReason::Interrupted);
    abduction.settle(&|| false);
    assert!(abduction.report().proven);
}

#[test]
fn more_observations_than_it_takes_are_refused() {
    let there = visits("ring-10-30").swap_remove(1);
    // It goes back by the gateway it came in by, over and over.
    let back = there.star.slots()[there.arrival.0 as usize].opposite;
    let again = Visit { departure: Some(back), ..there.clone() };
    let mut abduction = Abduction::best_first(AxiomSet::of(Profile::Paper), Limits::default());
    abduction.observe(&Visit { departure: None, ..there }).unwrap();
    (1..Abduction::MOST_SETTLED).for_each(|_| abduction.observe(&again).unwrap());
    assert_eq!(abduction.observe(&again), Err(VisitError::TooManyToSettle));
    assert_eq!(abduction.observations(), Abduction::MOST_SETTLED);
}
