//! The local perceptual model (LPM) of a place neighbourhood (seed, section 4.1).
//!
//! It is a bounded occupancy grid in a frame of its own, with the robot's pose in that frame at the moment of
//! arrival. The robot is expected to have settled, within the neighbourhood, what is free and what is not.

use crate::geometry::{Point, Pose};
use crate::grid::OccupancyGrid;

/// A bounded grid around a place and the pose at which the robot arrived in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lpm {
    /// The grid; its frame is the frame of the LPM.
    pub grid: OccupancyGrid,
    /// Pose of the robot on arrival, in the frame of the LPM.
    pub robot_pose: Pose,
    /// Where the robot has driven around the place, in the frame of the LPM; empty where it is not known.
    pub trail: Vec<Point>,
    /// The middle of the place, in the frame of the LPM, where the robot found it before: it stands at the edge of the
    /// place on arrival, where another place may be nearer. The place is looked for around the robot where it is not
    /// known.
    pub middle: Option<Point>,
}

impl Lpm {
    /// An LPM without a trail, of a robot that does not know the middle of the place.
    pub fn new(grid: OccupancyGrid, robot_pose: Pose) -> Self {
        Lpm { grid, robot_pose, trail: Vec::new(), middle: None }
    }

    /// The same LPM, its trail being the way on which the robot came to it where nothing more is known.
    #[must_use]
    pub fn reached_by(mut self, way: Option<Vec<Point>>) -> Self {
        if self.trail.is_empty() {
            self.trail = way.unwrap_or_default();
        }
        self
    }
}
