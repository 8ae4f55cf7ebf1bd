//! Logs from outside: files as recorders leave them, options, and what is said about them.

use crate::cli::{json, text, topostar};
use bzip2::Compression;
use bzip2::write::BzEncoder;
use flate2::write::GzEncoder;
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A drive of 12 m along a corridor 3 m wide that ends 20 m ahead, a scan each tenth of a metre.
fn corridor() -> String {
    let mut log = String::from("# a corridor\nPARAM robot_frontlaser_offset 0.0 nohost 0\n");
    for k in 0..=120 {
        let x = f64::from(k) / 10.0;
        let ranges: Vec<String> = ranges(x).map(|range| format!("{range:.2}")).collect();
        log += &format!("ODOM {x} 0 0 0 0 0 {k} nohost {k}\n");
        log += &format!("FLASER 181 {} {x} 0 0 {x} 0 0 {k}.5 nohost {k}\n", ranges.join(" "));
    }
    log
}

/// The ranges of a laser at x in a corridor 3 m wide that ends at 20 m, a beam each degree from -90 degrees.
fn ranges(x: f64) -> impl Iterator<Item = f64> {
    (0..=180).map(move |beam| {
        let (sin, cos) = (f64::from(beam) - 90.0).to_radians().sin_cos();
        let side = if sin == 0.0 { f64::INFINITY } else { 1.5 / sin.abs() };
        side.min((20.0 - x) / cos.max(1e-9)).min(30.0)
    })
}

/// A folder with the log under a name, and one arrival in it.
fn folder(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().unwrap();
    let visits = folder.path().join("visits.csv");
    fs::write(&visits, "place,raw_scan_index\nA,5\n").unwrap();
    let log = folder.path().join(name);
    fs::write(&log, content).unwrap();
    (folder, log, visits.to_str().unwrap().to_owned())
}

fn map(log: &Path, visits: &str, more: &[&str]) -> Output {
    topostar(&[&["map", log.to_str().unwrap(), "--visits", visits, "--json"], more].concat())
}

#[test]
fn a_log_is_read_plain_and_compressed_and_reported() {
    let plain = corridor().into_bytes();
    let mut bz2 = BzEncoder::new(Vec::new(), Compression::fast());
    bz2.write_all(&plain).unwrap();
    let mut gz = GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&plain).unwrap();
    let forms =
        [("run.LOG", plain), ("run.clf.BZ2", bz2.finish().unwrap()), ("run.log.gz", gz.finish().unwrap())];
    for (name, content) in forms {
        let (_kept, log, visits) = folder(name, &content);
        let output = map(&log, &visits, &[]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert_eq!(json(&output)["candidates_per_observation"].as_array().unwrap().len(), 1);
        assert!(
            said.contains("121 scans in 120.0 s; read 121 FLASER, 121 ODOM, 1 PARAM; passed over 1 comment"),
            "{said}"
        );
        assert!(
            said.contains("181 beams, from -90.00 degrees in steps of 1.000 (guessed from their number)"),
            "{said}"
        );
    }
}

