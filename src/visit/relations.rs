//! How far poses are off, beside relative poses that somebody has checked.

use crate::geometry::{Pose, wrap_angle};
use crate::sensor::LaserScan;
use crate::visit::Moment;
use std::collections::BTreeMap;
use thiserror::Error;

/// A relation between moments so many seconds apart closes a loop: the robot has come by again.
pub const LOOP: f64 = 30.0;

/// Where the robot was at one moment, seen from where it was at another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// The stamps of the two moments, seconds.
    pub stamps: [f64; 2],
    /// The pose at the second in the frame of the robot at the first.
    pub displacement: Pose,
}

/// A malformed list of relations.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {message}")]
pub struct RelationsFileError {
    /// Line number, from 1.
    pub line: usize,
    /// What was found and expected.
    pub message: String,
}

impl Relation {
    /// Reads lines of `t1 t2 x y z roll pitch yaw`, metres and radians (Kümmerle et al. 2009, "On measuring the accuracy
    /// of SLAM algorithms"). What is not planar is left out; so are empty lines and those that start with #.
    pub fn read(text: &str) -> Result<Vec<Relation>, RelationsFileError> {
        let lines = text.lines().enumerate();
        let lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let relation = |(line, text): (usize, &str)| {
            let wrong = |message: String| RelationsFileError { line: line + 1, message };
            let numbers: Result<Vec<f64>, String> = text
                .split_whitespace()
                .map(|word| match word.parse::<f64>() {
                    Ok(number) if number.is_finite() => Ok(number),
                    _ => Err(format!("has `{word}`, expected a number")),
                })
                .collect();
            match numbers.map_err(wrong)?[..] {
                [from, to, x, y, _, _, _, yaw] => {
                    Ok(Relation { stamps: [from, to], displacement: Pose::new(x, y, yaw) })
                }
                ref found => Err(wrong(format!(
                    "has {} numbers, expected 8: two stamps, x, y, z, roll, pitch, yaw",
                    found.len()
                ))),
            }
        };
        lines.map(relation).collect()
    }
}

/// Where the robot was at every scan, by its odometry and by scan matching.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    steps: Vec<Step>,
    /// The scan of each stamp, the first of equals.
    at: BTreeMap<i64, usize>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    odometry: Pose,
    matched: Pose,
    driven: f64,
}

/// Which relations are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// All of them.
    All,
    /// Those that close a loop, by time.
    Loops,
    /// Those between moments that one window holds, by metres driven: what local poses are for.
    Within,
    /// The others: there the robot has forgotten what it saw, and means to.
    Beyond,
}

/// How far poses are off, beside relations.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseErrors {
    /// Relations at stamps that no scan has.
    pub unknown: usize,
    /// Errors of the others.
    pub rows: Vec<(Reach, Compared)>,
}

/// The errors of some relations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// How many they are.
    pub relations: usize,
    /// Of odometry: translation in metres, rotation in radians.
    pub odometry: [Spread; 2],
    /// Of the poses of scan matching.
    pub matched: [Spread; 2],
}

/// How large errors are; 0 where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Their mean.
    pub mean: f64,
    /// The middle one.
    pub median: f64,
    /// The largest.
    pub max: f64,
}

impl Track {
    /// Adds the next scan and the moment it was taken at.
    pub fn add(&mut self, scan: &LaserScan, moment: &Moment) {
        self.at.entry(micros(scan.stamp)).or_insert(self.steps.len());
        self.steps.push(Step {
            odometry: scan.odom_from_robot,
            matched: moment.local_from_robot,
            driven: moment.driven,
        });
    }

    /// The same way with other poses in place of those of scan matching, scan by scan; the scans beyond them are left
    /// out.
    #[must_use]
    pub fn relaid(&self, poses: impl IntoIterator<Item = Pose>) -> Track {
        let steps =
            self.steps.iter().zip(poses).map(|(step, matched)| Step { matched, ..*step }).collect::<Vec<_>>();
        let at =
            self.at.iter().filter(|(_, at)| **at < steps.len()).map(|(stamp, at)| (*stamp, *at)).collect();
        Track { steps, at }
    }

    /// How far the poses are off, where what was seen `memory` metres of driving ago is forgotten.
    pub fn compare(&self, relations: &[Relation], memory: f64) -> PoseErrors {
        let step = |stamp: f64| self.at.get(&micros(stamp)).map(|&at| &self.steps[at]);
        let known: Vec<Error> = relations
            .iter()
            .filter_map(|relation| {
                let [from, to] = relation.stamps.map(step);
                Some(Error::of(relation, from?, to?))
            })
            .collect();
        let row = |reach: Reach| {
            let counted: Vec<&Error> = known.iter().filter(|error| reach.counts(error, memory)).collect();
            let spreads = |errors: fn(&Error) -> [f64; 2]| {
                [0, 1].map(|part| Spread::of(counted.iter().map(|&error| errors(error)[part])))
            };
            let (odometry, matched) = (spreads(|error| error.odometry), spreads(|error| error.matched));
            (reach, Compared { relations: counted.len(), odometry, matched })
        };
        PoseErrors { unknown: relations.len() - known.len(), rows: Reach::ALL.map(row).to_vec() }
    }
}

