//! The operator's word: it filters candidates exactly, in any order, and taking it back leaves nothing of it.

use crate::engine::{affordable, axiom_sets, explain, stories};
use crate::reference::Story;
use crate::strategies::{grid_walks, lies, tangled_walks};
use proptest::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use topostar::abduction::{
    Abduction, Assertion, AxiomId, AxiomSet, Clash, Evidence, Limits, Profile, Proposal, Revisable, Visit,
    WordError,
};

/// A word said after so many observations, and taken back after so many more, or never.
#[derive(Clone, Debug)]
struct Said {
    after: usize,
    visits: (usize, usize),
    same: bool,
    back: Option<usize>,
}

fn said(most: usize) -> impl Strategy<Value = Vec<Said>> {
    let one = (0..most, (0..most, 0..most), any::<bool>(), prop::option::of(0..most));
    let one = one.prop_map(|(after, visits, same, back)| Said { after, visits, same, back });
    prop::collection::vec(one, 0..4)
}

/// The word as it may be said of so many observations: after two at least, of two that differ.
fn sayable(said: &[Said], observations: usize) -> Vec<(Said, Assertion)> {
    let one = |(id, said): (u64, &Said)| {
        let after = 2 + said.after % (observations - 1);
        let [a, b] = [said.visits.0 % after, said.visits.1 % after];
        let visits = [a, if a == b { (b + 1) % after } else { b }];
        (Said { after, ..said.clone() }, Assertion { id, visits, same: said.same })
    };
    (0..).zip(said).map(one).collect()
}

/// The abduction of visits and word, in the order of the list where more is said at one time. With `taken_back` what
/// is taken back is said and taken back, without it is never said.
fn told(
    visits: &[Visit],
    axioms: AxiomSet,
    limits: Limits,
    word: &[(Said, Assertion)],
    taken_back: bool,
) -> Revisable {
    let mut abduction = Revisable::new(Abduction::new(axioms, limits));
    for (seen, visit) in (1..).zip(visits) {
        abduction.observe(visit, None).unwrap();
        for (said, assertion) in word.iter().filter(|(said, _)| taken_back || said.back.is_none()) {
            if said.after == seen {
                abduction.assert(*assertion).unwrap();
            }
        }
        for (said, assertion) in word.iter().filter(|_| taken_back) {
            if said.back.is_some_and(|more| (said.after + more).min(visits.len()) == seen) {
                abduction.retract(assertion.id).unwrap();
            }
        }
    }
    abduction
}

/// Whether the visits of an assertion are of one place exactly if it says so.
fn obeys(story: &Story, (_, assertion): &(Said, Assertion)) -> bool {
    let [a, b] = assertion.visits;
    (story[a].0 == story[b].0) == assertion.same
}

fn bytes(abduction: &Abduction) -> String {
    serde_json::to_string(&topostar::export::Report::new(&abduction.report())).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_word_filters_the_candidates(tangled in tangled_walks(8), lies in lies(8), word in said(8)) {
        for axioms in axiom_sets() {
            for visits in [affordable(&tangled.visits, axioms), affordable(&lies, axioms)] {
                if visits.len() < 2 {
                    continue;
                }
                let mut word = sayable(&word, visits.len());
                word.iter_mut().for_each(|(said, _)| said.back = None);
                let told = told(visits, axioms, Limits::default(), &word, false);
                let all = explain(visits, axioms);
                let obedient = |story: &Story| word.iter().all(|said| obeys(story, said));
                let expected: Vec<Story> = stories(&all).into_iter().filter(obedient).collect();
                prop_assert_eq!(stories(&told), expected);
                for candidate in all.candidates() {
                    prop_assert_eq!(told.word().allows(&candidate.visits), stories(&told).contains(&crate::engine::story(&candidate)));
                }
            }
        }
    }

    /// At the time it is said, it refutes exactly those that disobey, and they are counted.
    #[test]
    fn what_the_word_refutes_is_counted(walk in tangled_walks(8), word in said(8)) {
        let axioms = AxiomSet::of(Profile::Paper);
        let visits = affordable(&walk.visits, axioms);
        prop_assume!(visits.len() > 1);
        for (_, assertion) in sayable(&word, visits.len()) {
            let mut told = explain(visits, axioms);
            let before = told.report();
            told.assert(assertion).unwrap();
            let after = told.report();
            prop_assert_eq!(after.candidates.value + after.refuted.by_operator(), before.candidates.value);
            prop_assert_eq!(after.maps_created, before.maps_created);
            if told.is_empty() {
                let end = after.extinction.unwrap();
                prop_assert_eq!((end.observation, end.names()), (visits.len() - 1, vec!["operator"]));
                prop_assert_eq!(end.assertions, vec![assertion]);
            }
        }
    }

    #[test]
    fn what_is_taken_back_was_never_said(
        tangled in tangled_walks(8),
        grid in grid_walks(12),
        word in said(12),
        limit in prop::option::of(1usize..6),
    ) {
        for visits in [tangled.visits, grid.visits] {
            for profile in Profile::ALL {
                let axioms = AxiomSet::of(profile);
                let visits = affordable(&visits, axioms);
                if visits.len() < 2 {
                    continue;
                }
                let limits = Limits { max_candidates: limit, ..Limits::default() };
                let word = sayable(&word, visits.len());
                let [taken, never] = [true, false].map(|back| told(visits, axioms, limits, &word, back));
                prop_assert_eq!(bytes(&taken), bytes(&never));
                prop_assert_eq!(taken.report(), never.report());
                prop_assert!(taken.candidates().eq(never.candidates()));
            }
        }
    }

    #[test]
    fn the_order_of_what_is_said_does_not_matter(walk in tangled_walks(8), word in said(8)) {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        prop_assume!(visits.len() > 1);
        let mut word = sayable(&word, visits.len());
        word.iter_mut().for_each(|(said, _)| *said = Said { after: visits.len(), back: None, ..said.clone() });
        let one = told(visits, axioms, Limits::default(), &word, false);
        word.reverse();
        let other = told(visits, axioms, Limits::default(), &word, false);
        prop_assert!(one.candidates().eq(other.candidates()));
        prop_assert_eq!(one.report().refuted, other.report().refuted);
    }
}

