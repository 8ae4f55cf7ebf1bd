//! The patchwork of a candidate: where its places lie, what strains them, and one grid of all that was seen.

use crate::http::client::{Answer, Client, JSON, NDJSON, aces, array};
use axum::body::Body;
use axum::http::{HeaderValue, Request, header};
use serde_json::{Value, json};
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use tokio::task::JoinSet;
use tokio::time::timeout;
use topostar::geometry::{Point, Pose};
use topostar::grid::Cell;
use topostar::service::{Limits, Maps, MemoryStore};
use topostar::star::{PerceptionParameters, describe};
use topostar::trace::{EventKind, Percept, write_trace};
use topostar::worlds::{LpmTrace, bundled, lpm_trace};

pub(super) const GRID: &str = "/v1/maps/office/candidates/preferred/grid";
pub(super) const GRAPH: &str = "/v1/maps/office/candidates/preferred/graph";

pub(super) fn office() -> LpmTrace {
    lpm_trace(&bundled("office").unwrap(), 0, 0.1).unwrap()
}

pub(super) fn ndjson(trace: &LpmTrace) -> String {
    let mut text = Vec::new();
    write_trace(&mut text, &trace.events).unwrap();
    String::from_utf8(text).unwrap()
}

/// Where in the world the middle of each place was found on each visit.
fn middles(trace: &LpmTrace) -> Vec<Point> {
    let seen = trace.events.iter().filter_map(|event| match &event.kind {
        EventKind::Observation(seen) => Some(&seen.percept),
        _ => None,
    });
    let middle = |(percept, world_from_lpm): (&Percept, &Pose)| {
        let Percept::Lpm(lpm) = percept else { panic!("{percept:?}") };
        world_from_lpm.transform_point(&describe(lpm, &PerceptionParameters::default()).unwrap().center)
    };
    seen.zip(&trace.world_from_lpm).map(middle).collect()
}

/// A map that took the walk through the office as grids.
pub(super) async fn with_office(limits: Limits, config: &str) -> Client {
    filled(Client::with_limits(limits), config).await
}

async fn filled(client: Client, config: &str) -> Client {
    holding(client, config, &office()).await
}

/// A client of a map `office` that took a walk.
pub(super) async fn holding(client: Client, config: &str, walk: &LpmTrace) -> Client {
    client.put("office", config).await;
    assert_eq!(client.post("office", NDJSON, ndjson(walk)).await.status, 200);
    client
}

/// All threads of patchworks taken, until these tasks are aborted.
pub(super) async fn busy(maps: &Maps) -> JoinSet<()> {
    let threads = maps.patchwork_threads();
    let mut busy = JoinSet::new();
    for _ in 0..threads {
        let maps = maps.clone();
        busy.spawn(async move {
            let endless = |stop: &dyn Fn() -> bool| {
                while !stop() {
                    thread::yield_now()
                }
            };
            maps.lay_out(endless).await.unwrap()
        });
    }
    while maps.patchworks().running < threads {
        tokio::task::yield_now().await;
    }
    busy
}

async fn accepting(client: &Client, path: &str, accept: &str) -> Answer {
    client.send(Request::get(path).header(header::ACCEPT, accept).body(Body::empty()).unwrap()).await
}

/// The cells of a picture, row 0 at the bottom, in the numbers of ROS.
fn cells(picture: &[u8]) -> (Value, Vec<i64>) {
    let grey = image::load_from_memory(picture).unwrap().into_luma8();
    let value = |grey: &u8| match Cell::from_grey(*grey) {
        Cell::Unknown => -1,
        Cell::Free => 0,
        Cell::Occupied => 100,
    };
    let rows = grey.as_raw().chunks(grey.width() as usize).rev();
    (json!([grey.width(), grey.height()]), rows.flatten().map(value).collect())
}

