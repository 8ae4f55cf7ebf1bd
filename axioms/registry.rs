//! No axiom without its property, its rule in the answer-set theory, and a world in which it refutes something.

use crate::engine::explain;
use crate::measured;
use crate::reference;
use crate::topology::PROPERTIES;
use crate::traces::visits;
use std::fs;
use topostar::abduction::{Axiom, AxiomSet, Profile, REGISTRY};
use topostar::export::answer_set::THEORY;

/// For each axiom a trace of `worlds/` in which it refutes a candidate.
const REFUTING: &[(&str, &str)] = &[
    ("determinism", "grid3x3-16"),
    ("star-match", "door-shut"),
    ("travel-moves", "late-refutation"),
    ("path-order", "spiral"),
    ("planarity", "overpass"),
    ("boundary", "aliased-turns"),
    ("distance", "ring-10-30"),
    ("angle", "grid4x4-drift"),
    ("closure", "grid4x4-drift"),
    ("apart", "grid4x4-drift"),
];

/// Beside the axioms of profile `default`; a measured one beside all others, as it is judged after them.
fn refutes(axiom: &Axiom, world: &str) -> bool {
    let default = AxiomSet::of(Profile::Default);
    let report = match axiom.is_measured() {
        true => measured::explain(&measured::recorded(world), default).report(),
        false => explain(&visits(world), default.without_measured().with(axiom.id)).report(),
    };
    report.refuted.by(axiom.id) > 0
}

#[test]
fn every_axiom_has_a_property() {
    for axiom in &REGISTRY {
        let symbolic = PROPERTIES.iter().map(|(id, _)| *id);
        let mut ids = symbolic.chain(measured::LAWS.iter().map(|(id, _)| *id));
        assert!(ids.any(|id| id == axiom.id), "{} has no property", axiom.name);
    }
}

#[test]
fn the_reference_says_which_axioms_it_does_not_know() {
    for axiom in &REGISTRY {
        assert_ne!(reference::UNKNOWN.contains(&axiom.name), reference::knows(axiom.name), "{}", axiom.name);
    }
}

#[test]
fn every_axiom_has_a_rule_that_names_it_and_is_switched_by_it() {
    for axiom in &REGISTRY {
        let lines = || THEORY.iter().flat_map(|(_, text)| text.lines());
        let named = lines().any(|line| line.starts_with('%') && line.contains(axiom.name));
        assert!(named, "no comment in axioms/*.lp names {}", axiom.name);
        // What is built in is not switched; `measured` stands for the axioms whose clashes are handed in.
        let switches = [format!("axiom(\"{}\")", axiom.name), format!("measured(\"{}\")", axiom.name)];
        let switched =
            lines().any(|line| !line.starts_with('%') && switches.iter().any(|it| line.contains(it)));
        assert_eq!(switched, axiom.switchable, "{}", axiom.name);
    }
}

#[test]
fn every_axiom_refutes_in_some_world() {
    for axiom in &REGISTRY {
        let world = REFUTING.iter().find(|(name, _)| *name == axiom.name);
        let (_, world) = world.unwrap_or_else(|| panic!("no world for {}", axiom.name));
        assert!(refutes(axiom, world), "{} refutes nothing in {world}", axiom.name);
    }
}

#[test]
fn the_theory_is_that_of_the_files() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/axioms");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<String> = files.filter(|name| name.ends_with(".lp")).collect();
    let mut theory = THEORY.map(|(name, _)| name.to_owned()).to_vec();
    files.sort();
    theory.sort();
    assert_eq!(files, theory);
}
