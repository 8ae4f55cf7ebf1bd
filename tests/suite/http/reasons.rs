//! Reading reasons: the tree, differences, explanations, where to look next.

use crate::http::client::{Client, JSON, aces_lines, array};
use serde_json::{Value, json};

async fn aces(config: &str) -> Client {
    let client = Client::new();
    client.with_aces("aces", config).await;
    client
}

const REASONS: [&str; 5] =
    ["tree", "next", "candidates/preferred/explain", "candidates/preferred/diff/0", "candidates/0/graph"];

#[tokio::test]
async fn reasons_need_a_map_an_observation_and_a_candidate() {
    let client = Client::new();
    client.put("office", "").await;
    for path in REASONS {
        client.get(&format!("/v1/maps/office/{path}")).await.problem(404, "no-observation");
        client.get(&format!("/v1/maps/other/{path}")).await.problem(404, "unknown-map");
    }
    client.with_aces("aces", "").await;
    for path in
        ["candidates/23/explain", "candidates/-1/graph", "candidates/best/diff/0", "candidates/0/diff/99"]
    {
        client.get(&format!("/v1/maps/aces/{path}")).await.problem(404, "unknown-candidate");
    }
}

#[tokio::test]
async fn reasons_carry_a_tag_that_changes_with_them() {
    let client = Client::new();
    client.put("aces", "").await;
    let lines = aces_lines();
    let (last, before) = lines.split_last().unwrap();
    client.post("aces", JSON, array(before)).await;
    for path in REASONS {
        let path = format!("/v1/maps/aces/{path}");
        let tag = client.get(&path).await.headers["etag"].clone();
        let again = axum::http::Request::get(&path).header("if-none-match", tag);
        assert_eq!(client.send(again.body("".into()).unwrap()).await.status, 304, "{path}");
    }
    let tag = client.get("/v1/maps/aces/next").await.headers["etag"].clone();
    client.post("aces", JSON, last.clone()).await;
    assert_ne!(client.get("/v1/maps/aces/next").await.headers["etag"], tag);
}

#[tokio::test]
async fn the_graph_of_the_preferred_candidate_is_that_of_its_position() {
    let client = aces("").await;
    let all = client.get("/v1/maps/aces/candidates?limit=1000").await.json();
    let preferred = client.get("/v1/maps/aces/candidates/preferred").await.json();
    let position =
        all["candidates"].as_array().unwrap().iter().position(|it| it["visits"] == preferred["visits"]);
    let by_position = client.get(&format!("/v1/maps/aces/candidates/{}/graph", position.unwrap())).await;
    assert_eq!(by_position.body, client.get("/v1/maps/aces/candidates/preferred/graph").await.body);
    assert_ne!(by_position.body, client.get("/v1/maps/aces/candidates/13/graph").await.body);
}

#[tokio::test]
async fn two_visits_are_explained() {
    let client = aces("").await;
    let path = "/v1/maps/aces/candidates/preferred/explain";
    let said = client.get(&format!("{path}?visits=8,0")).await.json()["visits"].clone();
    assert_eq!((&said["same"], &said["visits"]), (&json!(true), &json!([0, 8])));
    assert_eq!((&said["together"]["value"], &said["apart"]["value"]), (&json!(10), &json!(13)));
    let reason = &said["reasons"][0];
    assert_eq!(
        (&reason["kind"], &reason["observation"], &reason["since"]),
        (&json!("closure"), &json!(8), &json!(0))
    );
    let said = client.get(&format!("{path}?visits=0,4")).await.json()["visits"].clone();
    let refuted = &said["alternatives"][0]["refuted"];
    assert_eq!((&refuted["axiom"], &refuted["observation"]), (&json!("star-match"), &json!(7)), "{said}");
    let rival = client.get("/v1/maps/aces/candidates/13/explain?visits=0,8").await.json()["visits"].clone();
    assert_eq!((&rival["same"], &rival["minimal_rivals"].as_array().unwrap().len()), (&json!(false), &1));
    for query in ["visits=0", "visits=0,0", "visits=0,15", "visits=a,b", "visits=0,1,2", "visit=0,1"] {
        client.get(&format!("{path}?{query}")).await.problem(400, "invalid-query");
    }
}

