//! The theory as answer-set programs: search, brute force and clingo find the same maps.
//!
//! These tests ask a Python with the module clingo, which `cargo xtask test` sets up and names in an environment
//! variable. Without it they say by name that they were skipped.

use crate::engine::{affordable, axiom_sets, explain, names, stories, story};
use crate::reference::{self, Story};
use crate::strategies::{grid_walks, lies, tangled_walks};
use crate::traces::visits;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use topostar::abduction::{Assertion, AxiomSet, Boundary, Profile, Visit};
use topostar::export::answer_set::{self, Nogood, facts, solve_and_measure};

/// Names the Python to ask.
const PYTHON: &str = "TOPOSTAR_CLINGO_PYTHON";

/// One process that answers many requests.
struct Clingo {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Clingo {
    /// None, said aloud, where there is none to ask.
    fn start(test: &str) -> Option<Clingo> {
        let Ok(python) = std::env::var(PYTHON) else {
            // Past the harness, which keeps what passing tests print.
            let said = format!("SKIPPED clingo::{test}: {PYTHON} is not set; `cargo xtask test` sets it\n");
            std::io::stderr().write_all(said.as_bytes()).unwrap();
            return None;
        };
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/axioms");
        let mut process = Command::new(&python)
            .args([&format!("{folder}/clingo_oracle.py"), folder])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{PYTHON}={python}: {error}"));
        let requests = process.stdin.take().unwrap();
        let answers = BufReader::new(process.stdout.take().unwrap());
        Some(Clingo { process, requests, answers })
    }

    /// The models of the theory with some facts, as stories in lexicographic order; each must be there once.
    fn models(&mut self, facts: &str, observations: usize, preferred: bool) -> Vec<Story> {
        writeln!(self.requests, "{}", json!({"facts": facts, "preferred": preferred})).unwrap();
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        let models: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
        let told = |model: &Value| {
            let atom = |it: &Value| format!("visit({},{},{})", it[0], it[1], it[2]);
            let atoms: Vec<String> = model.as_array().unwrap().iter().map(atom).collect();
            answer_set::story(atoms.iter().map(String::as_str), observations).unwrap()
        };
        let mut stories: Vec<Story> = models.as_array().unwrap().iter().map(told).collect();
        stories.sort_unstable();
        assert!(stories.windows(2).all(|pair| pair[0] < pair[1]), "a map has two models");
        stories
    }
}

impl Drop for Clingo {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
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
fn on_random<S: Strategy>(cases: u32, strategy: S, check: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    TestRunner::new(config).run(&strategy, check).unwrap_or_else(|error| panic!("{error}"));
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

/// Bounds on the length of each travel, or of the turn from slot 0 to slot 1 at each observation.
type Bounds = Vec<(i32, i32)>;

fn bounds() -> impl Strategy<Value = Bounds> {
    prop::collection::vec((0..20i32, 0..30i32).prop_map(|(low, wide)| (low, low + wide)), 16)
}

/// The first two measurements that speak of one thing and have no value in common.
fn clash<T: Ord>(of: impl Iterator<Item = (usize, T)>, bounds: &Bounds) -> Option<[usize; 2]> {
    let mut known: BTreeMap<T, Vec<usize>> = BTreeMap::new();
    for (measured, what) in of {
        let before = known.entry(what).or_default();
        let apart =
            |&&other: &&usize| bounds[other].0 > bounds[measured].1 || bounds[measured].0 > bounds[other].1;
        if let Some(&other) = before.iter().find(apart) {
            return Some([other, measured]);
        }
        before.push(measured);
    }
    None
}

/// The two travels along one segment whose lengths cannot be one.
fn uneven(visits: &[Visit], story: &Story, lengths: &Bounds) -> Option<[usize; 2]> {
    let travels = reference::travels(visits, story);
    clash((1..).zip(travels.into_iter().map(|(a, b)| (a.min(b), a.max(b)))), lengths)
}

/// The two observations of one turn at a place whose angles cannot be one.
fn askew(visits: &[Visit], story: &Story, turns: &Bounds) -> Option<[usize; 2]> {
    let slots = story.iter().zip(visits).map(|(&(place, rotation), visit)| {
        let size = visit.star.size();
        (place, rotation % size, (rotation + 1) % size)
    });
    clash(slots.enumerate(), turns)
}

#[test]
fn intervals_of_length_and_angle() {
    let Some(clingo) = Clingo::start("intervals_of_length_and_angle") else { return };
    let clingo = RefCell::new(clingo);
    on_random(40, (grid_walks(14), bounds(), bounds()), |(walk, lengths, turns)| {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let mut held = facts(visits, axioms, &[]);
        for (k, ((low, high), (least, most))) in lengths.iter().zip(&turns).enumerate() {
            held += &format!("length({k},{low},{high}). turned({k},0,1,{least},{most}).");
        }
        let mut expected = stories(&explain(visits, axioms));
        expected.retain(|story| uneven(visits, story, &lengths).or(askew(visits, story, &turns)).is_none());
        prop_assert_eq!(clingo.borrow_mut().models(&held, visits.len(), false), expected);
        Ok(())
    });
}

#[test]
fn measuring_models_and_solving_again_is_exact() {
    let Some(clingo) = Clingo::start("measuring_models_and_solving_again_is_exact") else { return };
    let clingo = RefCell::new(clingo);
    on_random(20, (grid_walks(14), bounds()), |(walk, lengths)| {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let held = facts(visits, axioms, &[]);
        let solve = |more: &str| -> Result<Vec<Story>, TestCaseError> {
            Ok(clingo.borrow_mut().models(&format!("{held}{more}"), visits.len(), false))
        };
        let measure = |story: &Story| {
            let [one, other] = uneven(visits, story, &lengths)?;
            Some(Nogood::new("distance", story, &[one - 1, one, other - 1, other]))
        };
        let mut expected = stories(&explain(visits, axioms));
        expected.retain(|story| uneven(visits, story, &lengths).is_none());
        prop_assert_eq!(solve_and_measure(solve, measure)?, expected);
        Ok(())
    });
}
