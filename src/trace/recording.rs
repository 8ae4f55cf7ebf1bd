//! A recorded log and the arrivals in it, cut into a trace of LPMs.
//!
//! Each LPM is ray-cast from the scans along a stretch of path around the place, at the poses that the raw
//! odometry gives them, in a frame with the axes of the odometry and its origin at the place. Drift enters only
//! within the stretch.

use crate::geometry::{Point, Pose, bearing};
use crate::grid::{GridError, GridInfo, OccupancyGrid};
use crate::lpm::Lpm;
use crate::sensor::{EvidenceGrid, LaserScan};
use crate::trace::event::{Event, EventKind, Observation, Percept, Travel, Turn, TurnTarget};
use crate::trace::odometry::OdometryNoise;
use std::ops::RangeInclusive;
use thiserror::Error;

/// How a log is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordingParameters {
    /// Metres before a place at which the robot counts as arrived, and after it as gone.
    pub place_radius: f64,
    /// Metres of path before the arrival and after the departure whose scans help to make the LPM.
    pub approach: f64,
    /// Side of the square LPM, metres.
    pub side: f64,
    /// Side of a cell, metres.
    pub resolution: f64,
    /// A scan is used when the robot has moved by this many metres since the last one used,
    pub step: f64,
    /// or turned by this many radians.
    pub turn: f64,
    /// How uncertain the log's odometry is.
    pub odometry: OdometryNoise,
}

impl Default for RecordingParameters {
    fn default() -> Self {
        let turn = 2.0_f64.to_radians();
        RecordingParameters {
            place_radius: 3.0,
            approach: 5.0,
            side: 20.0,
            resolution: 0.05,
            step: 0.05,
            turn,
            odometry: OdometryNoise::default(),
        }
    }
}

/// The moment at which a robot came to a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// The annotator's name of the place; the map never sees it.
    pub place: String,
    /// Index of the first scan at the place, counted over the scans of the log from 0.
    pub scan: usize,
}

/// Why a log could not be cut.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordingError {
    /// The list of arrivals is malformed.
    #[error("line {line}: {message}")]
    Arrivals {
        /// Line number, from 1.
        line: usize,
        /// What was found and expected.
        message: String,
    },
    /// An arrival beyond the log or not after the one before.
    #[error(
        "arrival {arrival} is at scan {scan}, expected a later scan than the arrival before it and below {scans}"
    )]
    Order {
        /// Arrival, counted from 0.
        arrival: usize,
        /// Its scan.
        scan: usize,
        /// Scans in the log.
        scans: usize,
    },
    /// The grid that the parameters ask for cannot be made.
    #[error(transparent)]
    Grid(#[from] GridError),
}

impl Arrival {
    /// Reads arrivals from CSV with the columns `place` and `raw_scan_index`; lines that start with # are left out.
    pub fn read_csv(text: &str) -> Result<Vec<Arrival>, RecordingError> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty());
        let wrong =
            |line: usize, message: &str| RecordingError::Arrivals { line: line + 1, message: message.into() };
        let (first, header) =
            lines.next().ok_or(wrong(0, "is missing, expected a header with place,raw_scan_index"))?;
        let column = |name: &str| {
            let found = header.split(',').position(|cell| cell.trim() == name);
            found.ok_or_else(|| {
                wrong(first, &format!("has no column {name}, expected place and raw_scan_index"))
            })
        };
        let (place, scan) = (column("place")?, column("raw_scan_index")?);
        let arrival = |(line, text): (usize, &str)| {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            let cell =
                |at: usize| cells.get(at).copied().ok_or(wrong(line, "has fewer columns than the header"));
            let index = cell(scan)?;
            let scan = index
                .parse()
                .map_err(|_| wrong(line, &format!("has `{index}` as raw_scan_index, expected a number")))?;
            Ok(Arrival { place: cell(place)?.into(), scan })
        };
        lines.map(arrival).collect()
    }
}

/// The trace of a log: at every arrival an LPM, between them the turn and the travel that odometry shows.
pub fn cut(
    scans: &[LaserScan],
    arrivals: &[Arrival],
    parameters: &RecordingParameters,
) -> Result<Vec<Event>, RecordingError> {
    check_order(scans, arrivals)?;
    let mut kinds = Vec::new();
    for (k, arrival) in arrivals.iter().enumerate() {
        let next = arrivals.get(k + 1).map(|a| a.scan);
        let place = Stay::new(scans, arrival.scan, next, k == 0, parameters.place_radius);
        let lpm = place.lpm(scans, parameters)?;
        kinds.push(EventKind::Observation(Box::new(Observation { percept: Percept::Lpm(lpm) })));
        if let Some(next) = next {
            kinds.push(EventKind::Turn(Turn {
                target: TurnTarget::Heading(place.way_out(scans)),
                angle: None,
            }));
            kinds.push(EventKind::Travel(Box::new(place.travel(scans, next, &parameters.odometry))));
        }
    }
    Ok(kinds.into_iter().zip(0..).map(|(kind, seq)| Event { seq, stamp: None, kind }).collect())
}

