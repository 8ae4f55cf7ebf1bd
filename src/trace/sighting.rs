//! What an observation tells, and what was measured of the travel that led to it.

use crate::geometry::{Point, Pose};
use crate::star::{SlotIndex, SmallScaleStar};

/// What an observation tells the logic.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// The star seen.
    pub star: SmallScaleStar,
    /// The slot the robot is at: on arrival the directed fragment it came in on.
    pub arrival: SlotIndex,
    /// The slot of the previous star by which it left; `None` at the first observation.
    pub departure: Option<SlotIndex>,
    /// The point of the place, in the frame of the observation, metres: the middle of a described LPM, the origin of
    /// a bare star's frame, which is where the robot stood on arrival unless `robot_pose` says otherwise.
    pub middle: Point,
    /// The robot's pose on arrival in the frame of the observation.
    pub robot_pose: Pose,
    /// What was measured of the travel that led here; `None` unless it has odometry and a covariance.
    pub motion: Option<Motion>,
}

/// A measured travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Where the travel began, in the frame of the observation before it.
    pub start: Point,
    /// Heading at its beginning in that frame, radians: as given, or that of the arrival, turned. `None` where the
    /// robot turned to a slot without bearing by an angle not measured.
    pub heading: Option<f64>,
    /// Whether the trace gave the pose at its beginning, so that it need not be guessed from the arrival.
    pub start_given: bool,
    /// Displacement of the robot, in its frame at the beginning.
    pub odometry: Pose,
    /// Covariance of the displacement, row-major x, y, theta.
    pub covariance: [f64; 9],
    /// The way it went, points in the frame of the displacement, its beginning and its end among them; empty where that was not
    /// told.
    pub shape: Vec<Point>,
}

/// A star and the slot the robot is at in it, read off an LPM.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// The star.
    pub star: SmallScaleStar,
    /// The directed fragment the robot came in on; at the first observation the slot it faces.
    pub arrival: SlotIndex,
    /// The middle of the place, in the frame of the LPM.
    pub middle: Point,
}
