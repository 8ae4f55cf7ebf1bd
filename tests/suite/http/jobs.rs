//! Jobs: grids and relaxed graphs that a client does not wait for.

use crate::http::client::{Answer, Client, NDJSON};
use crate::http::patchwork::{GRAPH, GRID, busy, holding, ndjson, office, with_office};
use axum::body::Body;
use axum::http::{Method, Request, header};
use humantime::parse_rfc3339;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};
use topostar::service::{Limits, Maps, MemoryStore, Workload};

const ASYNC: &str = "respond-async";
const OTHER: &str = "/v1/maps/office/candidates/0/graph";
const SOON: Duration = Duration::from_secs(120);

/// A client of a map `office` that took the walk, and the maps behind it.
async fn with_maps(limits: Limits, config: &str) -> (Client, Maps) {
    let maps = Maps::new(Arc::new(MemoryStore::new(9)), limits);
    (holding(Client::of(maps.clone()), config, &office()).await, maps)
}

/// Limits under which a grid may have so many cells that it takes long.
fn large() -> Limits {
    Limits { cells_per_answer: 64 << 20, ..Limits::default() }
}

/// The grid of a candidate with many cells, each of another size.
fn large_grid(number: usize) -> String {
    let resolution = 0.01 + 1e-6 * number as f64;
    format!("/v1/maps/office/candidates/0/grid?format=pgm&resolution={resolution}")
}

async fn preferring(client: &Client, path: &str, prefer: &str) -> Answer {
    client.send(Request::get(path).header("prefer", prefer).body(Body::empty()).unwrap()).await
}

/// The address of the job that a request became.
async fn begun(client: &Client, path: &str) -> String {
    let answer = preferring(client, path, ASYNC).await;
    assert_eq!(answer.status, 202, "{}", String::from_utf8_lossy(&answer.body));
    answer.headers[header::LOCATION].to_str().unwrap().to_owned()
}

/// The address of the job that was begun last.
async fn last(client: &Client) -> String {
    let jobs = client.get("/v1/jobs").await.json();
    format!("/v1/jobs/{}", jobs["jobs"].as_array().unwrap().last().unwrap()["id"])
}

async fn status(client: &Client, job: &str) -> String {
    client.get(job).await.json()["status"].as_str().unwrap().to_owned()
}

/// A job that has come to its end.
async fn ended(client: &Client, job: &str) -> Value {
    let polling = async {
        while ["queued", "running"].contains(&status(client, job).await.as_str()) {
            sleep(Duration::from_millis(2)).await;
        }
    };
    timeout(SOON, polling).await.unwrap();
    client.get(job).await.json()
}

async fn cancel(client: &Client, job: &str) -> Answer {
    client.call(Method::DELETE, job, "", "").await
}

/// The patchworks once so many of them run.
async fn running(maps: &Maps, count: usize) -> Workload {
    let waiting = async {
        while maps.patchworks().running != count {
            sleep(Duration::from_millis(1)).await;
        }
    };
    timeout(SOON, waiting).await.unwrap_or_else(|_| panic!("it stays at {:?}", maps.patchworks()));
    maps.patchworks()
}

