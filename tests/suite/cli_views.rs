//! Traces of views on the command line: profile `classic` from outside.

use crate::cli::{fed, json, text, topostar};
use std::path::Path;

/// What a trace begins with decides the profile; options that do not go with it are usage.
#[test]
fn a_trace_of_views_is_explained_in_profile_classic() {
    let output = topostar(&["map", "worlds/aces-views.ndjson", "--strategy", "best-first", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("a trace of views, explained in profile classic"));
    let report = json(&output);
    assert_eq!((&report["profile"], &report["strategy"]), (&"classic".into(), &"best-first".into()));
    let preferred = &report["preferred"];
    assert_eq!((&preferred["paths"], &preferred["places"]), (&6.into(), &7.into()));
    assert_eq!((&preferred["proven"], &preferred["unique"]), (&true.into(), &false.into()));
    for field in ["visits", "dstate_visits"] {
        assert_eq!(preferred[field].as_array().unwrap().len(), 73, "{field}");
    }
    assert_eq!((&report["stop_reason"], &report["complete"]), (&"minimum-proven".into(), &false.into()));
    let words = topostar(&["map", "worlds/aces-views.ndjson", "--strategy", "simplest-first"]);
    let words = text(&words.stdout);
    assert!(words.contains("no other as simple found, not proven\n7 places, 9 paths,"), "{words}");
    let cut = topostar(&["map", "worlds/aces-views.ndjson", "--max-candidates", "1000", "--json"]);
    assert_eq!(cut.status.code(), Some(5));
    assert_eq!(json(&cut)["stop_reason"], "candidate-limit");
}

#[test]
fn profile_and_kind_of_trace_must_fit() {
    let (views, stars) = ("worlds/aces-views.ndjson", "worlds/aces-stars.ndjson");
    let cases: [(&[&str], &str); 5] = [
        (
            &["map", views, "--profile", "default"],
            "is a trace of views, which profile classic alone explains",
        ),
        (
            &["map", views, "--axioms", "determinism,star-match"],
            "is a trace of views, which holds the axioms of profile",
        ),
        (
            &["map", stars, "--profile", "classic"],
            "is no trace of views, and profile classic explains nothing else",
        ),
        (
            &["map", stars, "--strategy", "simplest-first"],
            "is no trace of views, which alone --strategy simplest-first",
        ),
        (&["world", "office", "--views", "--stars"], "cannot be used with"),
    ];
    for (arguments, expected) in cases {
        let output = topostar(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(expected), "{}", text(&output.stderr));
    }
}

/// A dstate that was seen one way and is seen another way leaves no map.
#[test]
fn a_view_that_changes_leaves_no_map() {
    let trace = r#"{"seq":0,"kind":"observation","view":"a"}
{"seq":1,"kind":"turn","turn":"around"}
{"seq":2,"kind":"observation","view":"b"}
{"seq":3,"kind":"turn","turn":"around"}
{"seq":4,"kind":"observation","view":"c"}
"#;
    let output = fed(&["map", "-", "--json"], trace.as_bytes());
    assert_eq!(output.status.code(), Some(4));
    assert!(text(&output.stderr).contains("nothing explains observation 2; refuted by one-dstate"));
    let output = fed(&["map", "-", "--json"], trace.replace("\"c\"", "\"a\"").as_bytes());
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(json(&output)["preferred"]["dstate_visits"], serde_json::json!([0, 1, 0]));
    let mixed = trace.replace("\"turn\":\"around\"", "\"to\":1");
    let output = fed(&["map", "-", "--json"], mixed.as_bytes());
    assert_eq!(output.status.code(), Some(3));
    assert!(
        text(&output.stderr).contains("-: line 2: /to belongs to a trace of stars"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn files_are_written_for_a_trace_of_views_too() {
    let folder = tempfile::tempdir().unwrap();
    let output = topostar(&[
        "map",
        "worlds/aces-views.ndjson",
        "--strategy",
        "simplest-first",
        "-o",
        folder.path().to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let recorded = Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/aces-views.ndjson");
    assert_eq!(read("trace.ndjson"), std::fs::read_to_string(recorded).unwrap());
    assert!(read("map.txt").starts_with("paths, with the places on them in order"));
    assert!(read("report.json").contains("\"simplest-first\""));
}
