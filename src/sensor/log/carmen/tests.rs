//! Logs as robots, simulators and converters write them, whole, cut off and broken.

use super::*;
use crate::sensor::LaserScan;
use crate::sensor::log::{LogReport, MountSource, PoseChoice, Step, TrailingBytes};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::{self, Read};

const FLASER: &str = "FLASER 3 1.0 2.0 3.0 1.1 2.0 0.0 1.0 2.0 0.0 7.5 nohost 0.1\n";

type Outcome = (Vec<LaserScan>, LogReport, Option<String>);

fn read_with(text: impl AsRef<[u8]>, options: LogOptions) -> Outcome {
    let mut reader = carmen_scans(text.as_ref(), options);
    let (scans, fault) = reader.read_all();
    (scans, reader.report(), fault.map(|fault| fault.to_string()))
}

fn read(text: impl AsRef<[u8]>) -> Outcome {
    read_with(text, LogOptions::default())
}

fn near(a: &Pose, b: &Pose) -> bool {
    let off = a.inverse().compose(b);
    off.x.hypot(off.y) < 1e-9 && off.theta.abs() < 1e-9
}

#[test]
fn the_second_pose_is_the_robot() {
    let (scans, report, fault) = read(format!("# comment\nPARAM x y\n\n{FLASER}SYNC a\n"));
    assert_eq!((scans.len(), fault), (1, None));
    let scan = &scans[0];
    assert_eq!((scan.laser, scan.stamp), (LaserNumber::FRONT, 7.5));
    assert_eq!(scan.odom_from_robot, Pose::new(1.0, 2.0, 0.0));
    assert!((scan.robot_from_laser.x - 0.1).abs() < 1e-12);
    assert_eq!(scan.ranges, [Some(1.0), Some(2.0), Some(3.0)]);
    let hits: Vec<_> = scan.hits().collect();
    assert!((hits[0].y + 1.0).abs() < 1e-12 && (hits[1].x - 2.1).abs() < 1e-12);
    assert_eq!(report.read.get("FLASER"), Some(&1));
    let over: Vec<_> = report.passed_over.iter().map(|(kind, count)| (kind.as_str(), *count)).collect();
    assert_eq!(over, [("SYNC", 1), ("blank line", 1), ("comment", 1)]);
}

/// A difference of coordinates instead of poses would put the laser 0.1 m to the left here.
#[test]
fn the_mount_does_not_turn_with_the_robot() {
    let line = format!("FLASER 2 1.0 2.0 1.0 2.1 {FRAC_PI_2} 1.0 2.0 {FRAC_PI_2} 7.5 nohost 0.1\n");
    let (scans, report, _) = read(&line);
    assert!(near(&scans[0].robot_from_laser, &Pose::new(0.1, 0.0, 0.0)));
    assert_eq!(report.lasers[&LaserNumber::FRONT].mount_source, MountSource::Poses);
    assert_eq!(scans[0].angle_increment, PI);
}

#[test]
fn the_angles_follow_from_the_number_of_readings_or_the_parameters() {
    let line = |n: usize| format!("FLASER {n} {} 0 0 0 0 0 0 1 h 1\n", "1.0 ".repeat(n));
    let (scans, ..) = read([180, 181, 360, 361].map(line).concat());
    let steps: Vec<f64> = scans.iter().map(|scan| scan.angle_increment.to_degrees()).collect();
    assert!(steps.iter().zip([1.0, 1.0, 0.5, 0.5]).all(|(a, b)| (a - b).abs() < 1e-12), "{steps:?}");
    let parameters = "PARAM laser_front_laser_fov 100 h 0\r\nPARAM laser_front_laser_resolution 0.25 h 0\r\n";
    let (scans, ..) = read(format!("{parameters}{}{}", line(401), line(181)));
    assert!((scans[0].start_angle.to_degrees() + 50.0).abs() < 1e-9);
    assert!((scans[1].start_angle.to_degrees() + 90.0).abs() < 1e-9);
    let options = LogOptions { start_angle: Some(-1.0), ..LogOptions::default() };
    assert_eq!(read_with(line(401), options).0[0].start_angle, -1.0);
}