/// Two maps tie, so that the job also finds which is preferred. What it made is there while every thread is taken.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_makes_what_a_client_would_have_waited_for() {
    let paper = r#"{"profile":"paper"}"#;
    let (client, maps) = with_maps(Limits::default(), paper).await;
    let waiting = with_office(Limits::default(), paper).await;
    let next_seq = office().events.len();
    let grid = format!("{GRID}?resolution=0.1&format=json");
    let picture = format!("{GRID}?resolution=0.1&format=png");
    let mut begun = Vec::new();
    for (kind, path) in [("graph", GRAPH), ("grid", &grid), ("grid", &picture)] {
        let accepted = preferring(&client, path, ASYNC).await;
        assert_eq!(accepted.status, 202);
        let id = accepted.json()["id"].as_u64().unwrap();
        let address = format!("/v1/jobs/{id}");
        for (name, value) in
            [("location", address.as_str()), ("retry-after", "1"), ("preference-applied", ASYNC)]
        {
            assert_eq!(accepted.headers[name], value, "{path}");
        }
        let job = accepted.json();
        assert!(["queued", "running"].contains(&job["status"].as_str().unwrap()), "{job}");
        let done = ended(&client, &address).await;
        for job in [&job, &done] {
            let said = ["id", "kind", "of", "next_seq"].map(|field| &job[field]);
            assert_eq!(said, [&json!(id), &json!(kind), &json!(path), &json!(next_seq)]);
        }
        let result = format!("{address}/result");
        assert_eq!((&done["status"], &done["result"]), (&json!("done"), &json!(result)));
        let [began, ended] =
            ["began", "ended"].map(|when| parse_rfc3339(done[when].as_str().unwrap()).unwrap());
        let longest = ended.duration_since(began).unwrap();
        assert!(began.elapsed().unwrap() < SOON && longest < SOON, "{done}");
        let expected = waiting.get(path).await;
        let busy = busy(&maps).await;
        for answer in [client.get(&result), client.get(path)] {
            let answer = timeout(SOON, answer).await.unwrap();
            assert_eq!(answer.status, 200);
            assert!(answer.body == expected.body, "{path}");
            for name in [header::ETAG, header::CONTENT_TYPE] {
                assert_eq!(answer.headers[&name], expected.headers[&name]);
            }
        }
        // There is nothing left to wait for.
        let again = timeout(SOON, preferring(&client, path, ASYNC)).await.unwrap();
        assert_eq!((again.status.as_u16(), again.headers.contains_key("preference-applied")), (200, false));
        drop(busy);
        running(&maps, 0).await;
        begun.push(id);
    }
    let list = client.get("/v1/jobs").await;
    let ids: Vec<u64> =
        list.json()["jobs"].as_array().unwrap().iter().map(|job| job["id"].as_u64().unwrap()).collect();
    assert_eq!(ids, begun);
    assert!(begun.is_sorted());
    let job = format!("/v1/jobs/{}", begun[1]);
    for path in ["/v1/jobs", &job, &format!("{job}/result")] {
        let tag = client.get(path).await.headers[header::ETAG].clone();
        let known = Request::get(path).header(header::IF_NONE_MATCH, &tag).body(Body::empty()).unwrap();
        assert_eq!(client.send(known).await.status, 304, "{path}");
    }
}

