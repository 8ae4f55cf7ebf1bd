//! A drive through a floor plan: what a laser range finder and drifting odometry give on the way.

use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::grid::{Cell, GridError, GridInfo, OccupancyGrid};
use crate::sensor::LaserScan;
use crate::sensor::log::LaserNumber;
use crate::sensor::ray_cast::cells_crossed;
use crate::worlds::drawing::Drawing;
use crate::worlds::random::Random;
use std::f64::consts::FRAC_PI_2;

/// A robot that sees half a turn ahead, a beam a degree, up to 20 m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explorer {
    /// Noise of a range, metres.
    pub range_noise: f64,
    /// Heading that odometry gains on every metre, radians.
    pub heading_drift: f64,
    /// How much too long odometry takes every length, as a share of it.
    pub length_drift: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// Between two scans the robot moves or turns by so much: metres, radians.
const STEP: f64 = 0.1;
const TURN: f64 = 0.1;
const RANGE: f64 = 20.0;
const BEAMS: usize = 180;
/// Side of a cell of the plan, metres: walls are as rough as that.
const CELL: f64 = 0.025;
/// Free space that is drawn around a route, metres.
const AROUND: f64 = 25.0;

/// The scans of a robot that drives along straight lines from point to point and turns on the spot, and the index of
/// the scan at which it comes to each point of its route. Refuses a plan that is too large to be drawn.
pub fn drive(
    plan: &Drawing,
    route: &[Point],
    explorer: &Explorer,
) -> Result<(Vec<LaserScan>, Vec<usize>), GridError> {
    let grid = drawn(plan, route)?;
    let (poses, stops) = poses(route);
    let mut random = Random::new(explorer.seed);
    let mut odom = poses.first().copied().unwrap_or(Pose::IDENTITY);
    let mut last = odom;
    let scan = |(at, pose): (usize, &Pose)| {
        let motion = last.inverse().compose(pose);
        let length = motion.x.hypot(motion.y);
        let drifted = 1.0 + explorer.length_drift;
        let turned = motion.theta + explorer.heading_drift * length;
        odom = odom.compose(&Pose::new(motion.x * drifted, motion.y * drifted, turned));
        last = *pose;
        LaserScan {
            stamp: at as f64 / 10.0,
            laser: LaserNumber::FRONT,
            odom_from_robot: odom,
            robot_from_laser: Pose::IDENTITY,
            start_angle: -FRAC_PI_2,
            angle_increment: 1.0_f64.to_radians(),
            ranges: (0..BEAMS)
                .map(|beam| {
                    let angle = pose.theta - FRAC_PI_2 + (beam as f64).to_radians();
                    range(&grid, &pose.position(), angle).map(|r| r + explorer.range_noise * random.normal())
                })
                .collect(),
        }
    };
    Ok((poses.iter().enumerate().map(scan).collect(), stops))
}

/// The part of a plan that can be seen from a route.
fn drawn(plan: &Drawing, route: &[Point]) -> Result<OccupancyGrid, GridError> {
    let low = |f: fn(&Point) -> f64| route.iter().map(f).fold(f64::INFINITY, f64::min) - AROUND;
    let high = |f: fn(&Point) -> f64| route.iter().map(f).fold(f64::NEG_INFINITY, f64::max) + AROUND;
    let (x, y) = (low(|p| p.x), low(|p| p.y));
    let cells = |length: f64| (length / CELL).ceil() as usize;
    let info = GridInfo {
        resolution: CELL,
        width: cells(high(|p| p.x) - x),
        height: cells(high(|p| p.y) - y),
        origin: Pose::new(x, y, 0.0),
    };
    plan.render(&info, route.first().unwrap_or(&Point::origin()))
}

fn poses(route: &[Point]) -> (Vec<Pose>, Vec<usize>) {
    let mut poses: Vec<Pose> = Vec::new();
    let mut stops = Vec::new();
    for leg in route.windows(2) {
        let way = leg[1] - leg[0];
        let heading = bearing(&way);
        let from = poses.last().map_or(heading, |pose| pose.theta);
        let turn = wrap_angle(heading - from);
        let turns = (turn.abs() / TURN).ceil().max(1.0);
        stops.push(poses.len());
        poses.extend(
            (0..=turns as usize).map(|k| Pose::new(leg[0].x, leg[0].y, from + turn * k as f64 / turns)),
        );
        let steps = (way.norm() / STEP).ceil().max(1.0);
        poses.extend((1..=steps as usize).map(|k| {
            let at = leg[0] + way * (k as f64 / steps);
            Pose::new(at.x, at.y, heading)
        }));
    }
    stops.push(poses.len().saturating_sub(1));
    (poses, stops)
}

/// How far a beam goes until it meets something, if it does within range.
fn range(grid: &OccupancyGrid, from: &Point, angle: f64) -> Option<f64> {
    let end = from + crate::geometry::direction(angle) * RANGE;
    let wall = cells_crossed(grid.info(), from, &end).find(|&cell| grid.cell(cell) != Cell::Free)?;
    Some((grid.info().center(wall) - from).norm())
}