#[test]
fn robot_lasers_are_read_with_and_without_remissions() {
    let head = "ROBOTLASER1 0 -1.55 3.1 1.55 80.0 0.01 0 3 1.0 79.5 0.0";
    let poses = "1.10 2.0 0.0 1.00 2.0 0.0";
    for tail in [
        format!("0 {poses} 0.1 0.2 0.3 0.4 1e6 9.5 host 0.21"),
        format!("2 7 8.5 {poses} 0.1 0.2 0.3 0.4 1e6 9.5 host 0.21"),
        format!("{poses} 0.1 0.2 0.3 0.4 9.5 host 0.21"),
        format!("{poses} 0.1 0.2 0.3 0.4 1e6 9.5 host 0.21"),
        format!("2 7 8.5 {poses} 0.1 0.2 0.3 0.4 9.5 host 0.21"),
        format!("2 7 8.5 {poses} 0.1 0.2 0.3 0.4 1e6 9.5 127 0.21"),
        format!("{poses} 0.1 0.2 0.3 0.4 9.5 127 0.21"),
        format!("{poses} 0.1 0.2 0.3 0.4 1e6 9.5 127 0.21"),
        format!("2 7 8.5 {poses} 0.1 0.2 0.3 0.4 9.5 127 0.21"),
    ] {
        let (scans, _, fault) = read(format!("{head} {tail}\n"));
        assert_eq!(fault, None, "{tail}");
        let scan = &scans[0];
        assert_eq!((scan.stamp, scan.odom_from_robot), (9.5, Pose::new(1.0, 2.0, 0.0)), "{tail}");
        assert!((scan.robot_from_laser.x - 0.1).abs() < 1e-9, "{tail}");
        assert_eq!((scan.start_angle, scan.angle_increment), (-1.55, 1.55));
        assert_eq!(scan.ranges, [Some(1.0), None, None]);
    }
    // Remissions, or a coordinate without its decimals.
    let (_, _, fault) = read(format!("{head} 1 2.0 0.0 1.0 2.0 0.0 0.1 0.2 0.3 0.4 1e6 9.5 host 0.21\n"));
    assert!(fault.unwrap().contains("has 11 numbers after its readings, expected two poses"));
    let (_, _, fault) = read(format!("{FLASER}{head} {poses} 1 2\n"));
    assert!(fault.unwrap().starts_with("line 2: a message of the front laser has 8 numbers after"));
}

#[test]
fn a_told_start_angle_needs_none_in_the_messages() {
    let line = "ROBOTLASER1 0 -90 2 1 80 0.01 0 2 1 2 0 1 2 0 1 2 0 1 2 3 4 5 9.5 host 0.21\n";
    let options = LogOptions { start_angle: Some(-1.0), ..LogOptions::default() };
    let (scans, _, fault) = read_with(line, options);
    assert_eq!((scans[0].start_angle, scans[0].angle_increment, fault), (-1.0, 1.0, None));
}

#[test]
fn a_raw_sweep_lies_between_the_odometry_around_it() {
    let odom = |x: f64, t: f64| format!("ODOM {x} 0 0 0.1 0 0 {t} host {t}\n");
    let raw = |t: f64| format!("RAWLASER2 0 -1.5 3.0 1.5 20 0.01 0 3 1 2 3 0 {t} host {t}\n");
    let parameter = "PARAM robot_rearlaser_offset -0.3 1 host 1\n";
    let text = [parameter, &raw(0.5), &odom(1.0, 1.0), &raw(1.25), &odom(2.0, 2.0), &raw(2.5)].concat();
    let (scans, report, fault) = read(text);
    assert_eq!((scans.len(), fault), (1, None));
    assert!(near(&scans[0].odom_from_robot, &Pose::new(1.25, 0.0, 0.0)));
    assert!(near(&scans[0].robot_from_laser, &Pose::new(-0.3, 0.0, PI)));
    assert_eq!(report.lasers[&LaserNumber::REAR].without_odometry, 2);
    let (_, _, fault) = read(raw(1.0));
    assert!(fault.unwrap().starts_with("no scan in the log: 1 sweeps have no pose"));
}

