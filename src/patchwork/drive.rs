//! A drive: frames along the robot's way, each with the walls seen from it.

use crate::geometry::{Point, Pose, Vector};
use crate::grid::OccupancyGrid;
use crate::patchwork::merged::{Canvas, MergeError};
use crate::sensor::surface::{Surface, surfaces};
use crate::sensor::{EvidenceGrid, EvidenceParameters, LaserScan, LocalPose};
use nalgebra::Matrix3;

/// Frames are so far apart, metres or radians.
const SPACING: f64 = 0.5;
const SPACING_TURN: f64 = 0.4;

/// The robot's way as frames and all moments between them.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    frames: Vec<Frame>,
    moments: Vec<(f64, Pose)>,
}

/// Where the robot was, and what it saw there.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Index of the scan in the log, from 0.
    pub scan: usize,
    /// The robot's pose in the local frame of scan matching.
    pub local_from_robot: Pose,
    /// The covariance of the displacement from the frame before, x, y, heading in the robot's frame.
    pub drift: Matrix3<f64>,
    /// Metres driven since the log began.
    pub driven: f64,
    /// The walls seen, in the robot's frame.
    pub walls: Vec<Surface>,
    /// All that was seen.
    pub sweep: LaserScan,
}

/// Makes a drive of scans and the poses at them.
#[derive(Clone, Debug)]
pub struct DriveRecorder {
    drive: Drive,
    max_range: f64,
    /// What went wrong since the last frame, in the robot's frame now.
    drift: Matrix3<f64>,
    last: Option<Pose>,
    driven: f64,
}

impl DriveRecorder {
    /// No scans yet; walls are seen up to a range, metres.
    pub fn new(max_range: f64) -> Self {
        DriveRecorder { drive: Drive::default(), max_range, drift: Matrix3::zeros(), last: None, driven: 0.0 }
    }

    /// Takes the next scan and the pose that a [`ScanMatcher`](crate::sensor::ScanMatcher) gave it.
    pub fn add(&mut self, scan: &LaserScan, placed: &LocalPose) {
        let pose = placed.local_from_robot;
        if let Some(last) = self.last.replace(pose) {
            let carried = adjoint(&pose.inverse().compose(&last));
            self.drift = carried * self.drift * carried.transpose() + placed.drift;
            self.driven += (pose.position() - last.position()).norm();
        }
        self.drive.moments.push((scan.stamp, pose));
        let far = self.drive.frames.last().is_none_or(|last| {
            let motion = last.local_from_robot.inverse().compose(&pose);
            motion.x.hypot(motion.y) >= SPACING || motion.theta.abs() >= SPACING_TURN
        });
        if far {
            self.drive.frames.push(Frame {
                scan: self.drive.moments.len() - 1,
                local_from_robot: pose,
                drift: std::mem::take(&mut self.drift),
                driven: self.driven,
                walls: surfaces(scan, self.max_range),
                sweep: scan.clone(),
            });
        }
    }

    /// The drive.
    pub fn finish(self) -> Drive {
        self.drive
    }
}

impl Drive {
    /// The same way with other walls seen from each frame.
    #[cfg(test)]
    pub(super) fn see(&mut self, walls: impl Fn(usize) -> Vec<Surface>) {
        self.frames.iter_mut().enumerate().for_each(|(frame, at)| at.walls = walls(frame));
    }

