//! Bags written here, by the encoding's rules alone, and read back.

use super::*;
use crate::geometry::{Point, Pose};
use crate::sensor::LaserScan;
use crate::sensor::log::{LogReport, MountSource};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use nalgebra::{Isometry3, Point3, UnitQuaternion};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::io::Cursor;

/// Writes fields as CDR in either byte order.
struct Out {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Out {
    fn new(big_endian: bool) -> Out {
        Out { bytes: vec![0, u8::from(!big_endian), 0, 0], big_endian }
    }

    fn put<const N: usize>(mut self, little: [u8; N]) -> Self {
        while !(self.bytes.len() - 4).is_multiple_of(N) {
            self.bytes.push(0xee);
        }
        let mut bytes = little;
        if self.big_endian {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
        self
    }

    fn u32(self, value: u32) -> Self {
        self.put(value.to_le_bytes())
    }

    fn f32(self, value: f64) -> Self {
        self.put((value as f32).to_le_bytes())
    }

    fn f64s(self, values: &[f64]) -> Self {
        values.iter().fold(self, |out, value| out.put(value.to_le_bytes()))
    }

    fn text(mut self, text: &str) -> Self {
        self = self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
        self
    }

    fn header(self, stamp: f64, frame: &str) -> Self {
        let nanoseconds = ((stamp - stamp.floor()) * 1e9).round() as u32;
        self.u32(stamp.floor() as i32 as u32).u32(nanoseconds).text(frame)
    }

    fn pose(self, pose: &Isometry3<f64>) -> Self {
        let (t, q) = (pose.translation, pose.rotation.coords);
        self.f64s(&[t.x, t.y, t.z, q.x, q.y, q.z, q.w])
    }
}

fn isometry(x: f64, y: f64, roll: f64, yaw: f64) -> Isometry3<f64> {
    Isometry3::from_parts([x, y, 0.3].into(), UnitQuaternion::from_euler_angles(roll, 0.0, yaw))
}

/// Start angle, increment and ranges; nearest 0.1 m, farthest 10 m.
fn scan(big: bool, stamp: f64, start: f64, step: f64, ranges: &[f64]) -> Vec<u8> {
    bounded_scan(big, stamp, (start, step), (0.1, 10.0), ranges)
}

fn bounded_scan(
    big: bool,
    stamp: f64,
    (start, step): (f64, f64),
    (nearest, farthest): (f64, f64),
    ranges: &[f64],
) -> Vec<u8> {
    let head = [start, start + step * ranges.len() as f64, step, 0.0, 0.1, nearest, farthest];
    let out = Out::new(big).header(stamp, "laser");
    let out = head.iter().fold(out, |out, value| out.f32(*value)).u32(ranges.len() as u32);
    ranges.iter().fold(out, |out, range| out.f32(*range)).u32(0).bytes
}

fn odometry(big: bool, stamp: f64, x: f64) -> Vec<u8> {
    let out = Out::new(big).header(stamp, "odom").text("base_link").pose(&isometry(x, 0.0, 0.0, 0.0));
    out.f64s(&[0.0; 36 + 6 + 36]).bytes
}

fn static_transforms(big: bool, transforms: &[(&str, &str, Isometry3<f64>)]) -> Vec<u8> {
    let out = Out::new(big).u32(transforms.len() as u32);
    let one = |out: Out, (parent, child, pose): &(&str, &str, Isometry3<f64>)| {
        out.header(0.0, parent).text(child).pose(pose)
    };
    transforms.iter().fold(out, one).bytes
}

type Sent<'a> = (&'a str, &'a str, Vec<u8>);

fn bag(compression: Option<Compression>, encoding: &str, messages: &[Sent]) -> Vec<u8> {
    let options = WriteOptions::new().profile("ros2").compression(compression).chunk_size(Some(512));
    let mut writer = Writer::with_options(Cursor::new(Vec::new()), options).unwrap();
    for (number, (topic, kind, data)) in messages.iter().enumerate() {
        let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
        let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
        let log_time = 5_000_000_000 + number as u64;
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// A drive along x at 1 m/s with a scan each tenth of a second; transforms at the end, as latched topics may be.
fn drive(big: bool) -> Vec<Sent<'static>> {
    let mut sent = Vec::new();
    for k in 0..40 {
        let t = 100.0 + f64::from(k) / 4.0;
        sent.push(("/odom", ODOMETRY, odometry(big, t, t - 100.0)));
        sent.push(("/scan", SCAN, scan(big, t + 0.1, -1.0, 0.5, &[1.0, 2.0, 3.0, f64::INFINITY, 0.05])));
        sent.push(("/chatter", "std_msgs/msg/String", Out::new(big).text("hello").bytes));
    }
    let transforms = [
        ("base_link", "mast", isometry(0.2, 0.1, 0.0, 0.0)),
        ("mast", "laser", isometry(0.1, 0.0, 0.0, PI / 2.0)),
    ];
    sent.push(("/tf_static", TRANSFORMS, static_transforms(big, &transforms)));
    sent
}

use super::message::{ODOMETRY, SCAN, TRANSFORMS};

fn read_files(files: &[Vec<u8>], options: LogOptions) -> Result<(Vec<LaserScan>, LogReport), String> {
    let open = || files.iter().map(|file| Ok(file.as_slice()));
    let survey = BagSurvey::read(open()).map_err(|error| error.to_string())?;
    let mut reader = bag_scans(open(), survey, options).map_err(|error| error.to_string())?;
    match reader.read_all() {
        (scans, None) => Ok((scans, reader.report())),
        (_, Some(error)) => Err(error.to_string()),
    }
}

fn read(file: Vec<u8>) -> Result<(Vec<LaserScan>, LogReport), String> {
    read_files(&[file], LogOptions::default())
}

fn near(a: &Pose, b: &Pose) -> bool {
    let off = a.inverse().compose(b);
    off.x.hypot(off.y) < 1e-6 && off.theta.abs() < 1e-6
}

#[test]
fn scans_lie_between_the_odometry_on_the_laser_of_the_static_transforms() {
    let mut all = Vec::new();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        for big in [false, true] {
            let (scans, report) = read(bag(compression, "cdr", &drive(big))).unwrap();
            // The last scan is later than the last odometry.
            assert_eq!(scans.len(), 39);
            for (k, scan) in scans.iter().enumerate() {
                assert!(
                    near(&scan.odom_from_robot, &Pose::new(k as f64 / 4.0 + 0.1, 0.0, 0.0)),
                    "{k}: {scan:?}"
                );
                assert!(near(&scan.robot_from_laser, &Pose::new(0.3, 0.1, PI / 2.0)));
                assert_eq!(scan.ranges, [Some(1.0), Some(2.0), Some(3.0), None, None]);
                assert_eq!((scan.start_angle, scan.angle_increment), (-1.0, 0.5));
            }
            let laser = report.lasers[&LaserNumber::FRONT];
            assert_eq!((laser.without_odometry, laser.mount_source), (1, MountSource::Transforms));
            assert_eq!((report.read["/odom"], report.passed_over["/chatter"]), (40, 40));
            assert_eq!(report.remarks, ["scans from /scan, odometry from /odom, which moves base_link"]);
            all.push(scans);
        }
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn a_bag_in_several_files_is_one() {
    let sent = drive(false);
    let whole = read(bag(None, "cdr", &sent)).unwrap().0;
    let files = [&sent[..50], &sent[50..]].map(|part| bag(None, "cdr", part));
    assert_eq!(read_files(&files, LogOptions::default()).unwrap().0, whole);
}

#[test]
fn topics_are_chosen_where_there_is_a_choice_only() {
    let mut sent = drive(false);
    sent.push(("/rear", SCAN, scan(false, 105.0, 0.0, 0.1, &[1.0, 1.0])));
    let options = |topic: &str| LogOptions { scan_topic: Some(topic.into()), ..LogOptions::default() };
    assert_eq!(read(bag(None, "cdr", &sent)).unwrap().0.len(), 39);
    assert_eq!(read_files(&[bag(None, "cdr", &sent)], options("/rear")).unwrap().0.len(), 1);
    let error = read_files(&[bag(None, "cdr", &sent)], options("/nowhere")).unwrap_err();
    assert_eq!(error, "/nowhere is no topic of type sensor_msgs/msg/LaserScan, expected /rear, /scan");
    let renamed: Vec<Sent> = sent
        .iter()
        .map(|(topic, kind, data)| (if *topic == "/scan" { "/front" } else { *topic }, *kind, data.clone()))
        .collect();
    let error = read(bag(None, "cdr", &renamed)).unwrap_err();
    assert!(error.ends_with("choose by --scan-topic: /front, /rear"), "{error}");
    let without: Vec<Sent> = sent.into_iter().filter(|(topic, ..)| *topic != "/odom").collect();
    let error = read(bag(None, "cdr", &without)).unwrap_err();
    assert!(
        error.starts_with("the bag has no topic of type nav_msgs/msg/Odometry, it has /chatter"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_read_says_what_was_expected() {
    let mut sent = drive(false);
    let error = read(bag(None, "ros1", &sent)).unwrap_err();
    assert_eq!(error, "/scan is encoded as `ros1`, expected `cdr`, as ROS 2 writes it");
    sent[1].2[1] = 7;
    let error = read(bag(None, "cdr", &sent)).unwrap_err();
    assert!(
        error.starts_with("message 2 of the bag, on /scan, is encoded in XCDR2, expected plain CDR"),
        "{error}"
    );
    for file in [&b"no bag"[..], b"", &mcap::MAGIC[..7], b"not a bag at all"] {
        let error = read(file.to_vec()).unwrap_err();
        assert!(error.starts_with("is no MCAP file"), "{error}");
    }
}

#[test]
fn a_bag_without_the_topics_says_whether_it_is_whole() {
    let whole = bag(None, "cdr", &drive(false)[..1]);
    let error = |files: &[&[u8]]| {
        let files: Vec<Vec<u8>> = files.iter().map(|file| file.to_vec()).collect();
        read_files(&files, LogOptions::default()).unwrap_err()
    };
    let missing = "the bag has no topic of type sensor_msgs/msg/LaserScan, it has";
    assert_eq!(error(&[&whole]), format!("{missing} /odom (nav_msgs/msg/Odometry)"));
    let said = format!("{missing} /odom (nav_msgs/msg/Odometry), and breaks off there");
    assert_eq!(error(&[&whole[..whole.len() - 200]]), said);
    // The recorder had just begun its second file.
    for length in [0, 7, 8] {
        assert_eq!(error(&[&whole, &mcap::MAGIC[..length]]), said, "{length}");
    }
    let said = format!("{missing} /odom (nav_msgs/msg/Odometry), and is damaged there");
    assert_eq!(error(&[&whole, b"not a bag at all"]), said);
    assert_eq!(error(&[&whole, b"no bag"]), said);
    assert_eq!(error(&[mcap::MAGIC]), format!("{missing} no message at all, and breaks off there"));
}

#[test]
fn bounds_that_were_not_filled_in_discard_nothing() {
    let nan = f64::NAN;
    let ranges = [0.25, 1.0, 5.0, 12.0, f64::INFINITY];
    let with_bounds = |bounds: (f64, f64)| {
        let mut sent = drive(false);
        for (k, (_, _, data)) in sent.iter_mut().filter(|(topic, ..)| *topic == "/scan").enumerate() {
            // The farthest differ, so that none stands out.
            let ranges = ranges.map(|range| if range == 12.0 { range + k as f64 / 8.0 } else { range });
            *data = bounded_scan(false, 100.1 + k as f64 / 4.0, (-1.0, 0.5), bounds, &ranges);
        }
        read(bag(None, "cdr", &sent)).unwrap()
    };
    for (bounds, from, to) in [
        ((0.1, 10.0), 0, 3),
        ((0.1, 0.0), 0, 4),
        ((0.0, 0.0), 0, 4),
        ((0.5, nan), 1, 4),
        ((0.5, 0.4), 1, 4),
        ((nan, 10.0), 0, 3),
        ((nan, nan), 0, 4),
        ((f64::INFINITY, 10.0), 0, 3),
        ((0.5, f64::INFINITY), 1, 4),
    ] {
        let (scans, report) = with_bounds(bounds);
        let valid = |k: usize| (from..to).contains(&k).then(|| ranges[k]);
        assert_eq!(scans[0].ranges, [0, 1, 2, 3, 4].map(valid), "{bounds:?}");
        let told = report.remarks.iter().any(|remark| {
            remark.starts_with("from message 2 on, /scan has range_min") && remark.contains("--max-range")
        });
        let filled = bounds.0 < bounds.1 && bounds.0.is_finite();
        assert_eq!((told, report.remarks.len()), (!filled, 2 - usize::from(filled)), "{bounds:?}");
    }
}

#[test]
fn angles_of_no_laser_are_refused_unless_the_user_knows_them() {
    let refused = |start: f64, step: f64, options: LogOptions| {
        let mut sent = drive(false);
        sent[1].2 = scan(false, 100.1, start, step, &[1.0; 5]);
        read_files(&[bag(None, "cdr", &sent)], options).err().unwrap_or_default()
    };
    for step in [1e30, 1e38, 1e-30, -1e30, 0.0, f64::NAN] {
        let error = refused(-1.0, step, LogOptions::default());
        assert!(error.starts_with("message 2 of the bag, on /scan, has 5 beams in steps of"), "{error}");
    }
    for start in [1e38, f64::NAN, f64::INFINITY] {
        let error = refused(start, 0.5, LogOptions::default());
        assert!(error.contains("has a first beam at") && error.contains("--start-angle"), "{error}");
        let told = LogOptions { start_angle: Some(-1.0), ..LogOptions::default() };
        assert_eq!(refused(start, 0.5, told), "");
    }
}

#[test]
fn a_laser_without_transforms_needs_to_be_told_where_it_sits() {
    let mut sent = drive(false);
    sent.pop();
    let error = read(bag(None, "cdr", &sent)).unwrap_err();
    assert!(error.contains("no chain of static transforms leads from base_link to laser"), "{error}");
    let mount = Pose::new(0.4, 0.0, 0.0);
    let options = LogOptions { mount: Some(mount), ..LogOptions::default() };
    let (scans, _) = read_files(&[bag(None, "cdr", &sent)], options).unwrap();
    assert!(scans.iter().all(|scan| scan.robot_from_laser == mount));
}

#[test]
fn a_bag_that_breaks_off_keeps_what_came_before() {
    let mut sent = drive(false);
    sent.rotate_right(1);
    let whole = bag(None, "cdr", &sent);
    let all = read(whole.clone()).unwrap().0;
    let mut most = 0;
    for end in (0..whole.len()).step_by(97) {
        if let Ok((scans, report)) = read(whole[..end].to_vec()) {
            assert!(report.broken_off && scans == all[..scans.len()], "{end}");
            most = most.max(scans.len());
        }
    }
    assert_eq!(most, all.len());
}

#[test]
fn what_comes_before_a_damage_is_read() {
    let mut sent = drive(false);
    sent.rotate_right(1);
    let whole = bag(None, "cdr", &sent);
    let scans = |file: &[u8]| {
        let open = || [Ok(file)].into_iter();
        let survey = BagSurvey::read(open()).ok()?;
        Some(bag_scans(open(), survey, LogOptions::default()).ok()?.read_all().0)
    };
    let mut most = 0;
    for end in (0..whole.len()).step_by(89) {
        let mut damaged = whole.clone();
        damaged[end..].fill(0xff);
        let Some(kept) = scans(&whole[..end]) else { continue };
        let read = scans(&damaged).unwrap();
        // The message in which the damage begins may be read, with wrong values.
        assert!(read.len() >= kept.len() && read[..kept.len()] == kept, "{end}");
        most = most.max(read.len());
    }
    assert!(most > 30);
}

/// The points that the beams reach, by the transforms in space.
fn points_in_space(mount: &Isometry3<f64>, start: f64, step: f64, ranges: &[f64]) -> Vec<Point> {
    let point = |(k, range): (usize, &f64)| {
        let angle = start + step * k as f64;
        let hit = mount * Point3::new(range * angle.cos(), range * angle.sin(), 0.0);
        Point::new(hit.x, hit.y)
    };
    ranges.iter().enumerate().map(point).collect()
}

proptest! {
    #[test]
    fn a_laser_may_hang_and_turn_either_way(
        hanging in any::<bool>(),
        yaw in -3.0..3.0f64,
        (x, y) in (-1.0..1.0f64, -1.0..1.0f64),
        start in -3.0..3.0f64,
        step in prop_oneof![-0.1..-0.01f64, 0.01..0.1f64],
        ranges in prop::collection::vec(0.2..9.0f64, 2..20),
    ) {
        let mount = isometry(x, y, if hanging { PI } else { 0.0 }, yaw);
        let sent = [
            ("/tf_static", TRANSFORMS, static_transforms(false, &[("base_link", "laser", mount)])),
            ("/odom", ODOMETRY, odometry(false, 1.0, 0.0)),
            ("/scan", SCAN, scan(false, 1.5, start, step, &ranges)),
            ("/odom", ODOMETRY, odometry(false, 2.0, 0.0)),
        ];
        let (scans, _) = read(bag(None, "cdr", &sent)).unwrap();
        prop_assert!(scans[0].angle_increment > 0.0);
        let expected = points_in_space(&mount, start, step, &ranges);
        let mut found: Vec<Point> = scans[0].hits().collect();
        if (step < 0.0) != hanging {
            found.reverse();
        }
        prop_assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(&expected) {
            prop_assert!((a - b).norm() < 1e-4, "{} {}", a, b);
        }
    }

    #[test]
    fn bytes_changed_anywhere_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        compression in prop_oneof![Just(None), Just(Some(Compression::Lz4)), Just(Some(Compression::Zstd))],
    ) {
        let mut file = bag(compression, "cdr", &drive(false)[..12]);
        for (at, byte) in changes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        if let Ok((scans, _)) = read(file) {
            prop_assert!(scans.iter().all(|scan| scan.odom_from_robot.is_finite()));
        }
    }

    #[test]
    fn messages_changed_anywhere_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        which in 0..3usize,
        cut in any::<prop::sample::Index>(),
    ) {
        let mut message = drive(false).swap_remove([0, 1, 120][which]).2;
        for (at, byte) in changes {
            let at = at.index(message.len());
            message[at] = byte;
        }
        message.truncate(cut.index(message.len() + 1));
        let _ = ScanMessage::decode(&message);
        let _ = OdometryMessage::decode(&message);
        let _ = message::transforms(&message);
    }
}
