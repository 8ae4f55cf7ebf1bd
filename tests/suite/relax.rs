//! `topostar relax` from outside: what it prints and writes, and how it takes what is no graph.

use crate::cli::{fed, json, text, topostar};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::process::Command;

/// A square of corridors walked twice, its odometry turning a little too far, with what was recognised.
fn square() -> String {
    laps(2)
}

fn laps(laps: usize) -> String {
    let mut text = String::new();
    for k in 0..20 * laps {
        let turn = if k % 5 == 4 { 1.62 } else { 0.002 };
        writeln!(text, "EDGE_SE2 {k} {} 1.01 0.01 {turn} 400 0 0 400 0 2500", k + 1).unwrap();
    }
    for k in 0..=20 * (laps - 1) {
        writeln!(text, "EDGE_SE2 {k} {} 0.02 -0.01 0.001 400 0 0 400 0 2500", k + 20).unwrap();
    }
    text
}

fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    (folder, path.to_str().unwrap().to_owned())
}

#[test]
fn a_graph_is_relaxed_and_said_in_json() {
    let output = fed(&["relax", "-", "--json", "--covariance", "40"], square().as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = json(&output);
    assert_eq!((&report["poses"], &report["edges"]), (&41.into(), &61.into()));
    assert_eq!((&report["converged"], &report["outcome"]), (&true.into(), &"converged".into()));
    assert_eq!(report["degrees_of_freedom"], 3 * 61 - 3 * 40);
    assert_eq!(
        (&report["gauge"], &report["undetermined"]),
        (&serde_json::json!([0]), &serde_json::json!([]))
    );
    assert_eq!(report["parts"], serde_json::json!([{"first": 0, "poses": 41}]));
    let objective = report["objective"].as_f64().unwrap();
    assert!(objective > 1.0 && report["cost"].as_f64() == Some(objective));
    let strained = report["strained"].as_array().unwrap();
    assert!(strained.len() == 10 && strained[0]["chi_square"].as_f64() >= strained[9]["chi_square"].as_f64());
    assert!(report["covariances"]["40"][0][0].as_f64().unwrap() > 0.0);
    assert!(["reading", "setup", "relaxing"].iter().all(|part| report["seconds"][part].is_number()));
}

#[test]
fn what_is_written_is_the_graph_relaxed() {
    let (folder, graph) = file("square.g2o", square().as_bytes());
    let objective = json(&topostar(&["relax", &graph, "--json"]))["objective"].as_f64().unwrap();
    for name in ["out.g2o", "out.graph"] {
        let out = folder.path().join(name).to_str().unwrap().to_owned();
        assert_eq!(topostar(&["relax", &graph, "-o", &out]).status.code(), Some(0));
        let again = json(&topostar(&["relax", &out, "--start", "guesses", "--json"]));
        let left = again["objective"].as_f64().unwrap();
        assert!((left - objective).abs() < 1e-6 * objective, "{name}: {left} {objective}");
        assert!(again["iterations"].as_u64().unwrap() <= 1, "{name}: {again}");
        assert_eq!(again["information_order"], if name == "out.g2o" { "g2o" } else { "toro" });
    }
    let [tum, svg] = ["out.tum", "out.svg"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    assert_eq!(topostar(&["relax", &graph, "-o", &tum, "--svg", &svg]).status.code(), Some(0));
    let trajectory = fs::read_to_string(&tum).unwrap();
    assert_eq!(trajectory.lines().count(), 41);
    assert!(trajectory.lines().all(|line| line.split(' ').count() == 8 && !line.ends_with(' ')));
    let picture = fs::read_to_string(&svg).unwrap();
    assert!(picture.contains("before") && picture.contains("after") && picture.contains("</svg>"));
}

#[test]
fn compressed_graphs_are_read_and_broken_ones_refused() {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(square().as_bytes()).unwrap();
    let packed = packer.finish().unwrap();
    let (_folder, graph) = file("square.g2o.gz", &packed);
    assert_eq!(topostar(&["relax", &graph]).status.code(), Some(0));
    let (_folder, cut) = file("square.g2o.gz", &packed[..packed.len() / 2]);
    let output = topostar(&["relax", &cut]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("cannot be read"), "{}", text(&output.stderr));
}

/// Nothing that the machine offers may change a bit.
#[test]
fn the_same_graph_gives_the_same_bytes() {
    let (folder, graph) = file("square.g2o", square().as_bytes());
    let written = |threads: &str| {
        let out = folder.path().join(format!("{threads}.g2o"));
        let status = Command::new(env!("CARGO_BIN_EXE_topostar"))
            .args(["relax", &graph, "-o"])
            .arg(&out)
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap()
            .status;
        assert!(status.success());
        fs::read(out).unwrap()
    };
    let mut lines: Vec<String> = square().lines().map(str::to_owned).collect();
    let one = written("1");
    assert_eq!(one, written("7"));
    lines.reverse();
    fs::write(&graph, lines.join("\n")).unwrap();
    let vertices = |bytes: &[u8]| {
        let text = text(bytes);
        text.lines().filter(|line| line.starts_with("VERTEX")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(vertices(&one), vertices(&written("2")));
}

#[test]
fn what_is_hardly_a_graph_is_relaxed_all_the_same() {
    let cases = [
        ("", "0 poses, 0 edges"),
        ("VERTEX_SE2 5 1 2 3\n", "gauge: pose 5 held"),
        ("VERTEX_SE2 5 1 2 3\nVERTEX_SE2 9 0 0 0\n", "2 parts, of which nothing tells how they lie"),
        ("EDGE_SE2 0 1 1 0 0 0 0 0 0 0 9\n", "not determined by what was measured: pose 1"),
        ("EDGE_SE2 0 1 1 0 0 0 0 0 0 0 0\n", "converged after 0 iterations"),
    ];
    for (graph, said) in cases {
        let output = fed(&["relax", "-"], graph.as_bytes());
        assert_eq!(output.status.code(), Some(0), "{graph:?}: {}", text(&output.stderr));
        assert!(text(&output.stdout).contains(said), "{graph:?}: {}", text(&output.stdout));
    }
}

/// Some of what was asked for cannot be: the rest is answered all the same.
#[test]
fn a_pose_that_nothing_determines_has_no_covariance() {
    let graph = b"EDGE_SE2 0 1 1 0 0 4 0 0 4 0 4\nEDGE_SE2 1 2 1 0 0 0 0 0 0 0 9\n";
    let asked = ["relax", "-", "--covariance", "1", "--covariance", "2"];
    let report = json(&fed(&[&asked[..], &["--json"]].concat(), graph));
    let covariances = &report["covariances"];
    assert!((covariances["1"][0][0].as_f64().unwrap() - 0.25).abs() < 1e-6, "{covariances}");
    assert_eq!(
        (&covariances["2"], &report["undetermined"]),
        (&serde_json::Value::Null, &serde_json::json!([2]))
    );
    let output = fed(&asked, graph);
    assert_eq!(output.status.code(), Some(0));
    let said = "covariance of pose 2: none, what was measured does not determine it";
    assert!(text(&output.stdout).contains(said), "{}", text(&output.stdout));
}

#[test]
fn faults_are_told_with_line_and_mend() {
    let output = fed(&["relax", "-"], b"EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n");
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("line 2: the edge leads from pose 1 to itself"));
    let usage = |arguments: &[&str], said: &str| {
        let output = fed(arguments, square().as_bytes());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(said), "{arguments:?}: {}", text(&output.stderr));
    };
    usage(&["relax", "-", "-o", "out.csv"], "expected .g2o, .graph (TORO) or .tum");
    usage(&["relax", "-", "--covariance", "400"], "expected a pose of the graph");
    usage(&["relax", "-", "--loss-width=-1"], "a number above 0");
    let output = fed(&["relax", "-", "--max-iterations", "0"], square().as_bytes());
    assert_eq!(output.status.code(), Some(5));
    assert!(text(&output.stdout).contains("--max-iterations is reached"));
    assert_eq!(topostar(&["relax", "/nowhere.g2o"]).status.code(), Some(3));
}

/// Out of time, the best poses so far are told and written.
#[test]
fn time_ends_a_relaxation_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.g2o").to_str().unwrap().to_owned();
    let output = fed(&["relax", "-", "--json", "--max-seconds", "0", "-o", &out], square().as_bytes());
    assert_eq!(output.status.code(), Some(5));
    assert!(text(&output.stderr).contains("--max-seconds are over"), "{}", text(&output.stderr));
    let report = json(&output);
    assert_eq!((&report["converged"], &report["outcome"]), (&false.into(), &"interrupted".into()));
    assert_eq!(report["iterations"], 0);
    let again = json(&topostar(&["relax", &out, "--start", "guesses", "--max-iterations", "0", "--json"]));
    let [told, written] = [&report, &again].map(|report| report["objective"].as_f64().unwrap());
    assert!((told / written - 1.0).abs() < 1e-9, "{told} {written}");
    let long = fed(&["relax", "-", "--json", "--max-seconds", "1e9"], square().as_bytes());
    assert_eq!(json(&long)["outcome"], "converged");
    for wrong in ["-1", "nan", "1e30", "soon"] {
        let output = fed(&["relax", "-", &format!("--max-seconds={wrong}")], square().as_bytes());
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        assert!(text(&output.stderr).contains("expected seconds"), "{wrong}: {}", text(&output.stderr));
    }
}

/// Pose by pose it comes to the same minimum; only poses that close a loop move others, at most all that are there. Poses
/// of the file are not looked at, but where a part begins and where they are held.
#[test]
fn a_graph_taken_in_pose_by_pose_ends_where_the_whole_does() {
    let whole = json(&fed(&["relax", "-", "--json"], square().as_bytes()));
    assert!(whole.get("growing").is_none());
    let misled = format!("VERTEX_SE2 0 5 6 1\nVERTEX_SE2 1 900 -70 2\n{}", square());
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.g2o").to_str().unwrap().to_owned();
    for (graph, gauge, first) in [
        (square(), 0, "VERTEX_SE2 0 0 0 0\n"),
        (misled.clone(), 0, "VERTEX_SE2 0 5 6 1\n"),
        (format!("{misled}FIX 1\n"), 1, "VERTEX_SE2 1 900 -70 2\n"),
    ] {
        let grown = json(&fed(&["relax", "-", "--growing", "--json", "-o", &out], graph.as_bytes()));
        let [a, b] = [&whole, &grown].map(|report| report["objective"].as_f64().unwrap());
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
        assert_eq!((&grown["start"], &grown["gauge"]), (&"guesses".into(), &serde_json::json!([gauge])));
        assert!(fs::read_to_string(&out).unwrap().contains(first), "{first}");
        let growing = &grown["growing"];
        // The last 21 poses close loops, through all poses but the one that is held.
        assert_eq!((&growing["poses"], &growing["updates"]), (&41.into(), &21.into()));
        assert_eq!(growing["relaxed"], (20..=40).sum::<u64>());
        assert_eq!(growing["most_relaxed"], 40);
    }
    // A pose held far from where odometry leads takes all others along.
    let walk = format!("VERTEX_SE2 300 900 -70 2\n{}FIX 300\n", laps(30));
    let [whole, grown] = [&[][..], &["--growing"]]
        .map(|more| json(&fed(&[&["relax", "-", "--json"], more].concat(), walk.as_bytes())));
    let [a, b] = [&whole, &grown].map(|report| report["objective"].as_f64().unwrap());
    assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    assert_eq!((&grown["gauge"], &grown["growing"]["not_converged"]), (&serde_json::json!([300]), &0.into()));
    assert!(grown["iterations"].as_u64().unwrap() <= 2, "{}", grown["iterations"]);
    let words = fed(&["relax", "-", "--growing"], square().as_bytes());
    assert!(text(&words.stdout).contains("41 poses taken in one after the other"));
    assert!(text(&words.stdout).contains("21 of them moved others: 630 in all, 40 at most"));
    assert_eq!(fed(&["relax", "-", "--growing", "--start", "best"], b"").status.code(), Some(2));
    let cut = json(&fed(&["relax", "-", "--growing", "--json", "--max-seconds", "0"], square().as_bytes()));
    assert_eq!((&cut["growing"]["poses"], &cut["outcome"]), (&0.into(), &"interrupted".into()));
}

/// A strain that no number holds, and one that rounding keeps from falling, are no success.
#[test]
fn numbers_too_large_are_told() {
    let ends = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\nFIX 0 1\nEDGE_SE2 0 1 1e200 0 0 1 0 0 1 0 1\n";
    let output = fed(&["relax", "-", "--json"], ends.as_bytes());
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    assert_eq!((&report["converged"], &report["outcome"]), (&false.into(), &"overflow".into()));
    assert!(report["objective"].is_null() && report["cost"].is_null(), "{report}");
    let words = fed(&["relax", "-"], ends.as_bytes());
    assert!(text(&words.stdout).contains("beyond what a number holds"), "{}", text(&words.stdout));
    let far = square().replace(" 400 0 0 400 0 2500", " 4e8 0 0 4e8 0 25e8") + "VERTEX_SE2 0 1e12 0 0\n";
    let output = fed(&["relax", "-", "--json"], far.as_bytes());
    assert_eq!((output.status.code(), &json(&output)["outcome"]), (Some(1), &"stalled".into()));
    assert!(text(&output.stderr).contains("nearer to the origin"), "{}", text(&output.stderr));
}

/// TORO has no word for a pose that is held: that it is left out is said, and only there.
#[test]
fn what_a_format_cannot_say_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let graph = square() + "VERTEX_SE2 7 1 2 0.5\nFIX 7\n";
    for (name, left_out) in [("out.graph", true), ("out.g2o", false), ("out.tum", false)] {
        let out = folder.path().join(name);
        let output = fed(&["relax", "-", "--json", "-o", out.to_str().unwrap()], graph.as_bytes());
        let notes = json(&output)["notes"].to_string();
        assert_eq!(notes.contains("FIX of 1 is not written"), left_out, "{name}: {notes}");
        assert_eq!(fs::read_to_string(&out).unwrap().contains("FIX 7"), name == "out.g2o", "{name}");
    }
}

