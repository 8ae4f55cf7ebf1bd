//! How far the end of a chain of displacements may be off.
//!
//! Let `e` be the error of a displacement that begins in a frame of rotation `R` and ends at `p`, all seen from
//! where the chain begins. It moves the end `q` of the chain by `A e`, where `A` turns by `R` and lets an error of
//! heading swing what lies between `p` and `q`. Covariances come without a word on how the errors of one travel go
//! with those of the next. If they are independent, the end has the covariance `I`, the sum of all `A C A'`; if they
//! are one and the same error throughout, each time as large as its covariance allows, it is `F F'` with `F` the sum
//! of all `A L`, `L L' = C`. A mixture, in which some share of each variance is new on every travel and the rest the
//! same on all, has the mean of the two, weighed by the shares: so what bounds both, in the order of covariances,
//! bounds every mixture. It need not be their sum: `(I + F F' + |I - F F'|) / 2` does, and is no more than either
//! where they agree. This is done for each of three causes by itself, of which `L` has a column each, as one may be
//! new and another the same: what drives heading and what that brings with it, then length, then drift aside.
//!
//! All this is of first order. An error `f` of heading displaces what lies `d` ahead by `f d` sideways and by up to
//! `f f d / 2` more (Taylor). Within the gate `f` is at most that many standard deviations, so that the sum of these
//! is a bound on what first order leaves out. A displacement agrees if it lies in the ellipsoid of the gate
//! widened by a disc of that size; what is computed is an ellipsoid around both.

use crate::geometry::{Pose, Vector};
use crate::metric::chain::Step;
use crate::metric::leg::{lever, rotation};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A chain of displacements, composed.
#[derive(Debug)]
pub(super) struct Composed {
    /// The last frame in the first.
    pub(super) pose: Pose,
    /// Each displacement with where it is seen to begin and to end.
    placed: Vec<Placed>,
}

#[derive(Debug)]
struct Placed {
    step: Step,
    /// The rotation of the frame that the displacement is measured in.
    turned: f64,
    /// Where it ends, in the direction in which it was measured.
    end: Vector,
}

/// The covariance of a displacement and the bound on what first order leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uncertainty {
    /// Of x, y and heading.
    pub(super) covariance: Matrix3<f64>,
    /// Metres, for errors of heading up to the gate given.
    pub(super) slack: f64,
}

impl Composed {
    /// The composition of the steps of a chain.
    pub(super) fn new(steps: Vec<Step>) -> Composed {
        let mut pose = Pose::IDENTITY;
        let mut placed = Vec::with_capacity(steps.len());
        for step in steps {
            let (begin, next) = match step.back {
                false => (pose, pose.compose(&step.leg.pose)),
                true => {
                    let next = pose.compose(&step.leg.pose.inverse());
                    (next, next)
                }
            };
            let end = if step.back { pose } else { next };
            placed.push(Placed { step, turned: begin.theta, end: end.position().coords });
            pose = next;
        }
        Composed { pose, placed }
    }

    /// The steps again.
    pub(super) fn into_steps(self) -> Vec<Step> {
        self.placed.into_iter().map(|placed| placed.step).collect()
    }

    /// How far the chain and one travel from where the chain begins, `direct`, may be apart at its end. The errors of
    /// the travel may be those of the chain as well. `gate` is in standard deviations.
    pub(super) fn against(&self, direct: &Step, gate: f64) -> Uncertainty {
        let mut causes = [Cause::default(); 3];
        Cause::add(&mut causes, &factor(&direct.leg.odometry));
        let mut covariance = direct.leg.stay;
        // The variance of the heading so far, and its share if all errors are the same.
        let (mut heading, mut heading_same) = (0.0, 0.0);
        let mut slack = 0.0;
        let end = self.pose.position().coords;
        for Placed { step, turned, end: ends } in &self.placed {
            let length = step.leg.pose.x.hypot(step.leg.pose.y);
            let sign = if step.back { -1.0 } else { 1.0 };
            let moves = lever(&(end - ends)) * rotation(*turned);
            let (odometry, stay) = (&step.leg.odometry, &step.leg.stay);
            covariance += moves * stay * moves.transpose();
            Cause::add(&mut causes, &(moves * factor(odometry) * -sign));
            let advance = |heading: &mut f64, heading_same: &mut f64| {
                *heading += odometry.m33 + stay.m33;
                *heading_same += sign * odometry.m33.sqrt();
            };
            // Gone backwards, a displacement is turned by its own error too.
            if step.back {
                advance(&mut heading, &mut heading_same);
            }
            slack += length * gate * gate * (heading + heading_same * heading_same) / 2.0;
            if !step.back {
                advance(&mut heading, &mut heading_same);
            }
        }
        covariance += causes.iter().map(Cause::bound).sum::<Matrix3<f64>>();
        Uncertainty { covariance, slack }
    }
}

