//! One travel as measured: the displacement from the frame of a visit to that of the next.

use crate::geometry::{Pose, Vector, direction};
use crate::metric::MetricParameters;
use crate::metric::uncertainty::factor;
use crate::trace::{Motion, Sighting};
use nalgebra::{Matrix3, Vector3};

/// A displacement from one frame to the next with the covariance of its coordinates x, y and theta, all in the
/// first frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leg {
    /// The second frame in the first.
    pub(super) pose: Pose,
    /// What odometry is uncertain of. It may be the same error on all travels.
    pub(super) odometry: Matrix3<f64>,
    /// The factor of that by causes.
    pub(super) causes: Matrix3<f64>,
    /// What the robot's own turning and wandering at its beginning adds; another one at each place.
    pub(super) stay: Matrix3<f64>,
}

/// A measured travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Travelled {
    /// Distance between the points of the two places, metres.
    pub(super) length: f64,
    /// Its variance, without that of the points.
    pub(super) length_variance: f64,
    /// The displacement, where the heading at its beginning is known.
    pub(super) leg: Option<Leg>,
    /// How far the robot strayed from the straight line between the points of the two places, metres, at most; where the trace
    /// tells the way it went.
    pub(super) stray: Option<f64>,
}

impl Travelled {
    /// The travel that led to a sighting, from the frame of a visit whose place has this point. Frames of visits
    /// have the axes of the observation and their origin at the point of the place.
    pub(super) fn new(
        motion: &Motion,
        before: &Sighting,
        now: &Sighting,
        parameters: &MetricParameters,
    ) -> Travelled {
        let covariance = Matrix3::from_row_slice(&motion.covariance);
        let end_from_frame = moved(&now.robot_pose, &-now.middle.coords).inverse();
        let Some(heading) = motion.heading else {
            // The robot starts at one point of a place and ends at one of another.
            return Travelled::of(motion.odometry.position().coords, covariance, None);
        };
        let start = Pose::new(motion.start.x, motion.start.y, heading);
        let frame_from_start = moved(&start, &-before.middle.coords);
        let end = frame_from_start.compose(&motion.odometry);
        let pose = end.compose(&end_from_frame);
        let turned = rotation(frame_from_start.theta);
        let reach = pose.position() - end.position();
        // An error of heading turns what lies beyond the end as well.
        let carried = lever(&reach) * turned;
        let odometry = carried * covariance * carried.transpose();
        let stay = match motion.start_given {
            true => Matrix3::zeros(),
            false => guessed(&(pose.position() - frame_from_start.position()), parameters),
        };
        let length_covariance = odometry + stay;
        let leg = Some(Leg { pose, odometry, causes: factor(&odometry), stay });
        let way = motion.shape.iter().map(|point| frame_from_start.transform_point(point).coords);
        let bent = parameters.sigmas * bend(&pose.position().coords, covariance.m33);
        let stray = stray(way, &pose.position().coords).map(|stray| stray + bent);
        Travelled { stray, ..Travelled::of(pose.position().coords, length_covariance, leg) }
    }

    fn of(displacement: Vector, covariance: Matrix3<f64>, leg: Option<Leg>) -> Travelled {
        let along = displacement.try_normalize(0.0).unwrap_or_else(|| direction(0.0));
        let along = Vector3::new(along.x, along.y, 0.0);
        let length_variance = (along.transpose() * covariance * along).x;
        Travelled { length: displacement.norm(), length_variance, leg, stray: None }
    }
}

/// How far points are from a straight line that begins at the origin; none where there are no points.
fn stray(way: impl Iterator<Item = Vector>, line: &Vector) -> Option<f64> {
    let along = line.try_normalize(0.0)?;
    way.map(|point| along.perp(&point).abs()).reduce(f64::max)
}

/// By how much a way that is straight by odometry bends aside, in standard deviations: a heading that is gained evenly bends it by
/// an eighth of its length times that heading, one that wanders by at most the root of a forty-eighth (the middle of an
/// integrated Brownian motion, seen from its chord).
fn bend(line: &Vector, heading_variance: f64) -> f64 {
    line.norm() * (heading_variance / 48.0).sqrt()
}

/// What it means that a travel starts where the robot arrived, turned: it stands elsewhere in the place, and has
/// turned by somewhat more or less.
fn guessed(reach: &Vector, parameters: &MetricParameters) -> Matrix3<f64> {
    let (extent, turn) = (parameters.extent_sigma.powi(2), parameters.bearing_sigma.powi(2));
    let carried = lever(reach);
    carried * Matrix3::from_diagonal(&Vector3::new(extent, extent, turn)) * carried.transpose()
}

/// How an error of a displacement moves a point that far beyond its end: as it is, and by its heading.
pub(super) fn lever(reach: &Vector) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, -reach.y, 0.0, 1.0, reach.x, 0.0, 0.0, 1.0)
}

/// The rotation of x and y by an angle.
pub(super) fn rotation(angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

fn moved(pose: &Pose, by: &Vector) -> Pose {
    Pose { x: pose.x + by.x, y: pose.y + by.y, ..*pose }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_heading_moves_what_lies_ahead_sideways() {
        let moved = lever(&Vector::new(10.0, 2.0)) * Vector3::new(0.0, 0.0, 0.1);
        assert_eq!(moved, Vector3::new(-0.2, 1.0, 0.1));
    }
}
