//! The command line from outside: what it prints, what it writes, and the code it ends with.

use crate::openapi::assert_golden;
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

pub(crate) fn topostar(arguments: &[&str]) -> Output {
    fed(arguments, b"")
}

pub(crate) fn fed(arguments: &[&str], input: &[u8]) -> Output {
    let mut process = Command::new(env!("CARGO_BIN_EXE_topostar"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = process.stdin.take().unwrap();
    let input = input.to_vec();
    // A process that refuses its input early closes the pipe.
    let feeding = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = process.wait_with_output().unwrap();
    feeding.join().unwrap();
    output
}

pub(crate) fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn the_report_has_the_fields_that_are_promised() {
    let output = topostar(&[
        "map",
        "worlds/aces-stars.ndjson",
        "--profile",
        "paper",
        "--strategy",
        "breadth-first",
        "--json",
    ]);
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    assert_eq!(report["candidates"], serde_json::json!({"value": 35, "relation": "eq"}));
    assert_eq!(
        report["candidates_per_observation"],
        serde_json::json!([1, 1, 1, 1, 2, 2, 2, 1, 2, 2, 5, 5, 15, 15, 35])
    );
    assert_eq!(report["maps_created"], 68);
    assert_eq!(report["minimal"].as_array().unwrap().len(), 2);
    assert_eq!((&report["strategy"], &report["profile"]), (&"breadth-first".into(), &"paper".into()));
    assert_eq!((&report["complete"], &report["stop_reason"]), (&true.into(), &Value::Null));
    let preferred = &report["preferred"];
    assert_eq!((&preferred["unique"], &preferred["proven"]), (&false.into(), &true.into()));
    assert_eq!((&preferred["paths"], &preferred["places"]), (&6.into(), &9.into()));
    assert!(report["seconds"].is_number() && report["refuted"]["determinism"].is_number());
}

#[test]
fn the_simplest_maps_are_proven_without_the_others() {
    let walk = ["map", "worlds/grid4x4-28.ndjson", "--profile", "paper", "--strategy", "best-first"];
    let output = topostar(&[&walk[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    assert_eq!(report["candidates"], serde_json::json!({"value": 3, "relation": "gte"}));
    assert_eq!(report["bound"], serde_json::json!({"paths": 4, "places": 8}));
    assert_eq!(report["preferred"]["proven"], true);
    assert_eq!(report["preferred"]["unique"], false);
    assert_eq!((&report["complete"], &report["stop_reason"]), (&false.into(), &"minimum-proven".into()));
    let words = text(&topostar(&walk).stdout);
    assert!(words.contains("no map has fewer than 4 paths, nor with 4 fewer than 8 places\n"), "{words}");

    let cut = topostar(&[&walk[..], &["--max-steps", "5", "--json"]].concat());
    assert_eq!(cut.status.code(), Some(5));
    let report = json(&cut);
    assert_eq!((&report["stop_reason"], &report["steps"]), (&"step-limit".into(), &5.into()));
    assert!(text(&cut.stderr).contains("--max-steps ended the search"));
    let small = topostar(&[&walk[..], &["--max-memory", "4K", "--json"]].concat());
    assert_eq!(small.status.code(), Some(5));
    assert_eq!(json(&small)["stop_reason"], "memory-limit");
    assert!(text(&small.stderr).contains("--max-memory cut the search: what is shown is the simplest"));
    let usage = topostar(&[&walk[..], &["--max-seconds", "-1"]].concat());
    assert_eq!(usage.status.code(), Some(2));
}

#[test]
fn boundaries_refute_or_rank_as_asked() {
    let crescent = |how: &[&str]| {
        topostar(&[&["map", "worlds/crescent.ndjson", "--profile", "paper", "--json"], how].concat())
    };
    let bare = json(&crescent(&[]));
    assert_eq!((&bare["candidates"]["value"], &bare["preferred"]["places"]), (&3.into(), &3.into()));
    assert!(bare["preferred"].get("abnormalities").is_none());
    let soft = json(&crescent(&["--boundary", "soft"]));
    assert_eq!((&soft["candidates"]["value"], &soft["preferred"]["abnormalities"]), (&3.into(), &0.into()));
    assert_eq!(soft["preferred"]["places"], 4);
    let hard = json(&crescent(&["--boundary", "hard"]));
    assert_eq!((&hard["candidates"]["value"], &hard["refuted"]["boundary"]), (&1.into(), &2.into()));
    let listed = topostar(&[
        "map",
        "worlds/crescent.ndjson",
        "--axioms",
        "determinism,star-match",
        "--boundary",
        "hard",
    ]);
    assert_eq!(listed.status.code(), Some(2));
}

/// Where the second crossing is on a path and beside it, the text says for which path it is no boundary.
#[test]
fn the_map_in_words_says_what_lies_beside_each_path() {
    let words = text(&topostar(&["map", "worlds/crescent.ndjson", "--profile", "paper"]).stdout);
    assert!(words.contains("  Pa1   left -; right 0 1; no boundary for Pa2\n"), "{words}");
    assert!(words.contains("  Pa2   left 0 1 2; right -; no boundary for Pa1\n"), "{words}");
}

#[test]
fn a_trace_comes_from_standard_input_too() {
    let trace =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/aces-stars.ndjson")).unwrap();
    let report = json(&fed(&["map", "-", "--json"], &trace));
    assert_eq!(report["candidates"]["value"], 23);
    assert_eq!(
        report["preferred"]["visits"],
        serde_json::json!([0, 1, 2, 3, 4, 5, 6, 7, 0, 8, 4, 8, 6, 8, 2])
    );
    assert_eq!(report["preferred"]["unique"], true);
}

#[test]
fn bad_input_ends_with_code_3_and_names_file_and_line() {
    let output = fed(&["map", "-", "--json"], b"{\"seq\":0,\"kind\":\"travel\"}\n");
    assert_eq!(output.status.code(), Some(3));
    assert!(
        text(&output.stderr).contains("-: line 1: /kind a travel may not come here"),
        "{}",
        text(&output.stderr)
    );
    let output = topostar(&["map", "worlds/no-such-trace.ndjson"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("worlds/no-such-trace.ndjson: cannot be opened"));
}

/// Nothing before a fault is lost.
#[test]
fn what_came_before_a_fault_is_still_mapped() {
    let trace =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/aces-stars.ndjson"))
            .unwrap();
    let mut lines: Vec<&str> = trace.lines().take(20).collect();
    lines.push("{\"seq\":20");
    let output = fed(&["map", "-", "--json"], lines.join("\n").as_bytes());
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("-: line 21: "), "{}", text(&output.stderr));
    assert_eq!(json(&output)["candidates_per_observation"].as_array().unwrap().len(), 8);
}

/// What only a look into the grids can find is told with its line too.
#[test]
fn a_turn_that_faces_no_gateway_is_refused_at_its_line() {
    let grids = text(&topostar(&["world", "ring3", "--resolution", "0.1"]).stdout);
    let mut lines: Vec<String> = grids.lines().map(str::to_owned).collect();
    let at = lines.iter().position(|line| line.contains("\"turn\"")).unwrap();
    let mut turn: Value = serde_json::from_str(&lines[at]).unwrap();
    turn["heading"] = (turn["heading"].as_f64().unwrap() + std::f64::consts::PI).into();
    lines[at] = turn.to_string();
    let output = fed(&["map", "-", "--json"], format!("\n{}", lines.join("\n")).as_bytes());
    assert_eq!(output.status.code(), Some(3));
    let expected = format!("-: line {}: faces ", at + 2);
    assert!(text(&output.stderr).contains(&expected), "{}", text(&output.stderr));
}

#[test]
fn options_that_make_no_sense_are_usage() {
    let wrong: [&[&str]; 12] = [
        &["world", "no-such-world"],
        &["world", "office", "--resolution", "0"],
        &["world", "office", "--resolution", "0.0001"],
        &["extract", "lpm.json", "--passage-width", "nan"],
        &["extract", "worlds/aces-stars.ndjson", "--at", "0,0,0"],
        &["map", "worlds/aces-stars.ndjson", "--max-candidates", "0"],
        &["map", "worlds/aces-stars.ndjson", "--relations", "aces.relations"],
        &["map", "worlds/aces-stars.ndjson", "--assert", "0-8"],
        &["map", "worlds/aces-stars.ndjson", "--assert", "0=15"],
        &["map", "worlds/aces-stars.ndjson", "--assert", "3!=3"],
        &["map", "worlds/aces-stars.ndjson", "--explain=0"],
        &["map", "worlds/aces-stars.ndjson", "--explain=0,15"],
    ];
    for arguments in wrong {
        assert_eq!(topostar(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn usage_no_map_and_limit_have_codes_of_their_own() {
    assert_eq!(topostar(&["map"]).status.code(), Some(2));
    let refuted = topostar(&["map", "worlds/door-shut.ndjson", "--json"]);
    assert_eq!(refuted.status.code(), Some(4));
    assert!(text(&refuted.stderr).contains("refuted by star-match"), "{}", text(&refuted.stderr));
    assert_eq!(json(&refuted)["preferred"], Value::Null);
    let cut = topostar(&["map", "worlds/grid3x3-16.ndjson", "--max-candidates", "10", "--json"]);
    assert_eq!(cut.status.code(), Some(5));
    let report = json(&cut);
    assert_eq!((&report["complete"], &report["candidates"]["relation"]), (&false.into(), &"gte".into()));
    assert_eq!(report["stop_reason"], "candidate-limit");
    let cut = topostar(&["map", "worlds/grid3x3-16.ndjson", "--max-memory", "20K", "--json"]);
    assert_eq!(cut.status.code(), Some(5));
    let report = json(&cut);
    assert_eq!((&report["complete"], &report["candidates"]["relation"]), (&false.into(), &"gte".into()));
    assert_eq!(report["stop_reason"], "memory-limit");
    for wrong in ["0", "12T", "K", "99999999999999G"] {
        let refused = topostar(&["map", "worlds/grid3x3-16.ndjson", "--max-memory", wrong]);
        assert_eq!(refused.status.code(), Some(2), "{wrong}");
    }
}

/// A trace that no map explains is explained as far as it goes, with what stands in the way.
#[test]
fn where_no_map_goes_on_the_reason_and_the_map_before_are_told() {
    let refuted = topostar(&["map", "worlds/door-shut.ndjson", "--json"]);
    let standstill = &json(&refuted)["standstill"];
    assert_eq!(standstill["observation"], 3);
    let before = standstill["before"]["visits"].as_array().unwrap();
    assert_eq!(before.len(), 3);
    let reason = &standstill["reasons"][0];
    assert_eq!(reason["refuted"]["axiom"], "star-match");
    let doubts: Vec<u64> =
        reason["doubts"].as_array().unwrap().iter().map(|d| d["observation"].as_u64().unwrap()).collect();
    assert!(doubts.contains(&3) && doubts.iter().any(|&seen| seen < 3), "{doubts:?}");
    let words = topostar(&["map", "worlds/door-shut.ndjson"]);
    assert_eq!(words.status.code(), Some(4));
    let words = text(&words.stdout);
    for part in ["no map explains observation 3", "by star-match: gateway", "one of these was read wrongly"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    // Where there is a map, or the operator ended it, nothing stands still.
    let found = topostar(&["map", "worlds/aces-stars.ndjson", "--json"]);
    assert!(json(&found).get("standstill").is_none());
    let forbidden = ["map", "worlds/aces-stars.ndjson", "--json", "--assert", "0=1"];
    assert!(json(&topostar(&forbidden)).get("standstill").is_none());
    let folder = tempfile::tempdir().unwrap();
    let grids = text(&topostar(&["world", "dead-end", "--resolution", "0.1"]).stdout);
    let mut lines: Vec<String> = grids.lines().take(9).map(str::to_owned).collect();
    // Back at the junction the robot sees the end of the corridor that it comes from.
    let mut end: Value = serde_json::from_str(&lines[5]).unwrap();
    end["seq"] = 8.into();
    lines[8] = end.to_string();
    let walk = ["map", "-", "-o", folder.path().to_str().unwrap()];
    let output = fed(&[&walk[..], &["--as-read"]].concat(), lines.join("\n").as_bytes());
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let drawn = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap_or_default();
    assert!(drawn("map.svg").contains("Map before observation"));
    assert!(drawn("map.txt").contains("margin"), "{}", drawn("map.txt"));
    let pictures = std::fs::read_dir(folder.path()).unwrap();
    let pictures = pictures
        .filter(|file| file.as_ref().unwrap().file_name().to_string_lossy().starts_with("observation-"));
    assert_eq!(pictures.count(), 2);
}

/// A robot that does not notice a known place on its way comes, as it was read, to where it cannot be.
#[test]
fn a_map_with_readings_changed_says_so_everywhere() {
    let grids = text(&topostar(&["world", "dead-end", "--resolution", "0.1"]).stdout);
    let mut lines: Vec<&str> = grids.lines().collect();
    let last = lines[16].replacen("\"seq\":16", "\"seq\":14", 1);
    lines.truncate(13);
    lines.extend([r#"{"seq":13,"kind":"travel"}"#, &last]);
    let walk = lines.join("\n");
    let folder = tempfile::tempdir().unwrap();
    let mended = ["map", "-", "-o", folder.path().to_str().unwrap()];
    let as_read = fed(&["map", "-", "--as-read"], walk.as_bytes());
    assert_eq!(as_read.status.code(), Some(4), "{}", text(&as_read.stderr));
    let output = fed(&mended, walk.as_bytes());
    assert_eq!(output.status.code(), Some(4), "nothing explains what was read: {}", text(&output.stderr));
    let (words, change) =
        (text(&output.stdout), "on the way to observation 5 the place of observation 1 was passed unseen");
    for part in [
        "no map explains the walk as it was read",
        change,
        "observations 0 1 2 3 4 unseen 5",
        "paths, with the places on them in order",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let drawn = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap_or_default();
    assert!(drawn("map.txt").contains(change) && drawn("map.svg").contains("1 reading changed"));
    assert!(drawn("observation-05.svg").contains(change));
    let report: Value = serde_json::from_str(&drawn("report.json")).unwrap();
    let mending = &report["mending"];
    let [observations, explained, first] =
        ["observations", "explained", "first"].map(|name| mending[name].as_u64());
    assert_eq!((observations, explained, first), (Some(6), Some(6), Some(0)));
    assert_eq!(
        (&mending["changes"][0]["kind"], &mending["changes"][0]["like"]),
        (&"missed".into(), &1.into())
    );
    assert_eq!(mending["told"], serde_json::json!([0, 1, 2, 3, 4, null, 5]));
    assert_eq!(mending["map"]["visits"].as_array().unwrap().len(), 7);
    assert!(report["preferred"].is_null() && report["standstill"].is_object());
    assert_eq!(report["candidates"]["value"], 0);
}

/// There and back along a corridor: the side door of the junction is read on its wall's side in doubt, and the end of the
/// corridor, beyond doubt, as a way on.
#[test]
fn a_map_with_readings_changed_that_leads_no_further_says_how_far() {
    let slot = |[fragment, outward, inward]: [u32; 3], sign: &str, control: &str, margin: f64| {
        let gateway = |id: u32| (id > 0).then_some(id);
        let (outward, inward) = (gateway(outward), gateway(inward));
        serde_json::json!({ "fragment": fragment, "direction": sign, "out": outward, "in": inward,
            "control": control, "margin": margin })
    };
    let end = vec![slot([1, 1, 0], "+", "midline", 0.9), slot([1, 0, 1], "-", "dead_end", 0.9)];
    let on = vec![slot([1, 1, 2], "+", "midline", 0.9), slot([1, 2, 1], "-", "midline", 0.9)];
    let junction = |control: &str, margin: f64| {
        let [ahead, back] =
            [("+", [1, 1, 3]), ("-", [1, 3, 1])].map(|(sign, way)| slot(way, sign, "midline", 0.9));
        vec![ahead, slot([2, 0, 4], "+", "dead_end", 0.9), back, slot([2, 4, 0], "-", control, margin)]
    };
    let (travel, back) =
        (serde_json::json!({ "kind": "travel" }), serde_json::json!({ "kind": "turn", "to": 0 }));
    let seen = |slots: Vec<Value>, dstate: u32| serde_json::json!({ "kind": "observation", "star": { "slots": slots }, "dstate": dstate });
    let (first, again) = (seen(junction("midline", 0.9), 0), seen(junction("left_wall", 0.07), 2));
    let mut events = vec![seen(end.clone(), 0), travel.clone(), first, travel.clone(), seen(end, 1), back];
    events.extend([travel.clone(), again, travel, seen(on, 0)]);
    for (number, event) in events.iter_mut().enumerate() {
        event["seq"] = number.into();
    }
    let walk = events.iter().map(Value::to_string).collect::<Vec<_>>().join("\n");
    let output = fed(&["map", "-", "--json"], walk.as_bytes());
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let report = json(&output);
    let mending = &report["mending"];
    let numbers = ["observations", "first", "explained"].map(|name| mending[name].as_u64());
    assert_eq!(numbers, [Some(5), Some(0), Some(4)], "{report}");
    assert_eq!((&mending["told"], &mending["proven"]), (&serde_json::json!([0, 1, 2, 3]), &true.into()));
    let [change] = &mending["changes"].as_array().unwrap()[..] else { panic!("{mending}") };
    assert_eq!(
        ["kind", "observation", "like"].map(|name| &change[name]),
        [&Value::from("label"), &3.into(), &1.into()]
    );
    assert_eq!(mending["map"]["visits"].as_array().unwrap().len(), 4);
    assert_eq!(report["standstill"]["observation"], 3, "why the walk as it was read stands still");
    let words = text(&fed(&["map", "-"], walk.as_bytes()).stdout);
    for part in [
        "nor with doubtful readings changed. The map is that of observations 0 to 3",
        "observation 3, slot 3: midline read as left_wall, margin 7 %, as at observation 1",
        "1 observations are left",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
}

#[test]
fn an_operators_word_is_tried_out_and_written_down() {
    let trace = "worlds/aces-stars.ndjson";
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().to_str().unwrap();
    let said = topostar(&["map", trace, "--json", "--assert", "0!=8", "--assert", "4=10", "-o", to]);
    assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
    let report = json(&said);
    assert_eq!(report["asserts"].as_array().unwrap().len(), 2);
    let (kept, refuted) = (&report["candidates"]["value"], &report["refuted"]["operator"]);
    assert_eq!(kept.as_u64().unwrap() + refuted.as_u64().unwrap(), 23);
    let visits = &report["preferred"]["visits"];
    assert!(visits[0] != visits[8] && visits[4] == visits[10], "{visits}");
    let mut written =
        json(&topostar(&["map", folder.path().join("trace.ndjson").to_str().unwrap(), "--json"]));
    written["seconds"] = report["seconds"].clone();
    assert_eq!(written, report);
    let nothing = topostar(&["map", trace, "--json", "--assert", "0=8", "--assert", "0!=8"]);
    assert_eq!(nothing.status.code(), Some(4));
    let error = text(&nothing.stderr);
    assert!(error.contains("refuted by operator: retract one of the asserts with seq 37, 38"), "{error}");
}

#[test]
fn reasons_are_given_in_words_and_in_the_report() {
    let trace = "worlds/aces-stars.ndjson";
    let all = text(&topostar(&["map", trace, "--explain"]).stdout);
    for line in [
        "  observations 0 and 8 are one place, 0: so in 10 of 23 candidates",
        "  star-match 1: at observation 7, gateway 2.0 is known to lead to 3.2, but what was seen is not place 3: its \
         slot 0 is open without a way, and was seen as blocked",
    ] {
        assert!(all.lines().any(|own| own == line), "{all}");
    }
    let two = text(&topostar(&["map", trace, "--explain=0,4"]).stdout);
    let line =
        "    as place 0, refuted at observation 7 by star-match: gateway 2.0 is known to lead to 3.2, but";
    assert!(two.lines().any(|own| own.starts_with(line)), "{two}");
    let forbidden = text(&topostar(&["map", trace, "--assert", "0!=8", "--explain=0,8"]).stdout);
    assert!(
        forbidden.contains("as place 0, no axiom refutes it, but the assert with seq 37 does"),
        "{forbidden}"
    );
    let few = text(&topostar(&["map", trace, "--strategy", "best-first", "--explain"]).stdout);
    for line in ["so in 1 of 1 candidates that were kept\n", "  no rival was kept to tell apart\n"] {
        assert!(few.contains(line), "{few}");
    }
    let report = json(&topostar(&["map", trace, "--explain=0,4", "--json"]));
    assert_eq!(report["explain"]["visits"]["same"], false);
    assert_eq!(report["explain"]["closures"].as_array().unwrap().len(), 4);
    assert_eq!(json(&topostar(&["map", trace, "--json"])).get("explain"), None);
}

#[test]
fn no_events_give_no_map_and_no_error() {
    let report = json(&fed(&["map", "-", "--json"], b""));
    assert_eq!((&report["candidates"]["value"], &report["preferred"]), (&0.into(), &Value::Null));
}

#[test]
fn what_strains_a_measured_map_is_told_in_words() {
    let words = String::from_utf8(fed(&["map", "-"], &topostar(&["world", "office"]).stdout).stdout).unwrap();
    let strain = words.lines().find(|line| line.starts_with("patchwork: strain ")).unwrap();
    assert!(strain.ends_with(" with 18 degrees of freedom"), "{strain}");
    // Bare stars without odometry have no patchwork.
    let words = String::from_utf8(topostar(&["map", "worlds/grid4x3-20.ndjson"]).stdout).unwrap();
    assert!(words.contains("preferred map") && !words.contains("patchwork"), "{words}");
}

/// The picture at the head of the README is what the demo draws.
#[test]
fn the_demo_prefers_the_true_office_and_draws_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = topostar(&["demo", "-o", folder.path().to_str().unwrap()]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(printed.contains("preferred map: 1 of 16 possible, the simplest, proven"), "{printed}");
    assert!(printed.contains("visits to places 0 1 2 3 4 5 6 7 0 8 4 8 6 8 2"), "{printed}");
    let drawn = std::fs::read_to_string(folder.path().join("office.svg")).unwrap();
    assert_golden("worlds/pictures/office-map.svg", &drawn);
}

#[test]
fn every_world_is_written_mapped_and_drawn() {
    let names = text(&topostar(&["world"]).stdout);
    assert!(names.lines().count() >= 9, "{names}");
    for name in names.lines().filter_map(|line| line.split_whitespace().next()) {
        let grids = topostar(&["world", name, "--seed", "3", "--resolution", "0.1"]);
        let stars = topostar(&["world", name, "--stars"]);
        // Grids come with odometry, stars without.
        let symbols = "determinism,star-match,travel-moves,path-order,planarity";
        let counts = |trace: &Output| {
            json(&fed(&["map", "-", "--json", "--axioms", symbols], &trace.stdout))["candidates_per_observation"]
                .clone()
        };
        assert_eq!(counts(&grids), counts(&stars), "{name}");
        let measured = json(&fed(&["map", "-", "--json"], &grids.stdout));
        assert!(measured["axioms"].as_array().unwrap().contains(&"closure".into()), "{name}");
        assert!(text(&topostar(&["world", name, "--picture"]).stdout).starts_with("<svg"), "{name}");
    }
}

#[test]
fn a_place_is_extracted_as_json_and_as_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let trace = topostar(&["world", "office"]).stdout;
    let output = fed(&["extract", "-", "-o", folder.path().to_str().unwrap()], &trace);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let places: Vec<Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(places.len(), 15);
    assert_eq!(places[9]["gateways"].as_array().unwrap().len(), 4);
    let drawn = std::fs::read_to_string(folder.path().join("observation-00.svg")).unwrap();
    assert_golden("worlds/pictures/office-place.svg", &drawn);
    let sheet = std::fs::read_to_string(folder.path().join("visits.svg")).unwrap();
    assert!((0..15).all(|visit| sheet.contains(&format!(">\nVisit {visit}\n<"))), "{}", &sheet[..2000]);
    assert_eq!(sheet.matches("least margin").count(), 15);
    let file = folder.path().join("sheet.svg");
    let output = fed(&["extract", "-", "--svg", file.to_str().unwrap()], &trace);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_to_string(file).unwrap(), sheet);
}

#[test]
fn only_loopback_is_served() {
    let output = topostar(&["serve", "--listen", "0.0.0.0:0"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("not a loopback address"));
}
