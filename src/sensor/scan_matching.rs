//! The robot's pose among the walls around it: odometry corrected by what the scans show, never globally.
//!
//! Odometry is good over a step and poor over a corridor. Walls that are seen again tell where the robot is, but not
//! along a corridor without doors. Both are weighed, scan by scan: points are laid onto lines (Censi 2008, "An ICP
//! variant using a point-to-line metric"), with odometry as a prior and what is uncertain about it carried on as in a
//! Kalman filter. Walls are forgotten as they get far and old, so that no loop is closed: whether a place is a place
//! seen before is for the map to decide.

use crate::geometry::{Pose, wrap_angle};
use crate::sensor::LaserScan;
use crate::sensor::log::Step;
use crate::sensor::surface::{Surface, surfaces};
use crate::sensor::walls::Walls;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_4, PI};

/// What is known of robot and sensor. One set of defaults serves all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchingParameters {
    /// Walls are remembered in a square window of this side around the robot, metres. Default 30.
    pub window: f64,
    /// What was seen so many metres of driving ago is forgotten, so that the robot does not meet its own drift when it
    /// comes by again. Default 40.
    pub memory: f64,
    /// Beams up to this range are used, metres: further out they lie far apart. Default 12.
    pub max_range: f64,
    /// How far a wall may be from where it is expected, metres. Default 0.5.
    pub reach: f64,
    /// Noise of a range, metres. Default 0.03.
    pub range_noise: f64,
    /// How uncertain the length of a metre of odometry is, metres; grows with the root. Default 0.05: wheels slip.
    pub slip: f64,
    /// How uncertain the heading is after a metre or a radian of odometry, radians; grows with the root.
    /// Default 0.02.
    pub heading_slip: f64,
    /// A scan is used when the robot has moved by this many metres since the last one used,
    pub step: f64,
    /// or turned by this many radians.
    pub turn: f64,
}

impl Default for MatchingParameters {
    fn default() -> Self {
        MatchingParameters {
            window: 30.0,
            memory: 40.0,
            max_range: 12.0,
            reach: 0.5,
            range_noise: 0.03,
            slip: 0.05,
            heading_slip: 0.02,
            step: 0.05,
            turn: 2.0_f64.to_radians(),
        }
    }
}

/// Walls are remembered once in every square of this side, metres.
const ELEMENT: f64 = 0.1;
/// The robot remembers what it sees anew after so many metres or radians.
const REMEMBER: f64 = 0.3;
const REMEMBER_TURN: f64 = 0.17;
/// Rounds of matching at most, and those at which walls further away are still taken.
const ROUNDS: usize = 15;
const COARSE: usize = 4;
/// The least that odometry is ever wrong by, metres and radians: its last digits.
const LEAST: [f64; 3] = [1e-3, 1e-3, 3e-4];
/// Metres of driving over which the same walls are seen: over that length an error of a match is one and the same.
const MEMORY: f64 = 10.0;
/// Beams side by side err together; so many of them tell as much as one alone.
const BEAMS_ALIKE: f64 = 5.0;

/// A scan of which a smaller share than this lies on known walls was not laid onto them. On recorded logs that is one scan
/// in 120 to 1,400, nearly always one at which odometry has slipped or was late; of every other scan 0.96 and more lies on them.
const LAID: f64 = 2.0 / 3.0;
/// What lies on a wall is no further off than so many times the noise of a range.
const ON_WALL: f64 = 3.0;
/// Odometry is then taken to have slipped by so much (ahead, aside, in heading; metres and radians), and the scan is laid
/// anew from so many headings to either side: 5 degrees apart, so that walls 5 m away come within the reach of matching.
const SLIPPED: [f64; 3] = [0.5, 0.5, FRAC_PI_4];
const HEADINGS: i32 = 9;

/// What matching errs by on every metre however well it fits, ahead, aside (metres) and in heading (radians) after one
/// metre; grows with the root. Ranges that are long or short by a cell's breadth bend straight corridors, and what is seen
/// of their walls at one moment and at the next seems to tell how far the robot came. On the travels of a recorded log whose
/// loops are closed, errors are that large (root mean square): 3 degrees and 0.3 m after 20 m.
const BENT: [f64; 3] = [0.05, 0.02, 0.012];

const KILOMETRE: f64 = 1e3;

