//! The gateways of the place in which the robot stands, one for each way out.

use crate::gateway::constriction::first_constriction;
use crate::gateway::place::place_center;
use crate::gateway::way::{Way, local};
use crate::gateway::{Beyond, Gateway, GatewayParameters};
use crate::geometry::{Point, Vector, bearing, wrap_angle};
use crate::grid::{CellIndex, DistanceField, NodeKind, SkeletonGraph, SkeletonNode, SkeletonParameters};
use std::f64::consts::SQRT_2;

/// What is within 60 degrees of straight left or right bounds a gateway on that side: the sine of the rest.
const ABREAST: f64 = 0.5;

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

/// Walks outward from the middle of the place at or next to `near` along the skeleton; nothing if there is no way
/// out.
pub fn find_gateways(
    graph: &mut SkeletonGraph,
    distance: &DistanceField,
    near: &Point,
    skeleton: &SkeletonParameters,
    parameters: &GatewayParameters,
) -> Option<Neighborhood> {
    let center = place_center(graph, distance, near, parameters)?;
    let room = |node: &&SkeletonNode| node.kind == NodeKind::Room;
    let rooms: Vec<CellIndex> = graph.graph.node_weights().filter(room).map(|node| node.cell).collect();
    let measure = Measure { distance, rooms, skeleton, parameters };
    let ways = graph.ways_out(center).into_iter().map(|cells| Way::new(cells, distance));
    // A room that is part of the place itself is no way out of it.
    let ways = ways.filter(|way| measure.room_margin(way) >= 0.0).map(|way| {
        let at = first_constriction(&way, distance, parameters);
        WayOut { way, at }
    });
    let ways: Vec<WayOut> = ways.collect();
    let groups = innermost(&ways, distance.info().resolution);
    let gateways: Vec<Gateway> = groups.iter().map(|group| measure.gateway(group)).collect::<Option<_>>()?;
    let node = &graph.graph[center];
    (!gateways.is_empty()).then(|| Neighborhood {
        center: distance.info().center(node.cell),
        clearance: node.clearance,
        gateways,
    })
}

/// A way to an exit and the index of its gateway.
struct WayOut {
    way: Way,
    at: usize,
}

impl WayOut {
    fn gateway(&self) -> Point {
        self.way.points[self.at]
    }
}

/// Several exits can lie behind one gateway: of constrictions closer together than half their clearance, or one
/// behind the other on a way, only the first counts. Every group begins with the way of its gateway.
fn innermost(ways: &[WayOut], resolution: f64) -> Vec<Vec<&WayOut>> {
    let mut order: Vec<&WayOut> = ways.iter().collect();
    order.sort_by(|a, b| a.way.arc[a.at].total_cmp(&b.way.arc[b.at]));
    let mut groups: Vec<Vec<&WayOut>> = Vec::new();
    for one in order {
        let behind = |group: &&mut Vec<&WayOut>| {
            let gateway = group[0].gateway();
            let reach = (one.way.clearance[one.at] / 2.0).max(2.0 * resolution);
            let passed = one.way.points[..one.at].iter().any(|p| (p - gateway).norm() < resolution / 2.0);
            passed || (one.gateway() - gateway).norm() < reach
        };
        match groups.iter_mut().find(behind) {
            Some(group) => group.push(one),
            None => groups.push(vec![one]),
        }
    }
    groups
}

/// What is measured at a constriction.
struct Measure<'a> {
    distance: &'a DistanceField,
    /// The middles of the rooms.
    rooms: Vec<CellIndex>,
    skeleton: &'a SkeletonParameters,
    parameters: &'a GatewayParameters,
}

