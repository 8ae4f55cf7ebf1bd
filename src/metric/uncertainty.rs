//! How far a displacement may be off, and its causes.
//!
//! A covariance comes without a word on how the errors of one travel go with those of the next. It is split by cause:
//! what drives heading and what that brings with it, then length, then drift aside. Each may be new on every travel
//! or the same on all.
//!
//! All this is of first order. An error `f` of heading displaces what lies `d` ahead by `f d` sideways and by up to
//! `f f d / 2` more (Taylor). Within the gate `f` is at most that many standard deviations, so that the sum of these
//! is a bound on what first order leaves out. A displacement agrees if it lies in the ellipsoid of the gate
//! widened by a disc of that size; what is computed is an ellipsoid around both.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// The covariance of a displacement and the bound on what first order leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uncertainty {
    /// Of x, y and heading.
    pub(super) covariance: Matrix3<f64>,
    /// Metres, for errors of heading up to the gate given.
    pub(super) slack: f64,
}

impl Uncertainty {
    /// Chi-square of a difference of poses, where the gate is this many standard deviations.
    pub(super) fn of_pose(&self, difference: &Vector3<f64>, gate: f64) -> Option<f64> {
        let (along, aside) = self.widened(gate);
        let covariance = self.covariance * along + Matrix3::from_diagonal(&Vector3::new(aside, aside, 0.0));
        Some(difference.dot(&covariance.cholesky()?.solve(difference)))
    }

    /// Chi-square of a difference of positions.
    pub(super) fn of_position(&self, difference: &Vector2<f64>, gate: f64) -> Option<f64> {
        let (along, aside) = self.widened(gate);
        let covariance = self.position() * along + Matrix2::identity() * aside;
        Some(difference.dot(&covariance.cholesky()?.solve(difference)))
    }

    /// How far from the origin a position is at most, metres, that lies in the gate's ellipse around an estimate.
    ///
    /// By duality every `m` above the squares `s` of the ellipse's axes bounds the square of that distance, by
    /// `m + sum m a a / (m - s)` for an estimate `a` on these axes; the least bound is the distance.
    pub(super) fn at_most(&self, estimate: &Vector2<f64>, gate: f64) -> f64 {
        let axes = self.position().symmetric_eigen();
        let along = axes.eigenvectors.transpose() * estimate;
        let squares = axes.eigenvalues.map(|variance| variance.max(0.0) * gate * gate);
        let longest = squares.max();
        let (mut low, mut high) = (longest, longest + longest.sqrt() * along.norm());
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            let slope = along.zip_map(&squares, |a, s| s * (a / (middle - s)).powi(2));
            if slope.sum() > 1.0 { low = middle } else { high = middle }
        }
        let beyond = along.zip_map(&squares, |a, s| if high > s { high * a * a / (high - s) } else { a * a });
        (high + beyond.sum()).sqrt() + self.slack
    }

    fn position(&self) -> Matrix2<f64> {
        self.covariance.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// The factor of the covariance and what is added to it, so that its gate's ellipsoid holds the sum of the
    /// ellipsoid as it is and a disc of the slack. Of all such ellipsoids the one of least trace.
    fn widened(&self, gate: f64) -> (f64, f64) {
        let size = gate * self.position().trace().max(0.0).sqrt();
        if self.slack <= 0.0 || size <= 0.0 {
            return (1.0, (self.slack / gate).powi(2));
        }
        (1.0 + self.slack / size, (1.0 + size / self.slack) * (self.slack / gate).powi(2))
    }
}

/// Steps of bisection, for fifteen digits.
const HALVINGS: usize = 50;

/// How often five standard deviations are exceeded.
pub(super) const TAIL: f64 = 5.733e-7;

/// The probability that chi-square of so many degrees of freedom, or of one more where they are odd, exceeds a value.
pub(super) fn exceeded(value: f64, degrees: usize) -> f64 {
    let half = value / 2.0;
    let mut term = (-half).exp();
    let mut sum = term;
    for step in 1..degrees.div_ceil(2) {
        term *= half / step as f64;
        sum += term;
    }
    sum
}

/// The value that chi-square of so many degrees of freedom exceeds as rarely as that.
pub(super) fn quantile(degrees: usize) -> f64 {
    // Beyond the mean, at most six standard deviations and as much as for one degree of freedom.
    let (mut low, mut high) = (0.0, degrees as f64 + 6.0 * (2.0 * degrees as f64).sqrt() + 40.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if exceeded(middle, degrees) > TAIL { low = middle } else { high = middle }
    }
    high
}

/// A factor `L` of a covariance, `L L' = C`: its last column is what an error of heading brings with it, its first
/// what an error of x brings with it else. What is not positive, but for rounding, counts as nothing.
pub(super) fn factor(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let mut left = *covariance;
    let mut columns = Matrix3::zeros();
    for at in [2, 0, 1] {
        let variance = left[(at, at)];
        if variance > f64::EPSILON * covariance.amax() {
            let column = left.column(at) / variance.sqrt();
            left -= column * column.transpose();
            columns.set_column(at, &column);
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn gates_of_two_degrees_are_one() {
        let gate = crate::metric::MetricParameters::default().position_gate;
        assert!((quantile(2) - gate).abs() < 1e-3, "{}", quantile(2));
        // Of an odd number that of one more; each is beyond those of fewer.
        assert_eq!(quantile(3).to_bits(), quantile(4).to_bits());
        assert!((1..100).all(|degrees| quantile(degrees) < quantile(degrees + 2)));
        // About the normal distribution's five standard deviations for many (Fisher).
        let many = 400.0_f64;
        assert!(((2.0 * quantile(400)).sqrt() - (2.0 * many - 1.0).sqrt() - 4.87).abs() < 0.3);
    }

    #[test]
    fn the_farthest_point_is_that_found_all_around() {
        for (estimate, axes) in [((1.0, 2.0), (3.0, 0.5)), ((0.0, 2.0), (3.0, 0.5)), ((0.0, 0.0), (1.0, 0.0))]
        {
            let (estimate, turn) = (Vector2::new(estimate.0, estimate.1), nalgebra::Rotation2::new(0.4));
            let half = turn.matrix() * Matrix2::from_diagonal(&Vector2::new(axes.0, axes.1));
            let estimate = turn * estimate;
            let covariance = (half * half.transpose()).insert_row(2, 0.0).insert_column(2, 0.0);
            let around = (0..10_000).map(|part| f64::from(part) / 1e4 * TAU);
            let point = |angle: f64| (estimate + half * Vector2::new(angle.cos(), angle.sin()) * 2.0).norm();
            let farthest = around.map(point).fold(0.0, f64::max);
            let bound = Uncertainty { covariance, slack: 0.5 }.at_most(&estimate, 2.0);
            assert!((bound - 0.5 - farthest).abs() < 1e-5, "{bound} {farthest}");
        }
    }

    #[test]
    fn factors_multiply_to_what_they_are_of() {
        let covariance = Matrix3::new(2.0, 0.3, -0.4, 0.3, 1.5, 0.2, -0.4, 0.2, 0.7);
        let root = factor(&covariance);
        assert!((root * root.transpose() - covariance).amax() < 1e-12);
        assert_eq!(factor(&Matrix3::zeros()), Matrix3::zeros());
        let flat = Matrix3::from_diagonal(&Vector3::new(0.0, 4.0, 0.0));
        assert_eq!(factor(&flat) * factor(&flat).transpose(), flat);
    }
}
