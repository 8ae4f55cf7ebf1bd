//! Where a way out of a place is narrowest for the first time.
//!
//! A way narrows while the nearest obstacle on one of its sides lies ahead: a corner that the robot is still
//! driving towards. The gateway is abreast of the last such corner, where the nearest obstacle begins to slide
//! along a wall instead. Within the circle of clearance around the middle nothing stands, so that there a way has narrowed
//! only where it is narrower than the middle: a wall that ends beside the middle is no gateway across it. On a medial
//! axis this is the first local minimum of clearance outward; on a coast, where clearance is constant, it is where the wall
//! beyond the opening becomes followable.

use crate::gateway::GatewayParameters;
use crate::gateway::way::{Way, local};
use crate::geometry::{Point, Vector};
use crate::grid::DistanceField;

/// The index of the first constriction on a way, or of its cap.
pub(super) fn first_constriction(
    way: &Way,
    distance: &DistanceField,
    parameters: &GatewayParameters,
) -> usize {
    let resolution = distance.info().resolution;
    let least = parameters.constriction_depth.max(resolution);
    let limit = 2.0 * way.clearance[0] + parameters.cap;
    let mut corners: Vec<Point> = Vec::new();
    let mut narrows = false;
    for at in 0..way.points.len() {
        let here = way.points[at];
        if (here - way.points[0]).norm() > limit {
            break;
        }
        let Some(along) = heading(way, at, parameters) else { break };
        corners.retain(|corner| along.dot(&(corner - here)) > resolution / 2.0);
        // Every other cell is enough to see a corner come, but not to see that none is left.
        if at % 2 == 1 && !corners.is_empty() {
            continue;
        }
        let sides = distance.sides(way.cells[at], &along, 1.5 * resolution, 0.0);
        for cell in [sides.left, sides.right].into_iter().flatten() {
            let corner = local(cell, resolution);
            if fall(&(corner - here), &along) > least {
                narrows = true;
                corners.push(corner);
            }
        }
        let clear = (here - way.points[0]).norm() < way.clearance[0];
        let narrower = !clear || way.clearance[at] < way.clearance[0] - least;
        if narrows && narrower && corners.is_empty() && stays_narrow(way, at, least, parameters) {
            return at;
        }
    }
    cap(way, parameters)
}

/// How much nearer an obstacle will come before it is abreast; 0 if it is abreast or behind.
fn fall(offset: &Vector, along: &Vector) -> f64 {
    if along.dot(offset) <= 0.0 { 0.0 } else { offset.norm() - along.perp(offset).abs() }
}

/// The direction the way will take beyond its next bend: a coast or parabola swings around a corner first, at the scale
/// of the clearance. Behind a door the way may bend soon, and is looked at as shortly as the door is wide.
fn heading(way: &Way, at: usize, parameters: &GatewayParameters) -> Option<Vector> {
    let length = parameters.direction_length.min(2.0 * way.clearance[at]);
    let (near, far) = (way.ahead(at, 0.5 * length), way.ahead(at, 1.25 * length));
    let straight = way.arc[far] - way.arc[near] >= 0.25 * length;
    if straight {
        way.direction(near, far)
    } else {
        way.direction(at.min(way.ahead(0, way.arc[far] - length)), far)
    }
}

/// Whether the way does not narrow any further within sight.
fn stays_narrow(way: &Way, at: usize, least: f64, parameters: &GatewayParameters) -> bool {
    let sight = parameters.look_ahead.max(0.6 * way.clearance[at]);
    let ahead = &way.clearance[at..=way.ahead(at, sight)];
    ahead.iter().all(|&clearance| clearance >= way.clearance[at] - least)
}

fn cap(way: &Way, parameters: &GatewayParameters) -> usize {
    let radius = way.clearance[0] + parameters.cap;
    let outside = way.points.iter().position(|point| (point - way.points[0]).norm() >= radius);
    outside.unwrap_or(way.points.len() - 1)
}
