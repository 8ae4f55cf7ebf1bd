//! What is known of a robot that drives about: where it is, where it was, and what is around it.

use crate::geometry::{Point, Pose};
use crate::grid::{GridError, GridInfo, OccupancyGrid};
use crate::lpm::Lpm;
use crate::sensor::{EvidenceGrid, LaserScan, LocalPose, ScanMatcher};
use crate::visit::{Moment, VisitParameters};
use nalgebra::Matrix3;

/// Poses and a grid that scrolls with the robot. Memory is bounded by the window and by the way that is not yet
/// forgotten.
#[derive(Clone, Debug)]
pub(super) struct Follower {
    matcher: ScanMatcher,
    evidence: EvidenceGrid,
    moments: Vec<Moment>,
    /// Whether the last moment is of a robot that has not moved since the one before.
    standing: bool,
    scans: usize,
    side: f64,
}

/// The grid follows the robot in steps of so many metres.
const FOLLOW: f64 = 4.0;
/// The way is remembered for so many metres of driving, longer than walls: a door that the robot once went through is still
/// one, if half a metre beside. A robot that circles would have ever more of it.
const REMEMBERED: f64 = 200.0;
/// Points of a trail are this far apart, metres.
const TRAIL: f64 = 0.1;

impl Follower {
    /// A robot that has seen nothing yet; refuses a grid that is too large to be made.
    pub(super) fn new(parameters: &VisitParameters) -> Result<Self, GridError> {
        let VisitParameters { resolution, side, lag, .. } = *parameters;
        // The LPM of a place is taken when the robot is about twice as far away as it looks back.
        let cells = ((side + 4.0 * lag) / resolution).ceil() as usize;
        let info = GridInfo { resolution, width: cells, height: cells, origin: Pose::IDENTITY };
        OccupancyGrid::check(&info)?;
        Ok(Follower {
            matcher: ScanMatcher::new(parameters.matching),
            evidence: EvidenceGrid::new(info, parameters.matching.memory, parameters.evidence),
            moments: Vec::new(),
            standing: false,
            scans: 0,
            side,
        })
    }

    /// Takes the next scan.
    pub(super) fn add(&mut self, scan: &LaserScan) -> Moment {
        let pose = self.matcher.add(scan);
        self.add_placed(scan, &pose)
    }

    /// Takes the next scan, of which the pose is known; a pose that is not finite says that the robot is where it was.
    pub(super) fn add_placed(&mut self, scan: &LaserScan, pose: &LocalPose) -> Moment {
        if !pose.local_from_robot.is_finite() {
            let was = self.moments.last().map_or(Pose::IDENTITY, |last| last.local_from_robot);
            return self.push(&LocalPose { local_from_robot: was, drift: Matrix3::zeros(), used: false });
        }
        let moment = self.push(pose);
        if pose.used {
            let at = pose.local_from_robot.position();
            if (at - self.evidence.middle()).amax() > FOLLOW {
                self.evidence.center_on(&at);
            }
            self.evidence.add(scan, &pose.local_from_robot, moment.driven);
        }
        moment
    }

    fn push(&mut self, pose: &LocalPose) -> Moment {
        let LocalPose { local_from_robot, drift, .. } = *pose;
        let step = |last: &Moment| (local_from_robot.position() - last.local_from_robot.position()).norm();
        let driven = self.moments.last().map_or(0.0, |last| last.driven + step(last));
        let moment = Moment { scan: self.scans, local_from_robot, drift, driven };
        self.scans += 1;
        // Of a robot that stands the first moment and the last say all.
        if self.standing && !pose.used {
            self.moments.pop();
        }
        self.standing = !pose.used;
        self.moments.push(moment);
        moment
    }

    /// All moments that are remembered.
    pub(super) fn moments(&self) -> &[Moment] {
        &self.moments
    }

    /// Forgets the way before an arrival, but for what may still be part of a trail.
    pub(super) fn forget_before(&mut self, arrival: &Moment) {
        let needed =
            |moment: &Moment| moment.scan >= arrival.scan || moment.driven + REMEMBERED >= arrival.driven;
        self.moments.drain(..self.moments.iter().position(needed).unwrap_or(0));
    }

