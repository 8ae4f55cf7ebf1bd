//! Relaxation: the poses of least strain, by Gauss and Newton's method with damping.

use crate::geometry::{Point, Pose};
use crate::patchwork::pose_graph::RelaxError;
use crate::patchwork::pose_graph::descent::{Descended, Descent};
use crate::patchwork::pose_graph::graph::{PoseGraph, PoseId};
use crate::patchwork::pose_graph::loss::Loss;
use crate::patchwork::pose_graph::parts::{anchors, completed, origins, parts};
use crate::patchwork::pose_graph::problem::{Problem, State};
use crate::patchwork::pose_graph::relaxation::{Outcome, Part, Relaxation, Trial};
use crate::patchwork::pose_graph::singular::{free_nodes, is_sound, shift};
use crate::patchwork::pose_graph::start::rotation_first;
use crate::patchwork::pose_graph::strain::rank;
use crate::patchwork::pose_graph::structure::{NOWHERE, Structure};
use crate::patchwork::pose_graph::system::System;
use nalgebra::Matrix3;

/// How to relax.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxOptions {
    /// Where to start.
    pub start: Start,
    /// What an edge costs.
    pub loss: Loss,
    /// Relaxation has converged where a step would gain less than this share of the cost. Default 1e-9.
    pub tolerance: f64,
    /// How many steps are taken at most, from each start. Default 200.
    pub max_iterations: usize,
}

impl Default for RelaxOptions {
    fn default() -> Self {
        RelaxOptions { start: Start::Best, loss: Loss::Squared, tolerance: 1e-9, max_iterations: 200 }
    }
}

/// Where relaxation starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At the guesses; where they are wanting, along the edges from those that are there, odometry first.
    Guesses,
    /// As if there were no guesses: along the odometry.
    Odometry,
    /// At headings and then positions found from the measurements alone: no guess is so bad that it does harm.
    Rotations,
    /// At that of the above which costs least; and if what it leads to is unlikely, from the others too.
    Best,
}

/// A pose graph made ready: ordered, its normal equations analysed.
#[derive(Debug)]
pub struct Relaxer {
    options: RelaxOptions,
    problem: Problem,
    ids: Vec<PoseId>,
    parts: Vec<u32>,
    anchored: Vec<bool>,
    degrees_of_freedom: usize,
    /// The node of each pose in the order of elimination; nowhere for one that is not moved.
    nodes: Vec<u32>,
    structure: Structure,
    system: System<3>,
    /// The poses to begin with.
    given: Vec<Pose>,
    /// Where the states of each pose are seen from: a pose of its part that is held.
    origins: Vec<Point>,
    guesses: Vec<State>,
    odometry: Vec<State>,
    /// Where the last relaxation ended.
    states: Vec<State>,
    /// Whether each pose can move without strain.
    undetermined: Vec<bool>,
    /// Whether the factor is that of the states, undamped but for what is undetermined.
    factorized: bool,
}

/// Relaxes a pose graph. Fails only where memory does: everything else is told in the answer.
pub fn relax(graph: &PoseGraph, options: &RelaxOptions) -> Result<Relaxation, RelaxError> {
    relax_until(graph, options, &|| false)
}

/// The same, until `interrupted` says so, which is asked before each factorisation: then the outcome is
/// [`Outcome::Interrupted`], and the poses are the best found by then.
pub fn relax_until(
    graph: &PoseGraph,
    options: &RelaxOptions,
    interrupted: &dyn Fn() -> bool,
) -> Result<Relaxation, RelaxError> {
    Relaxer::new(graph, options)?.relax_until(interrupted)
}

impl Relaxer {
    /// Orders a graph and analyses its normal equations: near linear in poses and edges, but for the fill.
    pub fn new(graph: &PoseGraph, options: &RelaxOptions) -> Result<Relaxer, RelaxError> {
        let problem = Problem::new(graph, options.loss);
        let parts = parts(graph);
        let anchored = anchors(graph, &parts);
        let (nodes, structure) = eliminated(&problem, &anchored)?;
        let given = completed(graph, graph.guesses(), &parts);
        let origins = origins(&given, &parts, &anchored);
        let states = |poses: &[Pose]| -> Vec<State> {
            poses.iter().zip(&origins).map(|(pose, origin)| State::of(pose, origin)).collect()
        };
        let odometry = if options.start == Start::Odometry {
            let known = graph.guesses().iter().zip(&anchored);
            let known: Vec<Option<Pose>> = known.map(|(guess, held)| guess.filter(|_| *held)).collect();
            states(&completed(graph, &known, &parts))
        } else {
            vec![]
        };
        let guesses = states(&given);
        let measured: usize = graph.edges().iter().map(|edge| rank(&edge.information)).sum();
        Ok(Relaxer {
            options: *options,
            problem,
            ids: graph.ids().to_vec(),
            parts,
            anchored,
            degrees_of_freedom: measured.saturating_sub(3 * structure.nodes()),
            nodes,
            system: System::new(&structure)?,
            structure,
            states: guesses.clone(),
            given,
            origins,
            guesses,
            odometry,
            undetermined: vec![false; graph.len()],
            factorized: false,
        })
    }

