//! How far errors have to go to take a visit out of a circle: the profile of the likelihood (Wilks 1938).
//!
//! First order and a bound on what it leaves out is cheap, but where headings are off by tens of degrees the bound is
//! metres. Here the least chi-square is found with which all loops close and visits lie beyond lines: least squares
//! with more conditions, linearised anew where it leads, until it stays. What it takes beyond the chi-square without
//! that line is compared with the gate, as a difference of chi-squares is distributed as that of a linear model is
//! whatever the coordinates are.

use crate::geometry::direction;
use crate::metric::bound::{Bound, Edge};
use crate::metric::condition::{Condition, ahead};
use crate::metric::layout::{Layout, Span};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Sides of the polygon within the circle.
const SIDES: usize = 24;
/// At most so many linearisations, and how much chi-square is left where they end, as far as the last two tell.
const ROUNDS: usize = 40;
const SETTLED: f64 = 1e-3;
/// How much of the way to where a linearisation leads is gone, at least and at most.
const WAYS: [f64; 2] = [0.125, 2.0];
/// By how many standard deviations each error is shaken where a descent rests on what may be a saddle.
const SHAKE: f64 = 0.1;
/// How much chi-square it is to take to first order to come to the lines looked at before a side, in gates.
pub(super) const NEARER: [f64; 2] = [1.5, 3.0];

/// Where a descent came to.
#[derive(Debug)]
pub(super) struct Descent {
    /// How many problems were solved.
    pub(super) rounds: usize,
    /// Where it came to rest, if it did.
    pub(super) end: Option<Reached>,
}

/// Visits put within bounds.
#[derive(Debug)]
pub(super) struct Reached {
    /// How much more chi-square that takes.
    pub(super) chi_square: f64,
    /// Which of the bounds bear, by number, ascending.
    pub(super) bearing: Vec<usize>,
    /// All visits laid out so.
    pub(super) layout: Layout,
}

/// A side of the polygon, and where the visit lies towards it.
#[derive(Clone, Copy, Debug)]
struct Side {
    bound: Bound,
    off: f64,
    /// Standard deviation of that.
    sigma: f64,
}

impl Side {
    /// How many standard deviations it is away.
    fn sigmas(&self) -> f64 {
        (self.bound.by - self.off) / self.sigma
    }
}

impl Layout {
    /// Whether it takes chi-square more than the least, and more than a gate, to have all loops closed and the later
    /// visit outside a circle around the earlier one: if it does, how much at least. `None` where it is not found out.
    pub(super) fn to_rim(&self, span: Span, radius: f64, gate: f64) -> Option<f64> {
        let covariance = self.between(span)?;
        let begin = &self.poses[span.from];
        let off = self.poses[span.to].position() - begin.position();
        // A polygon in the circle: what is beyond the circle is beyond one of its sides.
        let at = radius * (PI / SIDES as f64).cos();
        let side = |side: usize| {
            let direction = direction(side as f64 / SIDES as f64 * TAU);
            let along = begin.rotate(&direction);
            let sigma = along.dot(&(covariance.fixed_view::<2, 2>(0, 0) * along)).sqrt();
            let edge = Edge::At { visit: span.from, direction };
            Side { bound: Bound { edge, visit: span.to, by: at }, off: off.dot(&along), sigma }
        };
        let mut sides: Vec<Side> = (0..SIDES).map(side).collect();
        sides.sort_by(|a, b| a.sigmas().total_cmp(&b.sigmas()));
        sides.iter().try_fold(f64::INFINITY, |least, side| Some(least.min(self.beyond(side, gate)?)))
    }

    /// How much more chi-square it takes at least to come beyond a side, if that is more than the gate. What is beyond
    /// a side is beyond every line before it, and near lines are found where those far out are not.
    fn beyond(&self, side: &Side, gate: f64) -> Option<f64> {
        let before = NEARER.map(|gates| side.off + (gates * gate).sqrt() * side.sigma);
        let lines = before.into_iter().filter(|&by| by < side.bound.by).chain([side.bound.by]);
        let mut reached = lines.map(|by| self.to_reach(&[Bound { by, ..side.bound }], |_| gate).end);
        reached.find_map(|reached| Some(reached?.chi_square).filter(|&takes| takes > gate))
    }