#[test]
fn a_word_that_makes_no_sense_is_refused_and_changes_nothing() {
    let visits = crate::traces::visits("aces-stars");
    let mut abduction = Revisable::new(explain(&visits, AxiomSet::of(Profile::Default)));
    let before = abduction.report();
    let assertion = |id, a, b| Assertion { id, visits: [a, b], same: true };
    let unseen = WordError::Unseen { visit: 15, observations: 15 };
    assert_eq!(abduction.assert(assertion(1, 3, 15)), Err(unseen));
    assert_eq!(abduction.assert(assertion(1, 3, 3)), Err(WordError::OneVisit(3)));
    assert_eq!(abduction.retract(1), Err(WordError::NotInForce(1)));
    assert_eq!(abduction.report(), before);
    abduction.assert(assertion(1, 0, 8)).unwrap();
    assert_eq!(abduction.assert(assertion(1, 0, 4)), Err(WordError::Taken(1)));
    abduction.retract(1).unwrap();
    assert_eq!(abduction.report(), before);
}

#[test]
fn words_that_contradict_each_other_leave_nothing_and_are_named() {
    let visits = crate::traces::visits("aces-stars");
    let mut abduction = Revisable::new(explain(&visits, AxiomSet::of(Profile::Default)));
    for (id, visits, same) in [(30, [4, 10], true), (31, [0, 8], true), (32, [8, 0], false)] {
        abduction.assert(Assertion { id, visits, same }).unwrap();
    }
    let end = abduction.report().extinction.unwrap();
    assert_eq!(
        end.to_string(),
        "observation 14; the last candidates were refuted by operator: retract one of the asserts with seq 31, 32"
    );
    abduction.retract(31).unwrap();
    abduction.retract(32).unwrap();
    abduction.retract(30).unwrap();
    assert_eq!(abduction.report(), explain(&visits, AxiomSet::of(Profile::Default)).report());
}

/// Measurements that speak against nothing and count how often they are asked.
#[derive(Debug, Default)]
struct Counting(AtomicUsize);

impl Evidence for Counting {
    fn holds(&self, _: AxiomId, _: &Proposal<'_>) -> bool {
        self.0.fetch_add(1, Ordering::Relaxed);
        true
    }

    fn clash(&self, _: AxiomId, _: &Proposal<'_>) -> Clash {
        Clash::default()
    }
}

/// Undoing costs what came after the assertion, and nothing of what came before it.
#[test]
fn undoing_judges_nothing_of_what_came_before() {
    let visits = crate::traces::visits("aces-stars");
    let counting = Arc::new(Counting::default());
    let mut abduction = Revisable::new(Abduction::new(AxiomSet::of(Profile::Default), Limits::default()));
    let asked = || counting.0.load(Ordering::Relaxed);
    for visit in &visits[..14] {
        abduction.observe(visit, Some(counting.clone())).unwrap();
    }
    abduction.assert(Assertion { id: 0, visits: [0, 8], same: true }).unwrap();
    let before = asked();
    abduction.retract(0).unwrap();
    assert_eq!(asked(), before);
    abduction.assert(Assertion { id: 1, visits: [0, 8], same: true }).unwrap();
    abduction.assert(Assertion { id: 2, visits: [0, 4], same: false }).unwrap();
    let before = asked();
    abduction.observe(&visits[14], Some(counting.clone())).unwrap();
    let one = asked() - before;
    abduction.retract(2).unwrap();
    assert_eq!(asked() - before, 2 * one);
    assert!(one > 0 && abduction.len() == 10);
}
