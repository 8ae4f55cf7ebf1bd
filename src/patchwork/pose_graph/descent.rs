//! The descent: Gauss and Newton's steps, shortened and damped as need be.
//!
//! A step solves the normal equations. Where it would not pay, it is first shortened, by the parabola through what is
//! known of the cost along it (Dennis and Schnabel 1983, section 6.3): that takes the errors alone, not another
//! factorisation. Where no length pays, or the equations are singular, the diagonal is raised (Levenberg 1944,
//! Marquardt 1963). A step that would raise the cost is never taken.
//!
//! Damping makes every step short, so that a damped step which gains little says nothing of being near the least. What
//! is left to gain is judged by the step under the least damping with which the equations have a solution: none, where
//! all is determined. There half its gain is the square of Newton's decrement (Boyd and Vandenberghe 2004, section 9.5.1).

use crate::patchwork::pose_graph::problem::{Problem, State};
use crate::patchwork::pose_graph::relax::RelaxOptions;
use crate::patchwork::pose_graph::relaxation::Outcome;
use crate::patchwork::pose_graph::structure::{NOWHERE, Structure};
use crate::patchwork::pose_graph::system::System;

/// What a descent goes by.
pub(super) struct Descent<'a> {
    pub(super) problem: &'a Problem,
    pub(super) structure: &'a Structure,
    /// The node of each pose.
    pub(super) nodes: &'a [u32],
    pub(super) system: &'a mut System<3>,
    pub(super) options: &'a RelaxOptions,
    /// Asked before each factorisation.
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

/// Where a descent ended.
#[derive(Clone, Debug)]
pub(super) struct Descended {
    pub(super) states: Vec<State>,
    /// The cost at the start and after each step.
    pub(super) costs: Vec<f64>,
    pub(super) outcome: Outcome,
    /// Whether a factorisation without damping failed at the last.
    pub(super) damped: bool,
}

/// Damping that is tried first, and below which there is none: shares of the diagonal.
const LEAST_DAMPING: f64 = 1e-6;
/// Damping at which steps are too short to change anything.
const MOST_DAMPING: f64 = 1e12;
/// By how much damping is raised and lowered.
const DAMPING_FACTOR: f64 = 10.0;
/// What every unknown has on the diagonal at least when it is damped, as a share of the largest there.
const LEAST_DIAGONAL: f64 = 1e-9;
/// How many lengths of a step are tried.
const LENGTHS: usize = 8;
/// A step shorter than this share of what was asked for calls for damping; one longer than the second for less.
const SHORT: f64 = 0.2;
const LONG: f64 = 0.5;

/// What the normal equations ask for.
struct Step {
    by: Vec<f64>,
    /// What the cost falls by to first order, half of it.
    descent: f64,
    /// What the cost falls by if errors are linear.
    gain: f64,
}

struct Taken {
    states: Vec<State>,
    cost: f64,
    length: f64,
}

