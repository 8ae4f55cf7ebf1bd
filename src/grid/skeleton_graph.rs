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

/// What a cell is while the graph is built.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    /// Not a cell of the skeleton.
    Nothing,
    Chain,
    /// Of a chain that was followed.
    Walked,
    /// Of a junction that is not a node yet.
    Crossing,
    Node(NodeIndex),
}

struct Builder<'a> {
    distance: &'a DistanceField,
    /// The smallest part of the grid that holds the skeleton, in a frame of one cell that makes every neighbourhood
    /// complete: its first cell within the frame, and its columns.
    corner: CellIndex,
    stride: usize,
    /// The cells of the skeleton by their positions in that part, ascending.
    places: Vec<usize>,
    /// By position.
    owner: Vec<Owner>,
    graph: UnGraph<SkeletonNode, SkeletonEdge>,
}

impl<'a> Builder<'a> {
    fn new(skeleton: &Skeleton, distance: &'a DistanceField) -> Self {
        let cells = &skeleton.cells[..];
        let span = |of: fn(&CellIndex) -> usize| {
            let first = cells.iter().map(of).min().unwrap_or(0);
            (first, cells.iter().map(of).max().map_or(0, |last| last + 1 - first))
        };
        let ((x, width), (y, height)) = (span(|cell| cell.x), span(|cell| cell.y));
        let (corner, stride) = (CellIndex { x, y }, width + 2);
        let owner = vec![Owner::Nothing; stride * (height + 2)];
        let mut builder =
            Builder { distance, corner, stride, places: Vec::new(), owner, graph: UnGraph::default() };
        builder.places = cells.iter().map(|&cell| builder.place(cell)).collect();
        builder.places.iter().for_each(|&place| builder.owner[place] = Owner::Chain);
        builder
    }

    /// The position of a cell of the skeleton.
    fn place(&self, cell: CellIndex) -> usize {
        (cell.y - self.corner.y + 1) * self.stride + cell.x - self.corner.x + 1
    }

    /// The inverse of `place`.
    fn cell(&self, place: usize) -> CellIndex {
        let (x, y) = (place % self.stride, place / self.stride);
        CellIndex { x: x + self.corner.x - 1, y: y + self.corner.y - 1 }
    }

    /// Cells of the skeleton around one of them, those that share a side first.
    fn around(&self, place: usize) -> impl Iterator<Item = usize> + use<'_, 'a> {
        let (stride, owner) = (self.stride, &self.owner);
        let sides = [place + 1, place + stride, place - 1, place - stride];
        let corners = [place + stride + 1, place + stride - 1, place - stride - 1, place - stride + 1];
        sides.into_iter().chain(corners).filter(|&next| owner[next] != Owner::Nothing)
    }

    fn add_nodes(&mut self, skeleton: &Skeleton) {
        let mut add = |kind, cells: &[CellIndex]| {
            cells.iter().for_each(|&cell| self.add_node(kind, &[self.place(cell)]));
        };
        add(NodeKind::Exit, &skeleton.exits);
        add(NodeKind::Room, &skeleton.rooms);
        add(NodeKind::DeadEnd, skeleton.dead_end.as_slice());
        let crosses = |&&place: &&usize| self.owner[place] == Owner::Chain && self.around(place).count() > 2;
        let crossings: Vec<usize> = self.places.iter().filter(crosses).copied().collect();
        crossings.iter().for_each(|&place| self.owner[place] = Owner::Crossing);
        for place in crossings {
            if self.owner[place] == Owner::Crossing {
                let cluster = self.cluster(place);
                self.add_node(NodeKind::Junction, &cluster);
            }
        }
    }

    /// The cells of a junction, from one of them on, which are taken for those of a chain from then on.
    fn cluster(&mut self, first: usize) -> Vec<usize> {
        self.owner[first] = Owner::Chain;
        let mut cluster = vec![first];
        let mut next = 0;
        while next < cluster.len() {
            let begun = cluster.len();
            cluster.extend(self.around(cluster[next]).filter(|&other| self.owner[other] == Owner::Crossing));
            cluster[begun..].iter().for_each(|&other| self.owner[other] = Owner::Chain);
            next += 1;
        }
        cluster
    }

    fn add_node(&mut self, kind: NodeKind, places: &[usize]) {
        let clearance = |place: &usize| self.distance.clearance(self.cell(*place));
        let widest = places.iter().copied().reduce(|a, b| if clearance(&b) > clearance(&a) { b } else { a });
        let Some(widest) = widest else { return };
        let (cell, clearance) = (self.cell(widest), clearance(&widest));
        let node = self.graph.add_node(SkeletonNode { kind, cell, clearance });
        places.iter().for_each(|&place| self.owner[place] = Owner::Node(node));
    }

    fn add_edges(&mut self) {
        for place in std::mem::take(&mut self.places) {
            let Owner::Node(node) = self.owner[place] else { continue };
            let around: Vec<usize> = self.around(place).collect();
            for next in around {
                match self.owner[next] {
                    Owner::Chain => self.walk(node, place, next),
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
    fn walk(&mut self, node: NodeIndex, from: usize, first: usize) {
        let mut cells = vec![self.graph[node].cell];
        let (mut before, mut at) = (from, first);
        loop {
            self.owner[at] = Owner::Walked;
            cells.push(self.cell(at));
            let end = |next: usize| match self.owner[next] {
                Owner::Node(other) if next != before && !(other == node && cells.len() == 2) => Some(other),
                _ => None,
            };
            let end = self.around(at).find_map(end);
            if let Some(other) = end {
                cells.push(self.graph[other].cell);
                self.graph.add_edge(node, other, edge_of(self.distance.info(), cells));
                return;
            }
            let Some(next) = self.around(at).find(|&next| self.owner[next] == Owner::Chain) else { return };
            (before, at) = (at, next);
        }
    }
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