/// How uncertain the robot's pose is after a step that is none ([`Step::is_leap`]), ahead, aside, in heading: anywhere in the building.
const LEAPT: [f64; 3] = [20.0, 20.0, PI];

/// A pose among the walls nearby.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPose {
    /// The robot's pose, in a frame that is the odometry's at the first scan, but for whole kilometres, and drifts away
    /// from it, slower than odometry does.
    pub local_from_robot: Pose,
    /// The covariance of the motion since the scan before, x, y, heading in the robot's frame.
    pub drift: Matrix3<f64>,
    /// Whether the scan was used; one taken where another was is not.
    pub used: bool,
}

/// Follows a robot from scan to scan.
#[derive(Clone, Debug)]
pub struct ScanMatcher {
    parameters: MatchingParameters,
    walls: Walls,
    last: Option<Match>,
    /// Stamp and odometry of the scan before.
    before: Option<(f64, Pose)>,
    /// Where the robot last remembered what it saw.
    remembered: Option<Pose>,
}

/// The last scan used.
#[derive(Clone, Copy, Debug)]
struct Match {
    odom_from_robot: Pose,
    local_from_robot: Pose,
    /// How uncertain that pose is among the walls remembered.
    covariance: Matrix3<f64>,
    /// What the walls say of the pose: the inverse of a covariance, x, y, heading in the local frame.
    information: Matrix3<f64>,
}

impl ScanMatcher {
    /// A robot that has seen nothing yet.
    pub fn new(parameters: MatchingParameters) -> Self {
        let walls = Walls::new(parameters.window, ELEMENT, parameters.memory);
        ScanMatcher { parameters, walls, last: None, before: None, remembered: None }
    }

    /// The pose at the next scan. Costs beams times rounds; scans at which the robot has not moved cost nothing, and
    /// neither do those whose odometry is not finite: the robot is then where it was.
    pub fn add(&mut self, scan: &LaserScan) -> LocalPose {
        let odom = scan.odom_from_robot;
        if !odom.is_finite() {
            let was = self.last.map_or(Pose::IDENTITY, |last| last.local_from_robot);
            return LocalPose { local_from_robot: was, drift: Matrix3::zeros(), used: false };
        }
        let leap = self.before.replace((scan.stamp, odom)).is_some_and(|before| is_leap(before, scan));
        let Some(last) = self.last else {
            // Far from zero, numbers are coarse and walls cannot be counted.
            let start = Pose { x: odom.x % KILOMETRE, y: odom.y % KILOMETRE, ..odom };
            let nothing = Matrix3::zeros();
            self.last = Some(Match {
                odom_from_robot: odom,
                local_from_robot: start,
                covariance: nothing,
                information: nothing,
            });
            self.remember(&surfaces(scan, self.parameters.max_range), &start);
            return LocalPose { local_from_robot: start, drift: nothing, used: true };
        };
        let motion = last.odom_from_robot.inverse().compose(&odom);
        let motion = if leap { Pose::IDENTITY } else { motion };
        let expected = last.local_from_robot.compose(&motion);
        let still =
            motion.x.hypot(motion.y) < self.parameters.step && motion.theta.abs() < self.parameters.turn;
        if still && !leap {
            return LocalPose { local_from_robot: expected, drift: Matrix3::zeros(), used: false };
        }
        self.walls.drive(motion.x.hypot(motion.y));
        let seen = surfaces(scan, self.parameters.max_range);
        let noise = if leap { squares(LEAPT) } else { self.noise(&motion) };
        let prior = carried(&last, &expected) + in_local(&noise, &expected);
        let found = self.lay(scan, &seen, &expected, &prior);
        let (found, noise) = match self.sought(scan, &seen, &expected, &found) {
            Some(elsewhere) => (elsewhere, squares(SLIPPED)),
            None => (found, noise),
        };
        self.remember(&seen, &found.local_from_robot);
        self.last = Some(found);
        LocalPose {
            local_from_robot: found.local_from_robot,
            drift: drift(&found, &noise, &motion),
            used: true,
        }
    }

    /// How uncertain a step of odometry is, in the robot's frame.
    fn noise(&self, motion: &Pose) -> Matrix3<f64> {
        let MatchingParameters { slip, heading_slip, .. } = self.parameters;
        let length = motion.x.hypot(motion.y);
        let along = slip * slip * length;
        let heading = heading_slip * heading_slip * (length + motion.theta.abs());
        let [x, y, theta] = LEAST.map(|least| least * least);
        // Wheels slip forward more than sideways.
        Matrix3::from_diagonal(&Vector3::new(along + x, along / 4.0 + y, heading + theta))
    }

