//! The skeleton as a graph: junctions, ends and exits, joined by chains of cells.

use crate::grid::{CellIndex, DistanceField, GridInfo, Skeleton};
use petgraph::graph::{EdgeIndex, NodeIndex, UnGraph};
use petgraph::visit::EdgeRef;

/// What a node of the skeleton is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Three or more ways meet.
    Junction,
    /// The only way ends here.
    DeadEnd,
    /// A way leaves the window.
    Exit,
    /// The widest point of a room that ends inside the window.
    Room,
    /// A point of interest on a way.
    Waypoint,
}

/// A node of the skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonNode {
    /// What it is.
    pub kind: NodeKind,
    /// Where it is; for a junction of several cells the one of greatest clearance.
    pub cell: CellIndex,
    /// Distance to the nearest obstacle there, metres.
    pub clearance: f64,
}

/// A way between two nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct SkeletonEdge {
    /// The cells from the edge's source to its target, both included.
    pub cells: Vec<CellIndex>,
    /// Length of the chain, metres.
    pub length: f64,
}

/// The skeleton of free space as a graph.
#[derive(Clone, Debug)]
pub struct SkeletonGraph {
    /// The graph. It may have loops and parallel edges, around obstacles.
    pub graph: UnGraph<SkeletonNode, SkeletonEdge>,
    info: GridInfo,
}

impl SkeletonGraph {
    /// The graph of a skeleton. Nodes are exits, rooms, the dead end and then junctions, each in row-major order of their
    /// first cells; edges go by the nodes' cells in that order.
    pub fn new(skeleton: &Skeleton, distance: &DistanceField) -> Self {
        let mut builder = Builder::new(skeleton, distance);
        builder.add_nodes(skeleton);
        builder.add_edges();
        SkeletonGraph { graph: builder.graph, info: *distance.info() }
    }

    /// The node at a cell of the skeleton, made by parting an edge if there is none.
    /// Nothing if the cell is not on the skeleton.
    pub fn ensure_node(&mut self, cell: CellIndex, distance: &DistanceField) -> Option<NodeIndex> {
        if let Some(node) = self.graph.node_indices().find(|&n| self.graph[n].cell == cell) {
            return Some(node);
        }
        let holds = |&e: &EdgeIndex| self.graph[e].cells.contains(&cell);
        let edge = self.graph.edge_indices().find(holds)?;
        let (source, target) = self.graph.edge_endpoints(edge)?;
        let cells = self.graph.remove_edge(edge)?.cells;
        let at = cells.iter().position(|&c| c == cell)?;
        let clearance = distance.clearance(cell);
        let node = self.graph.add_node(SkeletonNode { kind: NodeKind::Waypoint, cell, clearance });
        self.graph.add_edge(source, node, edge_of(&self.info, cells[..=at].to_vec()));
        self.graph.add_edge(node, target, edge_of(&self.info, cells[at..].to_vec()));
        Some(node)
    }

    /// The shortest way along the skeleton from a node to every exit and room that can be reached, as cells from the
    /// node to there; ordered by node indices.
    pub fn ways_out(&self, from: NodeIndex) -> Vec<Vec<CellIndex>> {
        let arrivals = self.arrivals(from);
        let exits = self.graph.node_indices().filter(|&n| n != from && self.leads_on(n));
        exits.filter_map(|exit| self.way(from, exit, &arrivals)).collect()
    }

    fn leads_on(&self, node: NodeIndex) -> bool {
        matches!(self.graph[node].kind, NodeKind::Exit | NodeKind::Room)
    }

    /// For every node, the edge by which the shortest way from `from` arrives (Dijkstra).
    fn arrivals(&self, from: NodeIndex) -> Vec<Option<EdgeIndex>> {
        let count = self.graph.node_count();
        let (mut length, mut done) = (vec![f64::INFINITY; count], vec![false; count]);
        let mut arrivals = vec![None; count];
        length[from.index()] = 0.0;
        let nearest = |length: &[f64], done: &[bool]| {
            let open = (0..count).filter(|&n| !done[n] && length[n].is_finite());
            open.min_by(|&a, &b| length[a].total_cmp(&length[b]))
        };
        while let Some(n) = nearest(&length, &done) {
            done[n] = true;
            for edge in self.graph.edges(NodeIndex::new(n)) {
                let next = edge.target().index();
                let reach = length[n] + edge.weight().length;
                if reach < length[next] {
                    length[next] = reach;
                    arrivals[next] = Some(edge.id());
                }
            }
        }
        arrivals
    }

    fn way(
        &self,
        from: NodeIndex,
        exit: NodeIndex,
        arrivals: &[Option<EdgeIndex>],
    ) -> Option<Vec<CellIndex>> {
        let mut way = vec![self.graph[exit].cell];
        let mut at = exit;
        while at != from {
            let edge = arrivals[at.index()]?;
            let (source, target) = self.graph.edge_endpoints(edge)?;
            let cells = &self.graph[edge].cells;
            if target == at {
                way.extend(cells.iter().rev().skip(1));
                at = source;
            } else {
                way.extend(cells.iter().skip(1));
                at = target;
            }
        }
        way.reverse();
        Some(way)
    }
}