/// A grid asked for by `Accept` has an address of its own.
#[tokio::test]
async fn a_job_is_of_the_form_that_was_accepted() {
    let (client, _) = with_maps(Limits::default(), "").await;
    let request = Request::get(format!("{GRID}?resolution=0.2")).header("prefer", ASYNC);
    let request = request.header(header::ACCEPT, "image/png").body(Body::empty()).unwrap();
    let job = client.send(request).await.json();
    assert_eq!(job["of"], format!("{GRID}?resolution=0.2&format=png"));
    let done = ended(&client, &last(&client).await).await;
    let answer = client.get(done["result"].as_str().unwrap()).await;
    assert_eq!(answer.headers[header::CONTENT_TYPE], "image/png");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_leaves_its_thread() {
    let (client, maps) = with_maps(large(), "").await;
    let turns = maps.patchwork_threads() / 2;
    let mut jobs = Vec::new();
    for candidate in 0..=turns {
        jobs.push(begun(&client, &large_grid(candidate)).await);
    }
    running(&maps, turns).await;
    assert_eq!(
        (status(&client, &jobs[0]).await.as_str(), status(&client, &jobs[turns]).await.as_str()),
        ("running", "queued")
    );
    assert_eq!(client.get(&format!("{}/result", jobs[0])).await.status, 202);
    // Those that wait first, so that they never have a turn.
    for job in jobs.iter().rev() {
        for _ in 0..2 {
            let gone = cancel(&client, job).await;
            assert_eq!((gone.status.as_u16(), gone.body.len()), (204, 0));
        }
        let cancelled = client.get(job).await.json();
        assert_eq!(cancelled["status"], "cancelled");
        assert!(cancelled["ended"].is_string() && cancelled.get("result").is_none(), "{cancelled}");
        client.get(&format!("{job}/result")).await.problem(410, "job-cancelled");
    }
    assert!(client.get(&jobs[turns]).await.json().get("began").is_none());
    let left = running(&maps, 0).await;
    assert_eq!(left, Workload { running: 0, ended: turns as u64, stopped: turns as u64 });
    // The turns are free as well.
    assert_eq!(ended(&client, &begun(&client, GRAPH).await).await["status"], "done");
}

#[tokio::test]
async fn what_is_done_stays_done() {
    let (client, _) = with_maps(Limits::default(), "").await;
    let job = begun(&client, GRAPH).await;
    let done = ended(&client, &job).await;
    assert_eq!(cancel(&client, &job).await.status, 204);
    assert_eq!((client.get(&job).await.json(), &done["status"]), (done.clone(), &json!("done")));
}

#[tokio::test]
async fn what_there_is_not_is_named() {
    let (client, _) = with_maps(Limits::default(), "").await;
    for id in ["1", "0", "-1", "x", "99999999999999999999"] {
        for path in [format!("/v1/jobs/{id}"), format!("/v1/jobs/{id}/result")] {
            client.get(&path).await.problem(404, "unknown-job");
        }
        cancel(&client, &format!("/v1/jobs/{id}")).await.problem(404, "unknown-job");
    }
    client.call(Method::POST, "/v1/jobs", "", "").await.problem(405, "method-not-allowed");
    for (path, status, code) in [
        ("/v1/maps/office/candidates/99/grid", 404, "unknown-candidate"),
        ("/v1/maps/other/candidates/preferred/graph", 404, "unknown-map"),
        ("/v1/maps/office/candidates/preferred/grid?resolution=9", 400, "invalid-query"),
    ] {
        preferring(&client, path, ASYNC).await.problem(status, code);
    }
    assert_eq!(client.get("/v1/jobs").await.json(), json!({"jobs": []}));
}

#[tokio::test(flavor = "multi_thread")]
async fn there_are_so_many_jobs_at_most() {
    let (client, maps) = with_maps(Limits { jobs: 2, ..Limits::default() }, "").await;
    let busy = busy(&maps).await;
    let first = begun(&client, GRAPH).await;
    let second = begun(&client, GRID).await;
    let refused = preferring(&client, OTHER, ASYNC).await;
    let problem = refused.problem(503, "too-many-jobs");
    assert_eq!(
        (&refused.headers[header::RETRY_AFTER], &problem["instance"]),
        (&"10".parse().unwrap(), &json!(OTHER))
    );
    cancel(&client, &first).await;
    let third = begun(&client, OTHER).await;
    client.get(&first).await.problem(404, "unknown-job");
    drop(busy);
    for job in [second, third] {
        assert_eq!(ended(&client, &job).await["status"], "done");
    }
}

/// A job is of the map as it was; the address that it is of is that of the map as it is.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_ends_for_the_map_that_it_was_asked_of() {
    let events = ndjson(&office());
    let lines: Vec<&str> = events.lines().collect();
    let seen = |line: &&str| line.contains("\"observation\"");
    let ninth = lines.iter().enumerate().filter(|(_, line)| seen(line)).nth(8).unwrap().0;
    let (before, after) = (lines[..=ninth].join("\n"), lines[ninth + 1..].join("\n"));
    let maps = Maps::new(Arc::new(MemoryStore::new(1)), Limits::default());
    let [client, other] = [Client::of(maps.clone()), Client::new()];
    for client in [&client, &other] {
        client.put("office", "").await;
        assert_eq!(client.post("office", NDJSON, before.clone()).await.status, 200);
    }
    let grid = format!("{GRID}?resolution=0.2");
    let busy = busy(&maps).await;
    let job = begun(&client, &grid).await;
    assert_eq!(client.post("office", NDJSON, after.clone()).await.status, 200);
    assert_ne!(begun(&client, &grid).await, job);
    drop(busy);
    let done = ended(&client, &job).await;
    assert_eq!((&done["status"], &done["next_seq"]), (&json!("done"), &json!(ninth + 1)));
    let old = client.get(done["result"].as_str().unwrap()).await;
    assert!(old.body == other.get(&grid).await.body);
    other.post("office", NDJSON, after).await;
    let new = client.get(done["of"].as_str().unwrap()).await;
    assert!(new.body == other.get(&grid).await.body && new.body != old.body);
}

