//! Which poses hang together, and what each part is held by.

use crate::geometry::{Point, Pose};
use crate::patchwork::pose_graph::graph::PoseGraph;
use std::collections::VecDeque;

/// Disjoint sets of poses; the least pose of each stands for it.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(count: usize) -> Sets {
        Sets((0..count as u32).collect())
    }

    pub(super) fn root(&mut self, mut node: u32) -> u32 {
        while self.0[node as usize] != node {
            let above = self.0[self.0[node as usize] as usize];
            self.0[node as usize] = above;
            node = above;
        }
        node
    }

    /// Joins two sets; whether they were two.
    pub(super) fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}

/// The part of each pose, by its first pose.
pub(super) fn parts(graph: &PoseGraph) -> Vec<u32> {
    let mut sets = Sets::new(graph.len());
    graph.ends().iter().for_each(|[a, b]| {
        sets.join(*a, *b);
    });
    (0..graph.len() as u32).map(|pose| sets.root(pose)).collect()
}

/// The poses that do not move: those held, and the first of each part without one.
pub(super) fn anchors(graph: &PoseGraph, parts: &[u32]) -> Vec<bool> {
    let mut anchored = graph.held().to_vec();
    let mut has_anchor = vec![false; graph.len()];
    for (_, part) in graph.held().iter().zip(parts).filter(|(held, _)| **held) {
        has_anchor[*part as usize] = true;
    }
    for (pose, part) in parts.iter().enumerate().filter(|(pose, part)| *pose == **part as usize) {
        anchored[pose] |= !has_anchor[*part as usize];
    }
    anchored
}

/// The origin to see each pose from: where the first pose of its part is that does not move.
pub(super) fn origins(poses: &[Pose], parts: &[u32], anchored: &[bool]) -> Vec<Point> {
    let mut origins = vec![None; poses.len()];
    for ((pose, part), _) in poses.iter().zip(parts).zip(anchored).filter(|(_, anchored)| **anchored) {
        origins[*part as usize].get_or_insert(pose.position());
    }
    // Each part has a pose that does not move.
    parts.iter().map(|part| origins[*part as usize].unwrap_or_else(Point::origin)).collect()
}

/// A value for every pose: the guess, else what measurements from the nearest known pose give.
///
/// Where some guesses are wanting, the edges that join poses next to each other in the graph's order come first, so
/// that a graph without guesses starts from its odometry. A part without any guess starts from its first pose at the
/// origin. Linear, but for sorting the edges by how many poses they pass.
pub(super) fn completed(graph: &PoseGraph, guesses: &[Option<Pose>], parts: &[u32]) -> Vec<Pose> {
    let mut known = guesses.to_vec();
    if known.iter().any(Option::is_none) {
        let mut guessed = vec![false; graph.len()];
        known.iter().zip(parts).for_each(|(pose, part)| guessed[*part as usize] |= pose.is_some());
        for first in (0..graph.len()).filter(|pose| parts[*pose] as usize == *pose && !guessed[*pose]) {
            known[first] = Some(Pose::IDENTITY);
        }
        spread(graph, &mut known, &tree(graph));
    }
    known.into_iter().map(|pose| pose.unwrap_or(Pose::IDENTITY)).collect()
}

/// A spanning forest of edges that pass few poses.
fn tree(graph: &PoseGraph) -> Vec<usize> {
    let key = |edge: &usize| {
        let [a, b] = graph.ends()[*edge];
        let measured = graph.edges()[*edge].displacement;
        let bits = [measured.x, measured.y, measured.theta].map(f64::to_bits);
        (a.abs_diff(b), a.min(b), a, bits)
    };
    let mut edges: Vec<usize> = (0..graph.edges().len()).collect();
    edges.sort_by_key(key);
    let mut sets = Sets::new(graph.len());
    edges.retain(|edge| sets.join(graph.ends()[*edge][0], graph.ends()[*edge][1]));
    edges
}

/// Carries known poses along the edges of a forest to the others, nearest first.
fn spread(graph: &PoseGraph, known: &mut [Option<Pose>], forest: &[usize]) {
    let mut edges_of = vec![Vec::new(); graph.len()];
    for &edge in forest {
        graph.ends()[edge].iter().for_each(|end| edges_of[*end as usize].push(edge));
    }
    let mut queue: VecDeque<usize> = (0..graph.len()).filter(|pose| known[*pose].is_some()).collect();
    while let Some(at) = queue.pop_front() {
        let Some(here) = known[at] else { continue };
        for &edge in &edges_of[at] {
            let [from, to] = graph.ends()[edge].map(|end| end as usize);
            let measured = &graph.edges()[edge].displacement;
            let (other, step) = if from == at { (to, *measured) } else { (from, measured.inverse()) };
            if known[other].is_none() {
                known[other] = Some(here.compose(&step));
                queue.push_back(other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patchwork::pose_graph::graph::{Edge, PoseId};
    use nalgebra::Matrix3;

    fn chain(guesses: &[Option<Pose>], edges: &[(u64, u64, f64)]) -> PoseGraph {
        let mut graph = PoseGraph::new();
        (0..).zip(guesses).for_each(|(id, guess)| graph.add_pose(PoseId(id), *guess).unwrap());
        for &(from, to, ahead) in edges {
            let displacement = Pose::new(ahead, 0.0, 0.0);
            let information = Matrix3::identity();
            graph.add_edge(Edge { from: PoseId(from), to: PoseId(to), displacement, information }).unwrap();
        }
        graph
    }

    #[test]
    fn without_guesses_poses_follow_the_odometry_and_not_the_loops() {
        let graph = chain(&[None; 5], &[(0, 3, 50.0), (1, 0, -1.0), (1, 2, 1.0), (2, 3, 1.0)]);
        let parts = parts(&graph);
        assert_eq!(parts, [0, 0, 0, 0, 4]);
        assert_eq!(anchors(&graph, &parts), [true, false, false, false, true]);
        let xs: Vec<f64> = completed(&graph, graph.guesses(), &parts).iter().map(|pose| pose.x).collect();
        assert_eq!(xs, [0.0, 1.0, 2.0, 3.0, 0.0]);
    }

    #[test]
    fn guesses_spread_to_what_has_none() {
        let last = Some(Pose::new(7.0, 0.0, 0.0));
        let mut graph = chain(&[None, None, last], &[(0, 1, 1.0), (1, 2, 1.0)]);
        graph.hold(PoseId(2)).unwrap();
        let parts = parts(&graph);
        assert_eq!(anchors(&graph, &parts), [false, false, true]);
        let xs: Vec<f64> = completed(&graph, graph.guesses(), &parts).iter().map(|pose| pose.x).collect();
        assert_eq!(xs, [5.0, 6.0, 7.0]);
    }
}