fn check_order(scans: &[LaserScan], arrivals: &[Arrival]) -> Result<(), RecordingError> {
    for (k, arrival) in arrivals.iter().enumerate() {
        let after = k == 0 || arrivals[k - 1].scan < arrival.scan;
        if !after || arrival.scan >= scans.len() {
            return Err(RecordingError::Order { arrival: k, scan: arrival.scan, scans: scans.len() });
        }
    }
    Ok(())
}

/// A stay at a place: scan indices and the place's position in the odometry frame.
struct Stay {
    center: Point,
    arrival: usize,
    departure: usize,
}

impl Stay {
    fn new(scans: &[LaserScan], arrival: usize, next: Option<usize>, first: bool, radius: f64) -> Stay {
        let ahead = if first { 0.0 } else { radius };
        let center = scans[arrival].odom_from_robot.transform_point(&Point::new(ahead, 0.0));
        let here = |k: &usize| (scans[*k].odom_from_robot.position() - center).norm() <= radius;
        // A robot that wanders about a place leaves its neighbourhood more than once before it travels on; after
        // the last arrival of the list nothing tells a return from wandering.
        let last_here = match next {
            Some(next) => (arrival..next).rev().find(here),
            None => (arrival..scans.len()).skip(1).skip_while(here).map(|k| k - 1).next(),
        };
        let departure = last_here.map_or(scans.len() - 1, |k| k + 1);
        Stay { center, arrival, departure: next.map_or(departure, |next| departure.min(next)) }
    }

    fn lpm(&self, scans: &[LaserScan], parameters: &RecordingParameters) -> Result<Lpm, RecordingError> {
        let cells = (parameters.side / parameters.resolution).round() as usize;
        let half = cells as f64 * parameters.resolution / 2.0;
        let info = GridInfo {
            resolution: parameters.resolution,
            width: cells,
            height: cells,
            origin: Pose::new(-half, -half, 0.0),
        };
        // Refuses bad sizes before memory is taken for them.
        OccupancyGrid::check(&info)?;
        let mut evidence = EvidenceGrid::new(info);
        let mut used: Option<Pose> = None;
        for scan in &scans[stretch(scans, self.arrival, self.departure, parameters.approach)] {
            let pose = scan.odom_from_robot;
            let moved = used.is_none_or(|last| {
                let motion = last.inverse().compose(&pose);
                motion.x.hypot(motion.y) >= parameters.step || motion.theta.abs() >= parameters.turn
            });
            if moved {
                evidence.add(scan, &self.lpm_from(&pose));
                used = Some(pose);
            }
        }
        Ok(Lpm::new(evidence.grid()?, self.lpm_from(&scans[self.arrival].odom_from_robot)))
    }

    /// A pose of the odometry frame in the LPM's frame.
    fn lpm_from(&self, odom: &Pose) -> Pose {
        Pose::new(odom.x - self.center.x, odom.y - self.center.y, odom.theta)
    }

    fn way_out(&self, scans: &[LaserScan]) -> f64 {
        bearing(&(scans[self.departure].odom_from_robot.position() - self.center))
    }

    /// The travel to the next arrival. Its covariance is that of all that was driven since this one, as place and
    /// arrival are measured by the same odometry.
    fn travel(&self, scans: &[LaserScan], next: usize, noise: &OdometryNoise) -> Travel {
        let start = scans[self.departure].odom_from_robot;
        let seen_from_start = |k: usize| start.inverse().compose(&scans[k].odom_from_robot);
        let driven: Vec<Pose> = scans[self.arrival..=next].iter().map(|scan| scan.odom_from_robot).collect();
        Travel {
            odometry: Some(seen_from_start(next)),
            covariance: Some(noise.covariance(&driven, &start)),
            from_pose: Some(self.lpm_from(&start)),
            shape: shape((self.departure..=next).map(seen_from_start)),
        }
    }
}

/// The scans from a length of path before one scan to the same length after another.
fn stretch(scans: &[LaserScan], from: usize, to: usize, length: f64) -> RangeInclusive<usize> {
    let step =
        |k: usize| (scans[k + 1].odom_from_robot.position() - scans[k].odom_from_robot.position()).norm();
    let (mut from, mut before) = (from, 0.0);
    while from > 0 && before + step(from - 1) <= length {
        from -= 1;
        before += step(from);
    }
    let (mut to, mut after) = (to, 0.0);
    while to + 1 < scans.len() && after + step(to) <= length {
        after += step(to);
        to += 1;
    }
    from..=to
}

