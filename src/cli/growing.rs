//! `topostar relax --growing`: a pose graph taken in pose by pose, as a robot drives.

use crate::export::GrowthReport;
use crate::geometry::Pose;
use crate::patchwork::{IncrementalGraph, PoseGraph, RelaxError, RelaxOptions};
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
    /// The guesses of the graph are looked at only where a part begins, as a robot that drives has none. `interrupted` is asked before each pose.
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
            let update = growing.relax()?;
            report.took(update.relaxed, update.iterations, clock.elapsed().as_secs_f64());
        }
        // What was relaxed has a pose.
        let poses = growing.poses().iter().map_while(|pose| *pose).collect();
        Ok(Grown { poses, report })
    }

    /// The graph with these poses as its guesses, and without those it had. What is held stays.
    pub(super) fn placed(&self, graph: &PoseGraph) -> PoseGraph {
        let held = graph.guesses().iter().zip(graph.held()).map(|(guess, held)| guess.filter(|_| *held));
        let poses: Vec<Pose> =
            self.poses.iter().zip(held).map(|(pose, held)| held.unwrap_or(*pose)).collect();
        graph.without_guesses().with_guesses(&poses)
    }
}
