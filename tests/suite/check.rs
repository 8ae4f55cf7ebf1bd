//! `topostar check` from outside: what it compares, how it ends, and the programs it writes.

use crate::cli::{fed, json, text, topostar};
use serde_json::Value;
use std::fs;

const TRACE: &str = "worlds/grid3x3-16.ndjson";

/// Without clingo, which not every machine has; tests of the axioms ask it.
fn check(more: &[&str]) -> std::process::Output {
    topostar(&[&["check", TRACE, "--clingo", "none"], more].concat())
}

#[test]
fn search_and_reference_agree() {
    let output = check(&["--profile", "paper", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let found = json(&output);
    assert_eq!((&found["equal"], &found["difference"]), (&true.into(), &Value::Null));
    assert_eq!((&found["observations"], &found["compared"]), (&17.into(), &17.into()));
    for judge in ["search", "reference"] {
        assert_eq!(found[judge]["candidates"], 84);
        assert_eq!(found[judge]["minimal"].as_array().unwrap().len(), 3);
        assert_eq!((&found[judge]["size"]["paths"], &found[judge]["size"]["places"]), (&5.into(), &7.into()));
    }
    let order = found["axioms"].as_array().unwrap().iter().find(|it| it["axiom"] == "path-order").unwrap();
    assert_eq!((&order["refutes"], &order["without"]), (&71.into(), &155.into()));
    let words = text(&check(&["--profile", "paper"]).stdout);
    assert!(words.contains("the same candidates and the same preferred ones"), "{words}");
    assert!(words.contains("path-order     71 of 155"), "{words}");
}

#[test]
fn boundaries_are_compared_soft_and_hard() {
    for (boundary, candidates) in [("soft", 63), ("hard", 57)] {
        let output = check(&["--boundary", boundary, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert_eq!(json(&output)["reference"]["candidates"], candidates);
    }
}

#[test]
fn a_budget_cuts_honestly() {
    let output = check(&["--profile", "paper", "--max-candidates", "20", "--json"]);
    assert_eq!(output.status.code(), Some(5));
    let found = json(&output);
    let compared = found["compared"].as_u64().unwrap();
    assert!((1..17).contains(&compared) && found["equal"] == true);
    assert!(found["search"]["candidates"].as_u64().unwrap() <= 20);
    let said = text(&output.stderr);
    assert!(said.contains(&format!("compared up to observation {} of 16", compared - 1)), "{said}");
}

#[test]
fn an_operators_word_is_compared_too() {
    let trace = fs::read_to_string(TRACE).unwrap();
    let seq = trace.lines().count();
    let said = format!("{{\"seq\":{seq},\"kind\":\"assert\",\"visits\":[0,16],\"same\":true}}\n");
    let output = fed(&["check", "-", "--clingo", "none", "--json"], (trace + &said).as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let candidates = json(&output)["search"]["candidates"].as_u64().unwrap();
    assert!(0 < candidates && candidates < 63);
}

/// What was measured is compared: lengths and directions by the reference too, the rest as the search has it.
#[test]
fn measurements_are_compared() {
    let trace = fs::read_to_string("worlds/grid4x4-drift.ndjson").unwrap();
    // An observation, then turn, travel and observation of eight travels.
    let beginning: String = trace.lines().take(25).map(|line| line.to_owned() + "\n").collect();
    let output = fed(&["check", "-", "--clingo", "none", "--json"], beginning.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found = json(&output);
    assert_eq!((&found["equal"], &found["profile"]), (&true.into(), &"default".into()));
    assert_eq!(found["stated_once"], serde_json::json!(["closure", "apart"]));
    let effects = found["axioms"].as_array().unwrap();
    for axiom in ["distance", "angle", "closure", "apart"] {
        let effect = effects.iter().find(|effect| effect["axiom"] == axiom).unwrap();
        assert!(effect["untried"].is_null() && effect["without"].is_u64(), "{effect}");
    }
    let words = text(&fed(&["check", "-", "--clingo", "none"], beginning.as_bytes()).stdout);
    assert!(words.contains("not compared: what closure, apart say"), "{words}");
    let program = text(&fed(&["check", "-", "--lp"], beginning.as_bytes()).stdout);
    assert!(program.contains("\nlength(1,") && program.contains("\nbearing(0,0,"), "{program}");
    // A trace without odometry says so.
    let words = text(&check(&[]).stdout);
    assert!(words.contains("distance       is of measurements, of which the trace has none"), "{words}");
}

#[test]
fn views_are_compared() {
    let trace = fs::read_to_string("worlds/aces-views.ndjson").unwrap();
    let beginning: String = trace.lines().take(31).map(|line| line.to_owned() + "\n").collect();
    let output = fed(&["check", "-", "--clingo", "none", "--json"], beginning.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found = json(&output);
    assert_eq!((&found["equal"], &found["profile"]), (&true.into(), &"classic".into()));
    assert_eq!((&found["compared"], &found["search"]), (&16.into(), &found["reference"]));
    assert_eq!(found["axioms"].as_array().unwrap().len(), 6);
    let program = text(&fed(&["check", "-", "--lp"], beginning.as_bytes()).stdout);
    assert!(program.contains("does(15,") && program.contains("#show at/2"), "{program}");
    let output = fed(&["check", "-", "--profile", "paper"], beginning.as_bytes());
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("a trace of views"), "{}", text(&output.stderr));
    let output = check(&["--profile", "classic"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn faults_end_as_they_do_for_map() {
    let output = topostar(&["check", "worlds/door-shut.ndjson", "--clingo", "none"]);
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let output = fed(&["check", "-", "--clingo", "none"], b"{\"seq\":0,\"kind\":\"dance\"}\n");
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("line 1"), "{}", text(&output.stderr));
    let output = topostar(&["check", TRACE, "--clingo", "no/such/clingo"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("no/such/clingo"));
}

#[test]
fn programs_are_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let output = check_program(&["-o", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let facts = fs::read_to_string(folder.path().join("facts.lp")).unwrap();
    assert_eq!(facts.matches("observation(").count(), 17);
    assert!(facts.contains("axiom(\"planarity\").") && facts.contains("departure(16,"));
    let program = text(&check_program(&[]).stdout);
    assert!(program.contains(&facts) && !program.contains("#minimize"));
    for entry in fs::read_dir("axioms").unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.ends_with(".lp") {
            let own = fs::read_to_string(format!("axioms/{name}")).unwrap();
            let of_views = name.starts_with("classic");
            assert_eq!(fs::read_to_string(folder.path().join(&name)).ok(), (!of_views).then(|| own.clone()));
            assert_eq!(program.contains(&own), !of_views && name != "preference.lp", "{name}");
        }
    }
}

fn check_program(more: &[&str]) -> std::process::Output {
    topostar(&[&["check", TRACE, "--lp"], more].concat())
}