    /// Gauss and Newton: the pose at which walls and odometry agree best, walls that do not fit counting less
    /// (Cauchy's weights).
    fn lay(&self, scan: &LaserScan, seen: &[Surface], expected: &Pose, prior: &Matrix3<f64>) -> Match {
        let trust = prior.try_inverse().unwrap_or_else(Matrix3::zeros);
        let mut pose = *expected;
        let mut information = Matrix3::zeros();
        for round in 0..ROUNDS {
            let reach = if round < COARSE { self.parameters.reach } else { self.parameters.reach / 2.0 };
            let (found, pull) = self.compare(seen, &pose, reach);
            information = found;
            let away = Vector3::new(
                pose.x - expected.x,
                pose.y - expected.y,
                wrap_angle(pose.theta - expected.theta),
            );
            let Some(covariance) = (trust + information).try_inverse() else { break };
            let step = covariance * (trust * away + pull);
            pose = Pose::new(pose.x - step.x, pose.y - step.y, pose.theta - step.z);
            if round >= COARSE && step.x.hypot(step.y) < 1e-4 && step.z.abs() < 1e-5 {
                break;
            }
        }
        let covariance = (trust + information).try_inverse().unwrap_or(*prior);
        let odom_from_robot = scan.odom_from_robot;
        Match { odom_from_robot, local_from_robot: pose, covariance, information }
    }

    /// Where most of a scan lies on known walls if it does not where it was found: odometry has slipped. Nothing if it
    /// does, or nowhere else either, as where the robot looks into a room for the first time.
    fn sought(&self, scan: &LaserScan, seen: &[Surface], expected: &Pose, found: &Match) -> Option<Match> {
        let laid = |found: &Match| self.laid(seen, &found.local_from_robot);
        let least = (LAID * seen.len() as f64) as usize;
        if laid(found) > least {
            return None;
        }
        let prior = in_local(&squares(SLIPPED), expected);
        let elsewhere = (-HEADINGS..=HEADINGS).map(|k| {
            let turned = f64::from(k) / f64::from(HEADINGS) * SLIPPED[2];
            let there = Pose { theta: wrap_angle(expected.theta + turned), ..*expected };
            self.lay(scan, seen, &there, &prior)
        });
        let laid = elsewhere.map(|one| (laid(&one), one)).filter(|(laid, _)| *laid > least);
        laid.max_by_key(|(laid, _)| *laid).map(|(_, one)| one)
    }

    /// How many surfaces lie on known walls.
    fn laid(&self, seen: &[Surface], pose: &Pose) -> usize {
        let local_from_robot = pose.transform();
        let on_wall = |surface: &&Surface| {
            let there = surface.seen_from(&local_from_robot);
            let wall = self.walls.nearest(&there, self.parameters.reach / 2.0);
            wall.is_some_and(|wall| {
                wall.normal.dot(&(there.at - wall.at)).abs() < ON_WALL * self.parameters.range_noise
            })
        };
        seen.iter().filter(on_wall).count()
    }

    /// What the walls say of a pose: information and gradient.
    fn compare(&self, seen: &[Surface], pose: &Pose, reach: f64) -> (Matrix3<f64>, Vector3<f64>) {
        let noise = self.parameters.range_noise;
        let (mut information, mut pull) = (Matrix3::zeros(), Vector3::zeros());
        let local_from_robot = pose.transform();
        for surface in seen {
            let there = surface.seen_from(&local_from_robot);
            let Some(wall) = self.walls.nearest(&there, reach) else { continue };
            let off = wall.normal.dot(&(there.at - wall.at));
            let arm = there.at - pose.position();
            let slope = Vector3::new(wall.normal.x, wall.normal.y, arm.perp(&wall.normal));
            let weight = 1.0 / (noise * noise + off * off / 4.0);
            information += slope * slope.transpose() * weight;
            pull += slope * (weight * off);
        }
        (information, pull)
    }

    fn remember(&mut self, seen: &[Surface], pose: &Pose) {
        let far = self.remembered.is_none_or(|last| {
            let motion = last.inverse().compose(pose);
            motion.x.hypot(motion.y) >= REMEMBER || motion.theta.abs() >= REMEMBER_TURN
        });
        if !far {
            return;
        }
        self.remembered = Some(*pose);
        let local_from_robot = pose.transform();
        seen.iter().for_each(|surface| self.walls.add(surface.seen_from(&local_from_robot)));
    }
}

