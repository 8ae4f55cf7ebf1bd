//! Entries of any log to scans at the robot's odometry.

use crate::geometry::Pose;
use crate::sensor::LaserScan;
use crate::sensor::log::entry::{Content, Entry, LaserNumber, Sweep};
use crate::sensor::log::laser::Laser;
use crate::sensor::log::odometry::Odometry;
use crate::sensor::log::report::LogReport;
use crate::sensor::log::steps::Step;
use crate::sensor::log::{LARGEST, LogError};
use std::collections::{BTreeMap, VecDeque};

/// A sweep is decided on when so many later ones have been seen.
const LOOK_AHEAD: usize = 64;

/// What a user may know better than a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogOptions {
    /// Ranges from here on mean that nothing came back, metres.
    pub max_range: Option<f64>,
    /// Angle of the first beam in the laser's frame, radians.
    pub start_angle: Option<f64>,
    /// Which of the two poses of a CARMEN message is that of the robot.
    pub pose: PoseChoice,
    /// Pose of the laser on the robot.
    pub mount: Option<Pose>,
    /// The topic of laser scans in a bag.
    pub scan_topic: Option<String>,
    /// The topic of odometry in a bag.
    pub odom_topic: Option<String>,
}

/// Which pose of a message with two poses the scans are laid at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PoseChoice {
    /// The second one, the robot's by its odometry.
    #[default]
    Robot,
    /// The first one, the laser's: odometry too in a log as recorded, but the outcome of mapping in a corrected one.
    Laser,
}

/// The scans of a log in file order, and a report of what it was made of.
///
/// A sweep waits until the next 64 have been read, so that its no-return value and the odometry after it
/// are known. Raw sweeps without a pose are laid between the odometry entries around their stamp, and
/// given up where there are none. Raw sweeps of a laser that also has sweeps with poses are the same sweeps, and passed
/// over. After an error nothing more comes; what came before it has all been given. A log without any scan ends
/// in [`LogError::NoScans`].
#[derive(Debug)]
pub struct ScanReader<E> {
    entries: E,
    options: LogOptions,
    waiting: VecDeque<Sweep>,
    odometry: Odometry,
    lasers: BTreeMap<LaserNumber, Laser>,
    report: LogReport,
    ended: bool,
    fault: Option<LogError>,
    /// Number, stamp and pose of the last scan given.
    last: Option<(u64, f64, Pose)>,
    given: bool,
}

impl<E: Iterator<Item = Result<Entry, LogError>>> ScanReader<E> {
    /// Over the entries of a log.
    pub fn new(entries: E, options: LogOptions) -> Self {
        ScanReader {
            entries,
            options,
            waiting: VecDeque::new(),
            odometry: Odometry::default(),
            lasers: BTreeMap::new(),
            report: LogReport::default(),
            ended: false,
            fault: None,
            last: None,
            given: false,
        }
    }

    /// What was read up to now.
    pub fn report(&self) -> LogReport {
        let lasers = self.lasers.iter().filter(|(_, laser)| laser.report.sweeps > 0);
        LogReport {
            lasers: lasers.map(|(number, laser)| (*number, laser.report)).collect(),
            ..self.report.clone()
        }
    }

    /// All scans, or those before the first fault with it.
    pub fn read_all(&mut self) -> (Vec<LaserScan>, Option<LogError>) {
        let mut scans = Vec::new();
        for scan in self {
            match scan {
                Ok(scan) => scans.push(scan),
                Err(fault) => return (scans, Some(fault)),
            }
        }
        (scans, None)
    }

    fn read_entry(&mut self) {
        match self.entries.next() {
            Some(Ok(entry)) => self.take(entry),
            Some(Err(fault)) => (self.ended, self.fault) = (true, Some(fault)),
            None => self.ended = true,
        }
    }

    fn take(&mut self, Entry { kind, content }: Entry) {
        match content {
            Content::Other => return self.report.pass_over(&kind),
            Content::CutOff(how) => return self.report.break_off(how),
            Content::Remark(remark) => return self.report.remark(remark),
            Content::Odometry { stamp: Some(stamp), odom_from_robot } => {
                self.odometry.add(stamp, odom_from_robot);
            }
            Content::Odometry { stamp: None, .. } | Content::Truth { .. } | Content::Known => {}
            Content::Parameter { name, value } => self.hear(&name, &value),
            Content::Sweep(sweep) => self.enqueue(&kind, sweep),
        }
        self.report.count(&kind);
    }

    fn hear(&mut self, name: &str, value: &str) {
        let Some(number) = value.parse().ok().filter(|number: &f64| number.abs() < LARGEST) else { return };
        let rear = name.contains("rear");
        self.laser(if rear { LaserNumber::REAR } else { LaserNumber::FRONT }).hear(name, number);
    }

    fn laser(&mut self, number: LaserNumber) -> &mut Laser {
        let options = &self.options;
        self.lasers.entry(number).or_insert_with(|| Laser::new(options))
    }

    fn enqueue(&mut self, kind: &str, mut sweep: Sweep) {
        let number = sweep.laser;
        let laser = self.laser(number);
        let first_with_poses = sweep.poses.is_some() && !laser.has_poses();
        if !laser.accepts(kind, &mut sweep) {
            return;
        }
        if first_with_poses {
            let before = self.waiting.len();
            self.waiting.retain(|waiting| waiting.laser != number);
            let repeated = before - self.waiting.len();
            self.laser(number).report.repeated += repeated as u64;
        }
        self.waiting.push_back(sweep);
    }

    /// The next scan of those that wait, if its place is known.
    fn finish(&mut self, sweep: Sweep) -> Option<LaserScan> {
        let between = sweep.stamp.and_then(|stamp| self.odometry.at(stamp));
        let options = self.options.clone();
        let scan = self.laser(sweep.laser).scan(sweep, between, &options)?;
        self.report.first_stamp.get_or_insert(scan.stamp);
        self.report.last_stamp = Some(scan.stamp);
        self.watch_step(&scan);
        self.given = true;
        Some(scan)
    }

    fn watch_step(&mut self, scan: &LaserScan) {
        let number = self.last.map_or(0, |(number, ..)| number + 1);
        let last = self.last.replace((number, scan.stamp, scan.odom_from_robot));
        let Some((_, stamp, pose)) = last else { return };
        let metres = (scan.odom_from_robot.position() - pose.position()).norm();
        let step = Step { scan: number, metres, seconds: scan.stamp - stamp };
        if step.is_impossible(self.laser(scan.laser).report.unstamped == 0) {
            self.report.impossible_step(step);
        }
    }

    /// What is said after the last scan, once.
    fn last_word(&mut self) -> Option<LogError> {
        let empty = !std::mem::replace(&mut self.given, true);
        let fault = self.fault.take();
        fault.or_else(|| empty.then(|| LogError::NoScans(self.report().why_no_scans())))
    }
}

impl<E: Iterator<Item = Result<Entry, LogError>>> Iterator for ScanReader<E> {
    type Item = Result<LaserScan, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if !self.ended && self.waiting.len() <= LOOK_AHEAD {
                self.read_entry();
            } else if let Some(sweep) = self.waiting.pop_front() {
                if let Some(scan) = self.finish(sweep) {
                    return Some(Ok(scan));
                }
            } else {
                return self.last_word().map(Err);
            }
        }
    }
}
