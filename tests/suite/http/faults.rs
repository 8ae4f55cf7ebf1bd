//! Faults that no handler sees, and limits: problem documents all the same.

use crate::http::client::{Client, JSON, NDJSON, aces, aces_lines, array};
use axum::body::Body;
use axum::http::{Method, Request, header};
use topostar::service::Limits;

#[tokio::test]
async fn unknown_resources() {
    let client = Client::new();
    for path in
        ["/", "/v2/maps", "/v1/maps", "/v1/maps/", "/v1/maps/a/b", "/v1/maps/a/candidates/3", "/livez/"]
    {
        assert_eq!(client.get(path).await.problem(404, "unknown-resource")["instance"], path);
    }
}

#[tokio::test]
async fn methods_that_a_resource_does_not_have() {
    let client = Client::new();
    let cases = [
        (Method::POST, "/v1/maps/a", "GET,HEAD,PUT"),
        (Method::GET, "/v1/maps/a/events", "POST"),
        (Method::DELETE, "/v1/maps/a/candidates", "GET,HEAD"),
        (Method::PUT, "/livez", "GET,HEAD"),
    ];
    for (method, path, allowed) in cases {
        let answer = client.call(method, path, JSON, "").await;
        answer.problem(405, "method-not-allowed");
        let mut allow: Vec<&str> = answer.headers[header::ALLOW].to_str().unwrap().split(',').collect();
        allow.sort_unstable();
        assert_eq!(allow.join(","), allowed);
    }
}

#[tokio::test]
async fn media_types_that_are_not_read() {
    let client = Client::new();
    client.put("aces", "").await;
    for kind in ["", "text/plain", "application/json5", "application/xml", "multipart/form-data", "\u{e9}"] {
        let answer = client.post("aces", kind, aces()).await;
        answer.problem(415, "unsupported-media-type");
    }
    let request = Request::post("/v1/maps/aces/events").body(Body::from(aces())).unwrap();
    client.send(request).await.problem(415, "unsupported-media-type");
    let zipped = Request::post("/v1/maps/aces/events")
        .header(header::CONTENT_TYPE, NDJSON)
        .header(header::CONTENT_ENCODING, "gzip")
        .body(Body::from(aces()))
        .unwrap();
    client.send(zipped).await.problem(415, "unsupported-media-type");
    let config = client.call(Method::PUT, "/v1/maps/b", "text/plain", "{}").await;
    config.problem(415, "unsupported-media-type");
}

#[tokio::test]
async fn bodies_and_lines_beyond_their_bounds() {
    let limits = Limits { json_bytes: 2000, line_bytes: 1000, config_bytes: 50, ..Limits::default() };
    let client = Client::with_limits(limits);
    client.put("aces", &format!("{{{}}}", " ".repeat(50))).await.problem(413, "body-too-large");
    client.put("aces", "").await;
    client.post("aces", JSON, array(&aces_lines())).await.problem(413, "body-too-large");
    let long = format!("{}\n{}\n", aces_lines()[0], " ".repeat(1001));
    let problem = client.post("aces", NDJSON, long).await.problem(413, "body-too-large");
    assert_eq!((problem["line"].as_u64(), problem["accepted_through"].as_u64()), (Some(2), Some(0)));
    assert_eq!(client.post("aces", NDJSON, aces()).await.status, 200);
}

#[tokio::test]
async fn maps_and_events_beyond_their_bounds() {
    let limits = Limits { maps: 1, events_per_map: 2, ..Limits::default() };
    let client = Client::with_limits(limits);
    assert_eq!(client.put("a", "").await.status, 201);
    assert_eq!(client.put("a", "").await.status, 200);
    client.put("b", "").await.problem(507, "too-many-maps");
    let problem = client.post("a", NDJSON, aces()).await.problem(507, "map-full");
    assert_eq!((problem["line"].as_u64(), problem["accepted_through"].as_u64()), (Some(3), Some(1)));
    let known = aces_lines()[..2].join("\n");
    assert_eq!(client.post("a", NDJSON, known).await.json()["replayed"], 2);
}

#[tokio::test]
async fn grids_beyond_their_bound() {
    let client = Client::with_limits(Limits { cells_per_map: 3, ..Limits::default() });
    client.put("a", "").await;
    let grid = r#"{"info":{"resolution":0.05,"width":2,"height":2},"data":[0,0,0,0]}"#;
    let event = format!(r#"{{"seq":0,"kind":"observation","lpm":{grid}}}"#);
    client.post("a", JSON, event).await.problem(507, "map-full");
}

#[tokio::test]
async fn candidates_beyond_their_bound_are_counted_as_at_least() {
    let client = Client::new();
    client.with_aces("aces", r#"{"profile":"paper","max_candidates":5}"#).await;
    let map = client.get("/v1/maps/aces").await.json();
    assert_eq!(map["candidates"], serde_json::json!({"value": 5, "relation": "gte"}));
    assert_eq!(
        (map["complete"].as_bool(), map["stop_reason"].as_str()),
        (Some(false), Some("candidate-limit"))
    );
    assert_eq!(
        (map["preferred"]["unique"].as_bool(), map["preferred"]["proven"].as_bool()),
        (Some(false), Some(false))
    );
}

#[tokio::test]
async fn events_for_an_unknown_map_say_how_to_make_it() {
    let problem = Client::new().post("aces", NDJSON, aces()).await.problem(404, "unknown-map");
    assert!(problem["detail"].as_str().unwrap().contains("PUT /v1/maps/aces"), "{problem}");
    assert_eq!(problem["instance"], "/v1/maps/aces/events");
}
