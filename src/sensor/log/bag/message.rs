//! The ROS 2 messages that scans are made of.

use crate::geometry::Pose;
use crate::sensor::log::bag::cdr::Cdr;
use crate::sensor::log::{LARGEST, MAX_BEAMS};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

pub(super) const SCAN: &str = "sensor_msgs/msg/LaserScan";
pub(super) const ODOMETRY: &str = "nav_msgs/msg/Odometry";
pub(super) const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";

/// How far the length of a quaternion may be from 1.
const UNIT: f64 = 1e-2;

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    /// Seconds; `None` if it was not filled in.
    pub(super) stamp: Option<f64>,
    pub(super) frame: String,
}

/// `sensor_msgs/msg/LaserScan` without intensities and the times within a sweep.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ScanMessage {
    pub(super) header: Header,
    pub(super) start_angle: f64,
    pub(super) angle_increment: f64,
    pub(super) range_min: f64,
    pub(super) range_max: f64,
    pub(super) ranges: Vec<f64>,
}

/// `nav_msgs/msg/Odometry` without covariances and velocities.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OdometryMessage {
    pub(super) header: Header,
    pub(super) child_frame: String,
    pub(super) odom_from_robot: Pose,
}

/// One transform of a `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Transform {
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) parent_from_child: Isometry3<f64>,
}

impl ScanMessage {
    pub(super) fn decode(message: &[u8]) -> Result<ScanMessage, String> {
        let mut cdr = Cdr::new(message)?;
        let header = header(&mut cdr)?;
        let mut field = || cdr.f32().map(f64::from);
        let [start_angle, _angle_max, angle_increment, _time_increment, _scan_time, range_min, range_max] =
            [field()?, field()?, field()?, field()?, field()?, field()?, field()?];
        let beams = cdr.length(4)?;
        if beams > MAX_BEAMS {
            return Err(format!("has {beams} ranges, expected at most {MAX_BEAMS}"));
        }
        let ranges = (0..beams).map(|_| cdr.f32().map(f64::from)).collect::<Result<_, _>>()?;
        Ok(ScanMessage { header, start_angle, angle_increment, range_min, range_max, ranges })
    }
}

impl OdometryMessage {
    pub(super) fn decode(message: &[u8]) -> Result<OdometryMessage, String> {
        let mut cdr = Cdr::new(message)?;
        let (header, child_frame) = (header(&mut cdr)?, frame(&mut cdr)?);
        let pose = transform(&mut cdr)?;
        let ahead = pose.rotation * nalgebra::Vector3::x();
        let odom_from_robot = Pose::new(pose.translation.x, pose.translation.y, ahead.y.atan2(ahead.x));
        Ok(OdometryMessage { header, child_frame, odom_from_robot })
    }
}

/// The transforms of a `tf2_msgs/msg/TFMessage`.
pub(super) fn transforms(message: &[u8]) -> Result<Vec<Transform>, String> {
    let mut cdr = Cdr::new(message)?;
    // Two lengths of names, a stamp, seven numbers.
    let count = cdr.length(72)?;
    let mut one = || {
        let (header, child) = (header(&mut cdr)?, frame(&mut cdr)?);
        Ok(Transform { parent: header.frame, child, parent_from_child: transform(&mut cdr)? })
    };
    (0..count).map(|_| one()).collect()
}

fn header(cdr: &mut Cdr) -> Result<Header, String> {
    let seconds = f64::from(cdr.u32()?.cast_signed());
    let stamp = seconds + f64::from(cdr.u32()?) * 1e-9;
    Ok(Header { stamp: (stamp != 0.0).then_some(stamp), frame: frame(cdr)? })
}

/// The name of a frame; old recordings have a slash before it.
fn frame(cdr: &mut Cdr) -> Result<String, String> {
    let name = cdr.string()?;
    Ok(name.strip_prefix('/').unwrap_or(&name).to_owned())
}

/// A position and a quaternion, of a pose or a transform.
fn transform(cdr: &mut Cdr) -> Result<Isometry3<f64>, String> {
    let mut number = || match cdr.f64()? {
        value if value.abs() < LARGEST => Ok(value),
        value => Err(format!("has {value} in a pose, expected a finite number")),
    };
    let translation = Translation3::new(number()?, number()?, number()?);
    let [x, y, z, w] = [number()?, number()?, number()?, number()?];
    let quaternion = Quaternion::new(w, x, y, z);
    if (quaternion.norm() - 1.0).abs() > UNIT {
        return Err(format!("has the quaternion x {x} y {y} z {z} w {w}, expected one of length 1"));
    }
    Ok(Isometry3::from_parts(translation, UnitQuaternion::from_quaternion(quaternion)))
}
