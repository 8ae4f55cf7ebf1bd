//! A relaxed pose graph as JSON.

use crate::export::strain::RelaxationOutcome;
use crate::patchwork::{Outcome, PoseGraph, Relaxation, Start, Update};
use serde::Serialize;

/// What `topostar relax --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RelaxationReport {
    /// How many poses the graph has.
    pub poses: usize,
    /// How many edges.
    pub edges: usize,
    /// The sum over edges of `e' W e`, error `e` and information `W`. In JSON null where it is beyond what a number holds:
    /// then the outcome is `overflow`, or `interrupted`, and `converged` is false.
    pub objective: f64,
    /// What was minimised: the objective, unless a robust loss was asked for. Null as the objective is.
    pub cost: f64,
    /// Numbers measured less numbers sought: what the objective is about where covariances are honest.
    pub degrees_of_freedom: usize,
    /// Steps of the descent that the answer came from.
    pub iterations: usize,
    /// Whether no step would gain anything.
    pub converged: bool,
    /// How it ended.
    pub outcome: RelaxationOutcome,
    /// Where the answer was started from: `guesses`, `odometry` or `rotations`.
    pub start: &'static str,
    /// The poses that were not moved, by number.
    pub gauge: Vec<u64>,
    /// The connected parts.
    pub parts: Vec<PartSize>,
    /// The poses that the measurements do not determine.
    pub undetermined: Vec<u64>,
    /// The most strained edges, worst first.
    pub strained: Vec<StrainedEdge>,
    /// The order in which the information was read: `g2o` or `toro`.
    pub information_order: &'static str,
    /// What is to be known of the file read, and what of it the file written cannot say.
    pub notes: Vec<String>,
    /// What it took to take the graph in pose by pose, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growing: Option<GrowthReport>,
    /// How long it took.
    pub seconds: RelaxationSeconds,
}

/// What it took to take in a graph pose by pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct GrowthReport {
    /// How many poses were taken in.
    pub poses: usize,
    /// How many of them came with measurements that asked poses to move.
    pub updates: usize,
    /// How many poses all updates together relaxed, and the largest of them.
    pub relaxed: usize,
    /// See `relaxed`.
    pub most_relaxed: usize,
    /// Steps of all updates together.
    pub iterations: usize,
    /// How many updates did not converge.
    pub not_converged: usize,
    /// How long all poses took, by the clock.
    pub seconds: f64,
    /// How long the slowest pose took.
    pub slowest: f64,
}

impl GrowthReport {
    /// One pose more, and what that took.
    pub fn took(&mut self, update: &Update, seconds: f64) {
        self.poses += 1;
        self.updates += usize::from(update.relaxed > 0);
        self.relaxed += update.relaxed;
        self.most_relaxed = self.most_relaxed.max(update.relaxed);
        self.iterations += update.iterations;
        self.not_converged += usize::from(update.outcome != Outcome::Converged);
        self.seconds += seconds;
        self.slowest = self.slowest.max(seconds);
    }
}

/// A connected part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PartSize {
    /// The number of its first pose.
    pub first: u64,
    /// How many poses it has.
    pub poses: usize,
}

/// An edge and its strain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StrainedEdge {
    /// The pose from which was measured.
    pub from: u64,
    /// The pose that was measured.
    pub to: u64,
    /// `e' W e`.
    pub chi_square: f64,
    /// How many numbers the edge measures.
    pub degrees_of_freedom: usize,
}

/// Where the time went, by the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RelaxationSeconds {
    /// Reading and checking the file.
    pub reading: f64,
    /// Ordering and symbolic analysis.
    pub setup: f64,
    /// The start and the descent.
    pub relaxing: f64,
}

/// How many strained edges are shown.
const SHOWN: usize = 10;

impl RelaxationReport {
    /// The report of a relaxation, without what only the caller knows: order, notes and times.
    pub fn of(graph: &PoseGraph, answer: &Relaxation) -> Self {
        let numbers = |ids: &[crate::patchwork::PoseId]| ids.iter().map(|id| id.0).collect();
        let part = |part: &crate::patchwork::Part| PartSize { first: part.first.0, poses: part.poses };
        RelaxationReport {
            poses: graph.len(),
            edges: graph.edges().len(),
            objective: answer.objective,
            cost: answer.cost,
            degrees_of_freedom: answer.degrees_of_freedom,
            iterations: answer.iterations,
            converged: answer.outcome == Outcome::Converged,
            outcome: answer.outcome.into(),
            start: match answer.start {
                Start::Guesses | Start::Best => "guesses",
                Start::Odometry => "odometry",
                Start::Rotations => "rotations",
            },
            gauge: numbers(&answer.gauge),
            parts: answer.parts.iter().map(part).collect(),
            undetermined: numbers(&answer.undetermined),
            strained: strained(graph, answer),
            information_order: "g2o",
            notes: vec![],
            growing: None,
            seconds: RelaxationSeconds::default(),
        }
    }
}

fn strained(graph: &PoseGraph, answer: &Relaxation) -> Vec<StrainedEdge> {
    let strains = graph.strains(&answer.poses).unwrap_or_default();
    let mut worst: Vec<usize> = (0..strains.len()).collect();
    worst.sort_by(|a, b| strains[*b].chi_square.total_cmp(&strains[*a].chi_square).then(a.cmp(b)));
    let shown = worst.into_iter().take(SHOWN);
    shown
        .map(|edge| StrainedEdge {
            from: graph.edges()[edge].from.0,
            to: graph.edges()[edge].to.0,
            chi_square: strains[edge].chi_square,
            degrees_of_freedom: strains[edge].degrees_of_freedom,
        })
        .collect()
}