/// What one cause of errors does to the end of a chain.
#[derive(Clone, Copy, Debug, Default)]
struct Cause {
    /// The covariance if it is another one on every travel.
    new: Matrix3<f64>,
    /// The error if it is the same on all, for one standard deviation of it.
    same: Vector3<f64>,
}

impl Cause {
    /// Adds a displacement, by what each cause does of it.
    fn add(causes: &mut [Cause; 3], columns: &Matrix3<f64>) {
        for (cause, column) in causes.iter_mut().zip(columns.column_iter()) {
            cause.new += column * column.transpose();
            cause.same += column;
        }
    }

    /// A covariance that bounds every mixture.
    fn bound(&self) -> Matrix3<f64> {
        let same = self.same * self.same.transpose();
        // In units in which metres and radians weigh alike; any units give a bound.
        let units = (self.new + same).diagonal().map(|variance| variance.max(f64::MIN_POSITIVE).sqrt());
        let scaled = |covariance: Matrix3<f64>| covariance.component_div(&(units * units.transpose()));
        let (new, same) = (scaled(self.new), scaled(same));
        let apart = (new - same).symmetric_eigen();
        let spread = apart.eigenvectors
            * Matrix3::from_diagonal(&apart.eigenvalues.abs())
            * apart.eigenvectors.transpose();
        ((new + same + spread) / 2.0).component_mul(&(units * units.transpose()))
    }
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
    use crate::metric::leg::Leg;

    fn step(pose: Pose, heading: f64, back: bool) -> Step {
        let odometry = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, heading * heading));
        Step { leg: Leg { pose, odometry, stay: Matrix3::zeros() }, back, travel: None }
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

    #[test]
    fn what_bounds_a_cause_bounds_every_mixture() {
        let mut causes = [Cause::default(); 3];
        for (k, turn) in [0.3, 1.2, -0.7, 2.0].into_iter().enumerate() {
            let covariance = Matrix3::new(2.0, 0.3, -0.04, 0.3, 1.5, 0.02, -0.04, 0.02, 0.01);
            let reach = Vector::new(k as f64, 3.0 - k as f64);
            Cause::add(&mut causes, &(lever(&reach) * rotation(turn) * factor(&covariance)));
        }
        for cause in causes {
            let same = cause.same * cause.same.transpose();
            assert!(cause.bound().trace() <= (cause.new + same).trace() + 1e-9);
            for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let left = cause.bound() - cause.new * share - same * (1.0 - share);
                assert!(left.symmetric_eigenvalues().min() > -1e-9, "{left}");
            }
        }
        assert_eq!(Cause::default().bound(), Matrix3::zeros());
    }

    #[test]
    fn out_and_back_the_same_error_cancels() {
        let leg = Pose::new(10.0, 1.0, 0.5);
        let there_and_back = Composed::new(vec![step(leg, 0.1, false), step(leg, 0.1, true)]);
        assert!(
            there_and_back.pose.position().coords.norm() < 1e-12 && there_and_back.pose.theta.abs() < 1e-12
        );
        let still = step(Pose::IDENTITY, 0.0, false);
        let off = there_and_back.against(&still, 5.0);
        // New errors of 0.1 rad, twice; the same one would cancel.
        assert!((off.covariance.m33 - 0.02).abs() < 1e-12);
    }

    #[test]
    fn first_order_and_slack_bound_what_a_wrong_heading_does() {
        // Three sides of a square, each turned by the same error of up to five standard deviations.
        let corner = Pose::new(10.0, 0.0, std::f64::consts::FRAC_PI_2);
        let sigma = 0.04;
        let believed = Composed::new(vec![step(corner, sigma, false); 3]);
        let still = step(Pose::IDENTITY, 0.0, false);
        for error in (-50..=50).map(|tenth| 0.1 * f64::from(tenth) * sigma) {
            let turned = Pose::new(corner.x, corner.y, corner.theta + error);
            let truth = Composed::new(vec![step(turned, sigma, false); 3]).pose;
            let gate = 5.0;
            let uncertainty = believed.against(&still, gate);
            let off = believed.pose.position() - truth.position();
            let chi_square = uncertainty.of_position(&Vector2::new(off.x, off.y), gate).unwrap();
            assert!(chi_square <= gate * gate, "{error}: {chi_square}");
            assert!(off.norm() <= uncertainty.radius(gate));
        }
    }
}
