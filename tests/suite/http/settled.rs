//! Maps that look for the simplest candidates alone, over HTTP.

use crate::http::client::{Client, JSON, NDJSON, aces_lines};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use topostar::abduction::{AxiomSet, Profile, Strategy};
use topostar::service::{Limits, MapConfig, Session, View};
use topostar::trace::read_trace;

const BEST_FIRST: &str = r#"{"profile":"paper","strategy":"best-first"}"#;
const BREADTH_FIRST: &str = r#"{"profile":"paper"}"#;

fn said(seq: usize, visits: [usize; 2], same: bool) -> String {
    json!({"seq": seq, "kind": "assert", "visits": visits, "same": same}).to_string()
}

fn taken_back(seq: usize, assert: usize) -> String {
    json!({"seq": seq, "kind": "retract", "assert": assert}).to_string()
}

/// All that a map answers, but for the number of its next event.
async fn state(client: &Client, map: &str) -> Vec<Value> {
    let mut answers = Vec::new();
    for path in
        ["", "/candidates", "/candidates/preferred/graph", "/candidates/preferred/explain", "/tree", "/next"]
    {
        let mut answer = client.get(&format!("/v1/maps/{map}{path}")).await.json();
        if path.is_empty() {
            answer["next_seq"] = json!(null);
        }
        answers.push(answer);
    }
    answers
}

/// What both strategies say in the same way.
async fn preferred(client: &Client, map: &str) -> [Value; 4] {
    let map = client.get(&format!("/v1/maps/{map}")).await.json();
    ["preferred", "minimal", "minimal_maps", "asserts"].map(|field| map[field].clone())
}

/// With words in odd orders among them, the batches do not show, and the other strategy prefers the same.
#[tokio::test]
async fn what_is_found_does_not_depend_on_the_batches() {
    let mut lines = aces_lines();
    let n = lines.len();
    lines.extend([
        said(n, [0, 8], false),
        said(n + 1, [0, 8], false),
        taken_back(n + 2, n),
        said(n + 3, [4, 10], true),
    ]);
    lines.extend([said(n + 4, [0, 8], true), taken_back(n + 5, n + 1), taken_back(n + 6, n + 3)]);
    let client = Client::new();
    for (map, config) in [("all", BEST_FIRST), ("other", BREADTH_FIRST)] {
        client.put(map, config).await;
        assert_eq!(client.post(map, NDJSON, lines.join("\n")).await.status, 200);
    }
    let expected = state(&client, "all").await;
    assert_eq!(expected[0]["preferred"]["proven"], true);
    assert_eq!(preferred(&client, "all").await, preferred(&client, "other").await);
    for size in [1, 2, 7, 30] {
        let map = format!("by-{size}");
        client.put(&map, BEST_FIRST).await;
        for batch in lines.chunks(size) {
            assert_eq!(client.post(&map, NDJSON, batch.join("\n")).await.status, 200);
        }
        // Sent again they change nothing.
        client.post(&map, NDJSON, lines.join("\n")).await;
        let mut found = state(&client, &map).await;
        found[0]["map"] = json!("all");
        assert_eq!(found, expected, "{size} a batch");
    }
}

#[tokio::test]
async fn a_word_taken_back_leaves_nothing() {
    let client = Client::new();
    client.with_aces("aces", BEST_FIRST).await;
    let n = aces_lines().len();
    let before = state(&client, "aces").await;
    client.post("aces", JSON, taken_back(n, 3)).await.problem(422, "malformed-event");
    let words = [said(n, [0, 8], true), said(n + 1, [8, 0], false), said(n + 2, [8, 0], false)];
    assert_eq!(client.post("aces", NDJSON, words.join("\n")).await.json()["candidates"]["value"], 0);
    let map = client.get("/v1/maps/aces").await.json();
    assert_eq!(map["extinction"]["axioms"], json!(["operator"]));
    assert_eq!((&map["stop_reason"], &map["preferred"]), (&"inconsistent".into(), &Value::Null));
    for path in ["/preferred", "/0/graph", "/preferred/explain", "/0/diff/1"] {
        client.get(&format!("/v1/maps/aces/candidates{path}")).await.problem(404, "no-consistent-map");
    }
    for path in ["tree", "next"] {
        client.get(&format!("/v1/maps/aces/{path}")).await.problem(404, "no-consistent-map");
    }
    // One of two that say the same does not suffice.
    let after = client.post("aces", JSON, taken_back(n + 3, n + 1)).await.json();
    assert_eq!(after["candidates"]["value"], 0);
    client.post("aces", JSON, taken_back(n + 4, n + 1)).await.problem(422, "malformed-event");
    let rest = [taken_back(n + 4, n), taken_back(n + 5, n + 2)];
    assert_eq!(client.post("aces", NDJSON, rest.join("\n")).await.status, 200);
    assert_eq!(state(&client, "aces").await, before);
}

