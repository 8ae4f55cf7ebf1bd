//! What the documents say is what the program does.

use std::fs;
use std::path::Path;
use std::process::Command;
use topostar::abduction::REGISTRY;
use topostar::classic::AXIOMS;

fn document(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

#[test]
fn the_architecture_states_every_axiom_as_the_registry_does() {
    let text = document("ARCHITECTURE.md");
    for axiom in &REGISTRY {
        let profiles: Vec<&str> = axiom.profiles.iter().map(|profile| profile.name()).collect();
        let held = if profiles.is_empty() { "on request".into() } else { profiles.join(", ") };
        let row = format!("| `{}` | {held} | {} |", axiom.name, axiom.statement);
        assert!(text.contains(&row), "ARCHITECTURE.md has no row\n{row}");
    }
    assert_eq!(rows_of_section(&text, "The axioms"), REGISTRY.len());
}

#[test]
fn the_architecture_states_every_axiom_of_profile_classic() {
    let text = document("ARCHITECTURE.md");
    for axiom in &AXIOMS {
        let row = format!("| `{}` | {} |", axiom.name, axiom.statement);
        assert!(text.contains(&row), "ARCHITECTURE.md has no row\n{row}");
    }
    assert_eq!(rows_of_section(&text, "The original SSH"), AXIOMS.len());
}

fn rows_of_section(text: &str, title: &str) -> usize {
    let section = text.split(&format!("## {title}\n")).nth(1).unwrap().split("\n## ").next().unwrap();
    section.lines().filter(|line| line.starts_with("| `")).count()
}

#[test]
fn what_the_worlds_are_said_to_be_tested_by_exists() {
    let text = document("worlds/README.md");
    let table = text.split("## What is tested where").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows: Vec<&str> =
        table.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| #")).collect();
    for (row, number) in rows.iter().zip(1..) {
        let (what, place) = row.rsplit_once(" | ").unwrap();
        assert!(what.starts_with(&format!("| {number} |")), "{row}");
        let mut source = String::new();
        let names: Vec<&str> = place.split('`').skip(1).step_by(2).collect();
        assert!(!names.is_empty(), "{row}");
        for name in names {
            match name.contains('/') {
                true => source = document(name),
                false => assert!(source.contains(&format!("fn {name}(")), "no test {name}: {row}"),
            }
        }
    }
    assert_eq!(rows.len(), 20);
}

/// All but the port, which the system chooses.
#[test]
fn the_readme_shows_what_the_demo_prints() {
    let folder = tempfile::tempdir().unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_topostar")).arg("demo").current_dir(&folder).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let text = document("README.md");
    let shown = text.split("$ cargo run --release -- demo\n").nth(1).unwrap().split("\n```").next().unwrap();
    let without_port = |line: &str| line.split("http://127.0.0.1").next().unwrap().to_owned();
    let lines = |text: &str| text.trim_end().lines().map(without_port).collect::<Vec<_>>();
    assert_eq!(lines(shown), lines(&printed));
}

/// Of what is printed, the README may show the end.
#[test]
fn the_readme_shows_what_map_prints() {
    let text = document("README.md");
    let shown = text.split("```console\n$ topostar map ").skip(1).filter_map(|rest| rest.split_once('\n'));
    let mut examples = 0;
    for (arguments, rest) in shown {
        let lines = rest.split("\n```").next().unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_topostar"))
            .arg("map")
            .args(arguments.split_whitespace())
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        let printed = String::from_utf8(output.stdout).unwrap();
        assert!(printed.trim_end().ends_with(lines.trim_start_matches("...\n")), "{arguments}\n{printed}");
        examples += 1;
    }
    assert_eq!(examples, 2);
}

#[test]
fn the_readme_names_files_and_verbs_that_exist() {
    let text = document("README.md");
    for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(link).exists(), "{link}");
    }
    let verbs = text.lines().filter_map(|line| line.strip_prefix("topostar ")?.split_whitespace().next());
    for verb in verbs {
        let help = Command::new(env!("CARGO_BIN_EXE_topostar")).args([verb, "--help"]).output().unwrap();
        assert!(help.status.success(), "topostar {verb}");
    }
}
