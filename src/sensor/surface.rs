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
    let seen = (stray / count as f64).sqrt() <= STRAIGHT && facing.abs() >= GRAZING * sight.norm();
    seen.then(|| Surface { at, normal: if facing > 0.0 { across } else { -across } })
}
