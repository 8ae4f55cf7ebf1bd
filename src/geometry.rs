//! Points, angles and poses of the plane: SI units, radians, counter-clockwise positive (REP-103).
//!
//! A transform is named `a_from_b`: it takes coordinates of frame `b` to frame `a`, so that
//! `a_from_b.compose(&b_from_c)` visibly chains to `a_from_c`.

use std::f64::consts::{PI, TAU};

/// A point of the plane, metres.
pub type Point = nalgebra::Point2<f64>;
/// A displacement of the plane, metres.
pub type Vector = nalgebra::Vector2<f64>;
/// The derivative of a pose by another, over x, y, heading each.
pub type Jacobian = nalgebra::Matrix3<f64>;

/// An element of SE(2): the pose of one frame in another, or the transform between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres along the first axis.
    pub x: f64,
    /// Metres along the second axis.
    pub y: f64,
    /// Heading in radians, in (-pi, pi].
    pub theta: f64,
}

impl Pose {
    /// The neutral element.
    pub const IDENTITY: Pose = Pose { x: 0.0, y: 0.0, theta: 0.0 };

    /// A pose from metres and radians; the heading is wrapped into (-pi, pi].
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Pose { x, y, theta: wrap_angle(theta) }
    }

    /// `a_from_c` for `self = a_from_b` and `b_from_c`.
    pub fn compose(&self, b_from_c: &Pose) -> Pose {
        let at = self.transform_point(&Point::new(b_from_c.x, b_from_c.y));
        Pose::new(at.x, at.y, self.theta + b_from_c.theta)
    }

    /// `b_from_a` for `self = a_from_b`.
    pub fn inverse(&self) -> Pose {
        let back = self.rotation().inverse() * Vector::new(-self.x, -self.y);
        Pose::new(back.x, back.y, -self.theta)
    }

    /// `b_from_c` for `self = a_from_b` and `a_from_c`: what `compose` undoes.
    pub fn between(&self, a_from_c: &Pose) -> Pose {
        let ahead = self.rotation().inverse() * (a_from_c.position() - self.position());
        Pose::new(ahead.x, ahead.y, a_from_c.theta - self.theta)
    }

    /// The derivatives of [`Pose::compose`] by the x, y, heading of `self` and by those of its argument.
    pub fn compose_jacobians(&self, b_from_c: &Pose) -> [Jacobian; 2] {
        let ahead = self.rotate(&Vector::new(b_from_c.x, b_from_c.y));
        let (sin, cos) = self.theta.sin_cos();
        [
            Jacobian::new(1.0, 0.0, -ahead.y, 0.0, 1.0, ahead.x, 0.0, 0.0, 1.0),
            Jacobian::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0),
        ]
    }

    /// The derivatives of [`Pose::between`] by the x, y, heading of `self` and by those of its argument.
    pub fn between_jacobians(&self, a_from_c: &Pose) -> [Jacobian; 2] {
        let ahead = self.between(a_from_c);
        let (sin, cos) = self.theta.sin_cos();
        [
            Jacobian::new(-cos, -sin, ahead.y, sin, -cos, -ahead.x, 0.0, 0.0, -1.0),
            Jacobian::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0),
        ]
    }

    /// The coordinates in frame `a` of a point given in frame `b`, for `self = a_from_b`.
    pub fn transform_point(&self, point: &Point) -> Point {
        self.transform().point(point)
    }

    /// The same transform, made ready for many points.
    pub fn transform(&self) -> Transform {
        Transform { rotation: self.rotation(), translation: Vector::new(self.x, self.y) }
    }

    /// The direction in frame `a` of a vector given in frame `b`, for `self = a_from_b`.
    pub fn rotate(&self, vector: &Vector) -> Vector {
        self.rotation() * vector
    }

    /// The same pose in a frame with the same axes and its origin at a point.
    pub fn seen_from(&self, origin: &Point) -> Pose {
        Pose { x: self.x - origin.x, y: self.y - origin.y, theta: self.theta }
    }

    /// The position, without the heading.
    pub fn position(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// Whether all three numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.theta.is_finite()
    }

    fn rotation(&self) -> nalgebra::Rotation2<f64> {
        nalgebra::Rotation2::new(self.theta)
    }
}

/// A pose whose sine and cosine are known, for many points.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    rotation: nalgebra::Rotation2<f64>,
    translation: Vector,
}

impl Transform {
    /// As [`Pose::transform_point`].
    pub fn point(&self, point: &Point) -> Point {
        self.rotation * point + self.translation
    }

    /// As [`Pose::rotate`].
    pub fn rotate(&self, vector: &Vector) -> Vector {
        self.rotation * vector
    }
}