fn edge_of(info: &GridInfo, cells: Vec<CellIndex>) -> SkeletonEdge {
    let step = |pair: &[CellIndex]| {
        let (dx, dy) = (pair[0].x.abs_diff(pair[1].x) as f64, pair[0].y.abs_diff(pair[1].y) as f64);
        dx.hypot(dy) * info.resolution
    };
    let length = cells.windows(2).map(step).sum();
    SkeletonEdge { cells, length }
}

/// What a cell of the skeleton belongs to while the graph is built.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    Nothing,
    Chain,
    Node(NodeIndex),
}

struct Builder<'a> {
    distance: &'a DistanceField,
    cells: &'a [CellIndex],
    /// The smallest part of the grid that holds the skeleton: its first cell, and its columns.
    corner: CellIndex,
    width: usize,
    owner: Vec<Owner>,
    graph: UnGraph<SkeletonNode, SkeletonEdge>,
}

impl<'a> Builder<'a> {
    fn new(skeleton: &'a Skeleton, distance: &'a DistanceField) -> Self {
        let cells = &skeleton.cells[..];
        let span = |of: fn(&CellIndex) -> usize| {
            let first = cells.iter().map(of).min().unwrap_or(0);
            (first, cells.iter().map(of).max().map_or(0, |last| last + 1 - first))
        };
        let ((x, width), (y, height)) = (span(|cell| cell.x), span(|cell| cell.y));
        let owner = vec![Owner::Nothing; width * height];
        let corner = CellIndex { x, y };
        let mut builder = Builder { distance, cells, corner, width, owner, graph: UnGraph::default() };
        for &cell in cells {
            let place = builder.place(cell);
            builder.owner[place] = Owner::Chain;
        }
        builder
    }

    /// The position of a cell of the skeleton.
    fn place(&self, cell: CellIndex) -> usize {
        (cell.y - self.corner.y) * self.width + cell.x - self.corner.x
    }

    fn around(&self, cell: CellIndex) -> impl Iterator<Item = CellIndex> + '_ {
        let info = self.distance.info();
        info.neighbors(cell, true).filter(|&next| self.owner_of(next) != Owner::Nothing)
    }

    fn owner_of(&self, cell: CellIndex) -> Owner {
        let beside = cell.x < self.corner.x || cell.y < self.corner.y || cell.x >= self.corner.x + self.width;
        if beside {
            return Owner::Nothing;
        }
        self.owner.get(self.place(cell)).copied().unwrap_or(Owner::Nothing)
    }

    fn add_node(&mut self, kind: NodeKind, cells: &[CellIndex]) {
        let clearance = |cell: &CellIndex| self.distance.clearance(*cell);
        let widest = cells.iter().copied().reduce(|a, b| if clearance(&b) > clearance(&a) { b } else { a });
        let Some(cell) = widest else { return };
        let node = self.graph.add_node(SkeletonNode { kind, cell, clearance: clearance(&cell) });
        for &member in cells {
            let place = self.place(member);
            self.owner[place] = Owner::Node(node);
        }
    }

    fn add_nodes(&mut self, skeleton: &Skeleton) {
        skeleton.exits.iter().for_each(|&cell| self.add_node(NodeKind::Exit, &[cell]));
        skeleton.rooms.iter().for_each(|&cell| self.add_node(NodeKind::Room, &[cell]));
        skeleton.dead_end.iter().for_each(|&cell| self.add_node(NodeKind::DeadEnd, &[cell]));
        let crossing: Vec<bool> = self.cells.iter().map(|&cell| self.around(cell).count() > 2).collect();
        let crosses =
            |cell: CellIndex| self.cells.binary_search_by_key(&key(cell), |&c| key(c)).map(|i| crossing[i]);
        let mut clusters = Vec::new();
        let mut seen = std::collections::BTreeSet::new();
        for (&cell, _) in self.cells.iter().zip(&crossing).filter(|(_, crossing)| **crossing) {
            if self.owner_of(cell) != Owner::Chain || !seen.insert(key(cell)) {
                continue;
            }
            let mut cluster = vec![cell];
            let mut next = 0;
            while next < cluster.len() {
                for other in self.around(cluster[next]) {
                    let joins = self.owner_of(other) == Owner::Chain && crosses(other) == Ok(true);
                    if joins && seen.insert(key(other)) {
                        cluster.push(other);
                    }
                }
                next += 1;
            }
            clusters.push(cluster);
        }
        clusters.iter().for_each(|cluster| self.add_node(NodeKind::Junction, cluster));
    }

    fn add_edges(&mut self) {
        let mut walked = vec![false; self.owner.len()];
        for &cell in self.cells {
            let Owner::Node(node) = self.owner_of(cell) else { continue };
            let around: Vec<CellIndex> = self.around(cell).collect();
            for next in around {
                match self.owner_of(next) {
                    Owner::Chain if !walked[self.place(next)] => {
                        self.walk(node, cell, next, &mut walked);
                    }
                    Owner::Node(other) if node < other && self.graph.find_edge(node, other).is_none() => {
                        let cells = vec![self.graph[node].cell, self.graph[other].cell];
                        self.graph.add_edge(node, other, edge_of(self.distance.info(), cells));
                    }
                    _ => {}
                }
            }
        }
    }

    /// Follows a chain from a node's cell to the node at its other end and adds the edge.
    fn walk(&mut self, node: NodeIndex, cell: CellIndex, first: CellIndex, walked: &mut [bool]) {
        let info = self.distance.info();
        let mut cells = vec![self.graph[node].cell];
        let (mut before, mut at) = (cell, first);
        loop {
            walked[self.place(at)] = true;
            cells.push(at);
            let fresh = |next: &CellIndex| match self.owner_of(*next) {
                Owner::Node(other) => *next != before && !(other == node && cells.len() == 2),
                _ => *next != before && !walked[self.place(*next)],
            };
            let nodes = |next: &CellIndex| matches!(self.owner_of(*next), Owner::Node(_));
            let ahead: Vec<CellIndex> = self.around(at).filter(fresh).collect();
            let Some(&next) = ahead.iter().find(|next| nodes(next)).or(ahead.first()) else { return };
            if let Owner::Node(other) = self.owner_of(next) {
                cells.push(self.graph[other].cell);
                self.graph.add_edge(node, other, edge_of(info, cells));
                return;
            }
            (before, at) = (at, next);
        }
    }
}

