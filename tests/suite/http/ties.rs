//! Maps that are equally simple: what was measured and seen tells which is preferred.

use crate::cli::fed;
use crate::http::client::Client;
use crate::http::patchwork::{GRAPH, holding, ndjson, office, with_office};
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;
use topostar::service::Limits;
use topostar::trace::EventKind;
use topostar::worlds::{FILES, LpmTrace, load, lpm_trace};

/// By the bare theory two maps of the office are equally simple; what was measured tells which.
#[tokio::test]
async fn the_least_strained_of_equally_simple_maps_is_preferred() {
    let trace = office();
    let mut answers = Vec::new();
    for strategy in ["breadth-first", "best-first"] {
        let config = format!(r#"{{"profile":"paper","strategy":"{strategy}"}}"#);
        let client = with_office(Limits::default(), &config).await;
        let map = client.get("/v1/maps/office").await.json();
        let preferred = &map["preferred"];
        assert_eq!(preferred["unique"], false);
        assert_eq!(preferred["visits"], json!(trace.places));
        assert_eq!(map["minimal"][0], preferred["visits"]);
        let ties = &map["ties"];
        assert_eq!(ties["ordered_by"], "strain");
        let strains = ties["strains"].as_array().unwrap();
        assert_eq!((strains.len(), map["minimal"].as_array().unwrap().len()), (2, 2));
        let probable = |at: usize| strains[at]["log10_probability"].as_f64().unwrap();
        assert!(probable(0) > -4.0 && probable(1) < -20.0, "{ties}");
        let graph = client.get(GRAPH).await.json();
        assert_eq!(graph["strain"]["chi_square"], strains[0]["chi_square"]);
        assert_eq!(client.get("/v1/maps/office/candidates/preferred").await.json(), *preferred);
        answers.push((map["minimal"].clone(), ties.clone()));
    }
    assert_eq!(answers[0], answers[1]);
    let printed =
        crate::cli::json(&fed(&["map", "-", "--profile", "paper", "--json"], ndjson(&trace).as_bytes()));
    assert_eq!((printed["minimal"].clone(), printed["ties"].clone()), answers[0]);
    let words = crate::cli::text(&fed(&["map", "-", "--profile", "paper"], ndjson(&trace).as_bytes()).stdout);
    assert!(words.contains("preferred as the least strained of them; strain "), "{words}");
}

/// Whoever asks is answered, in the order of assignments, where the strain is not known in time.
#[tokio::test]
async fn a_tie_that_takes_too_long_stays_in_the_order_of_assignments() {
    let hasty = Limits { patchwork_time: Duration::ZERO, ..Limits::default() };
    let client = with_office(hasty, r#"{"profile":"paper"}"#).await;
    let map = client.get("/v1/maps/office").await;
    assert_eq!(map.status, 200);
    let map = map.json();
    assert_eq!(map["ties"], json!({"ordered_by": "assignment", "strains": [null, null]}));
    assert_eq!(map["minimal"][0], map["preferred"]["visits"]);
    let visits = |at: usize| serde_json::from_value::<Vec<usize>>(map["minimal"][at].clone()).unwrap();
    assert!(visits(0) <= visits(1), "{}", map["minimal"]);
    let candidates = "/v1/maps/office/candidates";
    for path in ["preferred", "preferred/explain", "preferred/diff/0", "0/graph?poses=false"] {
        assert_eq!(client.get(&format!("{candidates}/{path}")).await.status, 200, "{path}");
    }
    assert_eq!(client.get(&format!("{candidates}/preferred")).await.json(), map["preferred"]);
}

/// Many who ask at once get one answer, and those who go away take it from nobody.
#[tokio::test(flavor = "multi_thread")]
async fn who_asks_at_once_is_told_the_same_order() {
    let client = Arc::new(with_office(Limits::default(), r#"{"profile":"paper"}"#).await);
    let ask = || {
        let client = Arc::clone(&client);
        tokio::spawn(async move { client.get("/v1/maps/office").await.json() })
    };
    let gone = ask();
    let asking: Vec<_> = (0..8).map(|_| ask()).collect();
    tokio::task::yield_now().await;
    gone.abort();
    for answer in asking {
        let map = answer.await.unwrap();
        assert_eq!(map["ties"]["ordered_by"], "strain");
        assert_eq!(map["preferred"]["visits"], json!(office().places));
    }
}

/// The office with corridors that bend four metres from its western place, walked with odometry that tells next to nothing.
/// All else is as it was: the western and the eastern place have the same star.
fn bent_office() -> LpmTrace {
    let (name, text) = FILES.iter().find(|(name, _)| *name == "office").unwrap();
    let corridor = |ways: &[[f64; 2]]| {
        let ways = ways.windows(2).map(|way| format!("{{ corridor = {way:?}, width = 2.0 }},"));
        ways.collect::<Vec<_>>().join("\n")
    };
    let straight = |way: &str| format!("{{ corridor = {way}, width = 2.0 }},");
    let west = corridor(&[
        [-20.0, -20.0],
        [-20.0, -16.0],
        [-22.0, -10.0],
        [-20.0, -4.0],
        [-20.0, 4.0],
        [-22.0, 10.0],
        [-20.0, 16.0],
        [-20.0, 20.0],
    ]);
    let middle = corridor(&[[-20.0, 0.0], [-16.0, 0.0], [-12.0, 2.0], [-8.0, 0.0], [20.0, 0.0]]);
    let bent = text
        .replace(&straight("[[-20, -20], [-20, 20]]"), &west)
        .replace(&straight("[[-20, 0], [20, 0]]"), &middle);
    assert_eq!(bent.matches("corridor = [").count(), text.matches("corridor = [").count() + 9);
    let mut trace = lpm_trace(&load(name, &bent).unwrap(), 0, 0.1).unwrap();
    for event in &mut trace.events {
        if let EventKind::Travel(travel) = &mut event.kind {
            travel.covariance.iter_mut().flatten().for_each(|number| *number *= 1e4);
        }
    }
    trace
}

/// Strain alone leaves them in the order of their assignments, and first the wrong one, which takes the western place for the
/// eastern one and the other way round: the walls of these do not lie on each other.
#[tokio::test]
async fn walls_that_differ_tell_equally_simple_maps_apart() {
    let trace = bent_office();
    let client = holding(Client::new(), r#"{"profile":"paper"}"#, &trace).await;
    let map = client.get("/v1/maps/office").await.json();
    assert_eq!((map["minimal"].as_array().unwrap().len(), &map["ties"]["ordered_by"]), (2, &json!("strain")));
    let strains = &map["ties"]["strains"];
    for at in 0..2 {
        let [chi_square, degrees] =
            ["chi_square", "degrees_of_freedom"].map(|name| strains[at][name].as_f64().unwrap());
        assert!(chi_square < 0.1 * degrees, "{strains}");
    }
    let differ = |at: usize| strains[at]["walls_differ"].as_u64().unwrap() as usize;
    assert!(differ(0) == 0 && differ(1) > 0, "{strains}");
    let visits = |at: usize| serde_json::from_value::<Vec<usize>>(map["minimal"][at].clone()).unwrap();
    assert!(visits(0) == trace.places && visits(1) < visits(0), "{}", map["minimal"]);
    assert_eq!(map["preferred"]["visits"], json!(trace.places));
    let candidates = client.get("/v1/maps/office/candidates?limit=100").await.json();
    let candidates = candidates["candidates"].as_array().unwrap();
    for at in 0..2 {
        let id = &candidates.iter().find(|candidate| candidate["visits"] == json!(visits(at))).unwrap()["id"];
        let graph = client.get(&format!("/v1/maps/office/candidates/{id}/graph")).await.json();
        let edges = graph["strain"]["edges"].as_array().unwrap().iter();
        let closures: Vec<&Value> =
            edges.filter(|edge| edge["walls"] == "differ").map(|edge| &edge["observations"]).collect();
        assert_eq!(closures.len(), differ(at), "{closures:?}");
        assert!(closures.iter().all(|&ends| [json!([2, 12]), json!([6, 14])].contains(ends)), "{closures:?}");
    }
}