/// Points of a trajectory, at least half a metre apart.
fn shape(poses: impl Iterator<Item = Pose>) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for pose in poses {
        let far = points.last().is_none_or(|last| (pose.x - last[0]).hypot(pose.y - last[1]) >= 0.5);
        if far {
            points.push([pose.x, pose.y]);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::log::LaserNumber;
    use std::f64::consts::FRAC_PI_2;

    /// A drive of 20 m east and 20 m north in steps of 0.1 m, a wall always 2 m ahead.
    fn drive() -> Vec<LaserScan> {
        let east = (0..=200).map(|k| Pose::new(0.1 * f64::from(k), 0.0, 0.0));
        let north = (0..=200).map(|k| Pose::new(20.0, 0.1 * f64::from(k), FRAC_PI_2));
        let scan = |(k, odom_from_robot)| LaserScan {
            laser: LaserNumber::FRONT,
            stamp: k as f64,
            odom_from_robot,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.1,
            ranges: vec![Some(2.0)],
        };
        east.chain(north).enumerate().map(scan).collect()
    }

    fn arrival(scan: usize) -> Arrival {
        Arrival { place: "P".into(), scan }
    }

    #[test]
    fn a_bend_becomes_an_observation_a_turn_and_a_travel() {
        let arrivals = [arrival(0), arrival(170), arrival(371)];
        let events = cut(&drive(), &arrivals, &RecordingParameters::default()).unwrap();
        assert!(events.iter().map(|event| event.seq).eq(0..7));
        let EventKind::Observation(seen) = &events[3].kind else { panic!("{:?}", events[3]) };
        let Percept::Lpm(lpm) = &seen.percept else { panic!("{seen:?}") };
        // The place is three metres ahead of the arrival: at the bend.
        assert!((lpm.robot_pose.x + 3.0).abs() < 1e-9 && lpm.robot_pose.y.abs() < 1e-9);
        let EventKind::Turn(Turn { target: TurnTarget::Heading(heading), .. }) = events[4].kind else {
            panic!()
        };
        assert!((heading - FRAC_PI_2).abs() < 1e-6, "{heading}");
        let EventKind::Travel(travel) = &events[5].kind else { panic!() };
        let way = travel.odometry.unwrap();
        // It left the place 3.1 m north of the bend, and arrived 17 m north of it.
        assert!((way.x - 13.9).abs() < 1e-6 && way.y.abs() < 1e-6 && way.theta.abs() < 1e-9, "{way:?}");
        assert!((travel.from_pose.unwrap().y - 3.1).abs() < 1e-6);
        let trail = travel.trail(&Pose::new(1.0, 2.0, 0.0));
        assert_eq!(trail.last().copied(), Some(Point::new(1.0, 2.0)));
        assert!(trail.iter().all(|point| (point.y - 2.0).abs() < 1e-6 && point.x <= 1.0 + 1e-6));
    }

    #[test]
    fn arrivals_must_come_in_order_and_lie_in_the_log() {
        let refused = |scans: &[usize]| {
            let arrivals: Vec<Arrival> = scans.iter().map(|&scan| arrival(scan)).collect();
            cut(&drive(), &arrivals, &RecordingParameters::default()).unwrap_err().to_string()
        };
        assert!(refused(&[5, 5]).starts_with("arrival 1 is at scan 5"));
        assert!(refused(&[402]).starts_with("arrival 0 is at scan 402"));
        assert_eq!(cut(&drive(), &[], &RecordingParameters::default()), Ok(Vec::new()));
    }

    #[test]
    fn a_malformed_list_of_arrivals_is_refused_by_line() {
        let read = |text: &str| Arrival::read_csv(text).map_err(|error| error.to_string());
        let good = read("# a comment\nvisit,place,raw_scan_index\n0,N, 12\n").unwrap();
        assert_eq!(good, [Arrival { place: "N".into(), scan: 12 }]);
        for (text, fault) in [
            ("", "line 1: is missing"),
            ("visit,place\n0,N\n", "line 1: has no column raw_scan_index"),
            ("place,raw_scan_index\nN,x\n", "line 2: has `x`"),
            ("place,raw_scan_index\nN\n", "line 2: has fewer columns"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(fault), "{error}");
        }
    }

    #[test]
    fn arrivals_are_read_from_what_spreadsheets_write() {
        let text = "\u{feff}place,raw_scan_index\r\n# a remark\r\nN,7\r\n";
        assert_eq!(Arrival::read_csv(text), Ok(vec![Arrival { place: "N".into(), scan: 7 }]));
    }
}