#[tokio::test(flavor = "multi_thread")]
async fn who_waits_a_while_has_what_is_done_by_then() {
    let (client, maps) = with_maps(large(), "").await;
    let graph = preferring(&client, GRAPH, "respond-async, wait=100").await;
    assert_eq!(graph.status, 200);
    assert!(graph.body == with_office(Limits::default(), "").await.get(GRAPH).await.body);
    let applied = preferring(&client, &large_grid(0), "wait=0, respond-async").await;
    assert_eq!(
        (applied.status.as_u16(), &applied.headers["preference-applied"]),
        (202, &"respond-async, wait=0".parse().unwrap())
    );
    cancel(&client, applied.headers[header::LOCATION].to_str().unwrap()).await;
    // Who goes away while waiting never learned the number of the job.
    running(&maps, 0).await;
    let gone = waiting(&client, &large_grid(0));
    running(&maps, 1).await;
    gone.abort();
    assert_eq!(ended(&client, &last(&client).await).await["status"], "cancelled");
    running(&maps, 0).await;
}

/// One who waits for an answer or for its job.
fn waiting(client: &Client, path: &str) -> JoinHandle<Answer> {
    let (client, path) = (client.clone(), path.to_owned());
    tokio::spawn(async move { preferring(&client, &path, "respond-async, wait=100").await })
}

/// Who asks again, as after a lost connection, has the same job; it ends for nobody as another goes away.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_that_of_all_who_ask_for_the_same() {
    let (client, maps) = with_maps(large(), "").await;
    let gone = waiting(&client, &large_grid(0));
    running(&maps, 1).await;
    let job = begun(&client, &large_grid(0)).await;
    assert_eq!((begun(&client, &large_grid(0)).await, last(&client).await), (job.clone(), job.clone()));
    assert_ne!(begun(&client, &large_grid(1)).await, job);
    gone.abort();
    assert!(gone.await.is_err());
    assert_eq!(status(&client, &job).await, "running");
    let told = waiting(&client, &large_grid(0));
    // Long enough to be heard.
    sleep(Duration::from_millis(500)).await;
    // It is nobody's fault that it was cancelled: it can be had again.
    cancel(&client, &job).await;
    let told = told.await.unwrap();
    let said =
        (told.status.as_u16(), told.headers[header::LOCATION].to_str().unwrap(), &told.json()["status"]);
    assert_eq!(said, (202, job.as_str(), &json!("cancelled")));
    assert!(!told.headers.contains_key(header::RETRY_AFTER));
    assert_ne!(begun(&client, &large_grid(0)).await, job);
}

/// However few processors there are.
#[tokio::test(flavor = "multi_thread")]
async fn jobs_leave_threads_to_those_who_wait() {
    let (client, maps) = with_maps(large(), "").await;
    let turns = maps.patchwork_threads() / 2;
    let mut jobs = Vec::new();
    for number in 0..=turns {
        jobs.push(begun(&client, &large_grid(number)).await);
    }
    running(&maps, turns).await;
    assert_eq!(client.get(GRAPH).await.status, 200);
    for (number, job) in jobs.iter().enumerate() {
        assert_eq!(status(&client, job).await, if number < turns { "running" } else { "queued" });
    }
}

#[tokio::test]
async fn a_job_that_fails_says_why() {
    let (client, _) = with_maps(Limits { cells_per_answer: 20_000, ..Limits::default() }, "").await;
    let job = begun(&client, &format!("{GRID}?format=png")).await;
    let failed = ended(&client, &job).await;
    let problem = &failed["problem"];
    assert_eq!((&failed["status"], &problem["code"]), (&json!("failed"), &json!("grid-too-large")));
    assert!(
        problem["instance"] == GRID && problem["fitting"].is_f64() && failed.get("result").is_none(),
        "{failed}"
    );
    client.get(&format!("{job}/result")).await.problem(422, "grid-too-large");
    preferring(&client, GRID, "respond-async, wait=100").await.problem(422, "grid-too-large");
}

