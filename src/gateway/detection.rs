//! The gateways of the place in which the robot stands, one for each way out.

use crate::gateway::constriction::first_constriction;
use crate::gateway::place::place_center;
use crate::gateway::way::{Way, local};
use crate::gateway::{Beyond, Gateway, GatewayParameters};
use crate::geometry::{Point, Vector, bearing, wrap_angle};
use crate::grid::{DistanceField, SkeletonGraph, SkeletonParameters};

/// A place and its gateways.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighborhood {
    /// The middle of the place, LPM frame.
    pub center: Point,
    /// Distance from the middle to the nearest obstacle, metres.
    pub clearance: f64,
    /// The gateways, in the order of their exits.
    pub gateways: Vec<Gateway>,
}

/// Walks outward from the middle of the robot's place along the skeleton; nothing if there is no way out.
pub fn find_gateways(
    graph: &mut SkeletonGraph,
    distance: &DistanceField,
    robot: &Point,
    skeleton: &SkeletonParameters,
    parameters: &GatewayParameters,
) -> Option<Neighborhood> {
    let center = place_center(graph, distance, robot, parameters)?;
    let found = graph.ways_out(center).into_iter().map(|cells| {
        let way = Way::new(cells, distance);
        let at = first_constriction(&way, distance, parameters);
        (way, at)
    });
    let found = innermost(found.collect(), distance.info().resolution);
    let anchored = found.iter().map(|(way, at)| {
        let measure = Measure { way, distance, skeleton, parameters };
        measure.gateway(*at)
    });
    let gateways: Vec<Gateway> = anchored.collect::<Option<_>>()?;
    let node = &graph.graph[center];
    (!gateways.is_empty()).then(|| Neighborhood {
        center: distance.info().center(node.cell),
        clearance: node.clearance,
        gateways,
    })
}

/// Several exits can lie behind one gateway: of constrictions closer together than half their clearance, or one
/// behind the other on a way, only the first is kept.
fn innermost(found: Vec<(Way, usize)>, resolution: f64) -> Vec<(Way, usize)> {
    let place = |(way, at): &(Way, usize)| (way.points[*at], way.clearance[*at], way.arc[*at]);
    let behind = |i: usize| {
        let (at, clearance, arc) = place(&found[i]);
        (0..found.len()).any(|j| {
            let (other, _, other_arc) = place(&found[j]);
            let passed =
                found[i].0.points[..found[i].1].iter().any(|p| (p - other).norm() < resolution / 2.0);
            let beside = (at - other).norm() < (clearance / 2.0).max(2.0 * resolution);
            j != i && (passed || (beside && (other_arc, j) < (arc, i)))
        })
    };
    let kept: Vec<bool> = (0..found.len()).map(|i| !behind(i)).collect();
    found.into_iter().zip(kept).filter_map(|(one, kept)| kept.then_some(one)).collect()
}

/// What is measured at a constriction.
struct Measure<'a> {
    way: &'a Way,
    distance: &'a DistanceField,
    skeleton: &'a SkeletonParameters,
    parameters: &'a GatewayParameters,
}

impl Measure<'_> {
    fn gateway(&self, at: usize) -> Option<Gateway> {
        let info = self.distance.info();
        let outward = self.outward(at)?;
        let [left, right] = self.ends(at, &outward);
        let width = (left - right).norm() - info.resolution;
        let narrowest = self.way.clearance.iter().copied().fold(f64::INFINITY, f64::min);
        let passage = 2.0 * narrowest - info.resolution;
        let to_frame = |point: &Point| info.origin.transform_point(point);
        Some(Gateway {
            center: to_frame(&self.way.points[at]),
            ends: [to_frame(&left), to_frame(&right)],
            bearing: wrap_angle(bearing(&outward) + info.origin.theta),
            width,
            margin: (passage / self.skeleton.passage_width - 1.0).max(0.0),
            beyond: self.beyond(at),
        })
    }

    fn outward(&self, at: usize) -> Option<Vector> {
        let length = self.parameters.direction_length;
        let far = self.way.ahead(at, length);
        let lacking = length - (self.way.arc[far] - self.way.arc[at]);
        // A gateway at the rim of the window is measured on what is left of its way, and on the approach.
        let near = if lacking > length / 2.0 {
            self.way.arc.partition_point(|&s| s < self.way.arc[far] - length / 2.0)
        } else {
            at
        };
        self.way.direction(near.min(at), far)
    }

    /// The closest obstacles left and right; a missing one is put at the comfort distance.
    fn ends(&self, at: usize, outward: &Vector) -> [Point; 2] {
        let resolution = self.distance.info().resolution;
        let slack = (self.skeleton.comfort_distance - self.way.clearance[at]).max(2.0 * resolution).min(0.5);
        let sides = self.distance.sides(self.way.cells[at], outward, slack);
        let here = self.way.points[at];
        let left = Vector::new(-outward.y, outward.x) * self.skeleton.comfort_distance;
        let point = |cell| local(cell, resolution);
        [sides.left.map_or(here + left, point), sides.right.map_or(here - left, point)]
    }

    /// Samples every quarter metre of the way up to the comfort distance beyond the gateway.
    fn beyond(&self, at: usize) -> Vec<Beyond> {
        let info = self.distance.info();
        let count = (self.skeleton.comfort_distance / 0.25).floor() as usize;
        let mut indices: Vec<usize> = (0..=count).map(|k| self.way.ahead(at, 0.25 * k as f64)).collect();
        indices.dedup();
        let sample = |i: usize| {
            let clearance = self.way.clearance[i];
            let along = self.outward(i).unwrap_or_else(Vector::zeros);
            let sides = self.distance.sides(self.way.cells[i], &along, 2.0 * info.resolution);
            let close = clearance <= self.skeleton.comfort_distance + info.resolution;
            Beyond {
                at: info.origin.transform_point(&self.way.points[i]),
                left: close && sides.left.is_some(),
                right: close && sides.right.is_some(),
                clearance,
            }
        };
        indices.into_iter().map(sample).collect()
    }
}