#[test]
fn options_say_what_a_log_does_not() {
    let (_kept, log, visits) = folder("run.log", corridor().as_bytes());
    let options = ["--max-range", "18.5", "--start-angle", "-1.5", "--mount", "-0.1,0,0.5"];
    let said = text(&map(&log, &visits, &options).stderr);
    for part in [
        "18.5 m and more, as asked for",
        "from -85.94 degrees",
        "x -0.100 m, y 0.000 m, 28.65 degrees (as asked for)",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let trace = topostar(&["map", "worlds/aces-stars.ndjson", "--max-range", "20"]);
    assert_eq!(trace.status.code(), Some(2));
    assert!(text(&trace.stderr).contains("the options for logs do not go with a trace"));
}

#[test]
fn what_came_before_a_bad_line_is_mapped() {
    let log = corridor();
    let lines: Vec<&str> = log.lines().collect();
    let broken = format!("{}\nFLASER 181 x\n{}\n", lines[..60].join("\n"), lines[60..].join("\n"));
    let (_kept, log, visits) = folder("run.log", broken.as_bytes());
    fs::write(&visits, "place,raw_scan_index\nA,5\nB,100\n").unwrap();
    let output = map(&log, &visits, &[]);
    assert_eq!(output.status.code(), Some(3));
    assert!(
        text(&output.stderr)
            .contains("run.log: line 61: FLASER announces 181 readings and has 1 words after that")
    );
    assert_eq!(json(&output)["candidates_per_observation"].as_array().unwrap().len(), 1);
}

#[test]
fn a_log_that_is_taken_for_a_trace_is_told_how_logs_are_known() {
    let (_kept, log, _) = folder("run.txt", corridor().as_bytes());
    let said = text(&topostar(&["map", log.to_str().unwrap()]).stderr);
    assert!(
        said.contains("run.txt: line 1: ") && said.contains("a log is known by the end of its name: .clf"),
        "{said}"
    );
    let (_kept, trace, _) = folder("run.ndjson", b"nothing\n");
    let said = text(&topostar(&["map", trace.to_str().unwrap()]).stderr);
    assert!(said.contains("line 1: ") && !said.contains("a log is known"), "{said}");
}

#[test]
fn a_log_that_breaks_off_is_mapped_as_far_as_it_goes() {
    let mut gz = GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(corridor().as_bytes()).unwrap();
    let whole = gz.finish().unwrap();
    let (_kept, log, visits) = folder("run.log.gz", &whole[..whole.len() * 9 / 10]);
    let output = map(&log, &visits, &[]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("the file breaks off before its end"), "{said}");
    let (_kept, log, visits) = folder("run.log.gz", &[&whole[..], &[0; 8]].concat());
    let output = map(&log, &visits, &[]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("121 scans") && said.contains("bytes behind the end of the compressed file"),
        "{said}"
    );
    assert!(!said.contains("breaks off"), "{said}");
}

#[test]
fn other_files_are_refused_with_what_to_do() {
    for (name, content, expected) in [
        ("run.db3", &b""[..], "mcap convert"),
        ("run.mcap", b"not a bag at all", "is no MCAP file"),
        ("run.log", b"", "no scan in the log: found nothing at all"),
        ("run.clf.bz2", b"plain text", "line 1: cannot be read"),
    ] {
        let (_kept, log, visits) = folder(name, content);
        let output = map(&log, &visits, &[]);
        assert_eq!(output.status.code(), Some(3), "{name}");
        assert!(text(&output.stderr).contains(expected), "{name}: {}", text(&output.stderr));
    }
}

/// Fields in the encoding of ROS 2, each aligned to its size.
#[derive(Default)]
struct Cdr(Vec<u8>);

impl Cdr {
    fn put<const N: usize>(mut self, bytes: [u8; N]) -> Cdr {
        let aligned = self.0.len().next_multiple_of(N);
        self.0.resize(aligned, 0);
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Cdr {
        let mut cdr = self.put((text.len() as u32 + 1).to_le_bytes());
        cdr.0.extend(text.bytes().chain([0]));
        cdr
    }

    fn header(self, stamp: f64, frame: &str) -> Cdr {
        let cdr = self.put((stamp as i32).to_le_bytes());
        cdr.put(((stamp.fract() * 1e9) as u32).to_le_bytes()).text(frame)
    }

    fn pose(self, x: f64) -> Cdr {
        [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].into_iter().fold(self, |cdr, value| cdr.put(value.to_le_bytes()))
    }

    fn message(self) -> Vec<u8> {
        [vec![0, 1, 0, 0], self.0].concat()
    }
}

/// A file of a bag with a part of the drive along the corridor.
fn bag(steps: std::ops::Range<i32>) -> Vec<u8> {
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let mut send = |topic: &str, kind: &str, stamp: f64, data: Vec<u8>| {
        let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        let time = (stamp * 1e9) as u64;
        let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &data).unwrap();
    };
    let mount = Cdr::default().put(1u32.to_le_bytes()).header(0.0, "base_link").text("laser").pose(0.25);
    send("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, mount.message());
    for k in steps {
        let (x, stamp) = (f64::from(k) / 10.0, f64::from(k));
        let odometry = Cdr::default().header(stamp, "odom").text("base_link").pose(x);
        send("/odom", "nav_msgs/msg/Odometry", stamp, odometry.message());
        let degree = 1f64.to_radians();
        let head = [-90.0 * degree, 90.0 * degree, degree, 0.0, 0.0, 0.1, 25.0];
        let scan = Cdr::default().header(stamp + 0.5, "laser");
        let scan = head.iter().fold(scan, |cdr, value| cdr.put((*value as f32).to_le_bytes()));
        let scan =
            ranges(x + 0.3).fold(scan.put(181u32.to_le_bytes()), |cdr, r| cdr.put((r as f32).to_le_bytes()));
        send("/scan", "sensor_msgs/msg/LaserScan", stamp + 0.5, scan.put(0u32.to_le_bytes()).message());
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn the_folder_of_a_bag_is_read_in_the_order_of_its_files() {
    let (kept, _, visits) = folder("metadata.yaml", b"");
    for (number, steps) in [(0, 0..50), (2, 50..80), (10, 80..121)] {
        fs::write(kept.path().join(format!("run_{number}.mcap")), bag(steps)).unwrap();
    }
    let output = map(kept.path(), &visits, &[]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("120 scans in 119.0 s; read 121 /odom, 121 /scan, 3 /tf_static"), "{said}");
    assert!(
        said.contains("on the robot at x 0.250 m, y 0.000 m, 0.00 degrees (by the static transforms)"),
        "{said}"
    );
    assert!(!said.contains("earlier stamp"), "{said}");
    assert_eq!(json(&output)["candidates_per_observation"].as_array().unwrap().len(), 1);
    let wrong = map(kept.path(), &visits, &["--scan-topic", "/front"]);
    assert_eq!(wrong.status.code(), Some(3));
    assert!(
        text(&wrong.stderr).contains("/front is no topic of type sensor_msgs/msg/LaserScan, expected /scan")
    );
}
