//! What a log was made of: read, passed over, guessed.

use crate::geometry::Pose;
use crate::sensor::log::entry::{CutOff, LaserNumber};
use crate::sensor::log::no_return::NoReturnSource;
use crate::sensor::log::steps::Step;
use std::collections::BTreeMap;
use std::fmt;

/// The most kinds of entries that are told apart, and the most remarks that are kept.
const MAX_KINDS: usize = 64;
const MAX_REMARKS: usize = 16;

/// What was read, passed over and guessed. Prints itself in a few lines for people.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogReport {
    /// Entries read, by kind.
    pub read: BTreeMap<String, u64>,
    /// Entries passed over, by kind.
    pub passed_over: BTreeMap<String, u64>,
    /// The lasers that had entries.
    pub lasers: BTreeMap<LaserNumber, LaserReport>,
    /// Stamp of the first scan, seconds.
    pub first_stamp: Option<f64>,
    /// Stamp of the last scan, seconds.
    pub last_stamp: Option<f64>,
    /// The number of the last line, if it was cut off.
    pub cut_off_line: Option<u64>,
    /// Whether the compressed stream or the bag broke off before its end.
    pub broken_off: bool,
    /// Steps between scans that no robot makes: more than 2 m in less than a second, or more than half a metre at more
    /// than 5 m/s by the stamps.
    pub impossible_steps: u64,
    /// The first of them.
    pub first_impossible_step: Option<Step>,
    /// What else is to be said, a sentence each.
    pub remarks: Vec<String>,
}

/// What was made of one laser's entries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaserReport {
    /// Entries of this laser.
    pub sweeps: u64,
    /// Scans made of them.
    pub scans: u64,
    /// The least and the most beams of a scan.
    pub beams: (usize, usize),
    /// Readings of all scans.
    pub readings: u64,
    /// Those of them that did not return.
    pub no_returns: u64,
    /// The least range that means no return, metres, at the last scan.
    pub no_return_from: Option<f64>,
    /// How that is known.
    pub no_return_source: NoReturnSource,
    /// Angles of the last scan.
    pub geometry: Geometry,
    /// Pose of the laser on the robot at the last scan.
    pub mount: Option<Pose>,
    /// How that is known.
    pub mount_source: MountSource,
    /// Whether the first pose of its messages is not odometry.
    pub corrected: bool,
    /// Entries with fewer than two beams, passed over.
    pub empty: u64,
    /// Entries of sweeps that the log also has in another form, passed over.
    pub repeated: u64,
    /// Entries without a pose that no odometry encloses, passed over.
    pub without_odometry: u64,
    /// Entries without a stamp, which have that of the entry before.
    pub unstamped: u64,
    /// Entries with the stamp of the entry before.
    pub same_stamp: u64,
    /// Entries with an earlier stamp than the entry before.
    pub backwards: u64,
}

/// The angles of a laser's beams.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Angle of the first beam, radians.
    pub start_angle: f64,
    /// Angle between beams, radians.
    pub angle_increment: f64,
    /// How they are known.
    pub source: GeometrySource,
}

/// How the angles of beams are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GeometrySource {
    /// From the message.
    Message,
    /// From parameters in the log.
    Parameters,
    /// Guessed from the number of readings.
    #[default]
    NumberOfReadings,
}

/// How the pose of a laser on its robot is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MountSource {
    /// By an option of the reader.
    Option,
    /// From the bag's static transforms.
    Transforms,
    /// From the two poses of each message.
    Poses,
    /// From parameters in the log.
    Parameters,
    /// From the first scan of a corrected log.
    FirstScan,
    /// Assumed: in the middle of the robot, the front laser looking ahead and the rear one back.
    #[default]
    Assumed,
}

impl LogReport {
    pub(super) fn count(&mut self, kind: &str) {
        count(&mut self.read, kind);
    }

    pub(super) fn pass_over(&mut self, kind: &str) {
        count(&mut self.passed_over, kind);
    }

    pub(super) fn break_off(&mut self, how: CutOff) {
        match how {
            CutOff::Line(line) => self.cut_off_line = Some(line),
            CutOff::Stream => self.broken_off = true,
        }
    }

    pub(super) fn remark(&mut self, remark: String) {
        if self.remarks.len() < MAX_REMARKS {
            self.remarks.push(remark);
        }
    }

    pub(super) fn impossible_step(&mut self, step: Step) {
        self.impossible_steps += 1;
        self.first_impossible_step.get_or_insert(step);
    }

    /// All scans made.
    pub fn scans(&self) -> u64 {
        self.lasers.values().map(|laser| laser.scans).sum()
    }

    /// What the log has instead of scans, and what would help.
    pub(super) fn why_no_scans(&self) -> String {
        let lost: u64 = self.lasers.values().map(|laser| laser.without_odometry).sum();
        if lost > 0 {
            return format!(
                "{lost} sweeps have no pose of their own, and no odometry encloses their stamps, expected odometry \
                 with stamps of the same clock"
            );
        }
        let empty: u64 = self.lasers.values().map(|laser| laser.empty).sum();
        if empty > 0 {
            return format!("{empty} sweeps have fewer than two beams, expected some with more");
        }
        let kinds: Vec<String> = self.read.iter().chain(&self.passed_over).map(counted).collect();
        let found = if kinds.is_empty() { "nothing at all".into() } else { kinds.join(", ") };
        let broken = if self.broken_off { ", and breaks off there" } else { "" };
        format!(
            "found {found}{broken}, expected sweeps of a laser: FLASER, RLASER, ROBOTLASER or RAWLASER, or \
             sensor_msgs/msg/LaserScan in a bag"
        )
    }
}

