//! Points, angles and poses of the plane: SI units, radians, counter-clockwise positive (REP-103).
//!
//! A transform is named `a_from_b`: it takes coordinates of frame `b` to frame `a`, so that
//! `a_from_b.compose(&b_from_c)` visibly chains to `a_from_c`.

use std::f64::consts::{PI, TAU};

/// A point of the plane, metres.
pub type Point = nalgebra::Point2<f64>;
/// A displacement of the plane, metres.
pub type Vector = nalgebra::Vector2<f64>;

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
