//! Posting events: order, idempotence, partial acceptance.

use crate::http::client::{Answer, Client, JSON, NDJSON, aces, aces_lines, array, root};
use axum::body::{Body, Bytes};
use axum::http::Method;
use futures_util::stream;
use serde_json::{Value, json};

const READS: [&str; 4] =
    ["", "/candidates?limit=1000", "/candidates/preferred", "/candidates/preferred/graph"];

/// All that can be read of a map.
async fn state(client: &Client, map: &str) -> Vec<Bytes> {
    let mut state = Vec::new();
    for path in READS {
        let read = client.get(&format!("/v1/maps/{map}{path}")).await;
        assert_eq!(read.status, 200);
        state.push(read.body);
    }
    state
}

fn receipt(answer: &Answer) -> Value {
    assert_eq!(answer.status, 200, "{}", String::from_utf8_lossy(&answer.body));
    answer.json()
}

#[tokio::test]
async fn the_trace_of_the_aces_building_has_the_candidates_it_must_have() {
    for (profile, candidates) in [("paper", 35), ("default", 23)] {
        let client = Client::new();
        let posted = client.with_aces("aces", &format!(r#"{{"profile":"{profile}"}}"#)).await;
        let events = aces_lines().len();
        let count = json!({"value": candidates, "relation": "eq"});
        assert_eq!(
            receipt(&posted),
            json!({
                "accepted": events, "replayed": 0, "accepted_through": events - 1, "next_seq": events,
                "candidates": count, "complete": true,
            })
        );
        let map = client.get("/v1/maps/aces").await.json();
        assert_eq!((&map["candidates"], &map["profile"]), (&count, &json!(profile)));
        assert_eq!((&map["preferred"]["unique"], &map["preferred"]["proven"]), (&json!(true), &json!(true)));
    }
}

#[tokio::test]
async fn the_state_does_not_depend_on_how_events_were_sent() {
    let (client, lines) = (Client::new(), aces_lines());
    client.with_aces("aces", "").await;
    let streamed = state(&client, "aces").await;

    let client = Client::new();
    client.put("aces", "").await;
    assert_eq!(client.post("aces", JSON, array(&lines)).await.status, 200);
    assert_eq!(state(&client, "aces").await, streamed);

    let client = Client::new();
    client.put("aces", "").await;
    for line in &lines {
        assert_eq!(receipt(&client.post("aces", JSON, line.clone()).await)["accepted"], 1);
    }
    assert_eq!(state(&client, "aces").await, streamed);
}

#[tokio::test]
async fn bytes_may_arrive_in_any_pieces() {
    let client = Client::new();
    client.put("aces", "").await;
    let pieces: Vec<Result<Bytes, std::io::Error>> =
        aces().trim_end().as_bytes().chunks(113).map(|piece| Ok(Bytes::copy_from_slice(piece))).collect();
    let body = Body::from_stream(stream::iter(pieces));
    let posted = receipt(&client.post("aces", "application/jsonl; charset=utf-8", body).await);
    assert_eq!(posted["candidates"]["value"], 23);
}

#[tokio::test]
async fn events_posted_again_change_nothing() {
    let (client, lines) = (Client::new(), aces_lines());
    client.with_aces("aces", "").await;
    let before = state(&client, "aces").await;
    let again = receipt(&client.post("aces", NDJSON, aces()).await);
    assert_eq!((&again["accepted"], &again["replayed"]), (&json!(lines.len()), &json!(lines.len())));
    let spaced = lines[3].replace(':', " : ");
    assert_eq!(receipt(&client.post("aces", JSON, spaced).await)["replayed"], 1);
    assert_eq!(state(&client, "aces").await, before);
}

#[tokio::test]
async fn another_event_under_a_taken_number_is_a_conflict() {
    let (client, lines) = (Client::new(), aces_lines());
    client.with_aces("aces", "").await;
    let before = state(&client, "aces").await;
    let problem =
        client.post("aces", JSON, r#"{"seq":0,"kind":"travel"}"#).await.problem(409, "event-conflict");
    assert_eq!((&problem["seq"], &problem["accepted_through"]), (&json!(0), &json!(lines.len() - 1)));
    assert_eq!(state(&client, "aces").await, before);
}

#[tokio::test]
async fn a_gap_names_the_event_expected() {
    let (client, lines) = (Client::new(), aces_lines());
    client.put("aces", "").await;
    let problem = client.post("aces", JSON, lines[2].clone()).await.problem(409, "sequence-gap");
    assert_eq!((&problem["expected"], &problem["seq"]), (&json!(0), &json!(2)));
    assert_eq!(problem["accepted_through"], json!(null));
    let body = [&lines[0], &lines[1], &lines[3]].map(|line| line.as_str()).join("\n");
    let problem = client.post("aces", NDJSON, body).await.problem(409, "sequence-gap");
    assert_eq!((&problem["expected"], &problem["line"]), (&json!(2), &json!(3)));
    assert_eq!(
        (&problem["accepted_through"], &problem["detail"]),
        (&json!(1), &json!("the event has seq 3, expected 2; send again from 2"))
    );
}

#[tokio::test]
async fn what_came_before_a_wrong_event_stays_and_nothing_after_it_is_taken() {
    let mut lines = aces_lines();
    lines[4] = lines[4].replace("\"midline\"", "\"middle\"");
    let at = json!("/star/slots/0/control");
    for (kind, body, place, number) in
        [(NDJSON, format!("\n{}", lines.join("\n")), "line", 6), (JSON, array(&lines), "index", 4)]
    {
        let client = Client::new();
        client.put("aces", "").await;
        let problem = client.post("aces", kind, body).await.problem(422, "malformed-event");
        assert_eq!((&problem["pointer"], &problem[place]), (&at, &json!(number)), "{problem}");
        assert_eq!((&problem["seq"], &problem["accepted_through"]), (&json!(4), &json!(3)));
        assert_eq!(client.get("/v1/maps/aces").await.json()["next_seq"], 4);
        let rest = aces_lines()[4..].join("\n");
        assert_eq!(receipt(&client.post("aces", NDJSON, rest).await)["candidates"]["value"], 23);
    }
}

#[tokio::test]
async fn an_event_out_of_order_is_wrong() {
    let client = Client::new();
    client.put("aces", "").await;
    let problem = client.post("aces", JSON, r#"{"seq":0,"kind":"turn","to":1}"#).await;
    assert_eq!(problem.problem(422, "malformed-event")["pointer"], "/kind");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_events_posted_at_once_leave_one_state() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let expected = state(&client, "aces").await;
    let client = Client::new();
    client.put("aces", "").await;
    let posts: Vec<_> = (0..8)
        .map(|i| {
            let client = client.clone();
            tokio::spawn(async move {
                match i % 2 {
                    0 => client.post("aces", NDJSON, aces()).await.status,
                    _ => client.post("aces", JSON, array(&aces_lines())).await.status,
                }
            })
        })
        .collect();
    for post in posts {
        assert_eq!(post.await.unwrap(), 200);
    }
    assert_eq!(state(&client, "aces").await, expected);
}

/// `api/examples` in the order in which a first client would send them.
#[tokio::test]
async fn the_examples_are_answered_as_they_stand() {
    let client = Client::new();
    let map = "/v1/maps/hall";
    let put = client.call(Method::PUT, map, JSON, root("api/examples/map-config.json")).await;
    assert_eq!(put.status, 201);
    for name in ["first-observation.json", "events.json", "lpm-observation.json"] {
        let map = if name.starts_with("lpm") { "grid" } else { "hall" };
        client.put("grid", "").await;
        receipt(&client.post(map, JSON, root(&format!("api/examples/{name}"))).await);
    }
    receipt(&client.post("hall", NDJSON, root("api/examples/events.ndjson")).await);
    let answer = client.get(map).await;
    assert_eq!(answer.json(), serde_json::from_str::<Value>(&root("api/examples/map.json")).unwrap());
    let gap = client.post("hall", JSON, r#"{"seq":9,"kind":"travel"}"#).await.problem(409, "sequence-gap");
    assert_eq!(gap, serde_json::from_str::<Value>(&root("api/examples/sequence-gap.json")).unwrap());
}
