//! One laser of a log: what has been learned of it, and its sweeps made scans.

use crate::geometry::Pose;
use crate::sensor::LaserScan;
use crate::sensor::log::entry::Sweep;
use crate::sensor::log::geometry::{ViewParameters, guessed};
use crate::sensor::log::mount::Mount;
use crate::sensor::log::no_return::{FRACTION, NoReturns, returned};
use crate::sensor::log::reader::{LogOptions, PoseChoice};
use crate::sensor::log::report::{Geometry, GeometrySource, LaserReport};

/// What is known of one laser.
#[derive(Debug)]
pub(super) struct Laser {
    no_returns: NoReturns,
    mount: Mount,
    view: ViewParameters,
    /// The kind of its messages with poses, once one was met.
    posed: Option<String>,
    last_stamp: Option<f64>,
    pub(super) report: LaserReport,
}

impl Laser {
    pub(super) fn new(options: &LogOptions) -> Self {
        Laser {
            no_returns: NoReturns::new(options.max_range),
            mount: Mount::new(options.mount),
            view: ViewParameters::default(),
            posed: None,
            last_stamp: None,
            report: LaserReport::default(),
        }
    }

    pub(super) fn has_poses(&self) -> bool {
        self.posed.is_some()
    }

    /// Takes a parameter of the robot that tells how this laser looks or where it sits.
    pub(super) fn hear(&mut self, name: &str, number: f64) {
        let mount = &mut self.mount.parameters;
        match name {
            "robot_frontlaser_offset" | "robot_rearlaser_offset" => mount.ahead = Some(number),
            "robot_frontlaser_side_offset" | "robot_rearlaser_side_offset" => mount.left = Some(number),
            "robot_frontlaser_angular_offset" | "robot_rearlaser_angular_offset" => {
                mount.angle = Some(number);
            }
            "laser_front_laser_fov" | "laser_rear_laser_fov" => self.view.field_of_view = Some(number),
            "laser_front_laser_resolution" | "laser_rear_laser_resolution" => {
                self.view.resolution = Some(number);
            }
            "robot_front_laser_max" | "robot_rear_laser_max" if number > 0.0 => {
                self.no_returns.hear_parameter(FRACTION * number);
            }
            _ => {}
        }
    }

    /// Whether a sweep is one to make a scan of; learns from it and gives it a stamp if so.
    pub(super) fn accepts(&mut self, kind: &str, sweep: &mut Sweep) -> bool {
        self.report.sweeps += 1;
        if sweep.ranges.len() < 2 {
            self.report.empty += 1;
            return false;
        }
        if sweep.poses.is_some() && self.posed.is_none() {
            self.posed = Some(kind.to_owned());
        }
        if self.posed.as_deref().is_some_and(|posed| posed != kind) {
            self.report.repeated += 1;
            return false;
        }
        self.keep_time(sweep);
        self.no_returns.observe(&sweep.ranges, sweep.no_return_from);
        if let Some(poses) = &sweep.poses {
            self.mount.observe(poses);
        }
        true
    }

    /// The order of the file is the order of the scans, whatever the stamps say.
    fn keep_time(&mut self, sweep: &mut Sweep) {
        match (sweep.stamp, self.last_stamp) {
            (None, last) => {
                self.report.unstamped += 1;
                sweep.stamp = Some(last.unwrap_or_default());
            }
            (Some(stamp), Some(last)) if stamp < last => self.report.backwards += 1,
            (Some(stamp), Some(last)) if stamp == last => self.report.same_stamp += 1,
            _ => {}
        }
        self.last_stamp = sweep.stamp;
    }

    /// The scan of a sweep, given where odometry had the robot at its stamp; `None` if nobody knows where it was.
    pub(super) fn scan(
        &mut self,
        sweep: Sweep,
        between: Option<Pose>,
        options: &LogOptions,
    ) -> Option<LaserScan> {
        let (robot_from_laser, mount_source) = self.mount.robot_from_laser(&sweep);
        let odom_from_robot = match (&sweep.poses, options.pose) {
            (Some(poses), PoseChoice::Robot) => Some(poses.odom_from_robot),
            (Some(poses), PoseChoice::Laser) => {
                Some(poses.world_from_laser.compose(&robot_from_laser.inverse()))
            }
            (None, _) => between,
        };
        let Some(odom_from_robot) = odom_from_robot else {
            self.report.without_odometry += 1;
            return None;
        };
        let geometry = self.geometry(&sweep, options);
        let limit = self.no_returns.limit();
        let ranges: Vec<Option<f64>> = sweep.ranges.iter().map(|&range| returned(range, limit)).collect();

        let report = &mut self.report;
        report.scans += 1;
        report.beams = (
            if report.scans == 1 { ranges.len() } else { report.beams.0.min(ranges.len()) },
            report.beams.1.max(ranges.len()),
        );
        report.readings += ranges.len() as u64;
        report.no_returns += ranges.iter().filter(|range| range.is_none()).count() as u64;
        (report.no_return_from, report.no_return_source) = limit;
        (report.mount, report.mount_source) = (Some(robot_from_laser), mount_source);
        (report.geometry, report.corrected) = (geometry, self.mount.corrected);
        Some(LaserScan {
            laser: sweep.laser,
            stamp: sweep.stamp.unwrap_or_default(),
            odom_from_robot,
            robot_from_laser,
            start_angle: geometry.start_angle,
            angle_increment: geometry.angle_increment,
            ranges,
        })
    }

    fn geometry(&self, sweep: &Sweep, options: &LogOptions) -> Geometry {
        let beams = sweep.ranges.len();
        let told =
            sweep.start_angle.zip(sweep.angle_increment).map(|angles| (angles, GeometrySource::Message));
        let logged = || self.view.angles(beams).map(|angles| (angles, GeometrySource::Parameters));
        let ((start_angle, angle_increment), source) =
            told.or_else(logged).unwrap_or_else(|| (guessed(beams), GeometrySource::NumberOfReadings));
        Geometry { start_angle: options.start_angle.unwrap_or(start_angle), angle_increment, source }
    }
}
