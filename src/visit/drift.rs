//! How uncertain a way is as a whole.

use crate::geometry::Pose;
use crate::visit::Moment;
use nalgebra::{Matrix3, Vector3};

/// The covariance of the last of a series of moments in the frame of `start`, of all that went wrong since the first of
/// them, where the steps err each by itself. Linear in the moments.
pub fn covariance(way: &[Moment], start: &Pose) -> Matrix3<f64> {
    let start_from_local = start.inverse();
    let seen = |moment: &Moment| start_from_local.compose(&moment.local_from_robot);
    let Some(end) = way.last().map(|last| seen(last).position()) else { return Matrix3::zeros() };
    let felt = |moment: &Moment| {
        let pose = seen(moment);
        let (sin, cos) = pose.theta.sin_cos();
        let arm = end - pose.position();
        let jacobian = Matrix3::new(cos, -sin, -arm.y, sin, cos, arm.x, 0.0, 0.0, 1.0);
        jacobian * moment.drift * jacobian.transpose()
    };
    way.iter().skip(1).fold(Matrix3::zeros(), |sum, moment| sum + felt(moment))
}

/// The squared length of an error in units of a covariance (chi-square, 3 degrees of freedom); nothing for a
/// covariance that has no inverse.
pub fn chi_square(error: &Pose, covariance: &Matrix3<f64>) -> Option<f64> {
    let error = Vector3::new(error.x, error.y, error.theta);
    Some((error.transpose() * covariance.try_inverse()? * error).x)
}