#[test]
fn a_sweep_that_is_logged_twice_is_taken_once() {
    let raw = "RAWLASER1 0 -1.5 3.0 1.5 20 0.01 0 3 1 2 3 0 7.4 host 1\n";
    let odom = "ODOM 1 0 0 0 0 0 7.0 host 1\nODOM 1 0 0 0 0 0 8.0 host 1\n";
    let robot = "ROBOTLASER1 0 0 3.1 1.0 80.0 0.01 0 3 1.0 2 3 0 1 2 0 1 2 0 1 2 3 4 5 9.5 host 0.21\n";
    let rear = FLASER.replace("FLASER", "RLASER");
    let (scans, report, fault) = read([odom, raw, FLASER, raw, robot, &rear].concat());
    assert_eq!(fault, None);
    let lasers: Vec<LaserNumber> = scans.iter().map(|scan| scan.laser).collect();
    assert_eq!(lasers, [LaserNumber::FRONT, LaserNumber::REAR]);
    assert_eq!(report.lasers[&LaserNumber::FRONT].repeated, 3);
}

#[test]
fn old_odometry_has_no_acceleration() {
    for text in
        ["ODOM 1 2 0 0.1 0 5.5 host 0\n", "ODOM 1 2 0 0.1 0 0 5.5 host 0\n", "ODOM 1 2 0 5.5 host 0\n"]
    {
        let entry = CarmenEntries::new(text.as_bytes()).next().unwrap().unwrap();
        let odom_from_robot = Pose::new(1.0, 2.0, 0.0);
        assert_eq!(entry.content, Content::Odometry { stamp: Some(5.5), odom_from_robot });
    }
}

#[test]
fn the_truth_is_a_stream_of_its_own() {
    let text = format!("{FLASER}TRUEPOS 1 2 0.5 3 4 0.25 8.5 host 0\nTRUEPOS 1 2 0.5 3 4 0.25\n");
    let truths: Vec<_> = CarmenEntries::new(text.as_bytes()).truths().map(Result::unwrap).collect();
    let pose = Pose::new(1.0, 2.0, 0.5);
    assert_eq!(truths, [(Some(8.5), pose), (None, pose)]);
}

#[test]
fn a_corrected_log_is_noticed() {
    let line = |k: usize| {
        let (laser, robot) = (0.1 + k as f64, k as f64 * 0.9);
        format!("FLASER 2 1 2 {laser} 0 0 {robot} 0 0 {k} host 0\n")
    };
    let text: String = (0..5).map(line).collect();
    let (scans, report, _) = read(&text);
    assert!(report.lasers[&LaserNumber::FRONT].corrected && report.to_string().contains("--pose laser"));
    assert!(scans.iter().all(|scan| near(&scan.robot_from_laser, &Pose::new(0.1, 0.0, 0.0))));
    assert!((scans[4].odom_from_robot.x - 3.6).abs() < 1e-9);
    let laser = LogOptions { pose: PoseChoice::Laser, ..LogOptions::default() };
    let (scans, ..) = read_with(&text, laser.clone());
    assert!((scans[4].odom_from_robot.x - 4.0).abs() < 1e-9);
    let (scans, report, _) = read_with(FLASER, laser);
    assert!(near(&scans[0].odom_from_robot, &Pose::new(1.0, 2.0, 0.0)));
    assert!(!report.lasers[&LaserNumber::FRONT].corrected);
}

#[test]
fn stamps_may_be_missing_repeated_or_early() {
    let line = |tail: &str| format!("FLASER 2 1 2 0 0 0 0 0 0{tail}\n");
    let text = ["", " 5 host 0", " 5 host 0", " 4.5", " 6 host 0"].map(line).concat();
    let (scans, report, fault) = read(text);
    let stamps: Vec<f64> = scans.iter().map(|scan| scan.stamp).collect();
    assert_eq!((stamps, fault), (vec![0.0, 5.0, 5.0, 4.5, 6.0], None));
    let front = report.lasers[&LaserNumber::FRONT];
    assert_eq!((front.unstamped, front.same_stamp, front.backwards), (1, 1, 1));
}

