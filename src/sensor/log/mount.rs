//! Where a laser sits on its robot.
//!
//! A message with two poses has the laser's first and the robot's second; the mount is
//! `robot_pose.inverse() * laser_pose`, a constant. Where it is none, or is longer than a robot, the first pose is
//! not odometry but the outcome of some mapping: the log was *corrected*, and the two poses say nothing about the mount.

use crate::geometry::{Pose, wrap_angle};
use crate::sensor::log::entry::{LaserNumber, Sweep, SweepPoses};
use crate::sensor::log::report::MountSource;
use std::f64::consts::{PI, TAU};

/// A laser sits no further from the middle of its robot, metres.
const LONGEST: f64 = 1.5;
/// How much the mount may differ between scans by rounding of what was logged: metres and radians.
const ROUNDING: f64 = 0.05;

/// What is known of the mount of one laser.
#[derive(Clone, Debug, Default)]
pub(super) struct Mount {
    option: Option<Pose>,
    pub(super) parameters: MountParameters,
    first: Option<Pose>,
    /// Whether the poses show that the log was corrected.
    pub(super) corrected: bool,
}

/// The robot's parameters that tell the mount: metres ahead and to the left, and the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MountParameters {
    pub(super) ahead: Option<f64>,
    pub(super) left: Option<f64>,
    pub(super) angle: Option<f64>,
}

impl Mount {
    pub(super) fn new(option: Option<Pose>) -> Self {
        Mount { option, ..Mount::default() }
    }

    /// Compares a sweep's poses with those before.
    pub(super) fn observe(&mut self, poses: &SweepPoses) {
        let offset = offset(poses);
        let first = *self.first.get_or_insert(offset);
        let moved = (offset.position() - first.position()).norm();
        let turned = wrap_angle(offset.theta - first.theta).abs();
        self.corrected |= length(&offset) > LONGEST || moved > ROUNDING || turned > ROUNDING;
    }

    /// The pose of the laser on the robot for a sweep.
    pub(super) fn robot_from_laser(&self, sweep: &Sweep) -> (Pose, MountSource) {
        let poses = sweep.poses.as_ref().filter(|_| !self.corrected);
        let first = self.first.filter(|first| length(first) <= LONGEST);
        if let Some(mount) = self.option {
            (mount, MountSource::Option)
        } else if let Some(mount) = sweep.robot_from_laser {
            (mount, MountSource::Transforms)
        } else if let Some(poses) = poses {
            (offset(poses), MountSource::Poses)
        } else if let Some(mount) = self.parameters.mount(sweep.laser) {
            (mount, MountSource::Parameters)
        } else if let Some(first) = first {
            (first, MountSource::FirstScan)
        } else {
            (Pose::new(0.0, 0.0, facing(sweep.laser)), MountSource::Assumed)
        }
    }
}

impl MountParameters {
    fn mount(&self, laser: LaserNumber) -> Option<Pose> {
        let ahead = self.ahead?;
        // Logged in degrees by some versions, in radians by others; no mount is turned by more than a turn.
        let angle = self.angle.map(|angle| if angle.abs() > TAU { angle.to_radians() } else { angle });
        Some(Pose::new(ahead, self.left.unwrap_or(0.0), angle.unwrap_or(facing(laser))))
    }
}

fn facing(laser: LaserNumber) -> f64 {
    if laser == LaserNumber::REAR { PI } else { 0.0 }
}

fn offset(poses: &SweepPoses) -> Pose {
    poses.odom_from_robot.inverse().compose(&poses.world_from_laser)
}

fn length(pose: &Pose) -> f64 {
    pose.x.hypot(pose.y)
}