#[tokio::test]
async fn explanations_are_those_of_the_command_line() {
    let client = aces("").await;
    let served = client.get("/v1/maps/aces/candidates/preferred/explain").await.json();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_topostar"))
        .args(["map", "worlds/aces-stars.ndjson", "--json", "--explain"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["explain"], served);
    assert_eq!(served["closures"].as_array().unwrap().len(), 4);
}

#[tokio::test]
async fn differences_are_told_from_both_sides() {
    let client = aces("").await;
    let one = client.get("/v1/maps/aces/candidates/preferred/diff/13").await.json();
    let other = client.get("/v1/maps/aces/candidates/13/diff/preferred").await.json();
    assert_eq!((&one["first"], &one["second"]), (&other["second"], &other["first"]));
    assert_eq!((&one["parting"], &other["parting"]), (&json!(8), &json!(8)));
    assert!(one["first"]["same_place"]["pairs"].as_array().unwrap().contains(&json!([0, 8])), "{one}");
    let none = client.get("/v1/maps/aces/candidates/3/diff/3").await.json();
    let nothing = json!({"count": 0, "pairs": []});
    for side in ["first", "second"] {
        assert_eq!((&none[side]["same_place"], &none[side]["same_path"]), (&nothing, &nothing));
    }
    assert_eq!((&none["parting"], &none["rotations"]), (&json!(null), &json!([])));
}

#[tokio::test]
async fn the_tree_is_read_in_pieces() {
    let client = aces("").await;
    let root = client.get("/v1/maps/aces/tree?depth=16").await.json()["node"].clone();
    assert_eq!((&root["leaves"], &root["observation"]), (&json!(23), &json!(0)));
    let mut leaves = vec![];
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        match node["children"].as_array() {
            Some(children) if !children.is_empty() => {
                let sum: u64 = children.iter().map(|child| child["leaves"].as_u64().unwrap()).sum();
                assert_eq!(
                    (json!(sum), json!(children.len())),
                    (node["leaves"].clone(), node["branches"].clone())
                );
                open.extend(children.iter().cloned());
            }
            _ => {
                assert_eq!((&node["observation"], &node["leaves"]), (&json!(14), &json!(1)));
                leaves.push(node["candidate"].as_u64().unwrap());
            }
        }
    }
    leaves.sort_unstable();
    assert_eq!(leaves, (0..23).collect::<Vec<u64>>());
    // The same children, one at a time.
    let path = "/v1/maps/aces/tree?observation=13&candidate=0&depth=1";
    let whole = client.get(path).await.json()["node"]["children"].clone();
    let mut paged = vec![];
    let mut page = client.get(&format!("{path}&limit=1")).await.json();
    loop {
        paged.extend(page["node"]["children"].as_array().unwrap().iter().cloned());
        let Some(cursor) = page["next"].as_str() else { break };
        page = client.get(&format!("{path}&limit=1&cursor={cursor}")).await.json();
    }
    assert_eq!(json!(paged), whole);
}

#[tokio::test]
async fn ended_branches_name_what_ended_them() {
    let client = aces("").await;
    let node = client.get("/v1/maps/aces/tree?observation=3&candidate=0&depth=2&ended=true").await.json();
    let ended = &node["node"]["ended"]["branches"];
    assert_eq!(ended[0]["ending"], "later", "{node}");
    assert_eq!((&ended[0]["place"], &ended[0]["refuted"]), (&json!(0), &json!(null)));
    let ended = &node["node"]["children"][0]["ended"];
    assert_eq!(ended["count"], json!(ended["branches"].as_array().unwrap().len()));
    let first = &ended["branches"][0];
    assert_eq!(
        (&first["ending"], &first["refuted"]["axiom"]),
        (&json!("refuted"), &json!("determinism")),
        "{ended}"
    );
    assert!(first["refuted"]["words"].as_str().unwrap().starts_with("gateway "));
}

#[tokio::test]
async fn a_wrong_part_of_the_tree_is_refused() {
    let client = aces("").await;
    for query in [
        "depth=0",
        "depth=17",
        "limit=0",
        "limit=101",
        "observation=15",
        "candidate=23",
        "cursor=x",
        "deep=1",
    ] {
        client.get(&format!("/v1/maps/aces/tree?{query}")).await.problem(400, "invalid-query");
    }
}

#[tokio::test]
async fn every_gateway_has_an_outlook_and_the_best_is_first() {
    let client = aces("").await;
    let next = client.get("/v1/maps/aces/next?limit=1000").await.json();
    let graph = client.get("/v1/maps/aces/candidates/preferred/graph").await.json();
    assert_eq!((&next["robot"], &next["candidates"]["value"]), (&graph["robot"], &json!(23)));
    let gateways = next["gateways"].as_array().unwrap();
    assert_eq!(next["total"], json!(gateways.len()));
    let best = client.get("/v1/maps/aces/next?limit=2").await.json();
    assert_eq!(best["gateways"], json!(gateways[..2]));
    for query in ["limit=0", "limit=1001", "most=3"] {
        client.get(&format!("/v1/maps/aces/next?{query}")).await.problem(400, "invalid-query");
    }
    let unexplored = gateways.iter().filter(|it| it["explored"] == false).count();
    assert_eq!(unexplored, graph["frontier"].as_array().unwrap().len());
    assert!(
        gateways
            .iter()
            .map(|it| it["expected"].as_f64().unwrap())
            .collect::<Vec<_>>()
            .is_sorted_by(|a, b| a >= b)
    );
    for gateway in gateways {
        let predicted =
            gateway["predictions"].as_array().unwrap().iter().map(|it| it["candidates"].as_u64().unwrap());
        assert_eq!(predicted.sum::<u64>(), 23);
        assert_eq!(gateway["route"].as_array().unwrap().last(), Some(&gateway["gateway"]));
    }
}
