//! Pieces of wall in a scan: the points it met, each with the direction of the wall there.

use crate::geometry::{Point, Transform, Vector, direction};
use crate::sensor::LaserScan;

/// A point of a wall and which way the wall faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Where the beam ended.
    pub at: Point,
    /// The unit vector across the wall, towards the side it was seen from.
    pub normal: Vector,
}

impl Surface {
    /// The same surface in the frame that the transform leads to.
    pub(super) fn seen_from(&self, to_frame: &Transform) -> Surface {
        Surface { at: to_frame.point(&self.at), normal: to_frame.rotate(&self.normal) }
    }
}

/// Beams on either side of one that may lie on the same wall.
const NEIGHBORS: usize = 4;
/// How far apart neighbours on one wall lie: metres, and gaps between beams at that range.
const NEAR: f64 = 0.15;
const GAPS: f64 = 4.0;
/// What is no straight piece of wall: points that stray more than this from a line, metres (root mean square).
const STRAIGHT: f64 = 0.05;
/// Walls seen under a flatter angle than this are not placed well by a range: the sine.
const GRAZING: f64 = 0.1;

/// The surfaces that a scan shows up to a range, in the robot's frame and the order of the beams. Points whose
/// neighbours do not make a line, such as legs and edges, are left out. Linear in the beams.
pub fn surfaces(scan: &LaserScan, max_range: f64) -> Vec<Surface> {
    let points: Vec<Option<Point>> =
        scan.beams().map(|beam| beam.filter(|(r, _)| *r < max_range).map(|(_, p)| p)).collect();
    let eye = scan.robot_from_laser.position();
    (0..points.len()).filter_map(|beam| surface(&points, beam, &eye, scan.angle_increment.abs())).collect()
}

fn surface(points: &[Option<Point>], beam: usize, eye: &Point, increment: f64) -> Option<Surface> {
    let at = points[beam]?;
    let sight = eye - at;
    let reach = NEAR + GAPS * sight.norm() * increment;
    let around = &points[beam.saturating_sub(NEIGHBORS)..points.len().min(beam + NEIGHBORS + 1)];
    let near = || around.iter().flatten().filter(|p| (*p - at).norm() < reach);
    let count = near().count();
    if count < 3 {
        return None;
    }
    let mean = near().fold(Vector::zeros(), |sum, p| sum + p.coords) / count as f64;
    let moment = |f: fn(Vector) -> f64| near().map(|p| f(p.coords - mean)).sum::<f64>();
    let (xx, xy, yy) = (moment(|d| d.x * d.x), moment(|d| d.x * d.y), moment(|d| d.y * d.y));
    let along = direction(0.5 * (2.0 * xy).atan2(xx - yy));
    let across = Vector::new(-along.y, along.x);
    let stray = across.x * across.x * xx + 2.0 * across.x * across.y * xy + across.y * across.y * yy;
    let facing = across.dot(&sight);
    // Of points on a line rounding leaves less than nothing.
    let seen = (stray.max(0.0) / count as f64).sqrt() <= STRAIGHT && facing.abs() >= GRAZING * sight.norm();
    seen.then(|| Surface { at, normal: if facing > 0.0 { across } else { -across } })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::sensor::log::LaserNumber;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const MAX_RANGE: f64 = 8.0;

    /// A half circle of beams, a degree apart, that end on a line so far from the laser and at this angle.
    fn wall(robot_from_laser: Pose, away: f64, angle: f64) -> LaserScan {
        let range = |k: i32| {
            let beam = f64::from(k).to_radians() - PI / 2.0;
            let met = away / (beam - angle).cos();
            (met > 0.0 && met < 60.0).then_some(met)
        };
        LaserScan {
            laser: LaserNumber::FRONT,
            stamp: 0.0,
            odom_from_robot: Pose::new(0.0, 0.0, 0.0),
            robot_from_laser,
            start_angle: -PI / 2.0,
            angle_increment: 1.0_f64.to_radians(),
            ranges: (0..=180).map(range).collect(),
        }
    }

    fn mounts() -> impl Strategy<Value = Pose> {
        (-0.5..0.5, -0.5..0.5, -3.1..3.1).prop_map(|(x, y, theta)| Pose::new(x, y, theta))
    }

    proptest! {
        /// Wherever a laser sits, a straight wall is one line of surfaces that face it: all points within range that are seen
        /// under more than a flat angle, and no other.
        #[test]
        fn a_wall_is_a_line_of_surfaces_that_face_the_laser(
            mount in mounts(), away in 0.3..7.0f64, angle in -1.5..1.5f64,
        ) {
            let scan = wall(mount, away, angle);
            let found = surfaces(&scan, MAX_RANGE);
            let facing = -direction(mount.theta + angle);
            for surface in &found {
                prop_assert!((surface.normal - facing).norm() < 1e-6);
                let from_laser = surface.at - mount.position();
                prop_assert!((from_laser.dot(&facing) + away).abs() < 1e-9);
            }
            let steep = |at: &Point, least: f64| away / (at - mount.position()).norm() > least;
            let points: Vec<Point> =
                scan.beams().flatten().filter(|(range, _)| *range < MAX_RANGE).map(|(_, at)| at).collect();
            let is_found = |at: &Point| found.iter().any(|surface| surface.at == *at);
            // The first and the last have neighbours on one side alone.
            for at in points.iter().skip(1).rev().skip(1) {
                prop_assert!(is_found(at) || !steep(at, 0.3), "{at}");
                prop_assert!(!is_found(at) || steep(at, GRAZING * 0.999), "{at}");
            }
            prop_assert!(found.iter().all(|surface| points.contains(&surface.at)));
        }

        /// What stands before a wall, narrower than two beams, is none, and neither is the wall where it ends.
        #[test]
        fn a_leg_is_no_wall(mount in mounts(), away in 2.0..6.0f64, nearer in 0.7..1.5f64, beam in 60usize..120) {
            let mut scan = wall(mount, away, 0.0);
            let behind = surfaces(&scan, MAX_RANGE).len();
            scan.ranges[beam] = Some(away - nearer);
            let found = surfaces(&scan, MAX_RANGE);
            let leg = scan.beams().nth(beam).flatten().unwrap().1;
            prop_assert!(found.iter().all(|surface| surface.at != leg));
            prop_assert_eq!(found.len() + 1, behind);
        }
    }
}