#[test]
fn leaps_of_the_odometry_are_counted() {
    let line = |x: f64, t: f64| format!("FLASER 2 1 2 {x} 0 0 {x} 0 0 {t} host 0\n");
    let drive = |steps: &[(f64, f64)]| read(steps.iter().map(|(x, t)| line(*x, *t)).collect::<String>()).1;
    let report = drive(&[(0.0, 0.0), (0.4, 0.2), (3.0, 0.4), (3.0, 0.6), (-1.0, 0.5), (40.0, 10.5)]);
    let Step { scan, metres, seconds } = report.first_impossible_step.unwrap();
    assert_eq!((report.impossible_steps, scan), (2, 2));
    assert!((metres - 2.6).abs() < 1e-9 && (seconds - 0.2).abs() < 1e-9);
    let said = "2 steps between scans are more than a robot makes; the first, to scan 2 (from 0), is 2.60 m in 0.200 s";
    assert!(report.to_string().contains(said), "{report}");
    let report = drive(&[(0.0, 0.0), (0.4, 0.2), (4.0, 2.0)]);
    assert!(report.impossible_steps == 0 && !report.to_string().contains("a robot makes"), "{report}");
    // Without stamps nobody knows how long it took.
    let unstamped = |x: f64| format!("FLASER 2 1 2 {x} 0 0 {x} 0 0\n");
    assert_eq!(read([0.0, 3.0, 6.0].map(unstamped).concat()).1.impossible_steps, 0);
}

#[test]
fn a_cut_off_line_is_left_out_wherever_it_is_cut() {
    for cut in 1..FLASER.len() - 1 {
        let (scans, report, fault) = read(format!("{FLASER}{}", &FLASER[..cut]));
        // From the name of the host on nothing is missing that a scan needs.
        let whole = cut > FLASER.find(" nohost").unwrap() + 1;
        assert_eq!((scans.len(), fault), (1 + usize::from(whole), None), "{cut}");
        let said = report.cut_off_line.is_some() || cut < "FLASER".len();
        assert!(said != whole, "{cut}: {report}");
        assert!(scans.iter().all(|scan| scan == &scans[0]));
    }
}

#[test]
fn a_byte_order_mark_does_not_hide_the_first_scan() {
    let (scans, report, _) = read(format!("\u{feff}{FLASER}{}", FLASER.replace('\n', "\r\n")));
    assert_eq!((scans.len(), report.passed_over.len()), (2, 0));
}

#[test]
fn text_that_is_no_utf_8_is_refused_and_not_taken_apart() {
    let wide = |bytes: fn(u16) -> [u8; 2], mark: &str| -> Vec<u8> {
        format!("{mark}{FLASER}{FLASER}").encode_utf16().flat_map(bytes).collect()
    };
    for (text, found) in [
        (wide(u16::to_le_bytes, "\u{feff}"), "begins with the mark of UTF-16"),
        (wide(u16::to_be_bytes, "\u{feff}"), "begins with the mark of UTF-16"),
        (wide(u16::to_le_bytes, ""), "has a NUL byte"),
        (wide(u16::to_be_bytes, ""), "has a NUL byte"),
        (vec![0; 100], "has a NUL byte"),
    ] {
        let (scans, report, fault) = read(text);
        assert_eq!((scans.len(), report.passed_over.len()), (0, 0));
        assert_eq!(
            fault.unwrap(),
            format!(
                "line 1: {found}, expected UTF-8 text; `iconv -f UTF-16 -t UTF-8` makes that of UTF-16 text"
            )
        );
    }
    // What a crash leaves at the end of a file.
    let (scans, report, fault) = read([FLASER.as_bytes(), &[0; 100]].concat());
    assert_eq!((scans.len(), report.cut_off_line, fault), (1, Some(2), None));
}

#[test]
fn sweeps_without_beams_are_told_from_no_sweeps() {
    let (_, _, fault) = read("FLASER 1 1 0 0 0 0 0 0 1 h 0\nFLASER 0 0 0 0 0 0 0 1 h 0\n");
    assert_eq!(
        fault.unwrap(),
        "no scan in the log: 2 sweeps have fewer than two beams, expected some with more"
    );
}