impl Measure<'_> {
    fn gateway(&self, group: &[&WayOut]) -> Option<Gateway> {
        let info = self.distance.info();
        let WayOut { way, at } = group.first()?;
        let outward = self.normal(way, *at, &self.common_direction(group)?);
        let [left, right] = self.ends(way, *at, &outward);
        let passage = 2.0 * way.narrowest() - info.resolution;
        let to_frame = |point: &Point| info.origin.transform_point(point);
        let width = (left - right).norm();
        Some(Gateway {
            center: to_frame(&way.points[*at]),
            ends: [to_frame(&left), to_frame(&right)],
            bearing: wrap_angle(bearing(&outward) + info.origin.theta),
            read_error: info.resolution / SQRT_2,
            width: width - info.resolution,
            passage,
            margin: (passage / self.skeleton.passage_width - 1.0).min(self.room_margin(way)).max(0.0),
            beyond: self.beyond(way, *at),
        })
    }

    /// By how much a room at the end of a way is wider than it must be; no bound where the way leaves the window.
    fn room_margin(&self, way: &Way) -> f64 {
        let ends_in_room = way.cells.last().is_some_and(|&end| self.rooms.contains(&end));
        match (self.skeleton.room_ratio, way.clearance.last()) {
            (Some(ratio), Some(widest)) if ends_in_room => widest / (ratio * way.narrowest()) - 1.0,
            _ => f64::INFINITY,
        }
    }

    /// The mean direction of all ways through a gateway: where they fork behind it, none of them alone tells.
    fn common_direction(&self, group: &[&WayOut]) -> Option<Vector> {
        let gateway = group.first()?.gateway();
        let directions = group.iter().filter_map(|one| {
            let away = |i: &usize| (one.way.points[*i] - gateway).norm();
            let at = (0..one.way.points.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
            self.outward(&one.way, at)
        });
        directions.fold(Vector::zeros(), |sum, direction| sum + direction).try_normalize(0.0)
    }

    /// The normal of the line between the walls left and right, taken over a stretch of the way as long as the gateway
    /// is wide, so that no single cell decides; without walls on both sides the direction of the way.
    fn normal(&self, way: &Way, at: usize, along: &Vector) -> Vector {
        let stretch = |half: f64| (way.arc.partition_point(|&s| s < way.arc[at] - half), way.ahead(at, half));
        let (from, to) = stretch(way.clearance[at]);
        let through = way.direction(from, to).unwrap_or(*along);
        let (from, to) = stretch(way.clearance[at] / 2.0);
        let resolution = self.distance.info().resolution;
        let across = (from..=to).filter_map(|i| {
            let sides = self.distance.sides(way.cells[i], &through, 2.0 * resolution, ABREAST);
            Some(local(sides.left?, resolution) - local(sides.right?, resolution))
        });
        let across = across.fold(Vector::zeros(), |sum, line| sum + line);
        let normal = Vector::new(across.y, -across.x).try_normalize(0.0);
        normal.filter(|normal| normal.dot(&through) > ABREAST).unwrap_or(*along)
    }

    fn outward(&self, way: &Way, at: usize) -> Option<Vector> {
        let length = self.parameters.direction_length;
        let far = way.ahead(at, length);
        let lacking = length - (way.arc[far] - way.arc[at]);
        // A gateway at the rim of the window is measured on what is left of its way, and on the approach.
        let near = if lacking > length / 2.0 {
            way.arc.partition_point(|&s| s < way.arc[far] - length / 2.0)
        } else {
            at
        };
        way.direction(near.min(at), far)
    }

    /// The closest obstacles left and right; a missing one is put at the comfort distance.
    fn ends(&self, way: &Way, at: usize, outward: &Vector) -> [Point; 2] {
        let resolution = self.distance.info().resolution;
        let comfort_distance = self.skeleton.comfort_distance;
        let slack = (comfort_distance - way.clearance[at]).max(2.0 * resolution).min(0.5);
        let sides = self.distance.sides(way.cells[at], outward, slack, ABREAST);
        let here = way.points[at];
        let left = Vector::new(-outward.y, outward.x) * comfort_distance;
        let point = |cell| local(cell, resolution);
        [sides.left.map_or(here + left, point), sides.right.map_or(here - left, point)]
    }

    /// Samples every quarter metre of the way up to the comfort distance beyond the gateway.
    fn beyond(&self, way: &Way, at: usize) -> Vec<Beyond> {
        let info = self.distance.info();
        let comfort_distance = self.skeleton.comfort_distance;
        let count = (comfort_distance / 0.25).floor() as usize;
        let mut indices: Vec<usize> = (0..=count).map(|k| way.ahead(at, 0.25 * k as f64)).collect();
        indices.dedup();
        let sample = |i: usize| {
            let along = self.outward(way, i).unwrap_or_else(Vector::zeros);
            let slack = (comfort_distance - way.clearance[i]).max(2.0 * info.resolution);
            let sides = self.distance.sides(way.cells[i], &along, slack, ABREAST);
            let close = way.clearance[i] <= comfort_distance + info.resolution;
            Beyond {
                at: info.origin.transform_point(&way.points[i]),
                left: close && sides.left.is_some(),
                right: close && sides.right.is_some(),
                clearance: way.clearance[i],
            }
        };
        indices.into_iter().map(sample).collect()
    }
}
