//! What a log holds, one entry after the other, whatever its format.

use crate::geometry::Pose;
use std::borrow::Cow;
use std::fmt;

/// One line or message of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The name of the message, such as `FLASER` or a topic.
    pub kind: Cow<'static, str>,
    /// What it says.
    pub content: Content,
}

/// What an entry says.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A sweep of a laser.
    Sweep(Sweep),
    /// Where odometry has the robot.
    Odometry {
        /// Seconds; `None` if the entry has no stamp.
        stamp: Option<f64>,
        /// Pose of the robot in the odometry frame.
        odom_from_robot: Pose,
    },
    /// Where the robot truly was, as a simulator tells it.
    Truth {
        /// Seconds; `None` if the entry has no stamp.
        stamp: Option<f64>,
        /// Pose of the robot in the world.
        world_from_robot: Pose,
        /// Pose of the robot in the odometry frame at that moment.
        odom_from_robot: Pose,
    },
    /// A setting of the robot that was logged.
    Parameter {
        /// Its name, module first.
        name: String,
        /// Its value as it stands in the log.
        value: String,
    },
    /// Something that scans need, and that is known already.
    Known,
    /// Something that scans do not need.
    Other,
    /// What the source chose or guessed, a sentence.
    Remark(String),
    /// The log breaks off.
    CutOff(CutOff),
}

/// How a log breaks off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutOff {
    /// The last line is not complete; it is left out.
    Line(u64),
    /// The compressed stream or the bag ends before its end; what had come by then is taken.
    Stream,
}

/// A sweep of a laser as the log has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Which laser.
    pub laser: LaserNumber,
    /// Seconds; `None` if the entry has no stamp.
    pub stamp: Option<f64>,
    /// Angle of the first beam in the laser's frame, radians, if the entry says it.
    pub start_angle: Option<f64>,
    /// Angle between beams, radians, counter-clockwise, if the entry says it.
    pub angle_increment: Option<f64>,
    /// Metres; not finite, or nought and less, where the entry itself says that nothing came back.
    pub ranges: Vec<f64>,
    /// Ranges from here on mean that nothing came back, if the entry says it; metres.
    pub no_return_from: Option<f64>,
    /// The poses in the entry.
    pub poses: Option<SweepPoses>,
    /// Pose of the laser on the robot, where the log knows it better than by the poses.
    pub robot_from_laser: Option<Pose>,
}

/// The two poses that come with a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepPoses {
    /// Pose of the laser: in the odometry frame, or corrected in the frame of a map.
    pub world_from_laser: Pose,
    /// Pose of the robot in the odometry frame.
    pub odom_from_robot: Pose,
}

/// The number of a laser on its robot: CARMEN calls the front one 1 and the rear one 2; a bag's is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaserNumber(pub u8);

impl LaserNumber {
    /// The laser that looks ahead.
    pub const FRONT: LaserNumber = LaserNumber(1);
    /// The laser that looks back.
    pub const REAR: LaserNumber = LaserNumber(2);
}

impl fmt::Display for LaserNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            LaserNumber::FRONT => f.write_str("the front laser"),
            LaserNumber::REAR => f.write_str("the rear laser"),
            LaserNumber(number) => write!(f, "laser {number}"),
        }
    }
}
