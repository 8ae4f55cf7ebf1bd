//! The service behind a socket, as clients reach it.

use crate::http::client::{NDJSON, aces, aces_lines};
use crate::http::patchwork::{ndjson, office};
use std::io::Write;
use std::net::TcpStream;
use std::sync::Arc;
use std::thread::{available_parallelism, sleep};
use std::time::{Duration, Instant};
use topostar::service::{Limits, Maps, MemoryStore, serve};
use ureq::Agent;

/// A service on a free port of loopback, for as long as the test runs, and its address.
async fn served(limits: Limits) -> String {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    let maps = Maps::new(Arc::new(MemoryStore::new(10)), limits);
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
    let address = served(Limits::default()).await;
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

/// Many clients ask for a large grid and go away: who stays need not wait until all of them are made.
#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_goes_away_ends_its_grid() {
    let long = Duration::from_secs(3600);
    let limits = Limits { cells_per_answer: 64 << 20, patchwork_time: long, ..Limits::default() };
    let address = served(limits).await;
    tokio::task::spawn_blocking(move || {
        let map = format!("{address}/v1/maps/office");
        assert_eq!(ureq::put(&map).send_empty().unwrap().status(), 201);
        assert_eq!(post(&format!("{map}/events"), &ndjson(&office())).0, 200);
        let grid = |resolution: f64| {
            let begun = Instant::now();
            let url = format!("{map}/candidates/preferred/grid?format=pgm&resolution={resolution}");
            assert_eq!(ureq::get(&url).call().unwrap().status(), 200);
            begun.elapsed()
        };
        let (whole, workers) = (grid(0.015), available_parallelism().map_or(1, |count| count.get()));
        let path = "/v1/maps/office/candidates/preferred/grid?format=pgm&resolution=0.015";
        let host = address.trim_start_matches("http://");
        let ask = |_| {
            let mut client = TcpStream::connect(host).unwrap();
            write!(client, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
            client
        };
        let rounds = 20;
        let clients: Vec<TcpStream> = (0..rounds * workers).map(ask).collect();
        sleep(whole / 4);
        drop(clients);
        let waited = grid(0.5);
        assert!(waited < whole * rounds as u32 / 4, "waited {waited:?} where one grid takes {whole:?}");
    })
    .await
    .unwrap();
}