#[tokio::test]
async fn the_grid_is_one_in_every_form() {
    let client = with_office(Limits::default(), "").await;
    let grid = client.get(&format!("{GRID}?resolution=0.1")).await;
    assert_eq!((grid.status.as_u16(), &grid.headers[header::CONTENT_TYPE]), (200, &JSON.parse().unwrap()));
    assert_eq!(grid.headers[header::VARY], "Accept");
    let json = grid.json();
    let info = &json["info"];
    assert_eq!(info["resolution"], 0.1);
    let data: Vec<i64> = serde_json::from_value(json["data"].clone()).unwrap();
    for (path, accept) in [
        (format!("{GRID}?resolution=0.1"), "image/png"),
        (format!("{GRID}?resolution=0.1"), "image/x-portable-graymap, application/json;q=0.5"),
        (format!("{GRID}?resolution=0.1&format=png"), "application/json"),
        (format!("{GRID}?resolution=0.1&format=pgm"), "text/html"),
    ] {
        let picture = accepting(&client, &path, accept).await;
        assert!(
            picture.headers[header::CONTENT_TYPE].to_str().unwrap().starts_with("image/"),
            "{path} {accept}"
        );
        let (size, shown) = cells(&picture.body);
        assert_eq!(size, json!([info["width"], info["height"]]));
        assert_eq!(shown, data);
        let tag = &picture.headers[header::ETAG];
        assert_ne!(tag, grid.headers[header::ETAG]);
        let known = Request::get(&path).header(header::ACCEPT, accept).header(header::IF_NONE_MATCH, tag);
        let again = client.send(known.body(Body::empty()).unwrap()).await;
        assert_eq!((again.status.as_u16(), again.body.len()), (304, 0));
    }
    // A grid is what a trace may hold as an LPM.
    let observation = json!({"seq": 0, "kind": "observation", "lpm": json, "robot_pose": {"x": 0.0, "y": 0.0, "theta": 0.0}});
    client.put("whole", "").await;
    let posted = client.post("whole", JSON, observation.to_string()).await;
    assert!(posted.status == 200 || posted.json()["pointer"] != "/lpm/info", "{}", posted.json());
}

/// The same events give the same bytes, in another service and cut into other requests.
#[tokio::test]
async fn the_grid_depends_on_the_events_alone() {
    let first = with_office(Limits::default(), "").await;
    let second = Client::new();
    second.put("office", "").await;
    for line in ndjson(&office()).lines() {
        second.post("office", JSON, line.to_owned()).await;
    }
    for path in [format!("{GRID}?resolution=0.2"), GRAPH.to_owned(), "/v1/maps/office".to_owned()] {
        let [one, other] = [first.get(&path).await, second.get(&path).await];
        assert_eq!(
            (&one.body, &one.headers[header::ETAG]),
            (&other.body, &other.headers[header::ETAG]),
            "{path}"
        );
    }
}

/// Places lie as far from each other as in the world, and where the robot stood the grid is free.
#[tokio::test]
async fn places_lie_where_they_are() {
    let trace = office();
    let client = with_office(Limits::default(), "").await;
    let graph = client.get(GRAPH).await.json();
    let point = |pose: &Value| Point::new(pose[0].as_f64().unwrap(), pose[1].as_f64().unwrap());
    let (visits, places) =
        (graph["poses"]["visits"].as_array().unwrap(), graph["poses"]["places"].as_array().unwrap());
    assert_eq!((visits.len(), places.len()), (15, 9));
    assert_eq!(graph["poses"]["parts"], json!(vec![0; 15]));
    let truth = middles(&trace);
    for (one, other) in (0..15).flat_map(|one| (0..one).map(move |other| (one, other))) {
        let away = |points: [Point; 2]| (points[0] - points[1]).norm();
        let found = away([one, other].map(|visit| point(&visits[visit])));
        let off = found - away([one, other].map(|visit| truth[visit]));
        // What is left is the noise of lengths and headings, 2 % and 2 degrees a travel.
        let most = if trace.places[one] == trace.places[other] { 0.4 } else { 2.5 };
        assert!(off.abs() < most, "visits {other} and {one} are {found} m apart, off by {off}");
    }
    for (visit, place) in trace.places.iter().enumerate() {
        let first = trace.places.iter().position(|other| other == place).unwrap();
        if first == visit {
            assert_eq!(places[*place], visits[visit]);
        }
    }
    let strain = &graph["strain"];
    // Fourteen travels and six visits to known places; fifteen frames, of which one is held.
    assert_eq!((strain["edges"].as_array().unwrap().len(), &strain["degrees_of_freedom"]), (20, &json!(18)));
    let sum: f64 =
        strain["edges"].as_array().unwrap().iter().map(|edge| edge["chi_square"].as_f64().unwrap()).sum();
    assert!((sum - strain["chi_square"].as_f64().unwrap()).abs() < 1e-6 && strain["converged"] == true);
    let grid = client.get(GRID).await.json();
    let number = |value: &Value| value.as_f64().unwrap();
    let origin = &grid["info"]["origin"]["position"];
    for pose in visits {
        let at = [("x", 0), ("y", 1)]
            .map(|(axis, k)| ((number(&pose[k]) - number(&origin[axis])) / 0.05) as usize);
        let width = grid["info"]["width"].as_u64().unwrap() as usize;
        assert_eq!(grid["data"][at[1] * width + at[0]], 0, "{pose}");
    }
    let bare = client.get(&format!("{GRAPH}?poses=false")).await.json();
    assert!(bare.get("poses").is_none() && bare.get("strain").is_none());
    assert_eq!((&bare["places"], &bare["robot"]), (&graph["places"], &graph["robot"]));
}

