//! The middle of the place at or next to a point: where the robot stands, or where the middle was found before.

use crate::gateway::GatewayParameters;
use crate::gateway::way::Way;
use crate::geometry::Point;
use crate::grid::{CellIndex, DistanceField, NodeKind, SkeletonGraph};
use petgraph::graph::NodeIndex;

/// How much of a way on either side of the point decides whether it bends, metres.
const BEND_SIGHT: f64 = 6.0;

/// The middle of the place: the junction whose circle of clearance holds the point or is nearest to it, with the
/// greatest clearance among such, or the widest point of a bend of the way beside the point, if that is nearer and
/// its circle does not meet that of the junction; without either in reach, the widest point of that way.
pub(super) fn place_center(
    graph: &mut SkeletonGraph,
    distance: &DistanceField,
    near: &Point,
    parameters: &GatewayParameters,
) -> Option<NodeIndex> {
    let way = nearest_way(graph, distance, near)?;
    let bend = way.bend(distance, near, parameters);
    let junction = junction(graph, distance, near, parameters);
    let before = |bend: CellIndex, node: NodeIndex| {
        let junction = graph.graph[node].cell;
        let between = (distance.info().center(junction) - distance.info().center(bend)).norm();
        let meet = between < distance.clearance(junction) + distance.clearance(bend);
        !meet && gap(distance, bend, near) < gap(distance, junction, near)
    };
    match junction {
        Some(node) if bend.is_none_or(|bend| !before(bend, node)) => Some(climb(graph, distance, node)),
        _ => {
            let cell = bend.or_else(|| way.middle(distance, parameters))?;
            graph.ensure_node(cell, distance)
        }
    }
}

/// Distance from a point to the circle of clearance around a cell; 0 inside.
fn gap(distance: &DistanceField, cell: CellIndex, near: &Point) -> f64 {
    ((distance.info().center(cell) - near).norm() - distance.clearance(cell)).max(0.0)
}

fn junction(
    graph: &SkeletonGraph,
    distance: &DistanceField,
    near: &Point,
    parameters: &GatewayParameters,
) -> Option<NodeIndex> {
    let place = |kind: NodeKind| matches!(kind, NodeKind::Junction | NodeKind::DeadEnd | NodeKind::Room);
    let nodes = graph.graph.node_indices().filter(|&n| place(graph.graph[n].kind));
    let near = nodes.map(|n| (gap(distance, graph.graph[n].cell, near), graph.graph[n].clearance, n));
    let near = near.filter(|&(gap, ..)| gap <= parameters.place_reach);
    near.min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1))).map(|(_, _, n)| n)
}

/// The widest of the junctions that lie in one another's circles of clearance: they are one place.
fn climb(graph: &SkeletonGraph, distance: &DistanceField, start: NodeIndex) -> NodeIndex {
    let info = distance.info();
    let mut best = start;
    loop {
        let (here, radius) = (info.center(graph.graph[best].cell), graph.graph[best].clearance);
        let better = graph.graph.node_indices().filter(|&n| {
            let node = &graph.graph[n];
            let inside = (info.center(node.cell) - here).norm() < radius;
            matches!(node.kind, NodeKind::Junction | NodeKind::Room) && node.clearance > radius && inside
        });
        match better.max_by(|&a, &b| graph.graph[a].clearance.total_cmp(&graph.graph[b].clearance)) {
            Some(next) => best = next,
            None => return best,
        }
    }
}

/// The way beside a point.
struct Beside {
    way: Way,
    /// Index of the cell nearest to the point.
    at: usize,
}

/// The edge of the skeleton that comes nearest to a point.
fn nearest_way(graph: &SkeletonGraph, distance: &DistanceField, near: &Point) -> Option<Beside> {
    let away = |cell: CellIndex| (distance.info().center(cell) - near).norm();
    let nearest = |cells: &[CellIndex]| cells.iter().map(|&c| away(c)).fold(f64::INFINITY, f64::min);
    let edge = graph.graph.edge_weights().min_by(|a, b| nearest(&a.cells).total_cmp(&nearest(&b.cells)))?;
    let way = Way::new(edge.cells.clone(), distance);
    let at = (0..way.cells.len()).min_by(|&a, &b| away(way.cells[a]).total_cmp(&away(way.cells[b])))?;
    Some(Beside { way, at })
}

impl Beside {
    /// The widest cell of a bend in reach of the point.
    fn bend(
        &self,
        distance: &DistanceField,
        near: &Point,
        parameters: &GatewayParameters,
    ) -> Option<CellIndex> {
        let bend = bend(&self.way, self.at, parameters)?;
        let reached = gap(distance, self.way.cells[bend], near) <= parameters.place_reach;
        reached.then(|| self.widest(bend, 1.0, distance)).flatten()
    }

    /// The widest cell in reach along the way.
    fn middle(&self, distance: &DistanceField, parameters: &GatewayParameters) -> Option<CellIndex> {
        self.widest(self.at, parameters.place_reach, distance)
    }

    fn widest(&self, at: usize, reach: f64, distance: &DistanceField) -> Option<CellIndex> {
        widest_near(&self.way, at, reach, distance.info().resolution).map(|at| self.way.cells[at])
    }
}

/// The point of a way that swings out furthest from the chord of the stretch in sight, if it is a bend.
fn bend(way: &Way, beside: usize, parameters: &GatewayParameters) -> Option<usize> {
    let first = way.arc.partition_point(|&s| s < way.arc[beside] - BEND_SIGHT);
    let last = way.ahead(beside, BEND_SIGHT);
    let chord = (way.points[last] - way.points[first]).try_normalize(0.0)?;
    let swing = |i: usize| chord.perp(&(way.points[i] - way.points[first])).abs();
    let furthest = (first..=last).max_by(|&a, &b| swing(a).total_cmp(&swing(b)))?;
    (swing(furthest) >= parameters.bend).then_some(furthest)
}

/// The widest point within `reach` of `middle` along the way; of those within a cell of the widest, the nearest.
fn widest_near(way: &Way, middle: usize, reach: f64, resolution: f64) -> Option<usize> {
    let first = way.arc.partition_point(|&s| s < way.arc[middle] - reach);
    let near = first..=way.ahead(middle, reach);
    let most = near.clone().map(|i| way.clearance[i]).fold(0.0, f64::max);
    near.filter(|&i| way.clearance[i] >= most - resolution).min_by_key(|&i| i.abs_diff(middle))
}