    /// What it takes at least to put visits within bounds. Where that is more than the gate of so many bounds as bear, it is more
    /// after a shake too. Without an end where it is not found out.
    pub(super) fn to_reach(&self, bounds: &[Bound], gate: impl Fn(usize) -> f64) -> Descent {
        let mut rounds = 0;
        let end = self.descend(bounds, gate, &mut rounds);
        Descent { rounds, end }
    }

    fn descend(&self, bounds: &[Bound], gate: impl Fn(usize) -> f64, rounds: &mut usize) -> Option<Reached> {
        let mut layout = self.clone();
        let (least, _) = layout.chi_square();
        let (mut last, mut way, mut shaken): (Option<Step>, _, _) = (None, 1.0, false);
        for round in 0..ROUNDS {
            *rounds += 1;
            layout.solve()?;
            let conditions = bounds.iter().map(|bound| Condition::new(bound, &layout));
            let conditions = conditions.collect::<Option<Vec<Condition>>>()?;
            let misses = conditions.iter().map(|condition| condition.within(&layout));
            let misses = DVector::from_iterator(bounds.len(), misses);
            if round == 0 && misses.iter().all(|misses| *misses >= 0.0) {
                return Some(Reached { chi_square: 0.0, bearing: Vec::new(), layout });
            }
            let covariance = covariance(&conditions, &layout);
            let pulls = pulls(&covariance, &misses);
            let (closing, _) = layout.chi_square();
            let chi_square = closing + taken(&covariance, &misses, &pulls) - least;
            let bearing: Vec<usize> = (0..bounds.len()).filter(|&bound| pulls[bound] < 0.0).collect();
            let ahead = ahead(&layout, conditions.iter().zip(pulls.iter().copied()))?;
            let left;
            (way, left) = last.map_or((way, f64::INFINITY), |last| last.then(&ahead));
            last = if left >= SETTLED {
                layout.go(&ahead, way);
                Some(Step { ahead, way })
            } else if shaken || chi_square <= gate(bearing.len()) {
                layout.go(&ahead, 1.0);
                return Some(Reached { chi_square, bearing, layout });
            } else {
                shaken = true;
                layout.shake(SHAKE);
                None
            };
        }
        None
    }
}

/// A step of a descent: how far ahead in the space of errors, in standard deviations, the least of the problem as linearised
/// there was, and how much of that way was gone.
struct Step {
    ahead: DVector<f64>,
    way: f64,
}

impl Step {
    /// How much of the way to go next, by how what is ahead has changed over the last one (Irons and Tuck 1969), and how much
    /// chi-square the way to the least takes off yet. Infinite where the way gets longer, as it does next to a saddle.
    fn then(&self, ahead: &DVector<f64>) -> (f64, f64) {
        if ahead.norm_squared() == 0.0 {
            return (1.0, 0.0);
        }
        let change = &self.ahead - ahead;
        let less = self.ahead.dot(&change);
        let [least, most] = WAYS;
        if less <= 0.0 {
            return (most, f64::INFINITY);
        }
        // Of chi-square around its least, in units of what linearised problems think it is.
        let curvature = less / (self.way * self.ahead.norm_squared());
        let way = self.way * less / change.norm_squared();
        (way.clamp(least, most), ahead.norm_squared() / curvature)
    }
}

/// The covariance of conditions that loops leave.
fn covariance(conditions: &[Condition], layout: &Layout) -> DMatrix<f64> {
    let mut covariance = DMatrix::zeros(conditions.len(), conditions.len());
    for (k, one) in conditions.iter().enumerate() {
        for (l, other) in conditions[..=k].iter().enumerate() {
            let entry = one.covariance(other, layout);
            (covariance[(k, l)], covariance[(l, k)]) = (entry, entry);
        }
    }
    covariance
}