/// The angle of the same direction in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// How far to turn clockwise from one direction to reach another, in [0, 2 pi).
pub fn clockwise_from(start: f64, to: f64) -> f64 {
    let turn = (start - to).rem_euclid(TAU);
    // rem_euclid of a tiny negative number rounds to the modulus itself.
    if turn >= TAU { 0.0 } else { turn }
}

/// The unit vector of a direction.
pub fn direction(angle: f64) -> Vector {
    Vector::new(angle.cos(), angle.sin())
}

/// The direction of a vector, in (-pi, pi]; 0 for the zero vector.
pub fn bearing(vector: &Vector) -> f64 {
    wrap_angle(vector.y.atan2(vector.x))
}

/// How an error of a displacement moves a point that far beyond its end: as it is, and by its heading.
pub(crate) fn lever(reach: &Vector) -> Jacobian {
    Jacobian::new(1.0, 0.0, -reach.y, 0.0, 1.0, reach.x, 0.0, 0.0, 1.0)
}

/// The rotation of x and y by an angle.
pub(crate) fn rotation(angle: f64) -> Jacobian {
    let (sin, cos) = angle.sin_cos();
    Jacobian::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn half_turns_wrap_to_plus_pi() {
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(3.0 * PI), PI);
        assert_eq!(wrap_angle(TAU), 0.0);
    }

    #[test]
    fn clockwise_is_negative_rotation() {
        assert!((clockwise_from(PI / 2.0, 0.0) - PI / 2.0).abs() < 1e-12);
        assert!((clockwise_from(0.0, PI / 2.0) - 1.5 * PI).abs() < 1e-12);
        assert_eq!(clockwise_from(1.0, 1.0 + 1e-17), 0.0);
    }

    fn poses() -> impl Strategy<Value = Pose> {
        (-50.0..50.0, -50.0..50.0, -10.0..10.0).prop_map(|(x, y, theta)| Pose::new(x, y, theta))
    }

    fn near(a: &Pose, b: &Pose, tolerance: f64) -> bool {
        [a.x - b.x, a.y - b.y, wrap_angle(a.theta - b.theta)].iter().all(|d| d.abs() < tolerance)
    }

    /// A derivative by central differences.
    fn numeric(at: &Pose, of: impl Fn(&Pose) -> Pose) -> Jacobian {
        let step = 1e-5;
        let columns = [(step, 0.0, 0.0), (0.0, step, 0.0), (0.0, 0.0, step)].map(|(x, y, theta)| {
            let [more, less] =
                [1.0, -1.0].map(|s| of(&Pose::new(at.x + s * x, at.y + s * y, at.theta + s * theta)));
            let turned = wrap_angle(more.theta - less.theta);
            nalgebra::Vector3::new(more.x - less.x, more.y - less.y, turned) / (2.0 * step)
        });
        Jacobian::from_columns(&columns)
    }

    proptest! {
        #[test]
        fn poses_are_a_group(a in poses(), b in poses(), c in poses()) {
            prop_assert!(near(&a.compose(&b).compose(&c), &a.compose(&b.compose(&c)), 1e-9));
            prop_assert!(near(&a.compose(&Pose::IDENTITY), &a, 1e-12));
            prop_assert!(near(&Pose::IDENTITY.compose(&a), &a, 1e-12));
            prop_assert!(near(&a.compose(&a.inverse()), &Pose::IDENTITY, 1e-9));
            prop_assert!(near(&a.inverse().compose(&a), &Pose::IDENTITY, 1e-9));
        }

        #[test]
        fn between_undoes_compose(a in poses(), b in poses()) {
            prop_assert!(near(&a.between(&a.compose(&b)), &b, 1e-9));
            prop_assert!(near(&a.between(&b), &a.inverse().compose(&b), 1e-9));
        }

        #[test]
        fn a_pose_acts_on_points_as_it_composes(a in poses(), b in poses()) {
            let there = a.compose(&b).position();
            prop_assert!((there - a.transform_point(&b.position())).norm() < 1e-9);
        }

        #[test]
        fn jacobians_are_the_numeric_derivatives(a in poses(), b in poses()) {
            let [by_a, by_b] = a.compose_jacobians(&b);
            prop_assert!((by_a - numeric(&a, |a| a.compose(&b))).abs().max() < 1e-6);
            prop_assert!((by_b - numeric(&b, |b| a.compose(b))).abs().max() < 1e-6);
            let [by_a, by_b] = a.between_jacobians(&b);
            prop_assert!((by_a - numeric(&a, |a| a.between(&b))).abs().max() < 1e-6);
            prop_assert!((by_b - numeric(&b, |b| a.between(b))).abs().max() < 1e-6);
        }
    }
}
