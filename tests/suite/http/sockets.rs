//! The service behind a socket, as clients reach it.

use crate::http::client::{JSON, NDJSON, aces, aces_lines};
use crate::http::patchwork::ndjson;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;
use topostar::service::{Limits, Maps, MemoryStore, Workload, serve};
use topostar::worlds::{bundled, lpm_trace};
use ureq::Agent;

/// A service on a free port of loopback, for as long as the test runs, and its address.
async fn serving(maps: Maps) -> String {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
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
    let address = serving(Maps::new(Arc::new(MemoryStore::new(10)), Limits::default())).await;
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

/// A service with a walk through the office as grids, and the maps that it serves.
async fn with_office(map: &str, config: &str) -> (String, Maps) {
    let long = Duration::from_secs(3600);
    let limits = Limits { cells_per_answer: 64 << 20, patchwork_time: long, ..Limits::default() };
    let maps = Maps::new(Arc::new(MemoryStore::new(10)), limits);
    let address = serving(maps.clone()).await;
    let (url, config) = (format!("{address}/v1/maps/{map}"), config.to_owned());
    tokio::task::spawn_blocking(move || {
        let made = ureq::put(&url).header("Content-Type", JSON).send(config).unwrap();
        assert_eq!(made.status(), 201);
        let walk = lpm_trace(&bundled("office").unwrap(), 0, 0.05).unwrap();
        assert_eq!(post(&format!("{url}/events"), &ndjson(&walk)).0, 200);
    })
    .await
    .unwrap();
    (address, maps)
}

/// A client that has sent a request and waits for the answer, until it is dropped.
fn asking(address: &str, path: &str) -> TcpStream {
    let host = address.trim_start_matches("http://");
    let mut client = TcpStream::connect(host).unwrap();
    write!(client, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    client
}

/// The beginning of the answer that a client gets.
fn status(mut client: TcpStream) -> [u8; 12] {
    let mut head = [0; 12];
    client.read_exact(&mut head).unwrap();
    head
}

/// Waits until the patchworks in the making are as wanted.
async fn until(maps: &Maps, wanted: impl Fn(Workload) -> bool) -> Workload {
    let waiting = async {
        loop {
            let workload = maps.patchworks();
            if wanted(workload) {
                return workload;
            }
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    let came = tokio::time::timeout(Duration::from_secs(120), waiting).await;
    came.unwrap_or_else(|_| panic!("it stays at {:?}", maps.patchworks()))
}

/// Whatever is made of a candidate ends with the connection that asked for it, long before it is done. What is told to
/// stop does so at once, as the tests beside the work show; what has come to its end is not told any more.
#[tokio::test(flavor = "multi_thread")]
async fn what_is_made_for_a_client_ends_with_its_connection() {
    for (config, path) in [
        ("", "graph"),
        ("", "grid?format=pgm&resolution=0.01"),
        // Two maps tie, and both are relaxed to tell which is preferred.
        (r#"{"profile":"paper"}"#, "graph"),
    ] {
        let (address, maps) = with_office("office", config).await;
        let client = asking(&address, &format!("/v1/maps/office/candidates/preferred/{path}"));
        until(&maps, |load| load.running == 1).await;
        drop(client);
        let left = until(&maps, |load| load.running == 0).await;
        assert_eq!(left, Workload { running: 0, ended: 1, stopped: 1 }, "{config} {path}");
    }
}

/// What two clients wait for, the order of maps that tie, is not lost with the one on whose account it is found.
#[tokio::test(flavor = "multi_thread")]
async fn who_waits_for_the_same_work_gets_it() {
    let (address, maps) = with_office("office", r#"{"profile":"paper"}"#).await;
    let path = "/v1/maps/office/candidates/preferred/graph";
    let gone = asking(&address, path);
    until(&maps, |load| load.running == 1).await;
    let staying = asking(&address, path);
    drop(gone);
    assert_eq!(tokio::task::spawn_blocking(|| status(staying)).await.unwrap(), *b"HTTP/1.1 200");
    let left = until(&maps, |load| load.running == 0).await;
    // The one was stopped; for the other the maps were put in order, and the first of them relaxed.
    assert_eq!(left, Workload { running: 0, ended: 3, stopped: 1 });
}

/// Many clients ask for a large grid and go away: all threads are free again, for those who stay.
#[tokio::test(flavor = "multi_thread")]
async fn clients_that_go_away_leave_the_threads_to_those_who_stay() {
    let (address, maps) = with_office("office", "").await;
    let path = |resolution: f64| {
        format!("/v1/maps/office/candidates/preferred/grid?format=pgm&resolution={resolution}")
    };
    let threads = maps.patchwork_threads();
    let gone: Vec<TcpStream> = (0..20 * threads).map(|_| asking(&address, &path(0.01))).collect();
    until(&maps, |load| load.running == threads).await;
    let staying = asking(&address, &path(0.5));
    drop(gone);
    let url = format!("{address}{}", path(0.5));
    let answer = tokio::task::spawn_blocking(move || {
        (status(staying), ureq::get(&url).call().unwrap().status().as_u16())
    });
    assert_eq!(answer.await.unwrap(), (*b"HTTP/1.1 200", 200));
    let left = until(&maps, |load| load.running == 0).await;
    // The two who stayed were answered, and nobody else's grid was made.
    assert!(left.stopped >= threads as u64 && left.ended == left.stopped + 2, "{left:?}");
}