#[tokio::test]
async fn what_is_asked_wrongly_is_refused() {
    let client = with_office(Limits::default(), "").await;
    for query in [
        "resolution=0",
        "resolution=0.009",
        "resolution=1.1",
        "resolution=nan",
        "resolution=-1",
        "resolution=x",
        "format=gif",
        "format=",
        "size=3",
    ] {
        client.get(&format!("{GRID}?{query}")).await.problem(400, "invalid-query");
    }
    client.get(&format!("{GRAPH}?poses=maybe")).await.problem(400, "invalid-query");
    let problem = accepting(&client, GRID, "text/html").await.problem(406, "not-acceptable");
    assert!(problem["detail"].as_str().unwrap().contains("image/png"), "{problem}");
    client.get("/v1/maps/office/candidates/99/grid").await.problem(404, "unknown-candidate");
    client.get("/v1/maps/office/candidates/first/grid").await.problem(404, "unknown-candidate");
    client.get("/v1/maps/other/candidates/preferred/grid").await.problem(404, "unknown-map");
    client.put("empty", "").await;
    client.get("/v1/maps/empty/candidates/preferred/grid").await.problem(404, "no-observation");
}

#[tokio::test]
async fn what_was_not_measured_is_named() {
    let client = Client::new();
    client.put("office", "").await;
    client.post("office", NDJSON, aces()).await;
    let problem = client.get(GRID).await.problem(404, "not-measured");
    assert!(problem["detail"].as_str().unwrap().contains("`lpm`"), "{problem}");
    let graph = client.get(GRAPH).await.json();
    assert!(graph.get("poses").is_none() && graph.get("strain").is_none());
    let unmeasured = ndjson(&office()).replace("\"covariance\"", "\"covariance_\"");
    let events: Vec<String> = unmeasured
        .lines()
        .map(|line| {
            let mut event: Value = serde_json::from_str(line).unwrap();
            event.as_object_mut().unwrap().remove("covariance_");
            event.to_string()
        })
        .collect();
    client.put("bare", "").await;
    let first = client.post("bare", JSON, events[0].clone()).await;
    assert_eq!(first.status, 200, "{}", first.json());
    // One place alone lies where it is.
    assert_eq!(client.get("/v1/maps/bare/candidates/preferred/grid").await.status, 200);
    assert_eq!(client.post("bare", JSON, array(&events[1..])).await.status, 200);
    let problem = client.get("/v1/maps/bare/candidates/preferred/grid").await.problem(404, "not-measured");
    assert!(problem["detail"].as_str().unwrap().contains("`covariance`"), "{problem}");
}

