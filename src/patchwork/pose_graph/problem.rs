//! What is minimised: the edges as arrays, their errors, and the normal equations.
//!
//! The error of an edge is `z^-1 (i^-1 j)`, position and heading, as in g2o's SE(2) edge. Its position is that of
//! `i^-1 j` less that of `z`, seen from `z`; so the turn of `z` goes into the information once, and what is left is
//! linear in the positions of both ends for given headings.
//!
//! Unknowns are x, y and heading of each pose, with the axes of the gauge's frame and their origin at the pose that is
//! held: far from the origin of a file numbers have few digits left for what is near each other. Moving `j` by `(u, v, w)` changes the error by
//! `P (u, v, w)`, with `P` the turn into the frame of `i`; moving `i` by it changes the error by `-P A (u, v, w)`, where
//! `A` carries the far end along as `i` turns. So one block `H = P' W P` gives all: `A' H A`, `-A' H` and `H`.

use crate::geometry::{Point, Pose};
use crate::patchwork::pose_graph::graph::{Edge, PoseGraph};
use crate::patchwork::pose_graph::loss::Loss;
use crate::patchwork::pose_graph::structure::NOWHERE;
use crate::patchwork::pose_graph::system::System;
use nalgebra::Matrix3;
use std::f64::consts::TAU;

/// An edge between two poses by their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    pub(super) ends: [u32; 2],
    /// x, y and heading measured.
    pub(super) measured: [f64; 3],
    /// The information of an error whose position is in the frame of the first end: xx, xy, yy, xt, yt, tt.
    pub(super) weight: [f64; 6],
}

/// The edges of a graph, in an order that does not depend on theirs.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) constraints: Vec<Constraint>,
    pub(super) loss: Loss,
    /// The information of all edges on metres, along and aside, and on radians.
    weights: [f64; 2],
}

/// A pose with its direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) theta: f64,
    pub(super) cos: f64,
    pub(super) sin: f64,
}

impl State {
    /// A state; its heading stays as it is given, so that it does not jump while it is searched for.
    pub(super) fn new(x: f64, y: f64, theta: f64) -> State {
        let (sin, cos) = theta.sin_cos();
        State { x, y, theta, cos, sin }
    }

    /// A pose seen from an origin.
    pub(super) fn of(pose: &Pose, origin: &Point) -> State {
        State::new(pose.x - origin.x, pose.y - origin.y, pose.theta)
    }

    /// The pose of a state seen from an origin.
    pub(super) fn pose(&self, origin: &Point) -> Pose {
        Pose::new(self.x + origin.x, self.y + origin.y, self.theta)
    }
}

/// How many units in the last place an error is off, of the numbers it is made of.
const UNITS: f64 = 16.0;
/// The share of a cost that matters to nobody, and the cost of an edge below which that is of the edges alone.
const NEGLIGIBLE: f64 = 1e-6;
const NEXT_TO_NOTHING: f64 = 1e-3;