    /// The frames in the order of the way.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The frame at which the robot was nearest to a scan on its way.
    pub fn frame_at(&self, scan: usize) -> Option<usize> {
        let after = self.frames.partition_point(|frame| frame.scan <= scan);
        let at = self.moments.get(scan)?.1;
        let away = |k: &usize| (self.frames[*k].local_from_robot.position() - at.position()).norm();
        let near = after.saturating_sub(1)..self.frames.len().min(after + 1);
        near.min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// The stamp of every scan and the pose at it, as the frames around it lie now: each scan goes with the nearest frame.
    pub fn trajectory(&self, frames: &[Pose]) -> Vec<(f64, Pose)> {
        let moved = |(scan, (stamp, local)): (usize, &(f64, Pose))| {
            let near = self.frame_at(scan)?;
            let pose =
                frames.get(near)?.compose(&self.frames[near].local_from_robot.inverse().compose(local));
            Some((*stamp, pose))
        };
        self.moments.iter().enumerate().filter_map(moved).collect()
    }
}

impl Drive {
    /// What all frames saw, with the frames in these poses; `None` where there are no frames.
    pub fn grid(&self, frames: &[Pose], canvas: &Canvas) -> Result<Option<OccupancyGrid>, MergeError> {
        let parameters = EvidenceParameters::default();
        let seen = [-parameters.max_range, parameters.max_range].map(Vector::repeat);
        let corners = frames.iter().flat_map(|pose| seen.map(|corner| pose.position() + corner));
        let all = corners.fold(None, |all: Option<[Point; 2]>, at| {
            let [low, high] = all.unwrap_or([at, at]);
            Some([low.inf(&at), high.sup(&at)])
        });
        let Some([low, high]) = all else { return Ok(None) };
        let mut evidence = EvidenceGrid::new(canvas.around(low, high)?, f64::INFINITY, parameters);
        for (frame, pose) in self.frames.iter().zip(frames) {
            evidence.add(&frame.sweep, pose, 0.0);
        }
        Ok(Some(evidence.grid()?))
    }
}

/// What an error of a frame, a displacement in its own coordinates, is in those of another: `b_from_a`.
pub fn adjoint(b_from_a: &Pose) -> Matrix3<f64> {
    let (sin, cos) = b_from_a.theta.sin_cos();
    Matrix3::new(cos, -sin, b_from_a.y, sin, cos, -b_from_a.x, 0.0, 0.0, 1.0)
}

/// The rotation of an error, x, y, heading, by an angle.
pub fn turned(angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::wrap_angle;
    use crate::sensor::log::LaserNumber;
    use crate::visit::{Moment, drift};
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn scan(stamp: usize, pose: Pose) -> LaserScan {
        LaserScan {
            stamp: stamp as f64,
            laser: LaserNumber::FRONT,
            odom_from_robot: pose,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.1,
            ranges: vec![Some(2.0)],
        }
    }

    /// A drive by steps ahead and turns, and its moments.
    fn driven(steps: &[(f64, f64)]) -> (Drive, Vec<Moment>) {
        let mut recorder = DriveRecorder::new(10.0);
        let (mut pose, mut length, mut moments) = (Pose::IDENTITY, 0.0, Vec::new());
        for (k, &(ahead, turn)) in steps.iter().enumerate() {
            pose = pose.compose(&Pose::new(ahead, 0.0, turn));
            length += ahead;
            let drift =
                Matrix3::from_diagonal(&Vector3::new(0.01 * ahead, 0.003, 0.001 + turn.abs() / 100.0));
            let moment = Moment { scan: k, local_from_robot: pose, drift, driven: length };
            recorder.add(&scan(k, pose), &LocalPose { local_from_robot: pose, drift, used: true });
            moments.push(moment);
        }
        (recorder.finish(), moments)
    }

    proptest! {
        /// What is felt of a small error of one frame in another, against composing poses.
        #[test]
        fn an_error_is_felt_in_another_frame(
            (x, y, theta) in (-5.0..5.0f64, -5.0..5.0f64, -3.1..3.1f64),
            (dx, dy, dtheta) in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
        ) {
            let b_from_a = Pose::new(x, y, theta);
            let small = Pose::new(1e-6 * dx, 1e-6 * dy, 1e-6 * dtheta);
            let felt = b_from_a.compose(&small).compose(&b_from_a.inverse());
            let told = adjoint(&b_from_a) * Vector3::new(small.x, small.y, small.theta);
            prop_assert!((told - Vector3::new(felt.x, felt.y, felt.theta)).norm() < 1e-10);
        }

        /// The drift of a frame is what its moments add up to, as `visit::drift` has it for a whole way.
        #[test]
        fn drift_adds_up_from_frame_to_frame(
            steps in prop::collection::vec((0.0..0.3f64, -0.3..0.3f64), 2..40),
        ) {
            let (drive, moments) = driven(&steps);
            for pair in drive.frames().windows(2) {
                let way = &moments[pair[0].scan..=pair[1].scan];
                let end = pair[1].local_from_robot;
                let whole = drift::covariance(way, &end);
                prop_assert!((whole - pair[1].drift).norm() < 1e-9 * (1.0 + whole.norm()));
            }
        }

        #[test]
        fn frames_that_stay_leave_the_way_as_it_was(
            steps in prop::collection::vec((0.0..0.3f64, -0.3..0.3f64), 1..40),
            (x, y, theta) in (-5.0..5.0f64, -5.0..5.0f64, -3.1..3.1f64),
        ) {
            let (drive, moments) = driven(&steps);
            let all = Pose::new(x, y, theta);
            let moved: Vec<Pose> = drive.frames().iter().map(|frame| all.compose(&frame.local_from_robot)).collect();
            let way = drive.trajectory(&moved);
            prop_assert_eq!(way.len(), moments.len());
            for ((stamp, pose), moment) in way.iter().zip(&moments) {
                let expected = all.compose(&moment.local_from_robot);
                prop_assert_eq!(*stamp, moment.scan as f64);
                prop_assert!((pose.position() - expected.position()).norm() < 1e-9);
                prop_assert!(wrap_angle(pose.theta - expected.theta).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn an_empty_drive_has_no_frames() {
        let drive = DriveRecorder::new(10.0).finish();
        assert!(drive.frames().is_empty() && drive.trajectory(&[]).is_empty() && drive.frame_at(3).is_none());
    }
}
