//! Recorded logs: all that is in them is read, by streaming as well as by reading twice.

use crate::data;
use bzip2::read::MultiBzDecoder;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use topostar::geometry::Pose;
use topostar::sensor::LaserScan;
use topostar::sensor::log::{
    CarmenEntries, Content, LogOptions, LogReport, MountSource, NoReturnSource, ScanReader, carmen_scans,
};

fn open(name: &str) -> BufReader<MultiBzDecoder<File>> {
    BufReader::new(MultiBzDecoder::new(File::open(data(&format!("logs/{name}.clf.bz2"))).unwrap()))
}

fn read(name: &str, options: LogOptions) -> (Vec<LaserScan>, LogReport) {
    let mut reader = carmen_scans(open(name), options);
    let (scans, fault) = reader.read_all();
    assert!(fault.is_none(), "{fault:?}");
    println!("{name}: {}", reader.report());
    (scans, reader.report())
}

pub(crate) fn scans(name: &str) -> Vec<LaserScan> {
    read(name, LogOptions::default()).0
}

/// Reads the front laser's messages with the whole log in memory: no return is 0.99 of the largest value.
fn read_twice(name: &str) -> Vec<(f64, Pose, Vec<Option<f64>>)> {
    let mut sweeps = Vec::new();
    for line in open(name).lines().map(Result::unwrap).filter(|line| line.starts_with("FLASER ")) {
        let words: Vec<&str> = line.split(' ').skip(1).collect();
        let n: usize = words[0].parse().unwrap();
        let numbers: Vec<f64> = words[1..n + 8].iter().map(|word| word.parse().unwrap()).collect();
        let robot = Pose::new(numbers[n + 3], numbers[n + 4], numbers[n + 5]);
        sweeps.push((numbers[n + 6], robot, numbers[..n].to_vec()));
    }
    let largest = sweeps.iter().flat_map(|(.., ranges)| ranges).copied().fold(0.0, f64::max);
    let returned = |range: f64| (range > 0.0 && range < 0.99 * largest).then_some(range);
    let marked = |ranges: Vec<f64>| ranges.into_iter().map(returned).collect();
    sweeps.into_iter().map(|(stamp, robot, ranges)| (stamp, robot, marked(ranges))).collect()
}

#[test]
fn the_streamed_scans_are_those_of_reading_twice() {
    for (name, count, beams) in [("aces", 7374, 180), ("fr079", 4934, 360), ("mit-csail", 1988, 361)] {
        let (streamed, twice) = (scans(name), read_twice(name));
        assert_eq!((streamed.len(), twice.len()), (count, count), "{name}");
        for (k, (scan, (stamp, robot, ranges))) in streamed.iter().zip(&twice).enumerate() {
            assert_eq!((scan.stamp, scan.odom_from_robot), (*stamp, *robot), "{name} {k}");
            assert_eq!(&scan.ranges, ranges, "{name} {k}");
            assert_eq!(ranges.len(), beams, "{name} {k}");
        }
    }
}

/// A reading that the laser never gave, where it says that nothing came back.
#[test]
fn one_stray_reading_changes_no_other() {
    let all = scans("aces");
    for (at, stray) in [(0, 60.0), (40, 90.0), (3000, 60.0), (7000, 81.83)] {
        let mut left = Some(());
        let mut sweeps = 0;
        let entries = CarmenEntries::new(open("aces")).map(|entry| {
            let mut entry = entry?;
            if let Content::Sweep(sweep) = &mut entry.content {
                sweeps += 1;
                let silent = sweep.ranges.iter_mut().find(|range| sweeps > at && **range == 50.0);
                silent.filter(|_| left.take().is_some()).into_iter().for_each(|range| *range = stray);
            }
            Ok(entry)
        });
        let mut reader = ScanReader::new(entries, LogOptions::default());
        let (scans, fault) = reader.read_all();
        assert!(fault.is_none() && scans == all, "{at} {stray}: {}", reader.report());
    }
}

#[test]
fn the_reports_say_what_is_known_of_these_logs() {
    let front = |report: &LogReport| *report.lasers.values().next().unwrap();
    let (_, aces) = read("aces", LogOptions::default());
    assert_eq!((aces.read["FLASER"], aces.read["ODOM"], aces.read["PARAM"]), (7374, 7375, 4));
    assert_eq!(front(&aces).no_return_source, NoReturnSource::Guess(50.0));
    assert_eq!((aces.cut_off_line, aces.broken_off, front(&aces).corrected), (None, false, false));
    let (_, fr079) = read("fr079", LogOptions::default());
    assert_eq!(front(&fr079).no_return_source, NoReturnSource::Parameter);
    assert_eq!(front(&fr079).mount_source, MountSource::Poses);
    let mount = front(&fr079).mount.unwrap();
    assert!((mount.x + 0.04).abs() < 1e-3 && mount.y.abs() < 1e-3 && mount.theta.abs() < 1e-3, "{mount:?}");
    let (_, csail) = read("mit-csail", LogOptions::default());
    assert_eq!(front(&csail).no_return_source, NoReturnSource::SickCodes);
    for (report, no_returns) in [(aces, 11_336), (fr079, 36_881), (csail, 23_711)] {
        assert_eq!(report.impossible_steps, 0, "{report}");
        assert_eq!(front(&report).no_returns, no_returns, "{report}");
    }
}

/// Sweeps without their poses, laid between the odometry of the same log, come out near where their poses had them:
/// those are the odometry of up to one entry before. One sweep lies in a gap of 3 s in which the robot turned by a
/// radian, and is given up.
#[test]
fn odometry_in_between_agrees_with_the_poses_of_the_messages() {
    let posed = scans("aces");
    let without_poses = CarmenEntries::new(open("aces")).map(|entry| {
        let mut entry = entry?;
        if let Content::Sweep(sweep) = &mut entry.content {
            sweep.poses = None;
        }
        Ok(entry)
    });
    let (raw, fault) = ScanReader::new(without_poses, LogOptions::default()).read_all();
    assert!(fault.is_none() && raw.len() + 1 == posed.len(), "{} {fault:?}", raw.len());
    let (mut apart, mut turned, count) = (0.0, 0.0, posed.len() as f64);
    let mut posed = posed.iter();
    for raw in &raw {
        let posed = posed.find(|posed| posed.stamp == raw.stamp && posed.ranges == raw.ranges).unwrap();
        let off = posed.odom_from_robot.inverse().compose(&raw.odom_from_robot);
        apart += off.x.hypot(off.y) / count;
        turned += off.theta.abs() / count;
    }
    println!("mean difference {apart} m, {turned} rad");
    assert!(apart < 0.04 && turned < 0.02, "{apart} {turned}");
}

#[test]
fn a_log_cut_anywhere_keeps_what_came_before() {
    let whole = fs::read(data("logs/mit-csail.clf.bz2")).unwrap();
    let all = scans("mit-csail");
    let mut counts = Vec::new();
    for tenth in 1..10 {
        let part = &whole[..whole.len() * tenth / 10];
        let mut reader = carmen_scans(BufReader::new(MultiBzDecoder::new(part)), LogOptions::default());
        let (scans, fault) = reader.read_all();
        assert!(fault.is_none() || scans.is_empty(), "{tenth}: {fault:?}");
        assert!(reader.report().broken_off, "{tenth}");
        assert_eq!(scans, all[..scans.len()], "{tenth}");
        counts.push(scans.len());
    }
    assert!(counts.is_sorted() && counts[8] > 1000, "{counts:?}");
}
