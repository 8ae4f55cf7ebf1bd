//! One travel as measured: the displacement from the frame of a visit to that of the next.

use crate::geometry::{Pose, Vector, direction, lever, rotation};
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
        let way: Vec<Vector> =
            motion.shape.iter().map(|point| frame_from_start.transform_point(point).coords).collect();
        let started = if motion.start_given { 0.0 } else { parameters.extent_sigma };
        let stray = stray(&way, &pose.position().coords, covariance.m33, started, parameters.sigmas);
        Travelled { stray, ..Travelled::of(pose.position().coords, length_covariance, leg) }
    }

    fn of(displacement: Vector, covariance: Matrix3<f64>, leg: Option<Leg>) -> Travelled {
        let along = displacement.try_normalize(0.0).unwrap_or_else(|| direction(0.0));
        let along = Vector3::new(along.x, along.y, 0.0);
        let length_variance = (along.transpose() * covariance * along).x;
        Travelled { length: displacement.norm(), length_variance, leg, stray: None }
    }
}

/// How far a way, as odometry has it, may have been from the straight line between the origin and its end, metres: none where it is
/// not told, or the line has no direction.
///
/// A heading that errs by `s` at the end, as it is gained on the way, bends a straight way aside by at most `s / sqrt(48)` of its
/// length where it wanders (the middle of an integrated Brownian motion, seen from its chord), and by an eighth where it is gained
/// evenly. Where the way is longer than the line, what moves the end turns the line, and all that lies far from it, by so much
/// more.
fn stray(way: &[Vector], line: &Vector, heading: f64, started: f64, sigmas: f64) -> Option<f64> {
    let along = line.try_normalize(0.0)?;
    let aside = way.iter().map(|point| along.perp(point).abs()).reduce(f64::max)?;
    let length: f64 = way.windows(2).map(|piece| (piece[1] - piece[0]).norm()).sum();
    let length = length.max(line.norm());
    let bent = length * (length / line.norm()) * (heading / 48.0).sqrt();
    let stray = aside + sigmas * (bent + started);
    stray.is_finite().then_some(stray)
}

/// What it means that a travel starts where the robot arrived, turned: it stands elsewhere in the place, and has
/// turned by somewhat more or less.
fn guessed(reach: &Vector, parameters: &MetricParameters) -> Matrix3<f64> {
    let (extent, turn) = (parameters.extent_sigma.powi(2), parameters.bearing_sigma.powi(2));
    let carried = lever(reach);
    carried * Matrix3::from_diagonal(&Vector3::new(extent, extent, turn)) * carried.transpose()
}

fn moved(pose: &Pose, by: &Vector) -> Pose {
    Pose { x: pose.x + by.x, y: pose.y + by.y, ..*pose }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way of corners, with a heading that is gained evenly, or slips at one point, by so much in all.
    fn bent(corners: &[[f64; 2]], by: f64, slips_at: Option<f64>) -> Vec<Vector> {
        let pieces: Vec<Vector> = corners
            .windows(2)
            .map(|ends| Vector::new(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]))
            .collect();
        let length: f64 = pieces.iter().map(|piece| piece.norm()).sum();
        let (mut at, mut gone, mut way) = (Vector::zeros(), 0.0, vec![Vector::zeros()]);
        for piece in pieces {
            let steps = (piece.norm() / 0.1).ceil();
            for _ in 0..steps as usize {
                let share = gone / length;
                let error = slips_at.map_or(by * share, |slips| if share < slips { 0.0 } else { by });
                at += nalgebra::Rotation2::new(error) * piece / steps;
                gone += piece.norm() / steps;
                way.push(at);
            }
        }
        way
    }

    /// Ways that turn back are seen along a line whose far end errors move by more than the line is long.
    #[test]
    fn no_likely_error_of_heading_takes_a_way_beyond_what_it_may_have_strayed() {
        let ways: [&[[f64; 2]]; 5] = [
            &[[0.0, 0.0], [20.0, 0.0]],
            &[[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [16.0, 4.0]],
            &[[0.0, 0.0], [20.0, 0.0], [20.0, 20.0]],
            &[[0.0, 0.0], [20.0, 0.0], [20.0, 6.0], [0.0, 6.0]],
            &[[0.0, 0.0], [25.0, 0.0], [25.0, 8.0], [8.0, 8.0]],
        ];
        for (which, corners) in ways.into_iter().enumerate() {
            let told = bent(corners, 0.0, None);
            for sigma in [0.01, 0.03, 0.06] {
                let most = stray(&told, &told[told.len() - 1], sigma * sigma, 0.0, 5.0).unwrap();
                for slips in [None, Some(0.2), Some(0.4), Some(0.6), Some(0.8)] {
                    for by in [-2.5 * sigma, 2.5 * sigma] {
                        let way = bent(corners, by, slips);
                        let true_one = stray(&way, &way[way.len() - 1], 0.0, 0.0, 5.0).unwrap();
                        assert!(true_one < most, "{which} {sigma} {slips:?} {by}: {true_one} {most}");
                    }
                }
            }
        }
        assert_eq!(stray(&[], &Vector::x(), 0.0, 0.0, 5.0), None);
        assert_eq!(stray(&[Vector::zeros()], &Vector::zeros(), 0.0, 0.0, 5.0), None);
        assert_eq!(stray(&[Vector::new(0.0, f64::MAX), Vector::zeros()], &Vector::x(), 0.1, 0.0, 5.0), None);
    }

    #[test]
    fn an_error_of_heading_moves_what_lies_ahead_sideways() {
        let moved = lever(&Vector::new(10.0, 2.0)) * Vector3::new(0.0, 0.0, 0.1);
        assert_eq!(moved, Vector3::new(-0.2, 1.0, 0.1));
    }
}