fn count(kinds: &mut BTreeMap<String, u64>, kind: &str) {
    let room = kinds.len() < MAX_KINDS || kinds.contains_key(kind);
    let kind = if room { kind } else { "others" };
    match kinds.get_mut(kind) {
        Some(count) => *count += 1,
        None => _ = kinds.insert(kind.to_owned(), 1),
    }
}

fn counted((kind, count): (&String, &u64)) -> String {
    format!("{count} {kind}")
}

impl fmt::Display for LogReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} scans", self.scans())?;
        if let (Some(first), Some(last)) = (self.first_stamp, self.last_stamp) {
            write!(f, " in {:.1} s", last - first)?;
        }
        for (verb, kinds) in [("read", &self.read), ("passed over", &self.passed_over)] {
            if !kinds.is_empty() {
                write!(f, "; {verb} {}", kinds.iter().map(counted).collect::<Vec<_>>().join(", "))?;
            }
        }
        for (number, laser) in &self.lasers {
            laser.describe(f, *number)?;
        }
        if let Some(Step { scan, metres, seconds }) = self.first_impossible_step {
            write!(
                f,
                "\n  {} steps between scans are more than a robot makes; the first, to scan {scan} (from \
                 0), is {metres:.2} m in {seconds:.3} s",
                self.impossible_steps
            )?;
        }
        if let Some(line) = self.cut_off_line {
            write!(f, "\n  line {line}, the last one, is cut off and left out")?;
        }
        if self.broken_off {
            write!(f, "\n  the file breaks off before its end; what had come by then was taken")?;
        }
        self.remarks.iter().try_for_each(|remark| write!(f, "\n  {remark}"))
    }
}

impl LaserReport {
    fn describe(&self, f: &mut fmt::Formatter<'_>, number: LaserNumber) -> fmt::Result {
        let (fewest, most) = self.beams;
        let beams = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
        write!(f, "\n  {number}: {} scans of {beams} beams", self.scans)?;
        if self.scans > 0 {
            let Geometry { start_angle, angle_increment, source } = self.geometry;
            let how = match source {
                GeometrySource::Message => "by the messages",
                GeometrySource::Parameters => "by the log's parameters",
                GeometrySource::NumberOfReadings => "guessed from their number",
            };
            let (start, step) = (start_angle.to_degrees(), angle_increment.to_degrees());
            write!(f, ", from {start:.2} degrees in steps of {step:.3} ({how})")?;
            let how = match self.mount_source {
                MountSource::Option => "as asked for",
                MountSource::Transforms => "by the static transforms",
                MountSource::Poses => "by the poses of the messages",
                MountSource::Parameters => "by the log's parameters",
                MountSource::FirstScan => "by the first scan",
                MountSource::Assumed => "assumed",
            };
            let Pose { x, y, theta } = self.mount.unwrap_or(Pose::IDENTITY);
            write!(
                f,
                "\n    on the robot at x {x:.3} m, y {y:.3} m, {:.2} degrees ({how})",
                theta.to_degrees()
            )?;
            write!(
                f,
                "\n    {} of {} readings did not return: {}",
                self.no_returns,
                self.readings,
                self.limit()
            )?;
        }
        if self.corrected {
            write!(
                f,
                "\n    looks like a corrected log: its two poses do not move together; the odometry is taken, \
                 --pose laser takes the corrected one"
            )?;
        }
        for (count, what) in [
            (self.without_odometry, "passed over, as no odometry encloses their stamps"),
            (self.repeated, "passed over, as the log has them in another form too"),
            (self.empty, "passed over, with fewer than two beams"),
            (self.unstamped, "without a stamp, which get the one before"),
            (self.same_stamp, "with the stamp of the one before"),
            (self.backwards, "with an earlier stamp than the one before; the order of the file is kept"),
        ] {
            if count > 0 {
                write!(f, "\n    {count} {what}")?;
            }
        }
        Ok(())
    }

    fn limit(&self) -> String {
        let from = self.no_return_from.unwrap_or_default();
        match self.no_return_source {
            NoReturnSource::Option => format!("{from} m and more, as asked for"),
            NoReturnSource::Parameter => format!("{from:.2} m and more, by the log's parameters"),
            NoReturnSource::Message => format!("{from:.2} m and more, by the messages"),
            NoReturnSource::SickCodes => format!("{from:.2} m and more, the codes of SICK lasers"),
            NoReturnSource::Guess(value) => {
                format!("{from:.2} m and more, guessed, as {value} m stands out (--max-range)")
            }
            NoReturnSource::Unknown => "no range stands out as a sign for that (--max-range)".into(),
        }
    }
}
