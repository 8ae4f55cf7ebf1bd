//! `topostar relax --growing`: a pose graph taken in pose by pose, as a robot drives.

use crate::export::GrowthReport;
use crate::geometry::Pose;
use crate::patchwork::{IncrementalGraph, PoseGraph, RelaxError, RelaxOptions};
use std::collections::BTreeMap;
use std::time::Instant;

/// A graph as far as it was taken in.
pub(super) struct Grown {
    /// The poses by then, in the order of the graph.
    pub(super) poses: Vec<Pose>,
    /// What it took.
    pub(super) report: GrowthReport,
}

impl Grown {
    /// Takes in the poses of a graph in their order, and relaxes after each what the measurements that came with it touch.
    /// The guesses of the graph are looked at only where a part begins, as a robot that drives has none. `interrupted` is
    /// asked before each pose and each factorisation.
    pub(super) fn of(
        graph: &PoseGraph,
        options: &RelaxOptions,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Grown, RelaxError> {
        let mut growing = IncrementalGraph::new(*options);
        let mut report = GrowthReport::default();
        for ((id, edges), &guess) in graph.in_order().zip(graph.guesses()) {
            if interrupted() {
                break;
            }
            let clock = Instant::now();
            growing.add_pose(id, guess)?;
            edges.into_iter().try_for_each(|edge| growing.add_edge(edge))?;
            let update = growing.relax_until(interrupted)?;
            report.took(&update, clock.elapsed().as_secs_f64());
        }
        // What was relaxed has a pose.
        let poses = growing.poses().iter().map_while(|pose| *pose).collect();
        Ok(Grown { poses, report })
    }

    /// The graph with these poses as its guesses, and without those it had. What is held stays, and the first pose of a part
    /// that is held has the part lie where it does.
    pub(super) fn placed(&self, graph: &PoseGraph) -> PoseGraph {
        let (parts, held) = (graph.parts(), graph.held());
        let held = |pose: usize| graph.guesses()[pose].filter(|_| held[pose]);
        let mut moves: BTreeMap<usize, Pose> = BTreeMap::new();
        for (pose, grown) in self.poses.iter().enumerate() {
            if let Some(at) = held(pose) {
                moves.entry(parts[pose]).or_insert_with(|| at.compose(&grown.inverse()));
            }
        }
        let lies = |(pose, grown): (usize, &Pose)| {
            let moved = moves.get(&parts[pose]).map_or(*grown, |by| by.compose(grown));
            held(pose).unwrap_or(moved)
        };
        let poses: Vec<Pose> = self.poses.iter().enumerate().map(lies).collect();
        graph.without_guesses().with_guesses(&poses)
    }
}
