//! Two travels, one after the other, as one.

use crate::geometry::Pose;
use crate::trace::{Motion, Sighting};
use nalgebra::{Matrix2, Matrix3};

/// The motion of the travel to a visit, of the stay there, and of the travel on, as one; `None` where any of it was not
/// measured. Covariances add up to first order, as of independent errors.
pub(super) fn joined(to: &Sighting, on: &Motion) -> Option<Motion> {
    let first = to.motion.as_ref()?;
    let start = Pose { x: on.start.x, y: on.start.y, theta: on.heading? };
    let stay = to.robot_pose.inverse().compose(&start);
    let before = first.odometry.compose(&stay);
    let odometry = before.compose(&on.odometry);
    // What the first travel errs in heading turns all that follows about its end.
    let lever = odometry.position() - first.odometry.position();
    let swung = Matrix3::new(1.0, 0.0, -lever.y, 0.0, 1.0, lever.x, 0.0, 0.0, 1.0);
    let (sine, cosine) = before.theta.sin_cos();
    let turned = Matrix2::new(cosine, -sine, sine, cosine).to_homogeneous();
    let [one, other] = [first.covariance, on.covariance].map(|c| Matrix3::from_row_slice(&c));
    let sum = swung * one * swung.transpose() + turned * other * turned.transpose();
    // A covariance is symmetric to the last bit.
    let sum = (sum + sum.transpose()) / 2.0;
    let shape = match [&first.shape, &on.shape].iter().any(|shape| shape.is_empty()) {
        true => Vec::new(),
        false => {
            let then = on.shape.iter().map(|point| before.transform_point(point));
            first.shape.iter().copied().chain(then).collect()
        }
    };
    let covariance = std::array::from_fn(|k| sum[(k / 3, k % 3)]);
    Some(Motion { odometry, covariance, shape, ..*first })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::star::{ControlLaw, Direction, FragmentId, GatewayId, Slot, SlotIndex, SmallScaleStar};

    fn motion(start: Pose, odometry: Pose, spread: f64) -> Motion {
        let covariance = std::array::from_fn(|k| if k % 4 == 0 { spread * (1.0 + k as f64) } else { 0.0 });
        Motion {
            start: start.position(),
            heading: Some(start.theta),
            start_given: true,
            odometry,
            covariance,
            shape: vec![Point::origin(), odometry.position()],
        }
    }

    fn visit(robot_pose: Pose, motion: Motion) -> Sighting {
        let slot = |direction, outward, inward| Slot {
            fragment: FragmentId(1),
            direction,
            outward,
            inward,
            control: ControlLaw::Midline,
            bearing: None,
            width: None,
            margin: None,
        };
        let gateway = Some(GatewayId(1));
        let slots = vec![slot(Direction::Plus, gateway, None), slot(Direction::Minus, None, gateway)];
        let star = SmallScaleStar::new(slots).unwrap();
        let (arrival, middle) = (SlotIndex(1), Point::origin());
        Sighting { star, arrival, departure: None, middle, robot_pose, motion: Some(motion) }
    }

    /// Against what small errors of either travel do to the whole, one by one.
    #[test]
    fn errors_of_two_travels_come_together_as_they_do_in_poses() {
        let (first, second) = (Pose::new(7.0, 1.0, 0.9), Pose::new(5.0, -2.0, -0.4));
        let (arrival, start) = (Pose::new(0.3, -0.2, 2.0), Pose::new(1.1, 0.6, 2.7));
        let to = visit(arrival, motion(Pose::IDENTITY, first, 0.01));
        let on = motion(start, second, 0.02);
        let found = joined(&to, &on).unwrap();
        let stay = arrival.inverse().compose(&start);
        let whole = |a: &Pose, b: &Pose| a.compose(&stay).compose(b);
        let exact = whole(&first, &second);
        assert!((found.odometry.position() - exact.position()).norm() < 1e-12);
        // The way of the second travel goes on from where that of the first one and the stay have led.
        let way = [Pose::IDENTITY, first, first.compose(&stay), exact].map(|pose| pose.position());
        assert!(found.shape.iter().zip(way).all(|(found, exact)| (found - exact).norm() < 1e-12));
        assert_eq!(found.shape.len(), way.len());
        let mut sum = Matrix3::zeros();
        for (which, covariance) in [(0, to.motion.as_ref().unwrap().covariance), (1, on.covariance)] {
            for axis in 0..3 {
                let small = 1e-6;
                let off = |pose: &Pose| {
                    let [x, y, theta] = std::array::from_fn(|k| if k == axis { small } else { 0.0 });
                    Pose { x: pose.x + x, y: pose.y + y, theta: pose.theta + theta }
                };
                let moved = match which {
                    0 => whole(&off(&first), &second),
                    _ => whole(&first, &off(&second)),
                };
                let by: Vector = (moved.position() - exact.position()) / small;
                let by = nalgebra::Vector3::new(by.x, by.y, (moved.theta - exact.theta) / small);
                sum += by * by.transpose() * covariance[4 * axis];
            }
        }
        let covariance = Matrix3::from_row_slice(&found.covariance);
        assert!((covariance - sum).amax() < 1e-5, "{covariance} {sum}");
        let untold = joined(&to, &Motion { shape: Vec::new(), ..on.clone() });
        assert_eq!(untold, Some(Motion { shape: Vec::new(), ..found }));
        assert_eq!(joined(&Sighting { motion: None, ..to }, &on), None);
    }
}
