//! The answer of a relaxation: the poses, what strains them, and how it ended.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::graph::PoseId;
use crate::patchwork::pose_graph::relax::Start;

/// The answer of a relaxation.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// A pose for each of the graph, in its order, in the frame of the gauge.
    pub poses: Vec<Pose>,
    /// The strain of all edges: the sum of `e' W e`, whatever the loss. Infinite or no number only where the outcome is
    /// [`Outcome::Overflow`], or where it was interrupted before that could be known.
    pub objective: f64,
    /// What was minimised, at these poses: the sum of the losses; the objective, if none was chosen.
    pub cost: f64,
    /// Steps taken from the start that the answer came from.
    pub iterations: usize,
    /// How it ended.
    pub outcome: Outcome,
    /// Where the answer was started from: never [`Start::Best`].
    pub start: Start,
    /// All descents, in order.
    pub trials: Vec<Trial>,
    /// The poses that were not moved: those held, and the first of each part without one. They are the gauge.
    pub gauge: Vec<PoseId>,
    /// The connected parts. Nothing is known of one part's place in another.
    pub parts: Vec<Part>,
    /// The poses that the measurements do not determine, though edges connect them.
    pub undetermined: Vec<PoseId>,
    /// Numbers measured less numbers sought.
    pub degrees_of_freedom: usize,
}

/// A connected part of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its first pose.
    pub first: PoseId,
    /// How many poses it has.
    pub poses: usize,
}

/// A descent from one start.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Where it began.
    pub start: Start,
    /// The cost there, and after each step taken. Never rises.
    pub costs: Vec<f64>,
    /// How it ended.
    pub outcome: Outcome,
}

/// How relaxation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// No step would gain more than the tolerance.
    Converged,
    /// There were more steps to take than allowed.
    OutOfIterations,
    /// The caller said so, or time was up: the poses are the best found by then.
    Interrupted,
    /// Rounding keeps the cost above the least: no step lowers it by what the equations promise, or the poses as given, whose
    /// numbers have so many digits, strain more than those found. Numbers are too large or too far apart.
    Stalled,
    /// The cost is beyond what a number holds, from every start tried: measurements or information are absurdly large.
    Overflow,
}
