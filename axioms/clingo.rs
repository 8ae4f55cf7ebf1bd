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
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use topostar::abduction::{AxiomSet, Profile, Visit};
use topostar::export::answer_set::{self, facts};

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
    let facts = facts(visits, axioms);
    prop_assert_eq!(clingo.models(&facts, visits.len(), false), expected);
    let minimal: Vec<Story> = found.report().minimal.iter().map(story).collect();
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
    on_random(30, (tangled_walks(7), lies(7)), |(walk, lies)| {
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
    on_random(60, grid_walks(14), |walk| {
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
fn boundaries_hard_and_soft() {
    let Some(clingo) = Clingo::start("boundaries_hard_and_soft") else { return };
    let clingo = RefCell::new(clingo);
    let check = |visits: &[Visit], axioms: AxiomSet| {
        let visits = affordable(visits, axioms);
        let held = facts(visits, axioms) + "axiom(\"boundary\").";
        let all = reference::explanations(visits, &names(axioms), true);
        let obeys = |story: &&Story| reference::obeys(visits, story, "boundary");
        let mut clingo = clingo.borrow_mut();
        let hard: Vec<Story> = all.iter().filter(obeys).cloned().collect();
        prop_assert_eq!(clingo.models(&held, visits.len(), false), hard);
        let soft = held + "soft(\"boundary\").";
        prop_assert_eq!(&clingo.models(&soft, visits.len(), false), &all);
        let minimal = reference::minimal(visits, &all, true);
        prop_assert_eq!(clingo.models(&soft, visits.len(), true), minimal);
        Ok(())
    };
    on_random(40, (tangled_walks(8), grid_walks(14)), |(tangled, grid)| {
        check(&tangled.visits, AxiomSet::of(Profile::Paper))?;
        check(&tangled.visits, AxiomSet::built_in())?;
        check(&grid.visits, AxiomSet::of(Profile::Default))
    });
}