/// Beyond a travel that was not measured nothing tells where places lie, until what was measured later joins them.
#[tokio::test]
async fn what_nothing_joins_to_the_first_observation_is_left_out() {
    let client = Client::new();
    let mut events: Vec<Value> =
        ndjson(&office()).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let seen = |event: &Value| event["kind"] == "observation";
    let ends: Vec<usize> = (0..events.len()).filter(|&at| seen(&events[at])).collect();
    let travel = (ends[1]..ends[2]).find(|&at| events[at]["kind"] == "travel").unwrap();
    events[travel].as_object_mut().unwrap().remove("covariance");
    let mut grids = Vec::new();
    for (map, last, parts) in [
        ("two", 1, vec![0, 0]),
        ("three", 2, vec![0, 0, 2]),
        ("eight", 7, vec![0, 0, 2, 2, 2, 2, 2, 2]),
        ("nine", 8, vec![0; 9]),
    ] {
        client.put(map, r#"{"profile":"paper"}"#).await;
        let lines: Vec<String> = events[..=ends[last]].iter().map(Value::to_string).collect();
        assert_eq!(client.post(map, NDJSON, lines.join("\n")).await.status, 200);
        let candidate = format!("/v1/maps/{map}/candidates/preferred");
        assert_eq!(
            client.get(&format!("{candidate}/graph")).await.json()["poses"]["parts"],
            json!(parts),
            "{map}"
        );
        grids.push(client.get(&format!("{candidate}/grid?resolution=0.1&format=pgm")).await.body);
    }
    assert!(grids[0] == grids[1] && grids[0] == grids[2] && grids[0].len() < grids[3].len());
}

#[tokio::test]
async fn a_grid_too_large_says_what_would_fit() {
    let client = with_office(Limits { cells_per_answer: 20_000, ..Limits::default() }, "").await;
    let problem = client.get(GRID).await.problem(422, "grid-too-large");
    let [width, height] = [0, 1].map(|side| problem["size"][side].as_u64().unwrap());
    assert!(width * height > 20_000, "{problem}");
    let fitting = problem["fitting"].as_f64().unwrap();
    let grid = client.get(&format!("{GRID}?resolution={fitting}")).await.json();
    let cells = grid["data"].as_array().unwrap().len();
    assert!((12_000..=20_000).contains(&cells), "{fitting}: {cells}");
}

/// While every thread is taken, a client learns that what it has is still what it would get; also after an event that
/// changes nothing, and no longer after one that does.
#[tokio::test]
async fn what_a_client_has_is_not_made_again() {
    let maps = Maps::new(Arc::new(MemoryStore::new(1)), Limits::default());
    let client = filled(Client::of(maps.clone()), "").await;
    let paths =
        [GRAPH.to_owned(), format!("{GRID}?resolution=0.1"), format!("{GRID}?resolution=0.1&format=pgm")];
    let mut tags = Vec::new();
    for path in &paths {
        tags.push(client.get(path).await.headers[header::ETAG].clone());
    }
    let conditional = |path: &String, tag: &HeaderValue| {
        let known = Request::get(path).header(header::IF_NONE_MATCH, tag);
        client.send(known.body(Body::empty()).unwrap())
    };
    let mut busy = busy(&maps).await;
    let turn = json!({"seq": office().events.len(), "kind": "turn", "heading": 0.0});
    for also in [None, Some(turn)] {
        if let Some(event) = also {
            let posted = client.post("office", JSON, event.to_string()).await;
            assert_eq!(posted.status, 200, "{}", posted.json());
        }
        for (path, tag) in paths.iter().zip(&tags) {
            let again = conditional(path, tag).await;
            assert_eq!((again.status.as_u16(), &again.headers[header::ETAG]), (304, tag), "{path}");
            let other = conditional(path, &HeaderValue::from_static("\"other\""));
            assert!(timeout(Duration::from_millis(20), other).await.is_err(), "{path} took no thread");
        }
    }
    busy.abort_all();
    for (path, tag) in paths.iter().zip(&tags) {
        assert_eq!(conditional(path, tag).await.status, 304);
        let other = conditional(path, &HeaderValue::from_static("\"other\"")).await;
        assert_eq!((other.status.as_u16(), &other.headers[header::ETAG]), (200, tag));
    }
}
