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

    /// The radius, in metres, of a disc around the estimate that holds the position.
    pub(super) fn radius(&self, gate: f64) -> f64 {
        gate * self.position().symmetric_eigenvalues().max().max(0.0).sqrt() + self.slack
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