#[test]
fn a_line_without_end_is_refused_before_it_fills_the_memory() {
    let endless = FLASER.as_bytes().chain(io::repeat(b'0'));
    let (scans, fault) = carmen_scans(io::BufReader::new(endless), LogOptions::default()).read_all();
    assert_eq!(scans.len(), 1);
    assert_eq!(
        fault.unwrap().to_string(),
        "line 2: is longer than 4194304 bytes, expected one message a line"
    );
}

#[test]
fn a_broken_line_is_refused_with_its_number_and_what_came_before_is_kept() {
    for (bad, fault) in [
        ("FLASER\n", "FLASER ends before the number of readings"),
        ("FLASER x\n", "FLASER announces `x` readings, expected a whole number up to 32768"),
        ("FLASER 99999999999 1\n", "FLASER announces `99999999999` readings"),
        ("FLASER 3 1 2\n", "FLASER announces 3 readings and has 2 words after that"),
        ("FLASER 2 1 two 0 0 0 0 0 0 1\n", "FLASER has `two` as a reading, expected metres"),
        ("FLASER 2 1 2 0 0 nan 0 0 0 1\n", "FLASER has `nan` as the laser's pose, expected a finite number"),
        ("FLASER 2 1 2 0 0 0 0 0\n", "FLASER ends before the robot's pose"),
        ("ODOM 1 2\n", "ODOM ends before the robot's pose"),
        ("ODOM 1e300 2 0 0 0 0 0 h 0\n", "ODOM has `1e300` as the robot's pose"),
        ("RAWLASER1 0 0 3 1 20 0 0 2 1 2 5 6 7 h 0\n", "a message of the front laser has 2 numbers after"),
        (
            "RAWLASER2 0 1e10 3 1 20 0 0 2 1 2 0 7 h 0\n",
            "RAWLASER2 has a first beam at 10000000000.0 radians, expected an angle within a turn; --start-angle",
        ),
        (
            "ROBOTLASER1 0 -90 180 1 80 0.01 0 2 1 2 0 1 2 0 1 2 0 1 2 3 4 5 9.5 host 0.21\n",
            "ROBOTLASER1 has a first beam at -90.0 radians, expected an angle within a turn; --start-angle",
        ),
        (
            "RAWLASER1 0 -1.5 180 90 20 0 0 2 1 2 0 7 h 0\n",
            "RAWLASER1 has 2 beams in steps of 90.0 radians, expected them to cover at most a turn",
        ),
        ("RAWLASER1 0 -1.5 1e-9 0 20 0 0 2 1 2 0 7 h 0\n", "RAWLASER1 has 2 beams in steps of"),
        ("TRUEPOS 1\n", "TRUEPOS ends before the true pose"),
        ("PARAM\n", "PARAM ends before a name"),
    ] {
        let (scans, _, said) = read(format!("{FLASER}{bad}{FLASER}"));
        let said = said.unwrap();
        assert!(said.starts_with(&format!("line 2: {fault}")), "{said}");
        assert_eq!(scans.len(), 1, "{bad}");
    }
    let (_, _, fault) = read("");
    assert!(fault.unwrap().starts_with("no scan in the log: found nothing at all, expected sweeps"));
    let (_, _, fault) = read("hello world\n");
    assert!(fault.unwrap().starts_with("no scan in the log: found 1 hello, expected sweeps"));
}

#[test]
fn what_some_converters_write_for_no_return_is_none() {
    let (scans, _, fault) =
        read("FLASER 5 1 nan inf -inf 0.0 0 0 0 0 0 0 1 h 0\nFLASER 1 1 0 0 0 0 0 0 1 h 0\n");
    assert_eq!((scans[0].ranges.clone(), fault), (vec![Some(1.0), None, None, None, None], None));
}

