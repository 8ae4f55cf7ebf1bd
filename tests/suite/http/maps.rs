//! Making and reading maps.

use crate::http::client::Client;
use axum::body::Body;
use axum::http::{Method, Request, header};
use serde_json::json;

#[tokio::test]
async fn a_map_is_made_once() {
    let client = Client::new();
    let made = client.put("office", "").await;
    assert_eq!(made.status, 201);
    assert_eq!(client.put("office", "{}").await.status, 200);
    assert_eq!(client.put("office", r#"{"profile":"default","strategy":"breadth-first"}"#).await.status, 200);
    client.put("office", r#"{"profile":"paper"}"#).await.problem(409, "config-conflict");
    assert_eq!(client.get("/v1/maps/office").await.body, made.body);
}

#[tokio::test]
async fn a_new_map_says_what_it_holds_and_expects() {
    let client = Client::new();
    let expected = json!({
        "map": "office", "next_seq": 0, "max_candidates": 7, "max_memory": 1000, "version": 1,
        "candidates": {"value": 0, "relation": "eq"}, "candidates_per_observation": [], "maps_created": 0,
        "refuted": {"determinism": 0, "path-order": 0, "star-match": 0, "travel-moves": 0},
        "strategy": "breadth-first", "profile": "paper",
        "axioms": ["determinism", "star-match", "travel-moves", "path-order"], "complete": true,
        "preferred": null, "minimal": [], "minimal_maps": 0, "stop_reason": null, "extinction": null, "asserts": [],
    });
    let made = client.put("office", r#"{"profile":"paper","max_candidates":7,"max_memory":1000}"#).await;
    assert_eq!(made.json(), expected);
}

#[tokio::test]
async fn axioms_are_a_configuration_of_their_own() {
    let client = Client::new();
    let four = r#"["path-order","star-match","determinism","travel-moves"]"#;
    let paper = client.put("a", &format!(r#"{{"axioms":{four}}}"#)).await;
    assert_eq!(paper.json()["profile"], "paper");
    let custom = client.put("b", r#"{"axioms":["determinism","star-match","planarity"]}"#).await;
    assert_eq!(custom.json()["profile"], "custom");
    assert_eq!(custom.json()["axioms"], json!(["determinism", "star-match", "planarity"]));
}

#[tokio::test]
async fn boundaries_join_a_profile() {
    let client = Client::new();
    let hard = client.put("hard", r#"{"profile":"paper","boundary":"hard"}"#).await.json();
    let paper = json!(["determinism", "star-match", "travel-moves", "path-order", "boundary"]);
    assert_eq!(
        (&hard["axioms"], &hard["profile"], &hard["refuted"]["boundary"]),
        (&paper, &json!("custom"), &json!(0))
    );
    let soft = client.put("soft", r#"{"boundary":"soft"}"#).await.json();
    assert_eq!(soft["axioms"].as_array().unwrap().last(), Some(&json!("boundary=soft")));
    assert!(soft["refuted"].get("boundary").is_none());
    let listed =
        client.put("listed", r#"{"axioms":["determinism","star-match","boundary=soft"]}"#).await.json();
    assert_eq!(listed["axioms"], json!(["determinism", "star-match", "boundary=soft"]));
}

#[tokio::test]
async fn an_empty_body_needs_no_media_type() {
    let request = Request::put("/v1/maps/office").body(Body::empty()).unwrap();
    assert_eq!(Client::new().send(request).await.status, 201);
}

#[tokio::test]
async fn a_wrong_configuration_is_refused_at_its_field() {
    let client = Client::new();
    let cases = [
        (r#"{"colour":1}"#, "/colour"),
        (r#"{"profile":"fast"}"#, "/profile"),
        (r#"{"strategy":"depth-first"}"#, "/strategy"),
        (r#"{"axioms":["path-order"]}"#, "/axioms"),
        (r#"{"axioms":[]}"#, "/axioms"),
        (r#"{"axioms":["gravity"]}"#, "/axioms"),
        (r#"{"axioms":[1]}"#, "/axioms/0"),
        (r#"{"axioms":["determinism","star-match"],"profile":"paper"}"#, "/axioms"),
        (r#"{"boundary":"firm"}"#, "/boundary"),
        (r#"{"axioms":["determinism","star-match"],"boundary":"soft"}"#, "/boundary"),
        (r#"{"axioms":["determinism","star-match","boundary","boundary=soft"]}"#, "/axioms"),
        (r#"{"max_candidates":0}"#, "/max_candidates"),
        (r#"{"max_candidates":18446744073709551615}"#, "/max_candidates"),
        (r#"{"max_candidates":-1}"#, "/max_candidates"),
        (r#"{"max_memory":0}"#, "/max_memory"),
        (r#"{"max_memory":1000000000000}"#, "/max_memory"),
        (r#"{"profile":"paper","profile":"default"}"#, ""),
        ("[]", ""),
        ("null", ""),
    ];
    for (config, pointer) in cases {
        let problem = client.put("office", config).await.problem(422, "malformed-config");
        assert_eq!(problem["pointer"], pointer, "{config}: {problem}");
        assert_eq!(problem["instance"], "/v1/maps/office");
    }
    client.put("office", "{").await.problem(400, "malformed-json");
    client.get("/v1/maps/office").await.problem(404, "unknown-map");
}

#[tokio::test]
async fn names_that_are_none_are_refused() {
    let client = Client::new();
    for name in ["a%2Fb", "%20", "%C3%A4", &"x".repeat(65), "%FF", ".."] {
        client.put(name, "").await.problem(422, "invalid-map-name");
    }
    assert_eq!(client.put(&"x".repeat(64), "").await.status, 201);
}

#[tokio::test]
async fn an_unchanged_map_is_not_sent_again() {
    let client = Client::new();
    client.with_aces("aces", "").await;
    for path in ["", "/candidates", "/candidates/preferred", "/candidates/preferred/graph"] {
        let path = format!("/v1/maps/aces{path}");
        let first = client.get(&path).await;
        let tag = first.headers[header::ETAG].clone();
        let again = Request::get(&path).header(header::IF_NONE_MATCH, &tag).body(Body::empty()).unwrap();
        let again = client.send(again).await;
        assert_eq!((again.status.as_u16(), again.body.len(), &again.headers[header::ETAG]), (304, 0, &tag));
        let other = Request::get(&path).header(header::IF_NONE_MATCH, "\"0\"").body(Body::empty()).unwrap();
        assert_eq!(client.send(other).await.body, first.body);
    }
}

#[tokio::test]
async fn the_process_says_that_it_lives_and_what_it_offers() {
    let client = Client::new();
    assert_eq!(client.get("/livez").await.status, 200);
    assert_eq!(
        client.get("/openapi.json").await.json(),
        serde_json::to_value(topostar::service::openapi()).unwrap()
    );
    let head = Request::builder().method(Method::HEAD).uri("/livez").body(Body::empty()).unwrap();
    assert_eq!(client.send(head).await.status, 200);
}
