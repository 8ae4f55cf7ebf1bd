//! `api/examples`: bodies as a first client would send them, and the answers it would get.

use crate::http::client::{Answer, Client, JSON, NDJSON, root};
use crate::openapi::assert_golden;

fn example(name: &str) -> String {
    root(&format!("api/examples/{name}"))
}

fn assert_answer(answer: &Answer, name: &str) {
    let text = serde_json::to_string_pretty(&answer.json()).unwrap() + "\n";
    assert_golden(&format!("api/examples/{name}"), &text);
}

#[tokio::test]
async fn events_in_each_form() {
    let client = Client::new();
    assert_eq!(client.put("aces", &example("map-config.json")).await.status, 201);
    let first = client.post("aces", JSON, example("first-observation.json")).await;
    assert_eq!(first.json()["next_seq"], 1);
    let array = client.post("aces", JSON, example("events.json")).await;
    assert_eq!(array.json()["next_seq"], 6);
    assert_answer(&client.post("aces", NDJSON, example("events.ndjson")).await, "receipt.json");
    assert_answer(&client.get("/v1/maps/aces").await, "map.json");
    assert_answer(&client.get("/v1/maps/aces/candidates?limit=2").await, "candidates.json");
    assert_answer(&client.get("/v1/maps/aces/candidates/preferred/graph").await, "graph.json");
    let next = client.get("/v1/maps/aces").await.json()["next_seq"].as_u64().unwrap();
    assert_answer(&client.post("aces", JSON, r#"{"seq":19,"kind":"travel"}"#).await, "sequence-gap.json");
    for (seq, word) in (next..).zip(["assert.json", "retract.json"]) {
        let posted = client.post("aces", JSON, example(word)).await.json();
        assert_eq!(posted["next_seq"], seq + 1, "{posted}");
    }
}

/// Of the whole walk, in which candidates branch.
#[tokio::test]
async fn reasons() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    for (path, name) in [
        ("candidates/preferred/explain?visits=0,8", "explain.json"),
        ("candidates/preferred/diff/13", "diff.json"),
        ("tree?observation=3&depth=2&limit=2&ended=true", "tree.json"),
        ("next?limit=2", "next.json"),
    ] {
        assert_answer(&client.get(&format!("/v1/maps/aces/{path}")).await, name);
    }
}

/// A crossing as a picture: its four ways make two paths.
#[tokio::test]
async fn an_observation_by_grid() {
    let client = Client::new();
    client.put("crossing", "").await;
    let first = example("lpm-observation.json");
    assert_eq!(client.post("crossing", JSON, first.clone()).await.json()["next_seq"], 1);
    let preferred = client.get("/v1/maps/crossing/candidates/preferred").await.json();
    assert_eq!((&preferred["dstates"], &preferred["paths"]), (&4.into(), &2.into()));
    let events = [
        r#"{"seq":1,"kind":"turn","heading":0.1}"#.to_owned(),
        r#"{"seq":2,"kind":"travel","odometry":{"x":9.0,"y":0.0,"theta":0.0},"covariance":[0.01,0,0,0,0.01,0,0,0,0.001]}"#.to_owned(),
        first.replace("\"seq\": 0", "\"seq\": 3"),
    ];
    let posted = client.post("crossing", JSON, format!("[{}]", events.join(","))).await;
    assert_eq!(posted.json()["next_seq"], 4, "{}", posted.json());
    let preferred = client.get("/v1/maps/crossing/candidates/preferred").await.json();
    assert_eq!((&preferred["segments"], &preferred["visits"]), (&1.into(), &serde_json::json!([0, 1])));
    let candidate = "/v1/maps/crossing/candidates/preferred";
    assert_answer(&client.get(&format!("{candidate}/graph")).await, "graph-measured.json");
    assert_answer(&client.get(&format!("{candidate}/grid?resolution=1")).await, "grid.json");
}

#[tokio::test]
async fn a_grid_without_a_place_is_refused_at_its_field() {
    let client = Client::new();
    client.put("void", "").await;
    let event = r#"{"seq":0,"kind":"observation","lpm":{"info":{"resolution":0.05,"width":2,"height":2},"data":[-1,-1,-1,-1]}}"#;
    assert_eq!(client.post("void", JSON, event).await.problem(422, "malformed-event")["pointer"], "/lpm");
}
