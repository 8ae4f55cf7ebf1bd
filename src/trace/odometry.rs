//! How uncertain raw wheel odometry is.

use crate::geometry::{Pose, Vector, bearing, direction, wrap_angle};
use nalgebra::{Matrix3, Vector3};

/// The errors of the wheel odometry of a robot of which nothing more is known. All are standard deviations.
///
/// The defaults are round numbers for a differential drive on office floors, on the large side of what such a robot
/// shows beside relative poses that were corrected by scan matching: 41 degrees of heading lost on 300 m, all in one
/// direction, a few degrees to either side of that, and one part in a hundred of a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryNoise {
    /// Heading gained or lost on all metres alike, radians a metre. Default 0.003: wheels that differ by a
    /// thousandth on an axle of a third of a metre.
    pub heading_bias: f64,
    /// Heading gained or lost anew on every metre, radians after one metre; grows with the root. Default 0.005.
    pub heading_noise: f64,
    /// Heading gained or lost anew on every radian turned, radians after one radian; grows with the root. Default
    /// 0.005: wheels slip where they turn.
    pub turn_noise: f64,
    /// Share of all lengths. Default 0.02: tyres give way, carpets pull.
    pub length_bias: f64,
}

impl Default for OdometryNoise {
    fn default() -> Self {
        OdometryNoise { heading_bias: 0.003, heading_noise: 0.005, turn_noise: 0.005, length_bias: 0.02 }
    }
}

impl OdometryNoise {
    /// The covariance of the last of a series of poses in the frame of `start`, one of them, row-major x, y, theta:
    /// of all that went wrong from the first pose on. Linear in the poses.
    pub fn covariance(&self, poses: &[Pose], start: &Pose) -> [f64; 9] {
        let start_from_odom = start.inverse();
        let seen: Vec<Pose> = poses.iter().map(|pose| start_from_odom.compose(pose)).collect();
        let Some(end) = seen.last().map(Pose::position) else { return [0.0; 9] };
        let (mut bias, mut scale) = (Vector3::zeros(), Vector3::zeros());
        let mut sum = Matrix3::zeros();
        for step in seen.windows(2) {
            let moved = step[1].position() - step[0].position();
            let (length, turned) = (moved.norm(), wrap_angle(step[1].theta - step[0].theta).abs());
            let heading = swings(&(end - step[1].position()));
            bias += heading * self.heading_bias * length;
            let noise = self.heading_noise.powi(2) * length + self.turn_noise.powi(2) * turned;
            sum += heading * heading.transpose() * noise;
            let along = direction(bearing(&moved)) * length;
            scale += Vector3::new(along.x, along.y, 0.0) * self.length_bias;
        }
        let covariance: Matrix3<f64> = sum + bias * bias.transpose() + scale * scale.transpose();
        std::array::from_fn(|k| covariance[(k / 3, k % 3)])
    }
}

/// What a radian of heading does to a pose so far ahead.
fn swings(reach: &Vector) -> Vector3<f64> {
    Vector3::new(-reach.y, reach.x, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_way_is_as_uncertain_as_its_length_says() {
        let noise = OdometryNoise { heading_noise: 0.0, ..OdometryNoise::default() };
        let poses: Vec<Pose> = (0..=200).map(|k| Pose::new(0.1 * f64::from(k), 5.0, 0.0)).collect();
        let covariance = noise.covariance(&poses, &poses[0]);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 0.02 * b, "{a} {b}");
        close(covariance[0].sqrt(), 0.02 * 20.0);
        close(covariance[8].sqrt(), 0.003 * 20.0);
        close(covariance[4].sqrt(), 0.003 * 20.0 * 10.0);
        // As much as the covariance of a travel may be asked for: symmetric.
        assert!((covariance[5] - covariance[7]).abs() < 1e-12);
    }

    #[test]
    fn an_error_before_the_start_counts_as_one_of_the_way() {
        let noise =
            OdometryNoise { heading_bias: 0.0, heading_noise: 0.0, length_bias: 0.0, turn_noise: 0.1 };
        let turned = [Pose::IDENTITY, Pose::new(0.0, 0.0, 1.0)];
        let poses = [turned[0], turned[1], turned[1].compose(&Pose::new(10.0, 0.0, 0.0))];
        let covariance = noise.covariance(&poses, &turned[1]);
        assert!((covariance[4].sqrt() - 1.0).abs() < 1e-9 && (covariance[8].sqrt() - 0.1).abs() < 1e-9);
    }
}
