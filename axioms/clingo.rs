//! The theory as answer-set programs: search, brute force and clingo find the same maps.
//!
//! These tests ask a Python with the module clingo, which `cargo xtask test` sets up and names in an environment
//! variable. Without it they say by name that they were skipped.

use crate::engine::{affordable, axiom_sets, explain, names, stories, story};
use crate::reference::{self, Story};
use crate::solver::{PYTHON, Solver};
use crate::strategies::{grid_walks, lies, tangled_walks};
use crate::traces::visits;
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use serde_json::json;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::io::Write;
use topostar::abduction::{Assertion, AxiomSet, Boundary, Profile, Visit};
use topostar::export::answer_set::{STARS, Theory, facts};

/// clingo as an oracle.
pub(crate) struct Clingo(Solver);

impl Clingo {
    /// None, said aloud, where there is none to ask.
    pub(crate) fn start(test: &str) -> Option<Clingo> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/axioms/clingo_oracle.py");
        let solver = Solver::start([script]);
        if solver.is_none() {
            // Past the harness, which keeps what passing tests print.
            let said = format!("SKIPPED clingo::{test}: {PYTHON} is not set; `cargo xtask test` sets it\n");
            std::io::stderr().write_all(said.as_bytes()).unwrap();
        }
        solver.map(Clingo)
    }

    /// The models of the theory of stars with some facts.
    pub(crate) fn models(&mut self, facts: &str, observations: usize, preferred: bool) -> Vec<Story> {
        self.models_of(&STARS, facts, observations, preferred)
    }

    /// The models of a theory with some facts, as stories in lexicographic order; each must be there once.
    pub(crate) fn models_of<S: Ord>(
        &mut self,
        theory: &Theory<S>,
        facts: &str,
        observations: usize,
        preferred: bool,
    ) -> Vec<S> {
        let program = theory.program(facts, preferred);
        let models = self.0.ask(&json!({"program": program, "preferred": preferred}));
        let models: Vec<Vec<String>> = serde_json::from_value(models).unwrap();
        let told = models.iter().map(|model| (theory.story)(model, observations).unwrap());
        let mut stories: Vec<S> = told.collect();
        stories.sort_unstable();
        assert!(stories.windows(2).all(|pair| pair[0] < pair[1]), "a map has two models");
        stories
    }
}

/// Candidates and preferred candidates of search, brute force and clingo.
fn all_agree(clingo: &mut Clingo, visits: &[Visit], axioms: AxiomSet) -> Result<(), TestCaseError> {
    let found = explain(visits, axioms);
    let expected = reference::explanations(visits, &names(axioms), true);
    prop_assert_eq!(&stories(&found), &expected);
    let facts = facts(visits, axioms, &[]);
    let minimal = reference::minimal(visits, &expected, axioms.boundary() == Some(Boundary::Soft));
    prop_assert_eq!(clingo.models(&facts, visits.len(), false), expected);
    prop_assert_eq!(&found.report().minimal.iter().map(story).collect::<Vec<Story>>(), &minimal);
    prop_assert_eq!(clingo.models(&facts, visits.len(), true), minimal);
    Ok(())
}

/// Runs a check on some random inputs.
pub(crate) fn on_random<S: Strategy>(
    cases: u32,
    strategy: S,
    check: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    TestRunner::new(config).run(&strategy, check).unwrap_or_else(|error| panic!("{error}"));
}

/// Runs a check on random inputs that are always the same, so that what they show can be counted.
pub(crate) fn on_the_same<S: Strategy<Value: Debug>>(
    cases: u32,
    strategy: S,
    check: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    let random = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    TestRunner::new_with_rng(config, random).run(&strategy, check).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn random_worlds_and_lies_in_every_set_of_axioms() {
    let Some(clingo) = Clingo::start("random_worlds_and_lies_in_every_set_of_axioms") else { return };
    let clingo = RefCell::new(clingo);
    on_random(16, (tangled_walks(7), lies(7)), |(walk, lies)| {
        for axioms in axiom_sets() {
            for visits in [&walk.visits, &lies] {
                all_agree(&mut clingo.borrow_mut(), affordable(visits, axioms), axioms)?;
            }
        }
        Ok(())
    });
}

#[test]
fn grids_in_every_profile() {
    let Some(clingo) = Clingo::start("grids_in_every_profile") else { return };
    let clingo = RefCell::new(clingo);
    on_random(40, grid_walks(14), |walk| {
        for axioms in Profile::ALL.map(AxiomSet::of) {
            all_agree(&mut clingo.borrow_mut(), affordable(&walk.visits, axioms), axioms)?;
        }
        Ok(())
    });
}

#[test]
fn recorded_traces() {
    let Some(mut clingo) = Clingo::start("recorded_traces") else { return };
    for name in ["aces-stars", "door-shut", "grid3x3-16", "grid4x3-20"] {
        for axioms in Profile::ALL.map(AxiomSet::of) {
            all_agree(&mut clingo, &visits(name), axioms).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }
}

#[test]
fn soft_boundaries_rank() {
    let Some(clingo) = Clingo::start("soft_boundaries_rank") else { return };
    let clingo = RefCell::new(clingo);
    on_random(30, (tangled_walks(8), grid_walks(14)), |(tangled, grid)| {
        for (walk, axioms) in [
            (&tangled, AxiomSet::of(Profile::Paper)),
            (&tangled, AxiomSet::built_in()),
            (&grid, AxiomSet::of(Profile::Default)),
        ] {
            let axioms = axioms.with_boundary(Some(Boundary::Soft));
            all_agree(&mut clingo.borrow_mut(), affordable(&walk.visits, axioms), axioms)?;
        }
        Ok(())
    });
}

#[test]
fn an_operator_says_which_visits_are_one_place() {
    let Some(clingo) = Clingo::start("an_operator_says_which_visits_are_one_place") else { return };
    let clingo = RefCell::new(clingo);
    on_random(20, (grid_walks(14), any::<u8>(), any::<u8>()), |(walk, a, b)| {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let pair = [a, b].map(|drawn| usize::from(drawn) % visits.len());
        for same in [true, false].into_iter().filter(|_| pair[0] != pair[1]) {
            let said = Assertion { id: 0, visits: pair, same };
            let mut found = explain(visits, axioms);
            found.assert(said).unwrap();
            let models = clingo.borrow_mut().models(&facts(visits, axioms, &[said]), visits.len(), false);
            prop_assert_eq!(models, stories(&found));
        }
        Ok(())
    });
}

#[test]
fn a_dstate_has_one_view() {
    let Some(clingo) = Clingo::start("a_dstate_has_one_view") else { return };
    let clingo = RefCell::new(clingo);
    on_random(20, (grid_walks(14), prop::collection::vec(0..2u8, 16)), |(walk, views)| {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let mut held = facts(visits, axioms, &[]) + "axiom(\"view\").";
        views.iter().enumerate().for_each(|(k, view)| held += &format!("view({k},{view})."));
        let one_view = |story: &Story| {
            let arrived = story.iter().zip(visits).map(|(&(place, rotation), visit)| {
                (place, (usize::from(visit.arrival.0) + rotation) % visit.star.size())
            });
            let mut seen = BTreeMap::new();
            arrived.zip(&views).all(|(dstate, view)| *seen.entry(dstate).or_insert(view) == view)
        };
        let mut expected = stories(&explain(visits, axioms));
        expected.retain(one_view);
        prop_assert_eq!(clingo.borrow_mut().models(&held, visits.len(), false), expected);
        Ok(())
    });
}