fn is_leap((stamp, odom_from_before): (f64, Pose), scan: &LaserScan) -> bool {
    let metres = (scan.odom_from_robot.position() - odom_from_before.position()).norm();
    Step { scan: 0, metres, seconds: scan.stamp - stamp }.is_leap()
}

/// The uncertainty of the last pose as it is felt at the next.
fn carried(last: &Match, next: &Pose) -> Matrix3<f64> {
    let step = next.position() - last.local_from_robot.position();
    let felt = Matrix3::new(1.0, 0.0, -step.y, 0.0, 1.0, step.x, 0.0, 0.0, 1.0);
    felt * last.covariance * felt.transpose()
}

/// A covariance of the robot's frame in the local frame.
fn in_local(covariance: &Matrix3<f64>, pose: &Pose) -> Matrix3<f64> {
    let turned = turned(pose);
    turned * covariance * turned.transpose()
}

fn turned(pose: &Pose) -> Matrix3<f64> {
    let (sin, cos) = pose.theta.sin_cos();
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// The covariance of a step in the robot's frame: that of odometry, held by the walls as far as they hold it. Matches
/// that share their walls err alike, so that what the walls say is spread over the length on which they are seen.
fn drift(found: &Match, noise: &Matrix3<f64>, motion: &Pose) -> Matrix3<f64> {
    let share = (motion.x.hypot(motion.y) + motion.theta.abs()) / MEMORY;
    let turned = turned(&found.local_from_robot);
    let walls = turned.transpose() * found.information * turned / (BEAMS_ALIKE * share.max(1e-6));
    let odometry = noise.try_inverse().unwrap_or_else(Matrix3::zeros);
    let length = motion.x.hypot(motion.y);
    (odometry + walls).try_inverse().unwrap_or(*noise) + squares(BENT) * length
}

fn squares(deviations: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(deviations.map(|deviation| deviation * deviation)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::sensor::log::LaserNumber;

    /// What a robot sees in a room of 6 x 4 m that has its middle at (1, 0.5).
    fn scan(stamp: f64, room_from_robot: &Pose, odom_from_robot: Pose) -> LaserScan {
        let ray = |k: usize| {
            let angle = room_from_robot.theta + (k as f64).to_radians();
            let to = |at: f64, along: f64, low: f64, high: f64| {
                if along == 0.0 {
                    f64::INFINITY
                } else {
                    ((if along > 0.0 { high } else { low }) - at) / along
                }
            };
            let across = to(room_from_robot.x, angle.cos(), -2.0, 4.0);
            Some(across.min(to(room_from_robot.y, angle.sin(), -1.5, 2.5)))
        };
        LaserScan {
            laser: LaserNumber::FRONT,
            stamp,
            odom_from_robot,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 1.0_f64.to_radians(),
            ranges: (0..360).map(ray).collect(),
        }
    }

    /// The way of the robot in the room, and what odometry makes of it: two thirds of a degree off in a metre.
    fn way() -> Vec<(Pose, Pose)> {
        let step = |k: usize| Pose::new(0.1, 0.0, if k % 30 < 15 { 0.1 } else { -0.08 });
        let mut at = (Pose::IDENTITY, Pose::IDENTITY);
        let mut way = vec![at];
        for k in 0..60 {
            let (motion, bent) = (step(k), Pose::new(0.1, 0.0, step(k).theta + 0.0012));
            at = (at.0.compose(&motion), at.1.compose(&bent));
            way.push(at);
        }
        way
    }

    fn matched(odom_from_start: impl Fn(usize) -> Pose) -> Vec<(Pose, LocalPose)> {
        let mut matcher = ScanMatcher::new(MatchingParameters::default());
        let seen = way().into_iter().enumerate().map(|(k, (room, odom))| {
            let odom = odom_from_start(k).compose(&odom);
            (room, matcher.add(&scan(k as f64 * 0.2, &room, odom)))
        });
        seen.collect()
    }

    fn off(matched: &[(Pose, LocalPose)]) -> f64 {
        let away = |(room, found): &(Pose, LocalPose)| -> f64 {
            let Point { coords } = found.local_from_robot.position();
            (coords - room.position().coords).norm()
        };
        matched.iter().map(away).fold(0.0, f64::max)
    }

    #[test]
    fn walls_hold_poses_wherever_the_frame_of_the_odometry_lies() {
        let starts = [(0.013, -0.4, 1.0), (3e8 + 1.0, -2e9 + 2.0, 2.5), (-3e3, 0.0, 0.0)];
        for start in starts.map(|(x, y, theta)| Pose::new(x, y, theta)) {
            let placed: Vec<(Pose, LocalPose)> = matched(|_| start);
            let back = Pose { x: start.x % KILOMETRE, y: start.y % KILOMETRE, ..start }.inverse();
            let in_room = |(room, found): (Pose, LocalPose)| {
                (room, LocalPose { local_from_robot: back.compose(&found.local_from_robot), ..found })
            };
            let off = off(&placed.into_iter().map(in_room).collect::<Vec<_>>());
            assert!(off < 0.03, "{off} at {start:?}");
        }
    }

    #[test]
    fn a_scan_without_odometry_is_passed_over() {
        let nowhere = Pose { x: f64::NAN, y: 0.0, theta: f64::INFINITY };
        let lost = |k: usize| k.is_multiple_of(7);
        let placed = matched(|k| if lost(k) { nowhere } else { Pose::IDENTITY });
        let (without, with): (Vec<_>, Vec<_>) = placed.iter().enumerate().partition(|(k, _)| lost(*k));
        assert!(without.iter().all(|(_, (_, found))| !found.used && found.local_from_robot.is_finite()));
        let with: Vec<(Pose, LocalPose)> = with.into_iter().map(|(_, placed)| *placed).collect();
        assert!(off(&with) < 0.03 && with.iter().all(|(_, found)| found.used), "{}", off(&with));
    }

    #[test]
    fn odometry_that_is_set_anew_does_not_carry_the_robot_off() {
        let leapt = matched(|k| if k < 30 { Pose::IDENTITY } else { Pose::new(-50.0, 20.0, 0.0) });
        assert!(off(&leapt) < 0.15, "{}", off(&leapt));
    }

    /// Wheels that slip while the robot turns, and odometry that is late by a scan: it turns by more than the reach of matching
    /// takes back.
    #[test]
    fn odometry_that_slips_in_heading_does_not_turn_the_robot() {
        for slipped in [-0.75, -0.4, -0.2, 0.2, 0.4, 0.75] {
            let (_, there) = way()[30];
            let turned = there.compose(&Pose::new(0.0, 0.0, slipped)).compose(&there.inverse());
            let slipping = matched(|k| if k < 30 { Pose::IDENTITY } else { turned });
            assert!(off(&slipping) < 0.03, "{slipped}: {}", off(&slipping));
            let turned = slipping.iter().map(|(room, found)| room.theta - found.local_from_robot.theta);
            let most = turned.map(|by| wrap_angle(by).abs()).fold(0.0, f64::max);
            assert!(most < 0.02, "{slipped}: {most}");
        }
    }

    #[test]
    fn a_leap_after_a_rest_or_back_in_time_is_one() {
        let mut matcher = ScanMatcher::new(MatchingParameters::default());
        let odom = |x: f64| Pose::new(x, 0.0, 0.0);
        let mut add =
            |stamp: f64, x: f64| matcher.add(&scan(stamp, &Pose::IDENTITY, odom(x))).local_from_robot.x;
        (0..300).for_each(|k| assert_eq!(add(f64::from(k) * 0.2, 0.0), 0.0));
        assert!(add(60.2, 50.0).abs() < 0.05);
        assert!(add(-1000.0, 90.0).abs() < 0.05);
    }

    #[test]
    fn a_leap_among_no_walls_says_nothing_of_where_the_robot_went() {
        let mut matcher = ScanMatcher::new(MatchingParameters::default());
        let blind = |stamp: f64, x: f64| LaserScan {
            ranges: vec![None; 360],
            ..scan(stamp, &Pose::IDENTITY, Pose::new(x, 0.0, 0.0))
        };
        matcher.add(&blind(0.0, 0.0));
        let slow = matcher.add(&blind(10.0, 3.0));
        assert!(slow.local_from_robot.x == 3.0 && slow.drift[(0, 0)] < 1.0);
        let leapt = matcher.add(&blind(10.2, 43.0));
        assert!(leapt.local_from_robot.x == 3.0 && leapt.drift[(0, 0)] >= 400.0);
    }
}
