//! Visits: when a robot that drives about is at a place, and what it saw there (seed, sections 3.1 and 4.1).
//!
//! Where a robot has no choice but to go on along one path, it travels; everywhere else it is at a place. Each piece of
//! its way is judged by the star of the grid around it, once the robot is some metres further, as a
//! range finder that looks ahead does not see what is beside it. The place is what several pieces of the way
//! agree on.

mod annotated;
mod detector;
pub mod drift;
mod follower;
mod passage;
mod recollection;
pub mod relations;
mod sighting;
mod stay;
pub mod truth;

pub use annotated::{AnnotatedVisits, ArrivalsError};
pub use detector::VisitDetector;

use crate::geometry::{Point, Pose, bearing};
use crate::lpm::Lpm;
use crate::sensor::{EvidenceParameters, MatchingParameters};
use crate::star::PerceptionParameters;
use nalgebra::Matrix3;

/// How visits are found, metres. One set of defaults serves all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisitParameters {
    /// How scans are matched.
    pub matching: MatchingParameters,
    /// How scans are made a grid.
    pub evidence: EvidenceParameters,
    /// How stars are read.
    pub perception: PerceptionParameters,
    /// Side of a cell. Default 0.05.
    pub resolution: f64,
    /// Side of the square LPM. Default 20.
    pub side: f64,
    /// Length of way between two points at which the surroundings are judged. Default 0.5.
    pub spacing: f64,
    /// How far the robot drives on before they are judged. Default 8: it has then seen beyond the window of a place.
    pub lag: f64,
    /// Middles nearer to each other than this are of one place: two pieces of way differ in what they saw.
    /// Default 1.5.
    pub agreement: f64,
    /// How near to the middle, outside the circle of its clearance, the robot must come to be at the place. Default 0.5.
    pub presence: f64,
    /// Length of way on which a place must be seen, while the robot is near, to be one. Default 1.5.
    pub hysteresis: f64,
}

impl Default for VisitParameters {
    fn default() -> Self {
        VisitParameters {
            matching: MatchingParameters::default(),
            evidence: EvidenceParameters::default(),
            perception: PerceptionParameters::default(),
            resolution: 0.05,
            side: 20.0,
            spacing: 0.5,
            lag: 8.0,
            agreement: 1.5,
            presence: 0.5,
            hysteresis: 1.5,
        }
    }
}

impl VisitParameters {
    /// Whether two middles, each found on one visit, are of one place.
    pub(crate) fn is_one_place(&self, one: &Point, other: &Point) -> bool {
        (one - other).norm() <= 2.0 * self.agreement
    }
}

/// A stay of the robot at a place. Poses are in the local frame of scan matching.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// The middle of the place.
    pub center: Point,
    /// What was seen over the whole visit, in a frame with the axes of the local frame and its origin in the middle of
    /// the place. Where the place was read before, and its walls of then are remembered still, it is what was seen then, if the
    /// robot came in and left by gateways that it had. Its robot pose is that of the arrival.
    pub lpm: Lpm,
    /// The scan at which the robot came in, counted from 0, and its pose.
    pub arrival: Moment,
    /// The scan at which it was out again, and its pose.
    pub departure: Moment,
}

impl Visit {
    /// The direction in which the robot left, seen from the middle of the place, radians.
    pub fn way_out(&self) -> f64 {
        bearing(&(self.departure.local_from_robot.position() - self.center))
    }
}

/// A scan and the pose of the robot at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Index of the scan in the log, from 0.
    pub scan: usize,
    /// The robot's pose in the local frame.
    pub local_from_robot: Pose,
    /// The covariance of the motion since the moment before, x, y, heading in the robot's frame.
    pub drift: Matrix3<f64>,
    /// Metres driven since the log began.
    pub driven: f64,
}

impl Moment {
    /// Those of a way from one scan to another, both included.
    fn between(way: &[Moment], from: usize, to: usize) -> &[Moment] {
        let at = |scan: usize| way.partition_point(|moment| moment.scan < scan);
        &way[at(from)..at(to.saturating_add(1)).max(at(from))]
    }
}

/// A visit and the way to it: all moments from the arrival at the visit before, or from the beginning of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The moments up to the arrival, which is the last of them.
    pub way: Vec<Moment>,
    /// The visit it leads to.
    pub visit: Visit,
}