/// The grids of a patchwork are as fine as was asked for.
#[test]
fn cells_of_a_patchwork_are_chosen() {
    let trace = topostar(&["world", "office", "--resolution", "0.1"]).stdout;
    let written = |resolution: &str| {
        let folder = tempfile::tempdir().unwrap();
        let to = folder.path().to_str().unwrap();
        let mapped = fed(&["map", "-", "-o", to, "--resolution", resolution], &trace);
        assert_eq!(mapped.status.code(), Some(0), "{}", text(&mapped.stderr));
        let yaml = std::fs::read_to_string(folder.path().join("patchwork.yaml")).unwrap();
        let cell: f64 =
            yaml.lines().find_map(|line| line.strip_prefix("resolution: ")).unwrap().parse().unwrap();
        let sizes = ["patchwork.png", "odometry.png"].map(|name| {
            let (width, height) = image::image_dimensions(folder.path().join(name)).unwrap();
            [width, height].map(|side| f64::from(side) * cell)
        });
        (cell, sizes, text(&mapped.stderr))
    };
    let (coarse, fine) = (written("0.5"), written("0.08"));
    assert_eq!((coarse.0, fine.0), (0.5, 0.08));
    // 40 m between opposite corridors, and what is seen beyond them, whatever the cells.
    for (sizes, other) in coarse.1.iter().flatten().zip(fine.1.iter().flatten()) {
        assert!((45.0..90.0).contains(sizes) && (sizes - other).abs() < 1.2, "{coarse:?} {fine:?}");
    }
    assert!(!fine.2.contains("has cells"), "{}", fine.2);
    // The first two places, and ten kilometres between them.
    let events = text(&trace);
    let far = events.lines().take(3).map(|line| {
        let mut event: Value = serde_json::from_str(line).unwrap();
        if event["kind"] == "travel" {
            event["odometry"]["x"] = 10_000.0.into();
        }
        event.to_string() + "\n"
    });
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().to_str().unwrap();
    let mapped = fed(&["map", "-", "-o", to], far.collect::<String>().as_bytes());
    let said = text(&mapped.stderr);
    assert_eq!(mapped.status.code(), Some(0), "{said}");
    assert!(
        said.contains("patchwork.png has cells of 1.") && said.contains("as of 0.05 m it would be 19"),
        "{said}"
    );
    assert!(!said.contains("odometry.png has"), "{said}");
    for wrong in ["0", "0.0001", "fine", "NaN", "1e9"] {
        let refused = fed(&["map", "-", "-o", "there", "--resolution", wrong], &trace);
        let said = text(&refused.stderr);
        assert!(
            refused.status.code() == Some(2) && said.contains("expected metres a cell"),
            "{wrong}: {said}"
        );
    }
    assert_eq!(fed(&["map", "-", "--resolution", "0.1"], &trace).status.code(), Some(2));
}