#[test]
fn a_stream_that_breaks_off_keeps_what_came_before() {
    struct Broken;
    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::ErrorKind::UnexpectedEof.into())
        }
    }
    for (partial, line) in [("", None), ("FLASER 3 1.", Some(2))] {
        let text = format!("{FLASER}{partial}");
        let mut reader =
            carmen_scans(io::BufReader::new(text.as_bytes().chain(Broken)), LogOptions::default());
        let (scans, fault) = reader.read_all();
        assert!(fault.is_none() && scans.len() == 1, "{fault:?}");
        assert_eq!((reader.report().broken_off, reader.report().cut_off_line), (true, line));
    }
}

#[test]
fn bytes_behind_a_whole_stream_are_no_early_end() {
    struct Trail;
    impl Read for Trail {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other(TrailingBytes))
        }
    }
    for (text, line) in [(FLASER.to_owned(), None), (format!("{FLASER}FLASER 3 1."), Some(2))] {
        let input = io::BufReader::new(text.as_bytes().chain(Trail));
        let mut reader = carmen_scans(input, LogOptions::default());
        let (scans, fault) = reader.read_all();
        let report = reader.report();
        assert!(fault.is_none() && scans.len() == 1, "{fault:?}");
        assert_eq!((report.broken_off, report.cut_off_line, report.remarks.len()), (false, line, 1));
        assert!(report.remarks[0].starts_with("bytes behind the end of the compressed file"));
    }
}

fn messages() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        4 => (-3.0..90.0f64).prop_map(|x| format!("{x:.2}")),
        2 => (0usize..6).prop_map(|n| n.to_string()),
        1 => "[a-z#\\PC]{0,3}",
        1 => Just("nan".to_owned()),
        1 => Just("1e400".to_owned()),
        1 => Just("18446744073709551615".to_owned()),
    ];
    let kind = prop_oneof![
        Just("FLASER"),
        Just("RLASER"),
        Just("ROBOTLASER1"),
        Just("ROBOTLASER2"),
        Just("RAWLASER1"),
        Just("RAWLASER9"),
        Just("ODOM"),
        Just("TRUEPOS"),
        Just("PARAM"),
        Just("PARAM robot_rearlaser_offset"),
        Just("PARAM robot_front_laser_max"),
        Just(""),
    ];
    (kind, prop::collection::vec(word, 0..24))
        .prop_map(|(kind, words)| format!("{kind} {}\n", words.join(" ")))
}

proptest! {
    #[test]
    fn whatever_lines_are_in_a_log_nothing_good_is_lost(lines in prop::collection::vec(messages(), 0..40)) {
        let (before, _, fault) = read(lines.concat());
        let good = fault
            .and_then(|fault| fault.strip_prefix("line ")?.split(':').next()?.parse::<usize>().ok())
            .map_or(lines.len(), |line| line - 1);
        let (scans, ..) = read(lines[..good].concat());
        prop_assert_eq!(&before, &scans);
        for scan in &scans {
            prop_assert!(scan.ranges.len() >= 2 && scan.stamp.is_finite());
            prop_assert!(scan.odom_from_robot.is_finite() && scan.robot_from_laser.is_finite());
            prop_assert!(scan.start_angle.is_finite() && scan.angle_increment.is_finite());
            prop_assert!(scan.ranges.iter().flatten().all(|range| range.is_finite() && *range > 0.0));
        }
    }

    #[test]
    fn bytes_changed_and_ends_cut_off_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let robot = "ROBOTLASER2 0 -1.5 3.1 1.5 80.0 0.01 0 3 1.0 79.5 0.0 1 8 1 2 0 1 2 0 1 2 3 4 5 9.5 host 0.21\n";
        let raw = "RAWLASER3 0 -1.5 3.0 1.5 20 0.01 0 3 1 2 3 0 1.5 host 1\n";
        let odom = "ODOM 1 0 0 0 0 0 1.0 host 1\nODOM 1 0 0 0 0 0 2.0 host 1\n";
        let mut text = [FLASER, robot, odom, raw, FLASER].concat().into_bytes();
        for (at, byte) in changes {
            let at = at.index(text.len());
            text[at] = byte;
        }
        text.truncate(cut.index(text.len() + 1));
        let (scans, report, _) = read(&text);
        prop_assert_eq!(scans.len() as u64, report.scans());
        prop_assert!(!report.to_string().is_empty());
    }
}