    /// What is known now around a point of the local frame, in a frame with its origin there and a robot in a pose of
    /// the local frame; nothing if there is no such grid.
    pub(super) fn lpm(&self, middle: &Point, robot: &Pose) -> Option<Lpm> {
        let grid = self.evidence.around(middle, self.side).ok()?;
        Some(Lpm {
            grid,
            robot_pose: robot.seen_from(middle),
            trail: self.trail(middle),
            middle: Some(Point::origin()),
        })
    }

    /// Where the robot has been within the LPM around a point, in the LPM's frame.
    fn trail(&self, middle: &Point) -> Vec<Point> {
        let now = self.moments.last().map_or(0.0, |last| last.driven);
        let from = self.moments.partition_point(|moment| moment.driven + REMEMBERED < now);
        let positions = self.moments[from..].iter();
        let positions = positions.map(|moment| moment.local_from_robot.position() - middle.coords);
        let mut trail: Vec<Point> = Vec::new();
        for at in positions.filter(|at| at.coords.amax() <= self.side / 2.0) {
            if trail.last().is_none_or(|last| (at - last).norm() >= TRAIL) {
                trail.push(at);
            }
        }
        trail
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::log::LaserNumber;

    fn scan() -> LaserScan {
        LaserScan {
            laser: LaserNumber::FRONT,
            stamp: 0.0,
            odom_from_robot: Pose::IDENTITY,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.1,
            ranges: vec![Some(2.0); 3],
        }
    }

    fn at(x: f64, used: bool) -> LocalPose {
        LocalPose { local_from_robot: Pose::new(x, 0.0, 0.0), drift: Matrix3::zeros(), used }
    }

    #[test]
    fn a_robot_that_stands_is_remembered_by_its_first_and_last_moment() {
        let mut follower = Follower::new(&VisitParameters::default()).unwrap();
        follower.add_placed(&scan(), &at(0.0, true));
        for _ in 0..1000 {
            follower.add_placed(&scan(), &at(0.01, false));
        }
        follower.add_placed(&scan(), &at(0.1, true));
        let scans: Vec<usize> = follower.moments().iter().map(|moment| moment.scan).collect();
        assert_eq!(scans, [0, 1000, 1001]);
    }

    #[test]
    fn a_robot_that_is_nowhere_is_where_it_was() {
        let mut follower = Follower::new(&VisitParameters::default()).unwrap();
        for x in [f64::NAN, 1.0, f64::INFINITY, 2.0] {
            follower.add_placed(&scan(), &at(x, true));
        }
        let driven: Vec<f64> = follower.moments().iter().map(|moment| moment.driven).collect();
        assert_eq!(driven, [0.0, 1.0, 1.0, 2.0]);
    }

    /// To and fro through a door, visit after visit: what was driven before the last one is still a way, for a while.
    #[test]
    fn an_arrival_does_not_end_the_trail() {
        let mut follower = Follower::new(&VisitParameters::default()).unwrap();
        let length = |follower: &Follower| -> f64 {
            let lpm = follower.lpm(&Point::origin(), &Pose::IDENTITY).unwrap();
            lpm.trail.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum()
        };
        for k in 0..1200 {
            let x = f64::from(if k / 10 % 2 == 0 { k % 10 } else { 10 - k % 10 }) / 2.0;
            let arrival = follower.add_placed(&scan(), &at(x, true));
            if k % 60 == 59 {
                follower.forget_before(&arrival);
                let most = REMEMBERED.min(arrival.driven);
                assert!((most - 1.0..=most).contains(&length(&follower)), "{}", length(&follower));
            }
        }
        assert!(follower.moments().len() <= 402, "{}", follower.moments().len());
    }

    #[test]
    fn a_trail_does_not_grow_for_ever() {
        let mut follower = Follower::new(&VisitParameters::default()).unwrap();
        // To and fro: it is always near.
        let ways = (0..4000).map(|k| f64::from(if k / 10 % 2 == 0 { k % 10 } else { 10 - k % 10 }) / 2.0);
        for x in ways {
            follower.add_placed(&scan(), &at(x, true));
        }
        let lpm = follower.lpm(&Point::origin(), &Pose::IDENTITY).unwrap();
        let length: f64 = lpm.trail.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
        assert!((REMEMBERED - 1.0..=REMEMBERED).contains(&length), "{length}");
    }
}