/// What `map -o` writes of a trace of grids: the patchwork as a picture, as odometry alone has it, and as a graph that this
/// solver finds nothing to do in.
#[test]
fn a_trace_of_grids_is_laid_out() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().to_str().unwrap();
    let trace = topostar(&["world", "office", "--resolution", "0.1"]).stdout;
    let mapped = fed(&["map", "-", "--json", "-o", to], &trace);
    assert_eq!(mapped.status.code(), Some(0), "{}", text(&mapped.stderr));
    assert!(!text(&mapped.stderr).contains("has cells"), "{}", text(&mapped.stderr));
    let strain = &json(&mapped)["strain"];
    let written = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let size = |name: &str| {
        let picture = image::load_from_memory(&written(name)).unwrap().into_luma8();
        let occupied = picture.pixels().filter(|grey| grey.0[0] == 0).count();
        assert!(occupied > 1000, "{name}: {occupied} occupied cells");
        [picture.width(), picture.height()].map(|side| f64::from(side) * 0.05)
    };
    // 40 m between opposite corridors, and what is seen beyond them.
    assert!(size("patchwork.png").iter().all(|side| (45.0..90.0).contains(side)));
    assert_ne!(size("odometry.png"), size("patchwork.png"));
    assert!(text(&written("patchwork.yaml")).starts_with("image: patchwork.png\n"));
    let graph = folder.path().join("patchwork.g2o");
    let relaxed = json(&topostar(&["relax", graph.to_str().unwrap(), "--json"]));
    assert_eq!((&relaxed["poses"], &relaxed["edges"]), (&15.into(), &20.into()));
    assert_eq!(relaxed["degrees_of_freedom"], strain["degrees_of_freedom"]);
    let [found, told] = [&relaxed["objective"], &strain["chi_square"]].map(|value| value.as_f64().unwrap());
    assert!((found / told - 1.0).abs() < 1e-6, "{found} {told}");
    // Of stars, which nothing was measured between, there is none.
    let other = tempfile::tempdir().unwrap();
    topostar(&["map", "worlds/aces-stars.ndjson", "-o", other.path().to_str().unwrap()]);
    let names = std::fs::read_dir(other.path()).unwrap().map(|file| file.unwrap().file_name());
    assert!(names.into_iter().all(|name| !name.to_string_lossy().contains("patchwork")));
}