/// At most so many rounds over all lines, and the change of chi-square that ends them.
const SWEEPS: usize = 500;
const STILL: f64 = 1e-12;
/// After how many rounds it is asked whether it is known by now which lines bear.
const ASKED: [usize; 4] = [5, 17, 65, 257];
/// How much of the variance of each line that bears the ones before it leave, at least, where that is asked: where they leave less, the
/// lines hardly meet, and rounds that end take a step that linearised problems still bear.
const FREE: f64 = 1e-4;

/// What pulls at each of some lines, so that none is missed: below zero, or zero where others pull far enough. Chi-square
/// is the greatest that such numbers give ([`taken`]), each of which is set to its best in turn (Hildreth 1957), until it is
/// known which lines bear.
pub(super) fn pulls(covariance: &DMatrix<f64>, misses: &DVector<f64>) -> DVector<f64> {
    let mut pulls: DVector<f64> = DVector::zeros(misses.len());
    // What is missed beside what all pull.
    let mut left = misses.clone();
    for round in 1..=SWEEPS {
        let mut change = 0.0_f64;
        for line in 0..misses.len() {
            let variance = covariance[(line, line)];
            if variance <= 0.0 {
                continue;
            }
            let more = (pulls[line] + left[line] / variance).min(0.0) - pulls[line];
            if more != 0.0 {
                change = change.max(more.powi(2) * variance);
                left.axpy(-more, &covariance.column(line), 1.0);
                pulls[line] += more;
            }
        }
        if change < STILL {
            break;
        }
        if ASKED.contains(&round)
            && let Some(best) = best(covariance, misses, &pulls)
        {
            return best;
        }
    }
    pulls
}

/// The best pulls, if the lines that bear are those at which these pull: then all of them pull, and no other line is missed
/// (Kuhn and Tucker 1951). None where that is not so.
fn best(covariance: &DMatrix<f64>, misses: &DVector<f64>, pulls: &DVector<f64>) -> Option<DVector<f64>> {
    let bear: Vec<usize> = (0..misses.len()).filter(|&line| pulls[line] < 0.0).collect();
    let among = covariance.select_rows(&bear).select_columns(&bear);
    let variances = among.diagonal();
    let root = among.cholesky()?;
    let free = root.l_dirty().diagonal().zip_map(&variances, |left, variance| left * left / variance);
    let pulled = root.solve(&misses.select_rows(&bear));
    let mut best = DVector::zeros(misses.len());
    bear.iter().zip(&pulled).for_each(|(&line, pull)| best[line] = *pull);
    let left = misses - covariance * &best;
    let holds = |line: usize| if pulls[line] < 0.0 { best[line] < 0.0 } else { left[line] >= 0.0 };
    (free.iter().all(|&free| free >= FREE) && (0..misses.len()).all(holds)).then_some(best)
}

