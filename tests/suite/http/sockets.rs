//! The service behind a socket, as clients reach it.

use crate::http::client::{NDJSON, aces, aces_lines};
use std::sync::Arc;
use topostar::service::{Limits, Maps, MemoryStore, serve};
use ureq::Agent;

/// A service on a free port of loopback, for as long as the test runs, and its address.
async fn served() -> String {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    let maps = Maps::new(Arc::new(MemoryStore::new(10)), Limits::default());
    tokio::spawn(serve(listener, maps));
    address
}

fn post(url: &str, body: &str) -> (u16, String) {
    let agent: Agent = Agent::config_builder().http_status_as_error(false).build().into();
    let mut answer = agent.post(url).header("Content-Type", NDJSON).send(body).unwrap();
    (answer.status().as_u16(), answer.body_mut().read_to_string().unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fault_early_in_a_long_stream_is_answered() {
    let address = served().await;
    tokio::task::spawn_blocking(move || {
        let map = format!("{address}/v1/maps/aces");
        assert_eq!(ureq::put(&map).send_empty().unwrap().status(), 201);
        let events = format!("{map}/events");
        let long = format!("{}\n{}\n{}", aces_lines()[0], "{}", aces().repeat(1000));
        let (status, problem) = post(&events, &long);
        assert!(status == 422 && problem.contains(r#""line":2"#), "{status} {problem}");
        let (status, receipt) = post(&events, &aces());
        assert!(status == 200 && receipt.contains(r#""value":23"#), "{status} {receipt}");
    })
    .await
    .unwrap();
}