#[tokio::test]
async fn what_is_not_there_is_not_found() {
    let client = Client::new();
    for config in [BEST_FIRST, BREADTH_FIRST] {
        let map = if config == BEST_FIRST { "best" } else { "all" };
        client.put(map, config).await;
        let paths = [
            "candidates/preferred",
            "candidates/0/graph",
            "candidates/0/explain",
            "candidates/0/diff/preferred",
            "tree",
            "next",
        ];
        for path in paths {
            client.get(&format!("/v1/maps/{map}/{path}")).await.problem(404, "no-observation");
        }
        client.post(map, NDJSON, aces_lines().join("\n")).await;
        for path in ["99/graph", "99/explain", "99/diff/0", "0/diff/99"] {
            client.get(&format!("/v1/maps/{map}/candidates/{path}")).await.problem(404, "unknown-candidate");
        }
        for query in ["tree?observation=15", "tree?candidate=99", "candidates/0/explain?visits=0,15"] {
            client.get(&format!("/v1/maps/{map}/{query}")).await.problem(400, "invalid-query");
        }
    }
}

#[tokio::test]
async fn memory_ends_the_search_and_says_so() {
    let client = Client::new();
    for strategy in ["best-first", "breadth-first"] {
        let config = format!(r#"{{"profile":"paper","strategy":"{strategy}","max_memory":6000}}"#);
        client.with_aces(strategy, &config).await;
        let map = client.get(&format!("/v1/maps/{strategy}")).await.json();
        assert_eq!((&map["stop_reason"], &map["complete"]), (&"memory-limit".into(), &false.into()), "{map}");
        assert_eq!(map["candidates"]["relation"], "gte");
        assert!(map["preferred"].is_null() || map["preferred"]["proven"] == false);
    }
}

#[tokio::test]
async fn time_ends_the_search_and_says_so() {
    let client = Client::with_limits(Limits { settling: Duration::ZERO, ..Limits::default() });
    client.with_aces("aces", BEST_FIRST).await;
    let map = client.get("/v1/maps/aces").await.json();
    assert_eq!((&map["stop_reason"], &map["complete"]), (&"interrupted".into(), &false.into()), "{map}");
    assert_eq!(map["candidates"], json!({"value": 0, "relation": "gte"}));
    client.with_aces("all", BREADTH_FIRST).await;
    assert_eq!(client.get("/v1/maps/all").await.json()["complete"], true);
}

/// What a search finds after an interruption is shown, though no event has come.
#[test]
fn an_interrupted_search_goes_on() {
    let config = MapConfig {
        axioms: AxiomSet::of(Profile::Paper),
        strategy: Strategy::BestFirst,
        max_candidates: 100,
        max_memory: None,
        max_steps: None,
    };
    let mut session = Session::new(config, Limits::default());
    for event in read_trace(aces_lines().join("\n").as_bytes()).0 {
        session.accept(&Arc::new(event)).unwrap();
    }
    session.settle(&|| true);
    let view = View::of(&session);
    assert!(!view.report.proven && view.shows(&session));
    session.settle(&|| false);
    assert!(!view.shows(&session));
    let view = view.next(&session);
    assert!(view.report.proven && view.shows(&session));
}

/// A star of so many fragments, all midline but the first slot, so that it lies on itself in one way only.
fn wide_star(fragments: usize) -> Value {
    let slot = |slot: usize| {
        let back = (slot + fragments) % (2 * fragments);
        let control = if slot == 0 { "left_wall" } else { "midline" };
        let direction = if slot < fragments { "+" } else { "-" };
        json!({"fragment": slot % fragments, "direction": direction, "out": slot, "in": back, "control": control})
    };
    json!({"slots": (0..2 * fragments).map(slot).collect::<Vec<Value>>()})
}

/// Sets of rotations are kept for stars of 64 slots at most; larger ones take another way.
#[tokio::test]
async fn wide_stars_are_explained_by_both_strategies() {
    for fragments in [32, 33, 127] {
        // There and back, then on by another way.
        let turns = [None, Some(fragments), None, Some(5), Some(5 + fragments)];
        let mut lines =
            vec![json!({"seq": 0, "kind": "observation", "star": wide_star(fragments), "dstate": 0})];
        for turn in turns {
            let seq = lines.len();
            lines.extend(turn.map(|to| json!({"seq": seq, "kind": "turn", "to": to})));
            lines.push(json!({"seq": lines.len(), "kind": "travel"}));
            let dstate = turn.unwrap_or(0);
            let seen = json!({"seq": lines.len(), "kind": "observation", "star": wide_star(fragments), "dstate": dstate});
            lines.push(seen);
        }
        let body: Vec<String> = lines.iter().map(Value::to_string).collect();
        let client = Client::new();
        for (map, config) in [("best", BEST_FIRST), ("all", BREADTH_FIRST)] {
            client.put(map, config).await;
            let posted = client.post(map, NDJSON, body.join("\n")).await;
            assert_eq!(posted.status, 200, "{}", posted.json());
            for path in ["candidates/preferred/graph", "candidates/preferred/explain", "tree", "next"] {
                assert_eq!(client.get(&format!("/v1/maps/{map}/{path}")).await.status, 200, "{path}");
            }
        }
        assert_eq!(
            preferred(&client, "best").await,
            preferred(&client, "all").await,
            "{fragments} fragments"
        );
    }
}