/// How much chi-square it takes at least to miss no line, by what pulls at them; if it is the best, just so much.
pub(super) fn taken(covariance: &DMatrix<f64>, misses: &DVector<f64>, pulls: &DVector<f64>) -> f64 {
    2.0 * misses.dot(pulls) - pulls.dot(&(covariance * pulls))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn solved(covariance: [f64; 4], misses: [f64; 2]) -> ([f64; 2], f64) {
        let (covariance, misses) =
            (DMatrix::from_row_slice(2, 2, &covariance), DVector::from_row_slice(&misses));
        let pulls = pulls(&covariance, &misses);
        ([pulls[0], pulls[1]], taken(&covariance, &misses, &pulls))
    }

    /// Of a linear problem, each of whose errors is off its least by so much and comes nearer by a share of that at a time.
    fn next(off: [f64; 2], shares: [f64; 2], way: f64) -> (f64, f64) {
        let ahead = |off: [f64; 2]| DVector::from_fn(2, |at, _| -off[at] * shares[at]);
        let then = std::array::from_fn(|at| off[at] * (1.0 - way * shares[at]));
        Step { ahead: ahead(off), way }.then(&ahead(then))
    }

    #[test]
    fn what_is_left_is_told_by_how_fast_the_way_shortens() {
        let near = |found: (f64, f64), way: f64, left: f64| {
            assert!((found.0 - way).abs() < 1e-9 && (found.1 - left).abs() < 1e-9, "{found:?}");
        };
        // Fast, slow, and to and fro: chi-square grows by the share with the square of what is off.
        near(next([1.0, 0.0], [0.8, 1.0], 1.0), 1.25, 0.8 * 0.04);
        near(next([1.0, 0.0], [0.1, 1.0], 1.0), 2.0, 0.1 * 0.81);
        near(next([1.0, 0.0], [2.5, 1.0], 1.0), 0.4, 2.5 * 2.25);
        // The slow one is what is left where the fast one has come to rest, though it is far from its own.
        near(next([0.0, 1.0], [1.0, 0.02], 0.5), 2.0, 0.02 * 0.99 * 0.99);
        // At rest, and next to a saddle.
        near(next([0.0, 0.0], [1.0, 1.0], 1.0), 1.0, 0.0);
        assert_eq!(next([0.0, 1e-6], [1.0, -0.3], 1.0), (2.0, f64::INFINITY));
    }

    #[test]
    fn lines_pull_as_far_as_others_leave_it_to_them() {
        let near = |found: ([f64; 2], f64), pulls: [f64; 2], taken: f64| {
            let off = (found.0[0] - pulls[0]).abs() + (found.0[1] - pulls[1]).abs() + (found.1 - taken).abs();
            assert!(off < 1e-5, "{found:?}");
        };
        near(solved([1.0, 0.5, 0.5, 1.0], [-1.0, -1.0]), [-2.0 / 3.0; 2], 4.0 / 3.0);
        // What the first line takes is more than the second one asks for.
        near(solved([1.0, 0.5, 0.5, 1.0], [-1.0, -0.2]), [-1.0, 0.0], 1.0);
        near(solved([1.0, 0.5, 0.5, 1.0], [0.3, 0.2]), [0.0, 0.0], 0.0);
        // A line that no errors move, one of which nothing is known, and one that was asked for before.
        near(solved([0.0, 0.0, 0.0, 4.0], [-1.0, -2.0]), [0.0, -0.5], 1.0);
        assert_eq!(solved([f64::NAN, 0.0, 0.0, 4.0], [-1.0, 2.0]).0, [0.0, 0.0]);
        near(solved([1.0; 4], [-1.0; 2]), [-1.0, 0.0], 1.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2048, failure_persistence: None, ..ProptestConfig::default() })]

        /// No line is missed, none pushes, and none pulls farther than it has to: but for some 1e-5, as rounds end by
        /// how little chi-square changes.
        #[test]
        fn pulls_are_the_best_there_are(
            mixed in prop::collection::vec(-1.0..1.0, 36),
            misses in prop::collection::vec(-2.0..1.0, 6),
        ) {
            let mixed = DMatrix::from_vec(6, 6, mixed);
            let covariance = &mixed * mixed.transpose() + DMatrix::identity(6, 6) * 0.3;
            let misses = DVector::from_vec(misses);
            let pulls = pulls(&covariance, &misses);
            let left = &misses - &covariance * &pulls;
            for (pull, left) in pulls.iter().zip(&left) {
                prop_assert!(*pull <= 0.0 && *left > -1e-4 && (pull * left).abs() < 1e-4, "{pulls} {left}");
            }
        }
    }

    /// Lines that no errors meet together take the more the longer they are pulled at, and never less than each alone.
    #[test]
    fn lines_against_each_other_take_more_than_each() {
        let (pulls, taken) = solved([1.0, -1.0, -1.0, 1.0], [-1.0; 2]);
        assert!(pulls.iter().all(|pull| pull.is_finite()) && taken > 100.0, "{pulls:?} {taken}");
    }
}