/// The angle of the same direction nearest to zero.
pub(super) fn nearest_angle(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

impl Problem {
    /// The problem of a graph. Sorting makes every sum the same in whatever order the edges were given.
    pub(super) fn new(graph: &PoseGraph, loss: Loss) -> Problem {
        let constraint = |(edge, ends): (&Edge, &[u32; 2])| {
            let z = &edge.displacement;
            let weight = turned(&edge.information, z.theta);
            Constraint { ends: *ends, measured: [z.x, z.y, z.theta], weight }
        };
        let mut constraints: Vec<Constraint> =
            graph.edges().iter().zip(graph.ends()).map(constraint).collect();
        let bits = |numbers: &[f64]| numbers.iter().map(|n| n.to_bits()).collect::<Vec<u64>>();
        constraints.sort_by(|a, b| {
            a.ends
                .cmp(&b.ends)
                .then_with(|| (bits(&a.measured), bits(&a.weight)).cmp(&(bits(&b.measured), bits(&b.weight))))
        });
        let weights = constraints.iter().fold([0.0; 2], |[metres, radians], Constraint { weight, .. }| {
            [metres + weight[0] + weight[2], radians + weight[5]]
        });
        Problem { constraints, loss, weights }
    }

    /// The sum of the costs of all edges; infinite or none where a state is.
    pub(super) fn cost(&self, states: &[State]) -> f64 {
        let cost = |constraint: &Constraint| self.loss.of(constraint.chi_square(states)).0;
        self.constraints.iter().map(cost).fold(0.0, |sum, cost| sum + cost)
    }

    /// The sum of `e' W e` of all edges, whatever the loss.
    pub(super) fn strain(&self, states: &[State]) -> f64 {
        self.constraints.iter().map(|constraint| constraint.chi_square(states)).fold(0.0, |sum, s| sum + s)
    }

    /// So much of the cost of some states may be nothing but rounding: what each error weighs that is off by a few units in
    /// the last place of the numbers it is made of.
    pub(super) fn rounding(&self, states: &[State]) -> f64 {
        let most = |of: fn(&State) -> f64| states.iter().map(of).fold(1.0, f64::max);
        let off = [most(|state| state.x.abs().max(state.y.abs())), most(|state| state.theta.abs())];
        let weighed = self.weights.iter().zip(off.map(|most| UNITS * f64::EPSILON * most));
        weighed.map(|(weight, off)| weight * off * off).sum()
    }

    /// So much more than a cost matters to nobody: a millionth of it. Of a cost that is itself next to nothing, as
    /// measurements that agree have it, a billionth for each edge.
    pub(super) fn negligible(&self, cost: f64) -> f64 {
        let edges = self.constraints.len() as f64;
        (NEGLIGIBLE * cost).max(NEGLIGIBLE * NEXT_TO_NOTHING * edges)
    }

    /// The normal equations at some states, over the nodes at which poses have their unknowns.
    ///
    /// `places` are those of the pairs of nodes of each constraint in the structure of the system. Gives half the gradient
    /// of the cost.
    pub(super) fn linearise(
        &self,
        states: &[State],
        nodes: &[u32],
        places: &[u32],
        system: &mut System<3>,
    ) -> Vec<f64> {
        system.clear();
        let unknowns = nodes.iter().filter(|node| **node != NOWHERE).count();
        let mut slope = vec![0.0; 3 * unknowns];
        let mut diagonal = vec![[0.0; 6]; unknowns];
        for (constraint, &place) in self.constraints.iter().zip(places) {
            let tangent = constraint.tangent(states, self.loss);
            let [from, to] = constraint.ends.map(|end| nodes[end as usize]);
            if to != NOWHERE {
                add(&mut diagonal[to as usize], &tangent.far);
                (0..3).for_each(|k| slope[3 * to as usize + k] += tangent.pull[k]);
            }
            if from != NOWHERE {
                let [along, aside, turn] = tangent.pull;
                let [lx, ly] = tangent.lever;
                add(&mut diagonal[from as usize], &tangent.near());
                let back = [along, aside, turn + lx * along + ly * aside];
                (0..3).for_each(|k| slope[3 * from as usize + k] -= back[k]);
            }
            if place != NOWHERE {
                let cross = tangent.cross();
                let block = if from < to { cross } else { transposed(&cross) };
                system.add_block(place, &block);
            }
        }
        for (node, [a, b, c, d, e, f]) in (0..).zip(diagonal) {
            system.add_diagonal(node, &[[a, b, d], [b, c, e], [d, e, f]]);
        }
        slope
    }
}

fn add(sum: &mut [f64; 6], term: &[f64; 6]) {
    sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += term);
}

fn transposed(block: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| block[c][r]))
}