    /// Relaxes from the start chosen. A step costs a factorisation, for planar graphs about `n^1.5`.
    pub fn relax(&mut self) -> Result<Relaxation, RelaxError> {
        self.relax_until(&|| false)
    }

    /// The same, until `interrupted` says so, which is asked before each factorisation.
    pub fn relax_until(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Relaxation, RelaxError> {
        let mut trials = vec![];
        let mut best: Option<(Start, Descended)> = None;
        for (start, states) in self.starts(interrupted)? {
            let found = |best: &Descended| best.outcome == Outcome::Converged && self.is_likely(cost(best));
            if best.as_ref().is_some_and(|(_, best)| found(best) || best.outcome == Outcome::Interrupted) {
                break;
            }
            let descended = self.descent(interrupted).run(states);
            let (costs, outcome) = (descended.costs.clone(), descended.outcome);
            trials.push(Trial { start, costs, outcome });
            if best.as_ref().is_none_or(|(_, best)| cost(&descended) < cost(best)) {
                best = Some((start, descended));
            }
        }
        let none = || Descended { states: vec![], costs: vec![], outcome: Outcome::Converged, damped: false };
        let (start, descended) = best.unwrap_or_else(|| (Start::Guesses, none()));
        self.states.clone_from(&descended.states);
        self.factorized = false;
        Ok(self.answer(start, &descended, trials))
    }

    /// The poses as given, those that were wanting filled in from the edges.
    pub fn guesses(&self) -> Vec<Pose> {
        self.given.clone()
    }

    /// The starts to try, the cheapest first.
    fn starts(&self, interrupted: &dyn Fn() -> bool) -> Result<Vec<(Start, Vec<State>)>, RelaxError> {
        let rotations =
            || rotation_first(&self.problem, &self.structure, &self.nodes, &self.guesses, interrupted);
        let mut starts = match self.options.start {
            Start::Guesses => vec![(Start::Guesses, self.guesses.clone())],
            Start::Odometry => vec![(Start::Odometry, self.odometry.clone())],
            Start::Rotations => vec![(Start::Rotations, rotations()?)],
            Start::Best if self.is_likely(self.problem.cost(&self.guesses)) => {
                vec![(Start::Guesses, self.guesses.clone())]
            }
            Start::Best => vec![(Start::Guesses, self.guesses.clone()), (Start::Rotations, rotations()?)],
        };
        starts.sort_by_cached_key(|(_, states)| {
            let cost = self.problem.cost(states);
            // Positive numbers are in the order of their bits; none comes last.
            if cost.is_nan() { u64::MAX } else { cost.to_bits() }
        });
        Ok(starts)
    }

    /// How often the normal equations have been factorised, all by the one order of elimination and the one symbolic
    /// analysis that [`Relaxer::new`] made.
    pub fn factorizations(&self) -> usize {
        self.system.factorizations()
    }

    fn descent<'a>(&'a mut self, interrupted: &'a dyn Fn() -> bool) -> Descent<'a> {
        self.factorized = false;
        Descent {
            problem: &self.problem,
            structure: &self.structure,
            nodes: &self.nodes,
            system: &mut self.system,
            options: &self.options,
            interrupted,
        }
    }

    /// Whether a cost is what honest covariances lead to, so that no other minimum need be looked for.
    fn is_likely(&self, cost: f64) -> bool {
        let degrees = self.degrees_of_freedom as f64;
        cost <= degrees + SPREAD * (2.0 * degrees).sqrt()
    }

    fn answer(&mut self, start: Start, descended: &Descended, trials: Vec<Trial>) -> Relaxation {
        let named = |wanted: &[bool], ids: &[PoseId]| -> Vec<PoseId> {
            ids.iter().zip(wanted).filter(|(_, wanted)| **wanted).map(|(id, _)| *id).collect()
        };
        self.undetermined = self.undetermined(descended.damped);
        let stopped = trials.iter().any(|trial| trial.outcome == Outcome::Interrupted);
        let poses = self.poses();
        let told = self.states_of(&poses);
        let (found, cost) = (cost(descended), self.problem.cost(&told));
        let outcome = match descended.outcome {
            _ if stopped => Outcome::Interrupted,
            _ if !(cost.is_finite() && found.is_finite()) => Outcome::Overflow,
            Outcome::Converged if cost > found + self.problem.negligible(found) => Outcome::Stalled,
            ended => ended,
        };
        Relaxation {
            objective: self.problem.strain(&told),
            poses,
            cost,
            iterations: descended.costs.len().saturating_sub(1),
            outcome,
            start,
            trials,
            gauge: named(&self.anchored, &self.ids),
            parts: self.named_parts(),
            undetermined: named(&self.undetermined, &self.ids),
            degrees_of_freedom: self.degrees_of_freedom,
        }
    }

    /// The poses of the states; those that were not moved are as they were, to the last bit.
    fn poses(&self) -> Vec<Pose> {
        let moved = self.states.iter().zip(&self.origins).map(|(state, origin)| state.pose(origin));
        let held = self.given.iter().zip(&self.anchored);
        moved.zip(held).map(|(moved, (given, held))| if *held { *given } else { moved }).collect()
    }

    /// The states at which some poses are, their headings as they have been found.
    fn states_of(&self, poses: &[Pose]) -> Vec<State> {
        let placed = poses.iter().zip(&self.origins).zip(&self.states);
        placed.map(|((pose, at), state)| State { x: pose.x - at.x, y: pose.y - at.y, ..*state }).collect()
    }

    fn named_parts(&self) -> Vec<Part> {
        let mut sizes = vec![0; self.ids.len()];
        self.parts.iter().for_each(|part| sizes[*part as usize] += 1);
        let parts = self.ids.iter().zip(sizes).filter(|(_, poses)| *poses > 0);
        parts.map(|(first, poses)| Part { first: *first, poses }).collect()
    }

    /// Whether each pose can move without strain. The factor at hand is from where the last step began, which is as good.
    fn undetermined(&mut self, damped: bool) -> Vec<bool> {
        let mut free = vec![false; self.ids.len()];
        if self.structure.nodes() == 0 || (!damped && is_sound(&self.system, &self.system.diagonals())) {
            return free;
        }
        self.linearise();
        let diagonals = self.system.diagonals();
        let free_nodes = free_nodes(&mut self.system, &diagonals);
        for (free, node) in free.iter_mut().zip(&self.nodes).filter(|(_, node)| **node != NOWHERE) {
            *free = free_nodes[*node as usize];
        }
        free
    }

    /// The covariance of x, y and heading of a pose in the frame of the gauge, where the last relaxation ended; zero for
    /// a pose of the gauge, none for one that is unknown or undetermined.
    ///
    /// The first asked for costs a factorisation, each more the solution of three systems.
    pub fn covariance(&mut self, id: PoseId) -> Option<Matrix3<f64>> {
        let pose = self.ids.iter().position(|known| *known == id)?;
        let node = self.nodes[pose];
        if node == NOWHERE {
            return Some(Matrix3::zeros());
        }
        if self.undetermined[pose] || !self.factorized_where_it_ended() {
            return None;
        }
        let unknowns = 3 * self.structure.nodes();
        let at = 3 * node as usize;
        let mut sides = vec![0.0; 3 * unknowns];
        (0..3).for_each(|k| sides[k * unknowns + at + k] = 1.0);
        self.system.solve(&mut sides);
        let covariance = Matrix3::from_fn(|row, column| sides[column * unknowns + at + row]);
        Some((covariance + covariance.transpose()) / 2.0)
    }

    fn factorized_where_it_ended(&mut self) -> bool {
        if !self.factorized {
            self.linearise();
            let diagonals = self.system.diagonals();
            if self.undetermined.contains(&true) {
                shift(&mut self.system, &diagonals);
            }
            self.factorized = self.system.factorize().is_ok();
        }
        self.factorized
    }

    fn linearise(&mut self) {
        let places = &self.structure.places;
        self.problem.linearise(&self.states, &self.nodes, places, &mut self.system);
        self.factorized = false;
    }
}

/// How many standard deviations of chi-square above its mean are still likely.
const SPREAD: f64 = 5.0;

fn cost(descended: &Descended) -> f64 {
    descended.costs.last().copied().unwrap_or_default()
}

/// The nodes of the poses that are moved, in the order of their elimination, and what meets there.
fn eliminated(problem: &Problem, anchored: &[bool]) -> Result<(Vec<u32>, Structure), RelaxError> {
    let mut nodes = vec![NOWHERE; anchored.len()];
    let free = nodes.iter_mut().zip(anchored).filter(|(_, anchored)| !**anchored);
    let count = free.zip(0..).map(|((node, _), number)| *node = number).count();
    let pairs = |nodes: &[u32]| -> Vec<[u32; 2]> {
        problem.constraints.iter().map(|constraint| constraint.ends.map(|end| nodes[end as usize])).collect()
    };
    let position = Structure::new(count, &pairs(&nodes)).elimination_order()?;
    for node in nodes.iter_mut().filter(|node| **node != NOWHERE) {
        *node = position[*node as usize];
    }
    let structure = Structure::new(count, &pairs(&nodes));
    Ok((nodes, structure))
}
