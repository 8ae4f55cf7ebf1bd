//! One sweep of a planar range finder.

use crate::geometry::{Point, Pose, direction};
use crate::sensor::log::LaserNumber;

/// A sweep of a planar range finder with the robot's odometry at that moment.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserScan {
    /// Which laser of the robot it is from.
    pub laser: LaserNumber,
    /// Seconds, as the log has them.
    pub stamp: f64,
    /// Pose of the robot in the odometry frame.
    pub odom_from_robot: Pose,
    /// Pose of the laser on the robot.
    pub robot_from_laser: Pose,
    /// Angle of the first beam in the laser's frame, radians.
    pub start_angle: f64,
    /// Angle between beams, radians, counter-clockwise.
    pub angle_increment: f64,
    /// Ranges in metres; `None` where the beam did not return.
    pub ranges: Vec<Option<f64>>,
}

impl LaserScan {
    /// The beams in their order: range and end point in the robot's frame, or nothing where it did not return.
    pub fn beams(&self) -> impl Iterator<Item = Option<(f64, Point)>> {
        let robot_from_laser = self.robot_from_laser.transform();
        self.ranges.iter().enumerate().map(move |(k, range)| {
            let angle = self.start_angle + self.angle_increment * k as f64;
            range.map(|r| (r, robot_from_laser.point(&Point::from(direction(angle) * r))))
        })
    }

    /// The end points of the beams that returned, in the robot's frame.
    pub fn hits(&self) -> impl Iterator<Item = Point> {
        self.beams().flatten().map(|(_, point)| point)
    }
}
