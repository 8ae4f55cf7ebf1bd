//! Reading candidates, the preferred one and its graph.

use crate::http::client::{Client, JSON, aces_lines, array};
use serde_json::{Value, json};
use std::collections::BTreeSet;

const ONE_WAY: &str = r#"{"slots":[{"fragment":1,"direction":"+","out":null,"in":1,"control":"dead_end"},{"fragment":1,"direction":"-","out":1,"in":null,"control":"midline"}]}"#;

#[tokio::test]
async fn pages_list_every_candidate_once_and_in_order() {
    let client = Client::new();
    client.with_aces("aces", r#"{"profile":"paper"}"#).await;
    let all = client.get("/v1/maps/aces/candidates?limit=1000").await.json();
    assert_eq!((&all["total"], &all["next"]), (&json!({"value": 35, "relation": "eq"}), &json!(null)));
    let mut paged: Vec<Value> = Vec::new();
    let mut path = "/v1/maps/aces/candidates?limit=8".to_owned();
    loop {
        let page = client.get(&path).await.json();
        paged.extend(page["candidates"].as_array().unwrap().iter().cloned());
        let Some(next) = page["next"].as_str() else { break };
        path = format!("/v1/maps/aces/candidates?limit=8&cursor={next}");
    }
    assert_eq!(json!(paged), all["candidates"]);
    assert!(paged.iter().enumerate().all(|(id, candidate)| candidate["id"] == id));
    let assignments: BTreeSet<String> =
        paged.iter().map(|c| format!("{}{}", c["visits"], c["rotations"])).collect();
    assert_eq!(assignments.len(), 35);
    let default_page = client.get("/v1/maps/aces/candidates").await.json();
    assert_eq!(default_page["candidates"].as_array().map(Vec::len), Some(20));
}

#[tokio::test]
async fn a_wrong_page_is_refused() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    for query in
        ["limit=0", "limit=1001", "limit=-1", "limit=x", "cursor=%21", "cursor=MTA", "order=up", "limit=%FF"]
    {
        client.get(&format!("/v1/maps/aces/candidates?{query}")).await.problem(400, "invalid-query");
    }
}

#[tokio::test]
async fn a_cursor_ends_with_the_next_observation() {
    let client = Client::new();
    client.put("aces", r#"{"profile":"paper"}"#).await;
    let lines = aces_lines();
    let (last, before) = lines.split_last().unwrap();
    client.post("aces", JSON, array(before)).await;
    let page = client.get("/v1/maps/aces/candidates?limit=1").await.json();
    let next = format!("/v1/maps/aces/candidates?limit=1&cursor={}", page["next"].as_str().unwrap());
    assert_eq!(client.get(&next).await.status, 200);
    client.post("aces", JSON, last.clone()).await;
    client.get(&next).await.problem(410, "stale-cursor");
}

#[tokio::test]
async fn the_preferred_candidate_is_that_of_the_map() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let preferred = client.get("/v1/maps/aces/candidates/preferred").await.json();
    assert_eq!(preferred, client.get("/v1/maps/aces").await.json()["preferred"]);
}

#[tokio::test]
async fn the_graph_holds_what_the_preferred_candidate_counts() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    let preferred = client.get("/v1/maps/aces/candidates/preferred").await.json();
    let graph = client.get("/v1/maps/aces/candidates/preferred/graph").await.json();
    let len = |value: &Value| json!(value.as_array().unwrap().len());
    for part in ["places", "paths", "segments"] {
        assert_eq!(len(&graph[part]), preferred[part], "{part}");
    }
    let places = graph["places"].as_array().unwrap();
    let dstates: Vec<&Value> = places.iter().flat_map(|p| p["dstates"].as_array().unwrap()).collect();
    assert_eq!(json!(dstates.len()), preferred["dstates"]);
    let open = dstates.iter().filter(|d| d["navigable"] == true && d["far_end"].is_null()).count();
    assert_eq!(len(&graph["frontier"]), open);
    for path in graph["paths"].as_array().unwrap() {
        let on = |name: &Value, place: &Value| {
            graph["paths"][name.as_u64().unwrap() as usize]["places"].as_array().unwrap().contains(place)
        };
        for beside in ["left", "right"].into_iter().flat_map(|side| path["regions"][side].as_array().unwrap())
        {
            assert!(!on(&path["id"], &beside["place"]));
            for by in beside["evidence"].as_array().unwrap() {
                assert!(
                    on(&path["id"], &by["at"])
                        && on(&by["path"], &by["at"])
                        && on(&by["path"], &beside["place"])
                );
            }
        }
        assert_eq!(path["regions"]["abnormal"], json!([]));
    }
    for segment in graph["segments"].as_array().unwrap() {
        let [a, b] = &segment["ends"].as_array().unwrap()[..] else { panic!("{segment}") };
        let far_end = |end: &Value| {
            let place = &graph["places"][end["place"].as_u64().unwrap() as usize];
            place["dstates"][end["slot"].as_u64().unwrap() as usize]["far_end"].clone()
        };
        assert_eq!((&far_end(a), &far_end(b)), (b, a));
    }
}

#[tokio::test]
async fn without_an_observation_nothing_is_preferred() {
    let client = Client::new();
    client.put("office", "").await;
    for path in ["preferred", "preferred/graph"] {
        client.get(&format!("/v1/maps/office/candidates/{path}")).await.problem(404, "no-observation");
        client.get(&format!("/v1/maps/other/candidates/{path}")).await.problem(404, "unknown-map");
    }
    assert_eq!(client.get("/v1/maps/office/candidates").await.json()["candidates"], json!([]));
}

/// From one dead end straight into another, and back by a gateway into a place that is not the first.
#[tokio::test]
async fn where_nothing_is_consistent_the_axioms_are_named() {
    let client = Client::new();
    client.put("office", "").await;
    let other = ONE_WAY.replace("midline", "left_wall");
    let events = [
        format!(r#"{{"seq":0,"kind":"observation","star":{ONE_WAY},"dstate":1}}"#),
        r#"{"seq":1,"kind":"travel"}"#.into(),
        format!(r#"{{"seq":2,"kind":"observation","star":{other},"dstate":0}}"#),
        r#"{"seq":3,"kind":"turn","to":1}"#.into(),
        r#"{"seq":4,"kind":"travel"}"#.into(),
        format!(r#"{{"seq":5,"kind":"observation","star":{other},"dstate":0}}"#),
    ];
    let posted = client.post("office", JSON, format!("[{}]", events.join(","))).await;
    assert_eq!(posted.json()["candidates"], json!({"value": 0, "relation": "eq"}));
    let map = client.get("/v1/maps/office").await.json();
    let extinction = json!({"observation": 2, "axioms": ["star-match"]});
    assert_eq!((&map["extinction"], &map["stop_reason"]), (&extinction, &json!("inconsistent")));
    for path in ["preferred", "preferred/graph"] {
        let problem =
            client.get(&format!("/v1/maps/office/candidates/{path}")).await.problem(404, "no-consistent-map");
        assert_eq!((&problem["observation"], &problem["axioms"]), (&json!(2), &json!(["star-match"])));
    }
}
