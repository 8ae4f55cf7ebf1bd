//! No axiom without its property, its rule in the answer-set theory, and a world in which it refutes something.

use crate::engine::explain;
use crate::lengths_and_angles::few_maps;
use crate::measured;
use crate::measured_reference::LAWS;
use crate::reference;
use crate::topology::PROPERTIES;
use crate::traces::visits;
use std::fs;
use topostar::abduction::{Axiom, AxiomSet, Profile, REGISTRY};
use topostar::classic::AXIOMS;
use topostar::export::answer_set::{Bounds, Rounding, STARS, VIEWS};
use topostar::metric::MetricParameters;

/// For each axiom a trace of `worlds/` in which it refutes a candidate.
const REFUTING: &[(&str, &str)] = &[
    ("determinism", "grid3x3-16"),
    ("star-match", "door-shut"),
    ("travel-moves", "late-refutation"),
    ("path-order", "spiral"),
    ("planarity", "overpass"),
    ("boundary", "aliased-turns"),
    ("distance", "ring-10-30"),
    ("angle", "rhombus"),
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
        let mut ids = symbolic.chain(LAWS.iter().map(|(id, _)| *id));
        assert!(ids.any(|id| id == axiom.id), "{} has no property", axiom.name);
    }
}

#[test]
fn the_reference_says_which_axioms_it_does_not_know() {
    for axiom in &REGISTRY {
        assert_ne!(reference::UNKNOWN.contains(&axiom.name), reference::knows(axiom.name), "{}", axiom.name);
    }
}

/// Whether a theory has a comment that names an axiom, and whether a rule is switched by it.
fn rule(texts: &[(&str, &str)], name: &str) -> (bool, bool) {
    let lines = || texts.iter().flat_map(|(_, text)| text.lines());
    // `measured` stands for the axioms whose clashes are handed in.
    let switches = [format!("axiom(\"{name}\")"), format!("measured(\"{name}\")")];
    let switched = |line: &str| !line.starts_with('%') && switches.iter().any(|it| line.contains(it));
    (lines().any(|line| line.starts_with('%') && line.contains(name)), lines().any(switched))
}

#[test]
fn every_axiom_has_a_rule_that_names_it_and_is_switched_by_it() {
    // What is built in is not switched.
    for axiom in &REGISTRY {
        assert_eq!(rule(STARS.laws, axiom.name), (true, axiom.switchable), "{}", axiom.name);
    }
    for axiom in &AXIOMS {
        assert_eq!(rule(VIEWS.laws, axiom.name), (true, true), "{}", axiom.name);
    }
}

/// A measured axiom that is stated by intervals refutes in its world by its rule, without clashes handed in.
#[test]
fn intervals_refute_in_their_worlds() {
    for name in reference::MEASURED {
        let (_, world) = REFUTING.iter().find(|(axiom, _)| *axiom == name).unwrap();
        let seen = measured::recorded(world);
        let (seen, visits, all) = few_maps(&seen, AxiomSet::of(Profile::Default).without_measured(), 2000);
        let known = reference::Measured::new(seen, MetricParameters::default());
        let bounds = Bounds::of(&known, Rounding::Outward);
        assert!(all.iter().any(|story| bounds.refute(&visits, story, name)), "{name} in {world}");
        let texts: Vec<&str> = STARS.laws.iter().map(|(_, text)| *text).collect();
        assert!(texts.iter().any(|text| text.contains(&format!(":- axiom(\"{name}\")"))), "{name}");
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
    let theory = STARS.files().chain(VIEWS.files());
    let mut theory: Vec<String> = theory.map(|(name, _)| name.to_owned()).collect();
    files.sort();
    theory.sort();
    assert_eq!(files, theory);
}