fn key(cell: CellIndex) -> (usize, usize) {
    (cell.y, cell.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Pose};
    use crate::grid::{SkeletonParameters, Surroundings, skeletonize};
    use crate::worlds::drawing::{Drawing, window};

    fn graph(plan: &Drawing) -> (SkeletonGraph, DistanceField) {
        let grid = plan.render(&window(16.0, 0.1, Point::origin(), 0.2), &Point::origin()).unwrap();
        let distance = DistanceField::new(&grid);
        let skeleton =
            skeletonize(&grid, &distance, &Surroundings::of(Point::origin()), &SkeletonParameters::default())
                .unwrap();
        (SkeletonGraph::new(&skeleton, &distance), distance)
    }

    fn kinds(graph: &SkeletonGraph, kind: NodeKind) -> usize {
        graph.graph.node_weights().filter(|node| node.kind == kind).count()
    }

    #[test]
    fn a_tee_has_one_junction_and_three_ways() {
        let tee =
            Drawing::new().corridor((-16.0, 0.0), (16.0, 0.0), 2.0).corridor((0.0, 0.0), (0.0, -16.0), 2.0);
        let (graph, _) = graph(&tee);
        assert_eq!((kinds(&graph, NodeKind::Junction), kinds(&graph, NodeKind::Exit)), (1, 3));
        assert_eq!(graph.graph.edge_count(), 3);
        let junction =
            graph.graph.node_indices().find(|&n| graph.graph[n].kind == NodeKind::Junction).unwrap();
        assert_eq!(graph.ways_out(junction).len(), 3);
    }

    #[test]
    fn a_block_gives_a_loop_with_two_ways_around() {
        let ring = Drawing::new().corridor((-16.0, 0.0), (16.0, 0.0), 2.0).room((-4.0, -4.0), (4.0, 4.0));
        let ring = ring.block((-2.0, -2.0), (2.0, 2.0)).moved(&Pose::new(-3.0, 0.0, 0.0));
        let (graph, _) = graph(&ring);
        assert_eq!((kinds(&graph, NodeKind::Junction), kinds(&graph, NodeKind::Exit)), (2, 2));
        assert_eq!(graph.graph.edge_count(), 4);
    }

    #[test]
    fn parting_an_edge_keeps_its_length() {
        let (mut graph, distance) = graph(&Drawing::new().corridor((-16.0, 0.0), (16.0, 0.0), 2.0));
        let length = |graph: &SkeletonGraph| graph.graph.edge_weights().map(|edge| edge.length).sum::<f64>();
        let before = length(&graph);
        let cell = graph.graph.edge_weights().next().unwrap().cells[50];
        let node = graph.ensure_node(cell, &distance).unwrap();
        assert_eq!(graph.ensure_node(cell, &distance), Some(node));
        assert!((length(&graph) - before).abs() < 1e-9);
        assert_eq!(graph.ways_out(node).len(), 2);
        assert_eq!(graph.ensure_node(CellIndex { x: 0, y: 0 }, &distance), None);
    }
}
