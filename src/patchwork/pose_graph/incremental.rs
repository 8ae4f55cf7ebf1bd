//! A pose graph that is kept relaxed while it grows.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::RelaxError;
use crate::patchwork::pose_graph::blocks::Neighbours;
use crate::patchwork::pose_graph::graph::{Edge, GraphError, PoseGraph, PoseId};
use crate::patchwork::pose_graph::relax::{RelaxOptions, Relaxer, Start};
use crate::patchwork::pose_graph::relaxation::Outcome;

/// A pose graph with its relaxed poses. What is added is relaxed on demand, and only what it touches: the loops through
/// it; what hangs on them follows as it is, without strain.
#[derive(Clone, Debug)]
pub struct IncrementalGraph {
    options: RelaxOptions,
    graph: PoseGraph,
    /// The relaxed pose of each, where it has one yet.
    poses: Vec<Option<Pose>>,
    neighbours: Neighbours,
    /// How many of the edges have been relaxed.
    settled: usize,
    /// How many of the poses, from the first on, have been placed.
    placed: usize,
}

/// What it took to take in what was added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Update {
    /// Poses that had to be relaxed.
    pub relaxed: usize,
    /// Steps, each with a factorisation for those poses alone.
    pub iterations: usize,
    /// How it ended.
    pub outcome: Outcome,
}

/// Chi-square of an edge that asks for nothing: a millionth of a standard deviation.
const AGREES: f64 = 1e-12;

impl IncrementalGraph {
    /// No poses yet.
    pub fn new(options: RelaxOptions) -> Self {
        IncrementalGraph {
            options,
            graph: PoseGraph::new(),
            poses: vec![],
            neighbours: Neighbours::default(),
            settled: 0,
            placed: 0,
        }
    }

    /// Adds a pose, see [`PoseGraph::add_pose`].
    pub fn add_pose(&mut self, id: PoseId, guess: Option<Pose>) -> Result<(), GraphError> {
        self.graph.add_pose(id, guess)?;
        self.poses.push(None);
        self.neighbours.add_pose();
        Ok(())
    }

    /// Adds a measurement, see [`PoseGraph::add_edge`].
    pub fn add_edge(&mut self, edge: Edge) -> Result<(), GraphError> {
        let number = self.graph.edges().len() as u32;
        self.graph.add_edge(edge)?;
        self.neighbours.add_edge(self.graph.ends()[number as usize], number);
        Ok(())
    }

    /// The graph as it is.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// The relaxed poses, in the order of the graph; none for what was added since and hangs on nothing relaxed.
    pub fn poses(&self) -> &[Option<Pose>] {
        &self.poses
    }

    /// Takes in what was added. A pose at the end of a single edge costs nothing; an edge that closes a loop costs a search
    /// through its part, linear, and the relaxation of the poses on loops through it.
    pub fn relax(&mut self) -> Result<Update, RelaxError> {
        self.relax_until(&|| false)
    }