/// What takes long becomes a job though nobody asked for one; and one that takes too long fails.
#[tokio::test]
async fn what_is_large_becomes_a_job() {
    let hasty = Limits { patchwork_time: Duration::ZERO, ..Limits::default() };
    let (client, _) = with_maps(hasty, "").await;
    let patient = with_office(Limits::default(), "").await;
    for (made, path) in [GRID, GRAPH].into_iter().enumerate() {
        let accepted = client.get(path).await;
        assert_eq!(accepted.status, 202, "{}", accepted.json());
        assert!(!accepted.headers.contains_key("preference-applied"));
        let job = accepted.headers[header::LOCATION].to_str().unwrap();
        assert_eq!(
            (job, &accepted.headers[header::RETRY_AFTER]),
            (&*last(&client).await, &"1".parse().unwrap())
        );
        let done = ended(&client, job).await;
        let expected = patient.get(path).await;
        // By now it is there.
        for path in [done["result"].as_str().unwrap(), path] {
            let answer = client.get(path).await;
            assert!(answer.status == 200 && answer.body == expected.body, "{path}: {}", answer.status);
        }
        assert_eq!(client.get("/v1/jobs").await.json()["jobs"].as_array().unwrap().len(), made + 1);
    }
    assert_eq!(client.get(&format!("{GRAPH}?poses=false")).await.status, 200);
    let (client, _) = with_maps(Limits { job_time: Duration::ZERO, ..hasty }, "").await;
    let job = client.get(GRAPH).await.headers[header::LOCATION].to_str().unwrap().to_owned();
    assert_eq!(ended(&client, &job).await["problem"]["code"], "out-of-time");
    client.get(&format!("{job}/result")).await.problem(503, "out-of-time");
    let (client, _) = with_maps(Limits { jobs: 0, ..hasty }, "").await;
    let refused = client.get(GRAPH).await;
    refused.problem(503, "too-many-jobs");
    assert_eq!(refused.headers[header::RETRY_AFTER], "10");
}

/// Who asks for what a job makes that has its turn waits for that job, and learns its number when it takes long. What a
/// stranger cancels is made for one who asked for no job.
#[tokio::test(flavor = "multi_thread")]
async fn what_a_job_makes_is_not_made_beside_it() {
    let hasty = Limits { patchwork_time: Duration::from_millis(200), ..large() };
    let (client, maps) = with_maps(hasty, "").await;
    let job = begun(&client, &large_grid(0)).await;
    running(&maps, 1).await;
    let told = client.get(&large_grid(0)).await;
    assert_eq!((told.status.as_u16(), &told.headers[header::LOCATION]), (202, &job.parse().unwrap()));
    assert_eq!((told.json()["status"].as_str(), running(&maps, 1).await.ended), (Some("running"), 0));
    cancel(&client, &job).await;
    let (client, maps) = with_maps(large(), "").await;
    let small = with_office(large(), "").await;
    for cancelled in [false, true] {
        let path = format!("{GRID}?format=pgm&resolution={}", if cancelled { 0.1 } else { 0.2 });
        let before = maps.patchworks().ended;
        let busy = busy(&maps).await;
        let job = begun(&client, &path).await;
        let joined = {
            let (client, path) = (client.clone(), path.clone());
            tokio::spawn(async move { client.get(&path).await })
        };
        // Long enough to be heard.
        sleep(Duration::from_millis(200)).await;
        if cancelled {
            cancel(&client, &job).await;
        }
        drop(busy);
        let answer = joined.await.unwrap();
        assert!(answer.status == 200 && answer.body == small.get(&path).await.body, "{}", answer.status);
        assert_eq!(status(&client, &job).await, if cancelled { "cancelled" } else { "done" });
        let made = running(&maps, 0).await.ended - before - maps.patchwork_threads() as u64;
        assert_eq!(made, 1, "{path}");
    }
}