impl Reach {
    const ALL: [Reach; 4] = [Reach::All, Reach::Loops, Reach::Within, Reach::Beyond];

    fn counts(self, error: &Error, memory: f64) -> bool {
        match self {
            Reach::All => true,
            Reach::Loops => error.seconds > LOOP,
            Reach::Within => error.driven < memory,
            Reach::Beyond => error.driven >= memory,
        }
    }
}

/// Stamps are the same where they are written with the same six decimals.
fn micros(stamp: f64) -> i64 {
    (stamp * 1e6).round() as i64
}

/// What is off in one relation: translation and rotation.
struct Error {
    seconds: f64,
    driven: f64,
    odometry: [f64; 2],
    matched: [f64; 2],
}

impl Error {
    fn of(relation: &Relation, from: &Step, to: &Step) -> Error {
        let off = |from: &Pose, to: &Pose| {
            let error = relation.displacement.inverse().compose(&from.inverse().compose(to));
            [error.x.hypot(error.y), wrap_angle(error.theta).abs()]
        };
        Error {
            seconds: (relation.stamps[1] - relation.stamps[0]).abs(),
            driven: (to.driven - from.driven).abs(),
            odometry: off(&from.odometry, &to.odometry),
            matched: off(&from.matched, &to.matched),
        }
    }
}

impl Spread {
    fn of(errors: impl Iterator<Item = f64>) -> Spread {
        let mut all: Vec<f64> = errors.collect();
        all.sort_by(f64::total_cmp);
        let (Some(&max), Some(&median)) = (all.last(), all.get(all.len() / 2)) else {
            return Spread::default();
        };
        Spread { mean: all.iter().sum::<f64>() / all.len() as f64, median, max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::log::LaserNumber;
    use nalgebra::Matrix3;
    use std::f64::consts::FRAC_PI_2;

    fn track(poses: &[(f64, Pose, Pose, f64)]) -> Track {
        let mut track = Track::default();
        for (scan, &(stamp, odom_from_robot, local_from_robot, driven)) in poses.iter().enumerate() {
            let laser = LaserScan {
                stamp,
                laser: LaserNumber::FRONT,
                odom_from_robot,
                robot_from_laser: Pose::IDENTITY,
                start_angle: 0.0,
                angle_increment: 0.1,
                ranges: Vec::new(),
            };
            track.add(&laser, &Moment { scan, local_from_robot, drift: Matrix3::zeros(), driven });
        }
        track
    }

    #[test]
    fn errors_are_those_of_the_displacement_in_the_frame_of_its_beginning() {
        let start = Pose::new(5.0, -3.0, FRAC_PI_2);
        let there = |forward: f64, turn: f64| start.compose(&Pose::new(forward, 0.0, turn));
        let track = track(&[(1.5, start, start, 0.0), (2.5, there(2.3, 0.2), there(2.0, 0.1), 2.0)]);
        let relation = Relation { stamps: [1.5, 2.5], displacement: Pose::new(2.0, 0.0, 0.1) };
        let found = track.compare(&[relation], 40.0);
        let (_, all) = found.rows[0];
        assert!((all.odometry[0].max - 0.3).abs() < 1e-9 && (all.odometry[1].mean - 0.1).abs() < 1e-9);
        assert!(all.matched.iter().all(|spread| spread.max < 1e-9), "{all:?}");
    }

    #[test]
    fn relations_are_told_apart_by_time_and_by_way() {
        let at = |x: f64| Pose::new(x, 0.0, 0.0);
        let poses = [(0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (40.0, 1.2, 1.2), (90.0, 0.0, 60.0)];
        let track = track(&poses.map(|(stamp, x, driven)| (stamp, at(x), at(x), driven)));
        let relation = |from, to| Relation { stamps: [from, to], displacement: Pose::IDENTITY };
        let relations = [relation(0.0, 1.0), relation(0.0, 40.0), relation(90.0, 0.0), relation(0.0, 7.0)];
        let found = track.compare(&relations, 40.0);
        let counts: Vec<usize> = found.rows.iter().map(|(_, row)| row.relations).collect();
        assert_eq!((found.unknown, counts), (1, vec![3, 2, 2, 1]));
        let spread = found.rows[0].1.odometry[0];
        assert!((spread.mean - 2.2 / 3.0).abs() < 1e-9 && spread.median == 1.0 && spread.max == 1.2);
        assert_eq!(Track::default().compare(&relations, 40.0).unknown, 4);
    }

    #[test]
    fn a_malformed_relation_is_refused_by_line() {
        let read = Relation::read("# a comment\n\n1 2 0.5 -0.1 0 0 0 0.2\n").unwrap();
        assert_eq!(read, [Relation { stamps: [1.0, 2.0], displacement: Pose::new(0.5, -0.1, 0.2) }]);
        for (text, fault) in
            [("1 2 3\n", "line 1: has 3 numbers"), ("\n1 2 x 0 0 0 0 0\n", "line 2: has `x`")]
        {
            let error = Relation::read(text).unwrap_err().to_string();
            assert!(error.starts_with(fault), "{error}");
        }
    }
}