    /// The same, until `interrupted` says so, which is asked before each factorisation: then the outcome is
    /// [`Outcome::Interrupted`], and what was added is left as far as it was relaxed by then.
    pub fn relax_until(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Update, RelaxError> {
        let fresh: Vec<u32> = (self.settled..self.graph.edges().len()).map(|edge| edge as u32).collect();
        self.place(&fresh);
        let strained: Vec<u32> = fresh.into_iter().filter(|edge| self.strain(*edge) > AGREES).collect();
        let mut update = Update { relaxed: 0, iterations: 0, outcome: Outcome::Converged };
        let mut done = vec![false; self.graph.edges().len()];
        for edge in strained {
            if done[edge as usize] {
                continue;
            }
            let first = self.graph.ends()[edge as usize][0];
            let blocks = self.neighbours.blocks(first, self.graph.edges().len());
            let block = blocks[edge as usize];
            let edges: Vec<u32> = (0..).zip(&blocks).filter(|(_, b)| **b == block).map(|(e, _)| e).collect();
            edges.iter().for_each(|edge| done[*edge as usize] = true);
            let one = self.relax_block(&edges, |edge| blocks[edge as usize] == block, interrupted)?;
            update.relaxed += one.relaxed;
            update.iterations += one.iterations;
            if one.outcome != Outcome::Converged {
                update.outcome = one.outcome;
            }
        }
        self.settled = self.graph.edges().len();
        Ok(update)
    }

    /// Gives poses to what has none: its guess if it is the first of its part, else by the edges added.
    fn place(&mut self, fresh: &[u32]) {
        loop {
            let mut placed = false;
            for edge in fresh {
                let [a, b] = self.graph.ends()[*edge as usize].map(|end| end as usize);
                let measured = self.graph.edges()[*edge as usize].displacement;
                match (self.poses[a], self.poses[b]) {
                    (Some(known), None) => self.poses[b] = Some(known.compose(&measured)),
                    (None, Some(known)) => self.poses[a] = Some(known.compose(&measured.inverse())),
                    _ => continue,
                }
                placed = true;
            }
            if placed {
                continue;
            }
            while self.poses.get(self.placed).is_some_and(Option::is_some) {
                self.placed += 1;
            }
            let Some(first) = self.poses.get_mut(self.placed) else { return };
            *first = Some(self.graph.guesses()[self.placed].unwrap_or(Pose::IDENTITY));
        }
    }

    fn strain(&self, edge: u32) -> f64 {
        let [from, to] = self.graph.ends()[edge as usize].map(|end| self.poses[end as usize]);
        match (from, to) {
            (Some(from), Some(to)) => self.graph.edges()[edge as usize].strain(&from, &to).chi_square,
            _ => 0.0,
        }
    }

    /// Relaxes the poses of a block, and carries along what hangs on it. The pose through which the first pose of all hangs
    /// on the block stays where it is.
    fn relax_block(
        &mut self,
        edges: &[u32],
        inside: impl Fn(u32) -> bool,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Update, RelaxError> {
        let mut members: Vec<u32> = edges.iter().flat_map(|edge| self.graph.ends()[*edge as usize]).collect();
        members.sort_unstable();
        members.dedup();
        let carriers = self.neighbours.carriers(&members, inside);
        let root = carriers.iter().flatten().next().copied();
        members.sort_by_key(|pose| (Some(*pose) != root, *pose));
        let part = self.part(&members, edges)?;
        let answer = Relaxer::new(&part, &RelaxOptions { start: Start::Best, ..self.options })?
            .relax_until(interrupted)?;
        // What the block hangs on stays to the last bit.
        self.carry(&members[1..], &answer.poses[1..], &carriers);
        Ok(Update { relaxed: members.len() - 1, iterations: answer.iterations, outcome: answer.outcome })
    }

    /// Some poses and edges as a graph of their own, from where they are.
    fn part(&self, members: &[u32], edges: &[u32]) -> Result<PoseGraph, GraphError> {
        let mut part = PoseGraph::new();
        for pose in members {
            part.add_pose(self.graph.ids()[*pose as usize], self.poses[*pose as usize])?;
        }
        for edge in edges {
            part.add_edge(self.graph.edges()[*edge as usize])?;
        }
        Ok(part)
    }

    /// Puts poses where they are now, and what they carry along with them.
    fn carry(&mut self, members: &[u32], after: &[Pose], carriers: &[Option<u32>]) {
        let mut moved = vec![None; self.poses.len()];
        for (pose, after) in members.iter().zip(after) {
            let before = self.poses[*pose as usize].unwrap_or(*after);
            moved[*pose as usize] = Some(after.compose(&before.inverse()));
        }
        for (pose, carrier) in self.poses.iter_mut().zip(carriers) {
            let by = carrier.and_then(|carrier| moved[carrier as usize]);
            *pose = pose.zip(by).map(|(pose, by): (Pose, Pose)| by.compose(&pose)).or(*pose);
        }
        for (pose, after) in members.iter().zip(after) {
            self.poses[*pose as usize] = Some(*after);
        }
    }
}
