//! Bodies made to break the service: each is refused, and the map goes on.

use crate::http::client::{Client, JSON, NDJSON, aces, aces_lines};
use axum::body::{Body, Bytes};

async fn fresh() -> Client {
    let client = Client::new();
    client.put("a", "").await;
    client
}

async fn still_works(client: &Client) {
    assert_eq!(client.get("/v1/maps/a").await.json()["next_seq"], 0);
    assert_eq!(client.post("a", NDJSON, aces()).await.json()["candidates"]["value"], 23);
}

#[tokio::test]
async fn deep_json() {
    let client = fresh().await;
    for open in ["[", "{\"a\":"] {
        let deep = open.repeat(200_000);
        client.post("a", JSON, deep.clone()).await.problem(400, "malformed-json");
        client.post("a", NDJSON, deep.clone()).await.problem(422, "malformed-event");
        client.put("a", &deep[..60_000]).await.problem(400, "malformed-json");
    }
    let closed = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    client.post("a", JSON, closed.clone()).await.problem(422, "malformed-event");
    let inside = format!(r#"{{"seq":0,"kind":"observation","star":{closed}}}"#);
    client.post("a", JSON, inside).await.problem(422, "malformed-event");
    still_works(&client).await;
}

#[tokio::test]
async fn huge_numbers() {
    let client = fresh().await;
    for seq in ["-1", "1e999", "18446744073709551616", "0.5", "1e0", "\"0\"", "null"] {
        let event = format!(r#"{{"seq":{seq},"kind":"travel"}}"#);
        assert_eq!(
            client.post("a", JSON, event).await.problem(422, "malformed-event")["pointer"],
            "/seq",
            "{seq}"
        );
    }
    let far = r#"{"seq":18446744073709551615,"kind":"travel"}"#;
    client.post("a", JSON, far).await.problem(409, "sequence-gap");
    let star = aces_lines()[0].replacen("\"fragment\": 2", "\"fragment\": 99999999999", 1);
    client.post("a", JSON, star).await.problem(422, "malformed-event");
    let side = r#"{"seq":0,"kind":"observation","lpm":{"info":{"resolution":0.05,"width":4294967296,"height":4294967296},"data":[]}}"#;
    client.post("a", JSON, side).await.problem(422, "malformed-event");
    still_works(&client).await;
}

/// Profile `classic` is not served.
#[tokio::test]
async fn events_of_a_trace_of_views() {
    let client = fresh().await;
    let view = r#"{"seq":0,"kind":"observation","view":"corridor ahead"}"#;
    for kind in [JSON, NDJSON] {
        let problem = client.post("a", kind, view).await.problem(422, "malformed-event");
        assert_eq!((&problem["pointer"], &problem["seq"]), (&"/view".into(), &0.into()));
        assert!(
            problem["detail"].as_str().unwrap().contains("which profile classic alone explains"),
            "{problem}"
        );
    }
    let turned = format!("{}\n{{\"seq\":1,\"kind\":\"turn\",\"turn\":\"left\"}}", aces_lines()[0]);
    client.put("b", "").await;
    let problem = client.post("b", NDJSON, turned).await.problem(422, "malformed-event");
    assert_eq!((&problem["pointer"], &problem["line"]), (&"/turn".into(), &2.into()));
    still_works(&client).await;
}

#[tokio::test]
async fn invalid_utf8() {
    let client = fresh().await;
    let mut body = br#"{"seq":0,"kind":""#.to_vec();
    body.extend([0xff, 0xfe]);
    body.extend(br#""}"#);
    client.post("a", JSON, body.clone()).await.problem(400, "malformed-json");
    assert_eq!(client.post("a", NDJSON, body).await.problem(422, "malformed-event")["line"], 1);
    still_works(&client).await;
}

#[tokio::test]
async fn truncated_and_empty_bodies() {
    let client = fresh().await;
    for body in ["", " \n", "[", "[{}", r#"{"seq":0"#, "{}{}", "[] []"] {
        client.post("a", JSON, body).await.problem(400, "malformed-json");
    }
    for body in ["[]", "[\n]"] {
        assert_eq!(client.post("a", JSON, body).await.json()["accepted"], 0);
    }
    for body in ["", "\n\n \r\n"] {
        let receipt = client.post("a", NDJSON, body).await.json();
        assert_eq!(
            (&receipt["accepted"], receipt["accepted_through"].is_null()),
            (&serde_json::json!(0), true)
        );
    }
    for body in ["null", "3", "\"x\"", "[null]", "{}"] {
        client.post("a", JSON, body).await.problem(422, "malformed-event");
    }
    still_works(&client).await;
}

#[tokio::test]
async fn the_last_line_may_lack_its_end_but_not_its_content() {
    let client = fresh().await;
    let body = aces();
    let cut = &body[..body.trim_end().len() - 1];
    let problem = client.post("a", NDJSON, cut.to_owned()).await.problem(422, "malformed-event");
    assert_eq!(problem["line"].as_u64(), Some(aces_lines().len() as u64));
    assert_eq!(client.post("a", NDJSON, body).await.json()["candidates"]["value"], 23);
}

#[tokio::test]
async fn a_body_that_breaks_off_keeps_the_lines_that_came() {
    let client = fresh().await;
    let first = format!("{}\n{{\"seq\":1", aces_lines()[0]);
    let pieces = [Ok(Bytes::from(first)), Err(std::io::Error::other("reset"))];
    let body = Body::from_stream(futures_util::stream::iter(pieces));
    client.post("a", NDJSON, body).await.problem(400, "incomplete-body");
    assert_eq!(client.get("/v1/maps/a").await.json()["next_seq"], 1);
}