/// An information matrix whose positions are in a frame turned by an angle, in the frame itself.
fn turned(information: &Matrix3<f64>, angle: f64) -> [f64; 6] {
    let (sin, cos) = angle.sin_cos();
    let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let w = turn * information * turn.transpose();
    let half = |r: usize, c: usize| f64::midpoint(w[(r, c)], w[(c, r)]);
    [w[(0, 0)], half(0, 1), w[(1, 1)], half(0, 2), half(1, 2), w[(2, 2)]]
}

/// An edge at some states: of its part of the normal equations what all blocks are made of.
struct Tangent {
    /// The block of the far end on the diagonal.
    far: [f64; 6],
    /// How the far end moves as the near one turns by a radian.
    lever: [f64; 2],
    /// Half the gradient by the far end.
    pull: [f64; 3],
}

impl Constraint {
    /// The error, its position in the frame of the first end.
    pub(super) fn error(&self, states: &[State]) -> [f64; 3] {
        let [i, j] = self.ends.map(|end| &states[end as usize]);
        let (dx, dy) = (j.x - i.x, j.y - i.y);
        let [x, y, theta] = self.measured;
        [i.cos * dx + i.sin * dy - x, i.cos * dy - i.sin * dx - y, nearest_angle(j.theta - i.theta - theta)]
    }

    /// `e' W e`.
    pub(super) fn chi_square(&self, states: &[State]) -> f64 {
        let error = self.error(states);
        let force = self.force(&error);
        error.iter().zip(force).map(|(e, f)| e * f).sum()
    }

    fn force(&self, [x, y, t]: &[f64; 3]) -> [f64; 3] {
        let [a, b, c, d, e, f] = self.weight;
        [a * x + b * y + d * t, b * x + c * y + e * t, d * x + e * y + f * t]
    }

    /// The block of positions alone, and half the gradient by the far end's position.
    pub(super) fn planar(&self, states: &[State]) -> ([[f64; 2]; 2], [f64; 2]) {
        let tangent = self.tangent(states, Loss::Squared);
        let [a, b, c, ..] = tangent.far;
        ([[a, b], [b, c]], [tangent.pull[0], tangent.pull[1]])
    }

    fn tangent(&self, states: &[State], loss: Loss) -> Tangent {
        let [i, j] = self.ends.map(|end| &states[end as usize]);
        let error = self.error(states);
        let force = self.force(&error);
        let chi_square = error.iter().zip(force).map(|(e, f)| e * f).sum();
        let (_, w) = loss.of(chi_square);
        let (c, s) = (i.cos, i.sin);
        let [a, b, d, e, f, g] = self.weight.map(|n| n * w);
        let (cc, cs, ss) = (c * c, c * s, s * s);
        Tangent {
            far: [
                cc * a - 2.0 * cs * b + ss * d,
                cs * (a - d) + (cc - ss) * b,
                ss * a + 2.0 * cs * b + cc * d,
                c * e - s * f,
                s * e + c * f,
                g,
            ],
            lever: [i.y - j.y, j.x - i.x],
            pull: [w * (c * force[0] - s * force[1]), w * (s * force[0] + c * force[1]), w * force[2]],
        }
    }
}

impl Tangent {
    /// `A' H`, whose negative is the block of the near end's rows and the far end's columns.
    fn carried(&self) -> [[f64; 3]; 3] {
        let [a, b, c, d, e, f] = self.far;
        let [lx, ly] = self.lever;
        [[a, b, d], [b, c, e], [d + lx * a + ly * b, e + lx * b + ly * c, f + lx * d + ly * e]]
    }

    fn cross(&self) -> [[f64; 3]; 3] {
        self.carried().map(|row| row.map(|n| -n))
    }

    /// `A' H A`, the block of the near end on the diagonal.
    fn near(&self) -> [f64; 6] {
        let [[a, b, d], [_, c, e], [p, q, r]] = self.carried();
        let [lx, ly] = self.lever;
        [a, b, c, d + lx * a + ly * b, e + lx * b + ly * c, r + lx * p + ly * q]
    }
}
