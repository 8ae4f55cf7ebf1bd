//! The operator's word over HTTP: taken like any event, undone without a trace.

use crate::http::client::{Client, JSON, NDJSON, aces_lines};
use serde_json::{Value, json};

fn assert_line(seq: usize, visits: [usize; 2], same: bool) -> String {
    json!({"seq": seq, "kind": "assert", "visits": visits, "same": same}).to_string()
}

fn retract_line(seq: usize, assert: usize) -> String {
    json!({"seq": seq, "kind": "retract", "assert": assert}).to_string()
}

/// All that a map answers, but for the number of its next event.
async fn state(client: &Client) -> (Value, Value, Value) {
    let mut map = client.get("/v1/maps/aces").await.json();
    map["next_seq"] = json!(null);
    let candidates = client.get("/v1/maps/aces/candidates?limit=1000").await.json();
    (map, candidates, client.get("/v1/maps/aces/candidates/preferred/explain").await.json())
}

#[tokio::test]
async fn an_assertion_prunes_and_a_retraction_brings_back() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let n = aces_lines().len();
    let before = state(&client).await;
    let posted = client.post("aces", JSON, assert_line(n, [0, 8], false)).await.json();
    assert_eq!(
        (&posted["candidates"], &posted["next_seq"]),
        (&json!({"value": 13, "relation": "eq"}), &json!(n + 1))
    );
    let map = client.get("/v1/maps/aces").await.json();
    assert_eq!(map["refuted"]["operator"], 10);
    assert_eq!(map["asserts"], json!([{"seq": n, "visits": [0, 8], "same": false}]));
    assert_eq!(map["preferred"]["places"], 10);
    client.post("aces", JSON, assert_line(n, [0, 8], false)).await;
    client.post("aces", JSON, retract_line(n + 1, n)).await;
    assert_eq!(state(&client).await, before);
    assert_eq!(client.get("/v1/maps/aces").await.json()["next_seq"], n + 2);
}

/// In any place of a trace, between travel and observation too; the map is that of the trace without them.
#[tokio::test]
async fn word_and_retraction_anywhere_leave_nothing() {
    let lines = aces_lines();
    let client = Client::new();
    client.with_aces("aces", "").await;
    let expected = state(&client).await;
    for (said, back) in [(14, 15), (14, 30), (17, 37), (30, 31)] {
        let mut told: Vec<Value> = lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
        told.insert(said, json!({"kind": "assert", "visits": [0, 3], "same": true}));
        told.insert(back, json!({"kind": "retract", "assert": said}));
        for (seq, event) in told.iter_mut().enumerate() {
            event["seq"] = json!(seq);
        }
        let body: Vec<String> = told.iter().map(Value::to_string).collect();
        let client = Client::new();
        client.put("aces", "").await;
        let posted = client.post("aces", NDJSON, body.join("\n")).await;
        assert_eq!(posted.status, 200, "{}", posted.json());
        assert_eq!(state(&client).await, expected);
    }
}

#[tokio::test]
async fn a_cursor_ends_with_the_operators_word() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let page = client.get("/v1/maps/aces/candidates?limit=1").await.json();
    let next = format!("/v1/maps/aces/candidates?limit=1&cursor={}", page["next"].as_str().unwrap());
    let n = aces_lines().len();
    client.post("aces", JSON, assert_line(n, [0, 8], true)).await;
    client.get(&next).await.problem(410, "stale-cursor");
    client.post("aces", JSON, retract_line(n + 1, n)).await;
    assert_eq!(client.get(&next).await.status, 200);
}

#[tokio::test]
async fn a_word_that_makes_no_sense_is_refused_at_its_field() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let n = aces_lines().len();
    let cases = [
        (assert_line(n, [0, 15], true), "/visits/1"),
        (assert_line(n, [15, 0], true), "/visits/0"),
        (assert_line(n, [3, 3], true), "/visits"),
        (retract_line(n, 2), "/assert"),
        (json!({"seq": n, "kind": "assert", "visits": [0, 8]}).to_string(), "/same"),
        (json!({"seq": n, "kind": "retract"}).to_string(), "/assert"),
        (json!({"seq": n, "kind": "assert", "visits": [0, 8], "same": true, "star": null}).to_string(), ""),
    ];
    for (line, pointer) in &cases[..6] {
        let problem = client.post("aces", JSON, line.clone()).await.problem(422, "malformed-event");
        assert_eq!(&problem["pointer"], pointer, "{problem}");
    }
    // A field that is null is one that is left out.
    assert_eq!(client.post("aces", JSON, cases[6].0.clone()).await.status, 200);
}

#[tokio::test]
async fn words_that_contradict_leave_nothing_say_so_and_can_be_taken_back() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let before = state(&client).await;
    let n = aces_lines().len();
    let words =
        [assert_line(n, [4, 10], true), assert_line(n + 1, [0, 8], true), assert_line(n + 2, [8, 0], false)];
    let posted = client.post("aces", NDJSON, words.join("\n")).await.json();
    assert_eq!(posted["candidates"]["value"], 0);
    let map = client.get("/v1/maps/aces").await.json();
    let extinction = json!({"observation": 14, "axioms": ["operator"], "asserts": [n + 1, n + 2]});
    assert_eq!((&map["extinction"], &map["preferred"]), (&extinction, &json!(null)));
    let problem = client.get("/v1/maps/aces/candidates/preferred").await.problem(404, "no-consistent-map");
    assert_eq!(problem["axioms"], json!(["operator"]));
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        detail.ends_with(&format!("retract one of the asserts with seq {}, {}", n + 1, n + 2)),
        "{detail}"
    );
    let back = [retract_line(n + 3, n + 1), retract_line(n + 4, n + 2), retract_line(n + 5, n)];
    client.post("aces", NDJSON, back.join("\n")).await;
    assert_eq!(state(&client).await, before);
    client.post("aces", JSON, retract_line(n + 6, n)).await.problem(422, "malformed-event");
}