impl Descent<'_> {
    /// Descends as far as it goes. Each step costs a factorisation or more.
    pub(super) fn run(mut self, states: Vec<State>) -> Descended {
        let cost = self.problem.cost(&states);
        let mut at =
            Descended { states, costs: vec![cost], outcome: Outcome::OutOfIterations, damped: false };
        if self.structure.nodes() == 0 {
            at.outcome = Outcome::Converged;
            return at;
        }
        let mut damping = Damping(0.0);
        while at.costs.len() <= self.options.max_iterations {
            if let Some(outcome) = self.advance(&mut at, &mut damping) {
                at.outcome = outcome;
                break;
            }
        }
        at
    }

    /// One step; the outcome, if there are no more to take.
    fn advance(&mut self, at: &mut Descended, damping: &mut Damping) -> Option<Outcome> {
        let slope = self.problem.linearise(&at.states, self.nodes, &self.structure.places, self.system);
        let cost = at.costs.last().copied().unwrap_or_default();
        let diagonals = self.system.diagonals();
        let enough = Enough::of(self.problem, &at.states, cost, self.options.tolerance);
        // The gain of the least damped step, once all less damping has been tried.
        let (mut from_none, mut promised) = (damping.is_none(), None);
        loop {
            if (self.interrupted)() {
                return Some(Outcome::Interrupted);
            }
            at.damped = !damping.is_none();
            if let Some(step) = self.step(&slope, &diagonals, damping.0) {
                let last = enough.is_little(step.gain);
                if last && !from_none {
                    (*damping, from_none, promised) = (Damping(0.0), true, None);
                    continue;
                }
                let promised = *promised.get_or_insert(step.gain);
                let taken = self.search(&at.states, cost, &step, last);
                let found = taken.is_some();
                if let Some(taken) = taken {
                    damping.after(taken.length);
                    at.states = taken.states;
                    at.costs.push(taken.cost);
                }
                if found || last {
                    return last.then(|| enough.outcome(promised));
                }
            }
            if !damping.raise() {
                return Some(if is_at_rest(&slope) { Outcome::Converged } else { Outcome::Stalled });
            }
        }
    }

    /// The step under some damping, if the normal equations have a solution.
    fn step(&mut self, slope: &[f64], diagonals: &[f64], damping: f64) -> Option<Step> {
        let least = diagonals.iter().copied().fold(0.0, f64::max) * LEAST_DIAGONAL;
        let extra = |entry: f64| damping * entry.max(least);
        self.system.set_diagonals(diagonals.iter().map(|entry| entry + extra(*entry)));
        self.system.factorize().ok()?;
        let mut by: Vec<f64> = slope.iter().map(|s| -s).collect();
        self.system.solve(&mut by);
        let descent = -by.iter().zip(slope).map(|(b, s)| b * s).sum::<f64>();
        let held_back: f64 = by.iter().zip(diagonals).map(|(b, entry)| b * b * extra(*entry)).sum();
        let gain = descent + held_back;
        (gain.is_finite() && gain >= 0.0).then_some(Step { by, descent, gain })
    }

    /// The length of a step that pays best of those tried, if one does.
    fn search(&self, states: &[State], cost: f64, step: &Step, last: bool) -> Option<Taken> {
        let mut best: Option<Taken> = None;
        let mut length = 1.0;
        for _ in 0..if last { 1 } else { LENGTHS } {
            let there = self.moved(states, &step.by, length);
            let after = self.problem.cost(&there);
            let better = after <= best.as_ref().map_or(cost, |taken| taken.cost);
            if better {
                best = Some(Taken { states: there, cost: after, length });
            }
            // Half of what was promised is good enough; and past the best length there is no better one.
            if (better && after <= cost - 0.5 * step.descent * length) || (!better && best.is_some()) {
                break;
            }
            let parabola = step.descent * length * length / (after - cost + 2.0 * step.descent * length);
            length =
                if parabola.is_finite() { parabola.clamp(0.1 * length, 0.6 * length) } else { 0.1 * length };
        }
        best
    }

    fn moved(&self, states: &[State], by: &[f64], length: f64) -> Vec<State> {
        let moved = |(state, node): (&State, &u32)| {
            if *node == NOWHERE {
                return *state;
            }
            let [x, y, theta] = std::array::from_fn(|k| length * by[3 * *node as usize + k]);
            State::new(state.x + x, state.y + y, state.theta + theta)
        };
        states.iter().zip(self.nodes).map(moved).collect()
    }
}

/// Whether nothing pulls: nothing was measured, and there is nothing to solve.
fn is_at_rest(slope: &[f64]) -> bool {
    slope.iter().all(|slope| *slope == 0.0)
}

/// What is too little to be worth a step.
struct Enough {
    /// So much of the cost is within the tolerance.
    share: f64,
    /// So much of it is rounding.
    rounding: f64,
    /// So much of it matters to nobody.
    negligible: f64,
}

impl Enough {
    fn of(problem: &Problem, states: &[State], cost: f64, tolerance: f64) -> Enough {
        // A cost beyond all numbers is a share of nothing.
        let share = if cost.is_finite() { tolerance * cost } else { 0.0 };
        Enough { share, rounding: problem.rounding(states), negligible: problem.negligible(cost) }
    }

    fn is_little(&self, gain: f64) -> bool {
        gain <= self.share.max(self.rounding)
    }

    /// How a descent has ended where all that is left to gain is so much.
    fn outcome(&self, promised: f64) -> Outcome {
        match promised <= self.share || (promised <= self.rounding && self.rounding <= self.negligible) {
            true => Outcome::Converged,
            false => Outcome::Stalled,
        }
    }
}

/// What is added to the diagonal, as a share of it.
struct Damping(f64);

impl Damping {
    fn is_none(&self) -> bool {
        self.0 <= 0.0
    }

    /// More of it; false where there is no sense in more.
    fn raise(&mut self) -> bool {
        self.0 = (self.0 * DAMPING_FACTOR).max(LEAST_DAMPING);
        self.0 <= MOST_DAMPING
    }

    /// What a step of some length calls for.
    fn after(&mut self, length: f64) {
        if length < SHORT {
            self.raise();
        } else if length > LONG {
            self.0 = if self.0 <= LEAST_DAMPING { 0.0 } else { self.0 / DAMPING_FACTOR };
        }
    }
}
