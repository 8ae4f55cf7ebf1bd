//! How far errors have to go to take a visit out of a circle: the profile of the likelihood (Wilks 1938).
//!
//! First order and a bound on what it leaves out is cheap, but where headings are off by tens of degrees the bound is
//! metres. Here the least chi-square is found with which all loops close and a visit lies beyond a line: least squares
//! with one more condition, linearised anew where it leads, until it stays. What it takes beyond the chi-square without
//! that line is compared with the gate, as a difference of chi-squares is distributed as that of a linear model is
//! whatever the coordinates are.

use crate::geometry::{Vector, direction};
use crate::metric::layout::{Layout, Span};
use crate::metric::leg::lever;
use nalgebra::RowVector3;
use std::f64::consts::{PI, TAU};

/// Sides of the polygon within the circle.
const SIDES: usize = 24;
/// At most so many linearisations, and the change of chi-square that ends them. Errors come to rest more slowly, but
/// near its least chi-square hardly depends on them.
const ROUNDS: usize = 40;
const SETTLED: f64 = 0.01;

/// A line that a visit is to lie on, seen from an earlier one: the points so far in a direction of that one's frame.
#[derive(Clone, Copy, Debug)]
struct Line {
    span: Span,
    direction: Vector,
    at: f64,
}

impl Layout {
    /// Whether the later visit lies within a circle around the earlier one for all errors with which loops close and
    /// whose chi-square is at most `gate` more than the least. Where it is not found out, it does not.
    pub(super) fn within(&self, span: Span, radius: f64, gate: f64) -> bool {
        let Some(uncertainty) = self.between(span, gate.sqrt()) else { return false };
        let begin = &self.poses[span.from];
        let off = self.poses[span.to].position() - begin.position();
        // A polygon in the circle: what is beyond the circle is beyond one of its sides.
        let at = radius * (PI / SIDES as f64).cos();
        let mut sides: Vec<(f64, Vector)> = (0..SIDES)
            .map(|side| {
                let way = direction(side as f64 / SIDES as f64 * TAU);
                let sigma = uncertainty.along(&begin.rotate(&way)).sqrt();
                ((at - off.dot(&begin.rotate(&way))) / sigma, way)
            })
            .collect();
        // The nearest in standard deviations first.
        sides.sort_by(|a, b| a.0.total_cmp(&b.0));
        let needs = |line: &Line| self.to_reach(line).is_some_and(|chi_square| chi_square > gate);
        sides.iter().all(|&(_, direction)| needs(&Line { span, direction, at }))
    }

    /// How much more chi-square it takes at least to put a visit on a line from this side of it, or beyond.
    fn to_reach(&self, line: &Line) -> Option<f64> {
        let mut layout = self.clone();
        let (least, _) = layout.chi_square();
        let mut last = f64::NAN;
        for round in 0..ROUNDS {
            layout.solve()?;
            let Span { from, to } = line.span;
            let (begin, end) = (layout.poses[from], layout.poses[to]);
            let along = begin.rotate(&line.direction);
            let moves: RowVector3<f64> = along.transpose() * lever(&end.position().coords).fixed_rows::<2>(0);
            let known = layout.known(line.span, None)? * moves.transpose();
            let left = along.dot(&(end.position() - begin.position())) - line.at
                + (moves * layout.gathered(line.span)).x;
            let misses = left - known.dot(&layout.whitened().column(0));
            if round == 0 && misses >= 0.0 {
                return Some(0.0);
            }
            let variance =
                (moves * layout.shared(line.span, line.span) * moves.transpose()).x - known.norm_squared();
            let pull = misses / variance;
            let (closing, _) = layout.chi_square();
            let chi_square = closing + misses * pull;
            if (chi_square - last).abs() < SETTLED {
                return Some(chi_square - least);
            }
            last = chi_square;
            layout.pulled(layout.whitened() - known * pull, Some((line.span, moves.transpose() * pull)))?;
        }
        None
    }
}
