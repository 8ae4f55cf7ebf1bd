//! From a map and a drive to a pose graph: what the map says is one place is one place.

use crate::geometry::Pose;
use crate::patchwork::alignment::{moved, settle};
use crate::patchwork::closures::Closure;
use crate::patchwork::drive::{Drive, Frame, adjoint};
use crate::patchwork::submap::Submap;
use crate::patchwork::{
    Edge, GraphError, Loss, PoseGraph, PoseId, RelaxError, RelaxOptions, Relaxation, Start, relax,
};
use nalgebra::{Matrix3, Vector3};

/// A visit within a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Index of a scan at which the robot was there.
    pub scan: usize,
    /// The frame of the visit, its origin at the point of the place, in the local frame of scan matching.
    pub local_from_visit: Pose,
}

/// A drive relaxed: where its frames lie.
#[derive(Clone, Debug)]
pub struct RelaxedDrive {
    /// The frames by odometry, scan matching and the closures of the map alone, and how strained they are.
    pub by_map: Relaxation,
    /// The same once frames of different passes have been laid onto each other.
    pub by_scans: Relaxation,
    /// How many pairs of frames that were.
    pub passes: usize,
}

/// A loss that lets go of what is more than so many standard deviations off: two passes may see different things.
const ROBUST: Loss = Loss::Cauchy { width: 3.0 };

/// A robust loss converges by shares, not by squares: what a step gains less than this share of the cost moves little:
/// all that 200 steps gained beyond was 0.006 of a chi-square of 306 (ACES).
const ENOUGH_GAIN: f64 = 1e-6;

impl RelaxedDrive {
    /// Relaxes a drive in which places were recognised.
    pub fn new(drive: &Drive, stops: &[Stop], closures: &[Closure]) -> Result<RelaxedDrive, RelaxError> {
        let mut graph = graph(drive, stops, closures)?;
        let by_map = relax(&graph, &RelaxOptions::default())?;
        let found = passes(drive, &by_map.poses);
        let passes = found.len();
        graph = graph.with_guesses(&by_map.poses);
        found.into_iter().try_for_each(|edge| graph.add_edge(edge))?;
        let options = RelaxOptions {
            start: Start::Guesses,
            loss: ROBUST,
            tolerance: ENOUGH_GAIN,
            ..RelaxOptions::default()
        };
        let by_scans = relax(&graph, &options)?;
        Ok(RelaxedDrive { by_map, by_scans, passes })
    }
}

/// Rounding, as a variance: no displacement is known better, metres and radians squared.
const LEAST: f64 = 1e-7;
/// The walls around a frame are those seen on so many metres of driving before and after.
const AROUND: f64 = 4.0;
/// Frames are compared where the robot was within so many metres, and had driven so many in between.
const NEAR: f64 = 4.0;
const APART: f64 = 15.0;
/// A turned frame counts as so many metres for each radian.
const TURNED: f64 = 0.3;
/// Every so many frames one is compared, with one frame of each pass.
const EVERY: usize = 2;
const PASS: f64 = 10.0;
/// How uncertain the patchwork is where two passes are compared: metres and radians, one standard deviation.
const LOOSE: [f64; 2] = [0.5, 0.1];
/// Fewer walls than these do not fix a frame.
const ENOUGH: usize = 40;

/// The graph of a drive in which places were recognised: a pose for each frame, in their order. Linear in the frames.
pub fn graph(drive: &Drive, stops: &[Stop], closures: &[Closure]) -> Result<PoseGraph, GraphError> {
    let mut graph = PoseGraph::new();
    for (number, frame) in (0..).zip(drive.frames()) {
        graph.add_pose(PoseId(number), Some(frame.local_from_robot))?;
    }
    for (before, pair) in (0..).zip(drive.frames().windows(2)) {
        graph.add_edge(driven(before, &pair[0], &pair[1]))?;
    }
    for closure in closures {
        if let Some(edge) = closing(drive, stops, closure) {
            graph.add_edge(edge)?;
        }
    }
    Ok(graph)
}

fn driven(before: u64, from: &Frame, to: &Frame) -> Edge {
    let covariance = to.drift + Matrix3::from_diagonal_element(LEAST);
    Edge {
        from: PoseId(before),
        to: PoseId(before + 1),
        displacement: from.local_from_robot.inverse().compose(&to.local_from_robot),
        information: symmetric(covariance.try_inverse().unwrap_or_else(Matrix3::zeros)),
    }
}

/// A closure, between the frames of the way that are nearest to the two visits.
fn closing(drive: &Drive, stops: &[Stop], closure: &Closure) -> Option<Edge> {
    let [one, other] = closure.visits.map(|visit| {
        let stop = stops.get(visit)?;
        let frame = drive.frame_at(stop.scan)?;
        let visit_from_frame =
            stop.local_from_visit.inverse().compose(&drive.frames()[frame].local_from_robot);
        Some((frame, visit_from_frame))
    });
    let ((from, one_from_frame), (to, other_from_frame)) = (one?, other?);
    let found = closure.agreement.alignment;
    let displacement = one_from_frame.inverse().compose(&found.pose).compose(&other_from_frame);
    let felt = adjoint(&other_from_frame);
    let information = felt.transpose() * found.information * felt;
    (from != to).then(|| Edge {
        from: PoseId(from as u64),
        to: PoseId(to as u64),
        displacement,
        information: symmetric(information),
    })
}

/// The second relaxation: what frames of different passes through one stretch see of each other, as they lie now
/// (`poses`, by frame).
pub fn passes(drive: &Drive, poses: &[Pose]) -> Vec<Edge> {
    let trust = Vector3::new(LOOSE[0], LOOSE[0], LOOSE[1]).map(|sigma| 1.0 / (sigma * sigma));
    let trust = Matrix3::from_diagonal(&trust);
    let edge = |(from, to): (usize, usize)| {
        let seen = Submap::new(drive.frames()[to].walls.iter().copied());
        let start = poses[from].inverse().compose(&poses[to]);
        let found = settle(&seen, &around(drive, poses, from), start, &trust, &|| false)?;
        (found.is_same() && drive.frames()[to].walls.len() >= ENOUGH).then(|| Edge {
            from: PoseId(from as u64),
            to: PoseId(to as u64),
            displacement: found.pose,
            information: symmetric(found.information),
        })
    };
    (0..drive.frames().len().min(poses.len()))
        .step_by(EVERY)
        .flat_map(|to| partners(drive, poses, to))
        .filter_map(edge)
        .collect()
}

/// The nearest frame of each earlier pass near a frame.
fn partners(drive: &Drive, poses: &[Pose], to: usize) -> Vec<(usize, usize)> {
    let frames = drive.frames();
    let away = |from: usize| {
        let between = poses[from].inverse().compose(&poses[to]);
        between.x.hypot(between.y) + TURNED * between.theta.abs()
    };
    let mut near: Vec<(f64, usize)> = (0..to)
        .filter(|&from| frames[to].driven - frames[from].driven > APART)
        .map(|from| (away(from), from))
        .filter(|(away, _)| *away < NEAR)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken: Vec<usize> = Vec::new();
    for (_, from) in near {
        if taken.iter().all(|&other| (frames[from].driven - frames[other].driven).abs() >= PASS) {
            taken.push(from);
        }
    }
    taken.into_iter().map(|from| (from, to)).collect()
}

/// The walls around a frame, in that frame, as seen on the way near it.
fn around(drive: &Drive, poses: &[Pose], frame: usize) -> Submap {
    let frames = drive.frames();
    let at = frames[frame].driven;
    let first = frames.partition_point(|other| other.driven <= at - AROUND);
    let last = frames.partition_point(|other| other.driven < at + AROUND);
    let back = poses[frame].inverse();
    Submap::new((first..last).flat_map(|other| {
        let pose = back.compose(&poses[other]);
        frames[other].walls.iter().map(move |surface| moved(surface, &pose))
    }))
}

fn symmetric(matrix: Matrix3<f64>) -> Matrix3<f64> {
    (matrix + matrix.transpose()) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::patchwork::agreement::{Agreement, Walls};
    use crate::patchwork::alignment::Alignment;
    use crate::patchwork::drive::DriveRecorder;
    use crate::sensor::log::LaserNumber;
    use crate::sensor::surface::Surface;
    use crate::sensor::{LaserScan, LocalPose};

    /// Frames to each side of a square corridor, and its side in metres.
    const SIDE: usize = 24;
    const LENGTH: f64 = 12.24;

    /// A robot that goes around a square corridor so many times, and its true poses. Its heading bends by `bent` a frame.
    fn around(laps: usize, bent: f64) -> (Drive, Vec<Pose>) {
        let step = Pose::new(LENGTH / SIDE as f64, 0.0, 0.0);
        let mut truth = vec![Pose::IDENTITY];
        for k in 1..=4 * SIDE * laps {
            let turn = if k % SIDE == 0 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
            let last = truth[k - 1];
            truth.push(last.compose(&step).compose(&Pose::new(0.0, 0.0, turn)));
        }
        let mut recorder = DriveRecorder::new(12.0);
        let mut local = Pose::IDENTITY;
        for k in 0..truth.len() {
            if k > 0 {
                local = local.compose(&truth[k - 1].between(&truth[k])).compose(&Pose::new(0.0, 0.0, bent));
            }
            let drift = Matrix3::from_diagonal(&Vector3::new(4e-4, 1e-4, 1e-4));
            recorder.add(&nothing(k), &LocalPose { local_from_robot: local, drift, used: true });
        }
        let mut drive = recorder.finish();
        assert_eq!(drive.frames().len(), truth.len());
        drive.see(|frame| seen(&truth[frame]));
        (drive, truth)
    }

    fn nothing(k: usize) -> LaserScan {
        LaserScan {
            laser: LaserNumber::FRONT,
            stamp: k as f64,
            odom_from_robot: Pose::IDENTITY,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.1,
            ranges: Vec::new(),
        }
    }

    /// What is to be seen from a pose within 5 m: the walls on both sides of the corridor, and niches in the outer one
    /// at distances that do not repeat.
    fn seen(pose: &Pose) -> Vec<Surface> {
        let corners = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, LENGTH), (0.0, LENGTH)];
        let corners = corners.map(|(x, y)| Point::new(x, y));
        let mut walls = Vec::new();
        for side in 0..4 {
            let (from, to) = (corners[side], corners[(side + 1) % 4]);
            let along = (to - from).normalize();
            let inward = Vector::new(-along.y, along.x);
            for k in -10..130 {
                let at = from + along * (0.1 * f64::from(k));
                walls.push(Surface { at: at - inward, normal: inward });
                if (10..110).contains(&k) {
                    walls.push(Surface { at: at + inward, normal: -inward });
                }
            }
            for niche in [2.0 + 0.7 * side as f64, 5.5, 9.0 - 0.5 * side as f64] {
                for k in 0..6 {
                    let at = from + along * niche - inward * (1.0 + 0.1 * f64::from(k));
                    walls.push(Surface { at, normal: along });
                    walls.push(Surface { at: at + along * 0.8, normal: -along });
                }
            }
        }
        let back = pose.inverse();
        let near = |wall: &Surface| (wall.at - pose.position()).norm() < 5.0;
        walls.into_iter().filter(near).map(|wall| moved(&wall, &back)).collect()
    }

    /// The visits to the corner where the robot began, and what they show of the first.
    fn closed(drive: &Drive, truth: &[Pose]) -> (Vec<Stop>, Vec<Closure>) {
        let scans: Vec<usize> = (0..truth.len()).step_by(4 * SIDE).collect();
        let stop = |&scan: &usize| Stop { scan, local_from_visit: drive.frames()[scan].local_from_robot };
        let closure = |visit: usize| {
            let alignment = Alignment {
                pose: truth[0].between(&truth[scans[visit]]),
                information: Matrix3::from_diagonal(&Vector3::new(1e4, 1e4, 1e5)),
                share: 1.0,
                stray: 0.0,
            };
            Closure { visits: [0, visit], agreement: Agreement { alignment, walls: Walls::Alike } }
        };
        (scans.iter().map(stop).collect(), (1..scans.len()).map(closure).collect())
    }

    /// The largest error of the second lap as seen from the first.
    fn apart(truth: &[Pose], poses: &[Pose]) -> f64 {
        let off = |k: usize| {
            let (there, here) = (k + 4 * SIDE, k);
            let off =
                truth[here].between(&truth[there]).inverse().compose(&poses[here].between(&poses[there]));
            off.x.hypot(off.y)
        };
        (0..4 * SIDE).map(off).fold(0.0, f64::max)
    }

    #[test]
    fn a_place_recognised_closes_the_way_and_scans_close_it_everywhere() {
        let (drive, truth) = around(2, 0.003);
        let (stops, closures) = closed(&drive, &truth);
        let local: Vec<Pose> = drive.frames().iter().map(|frame| frame.local_from_robot).collect();
        let relaxed = RelaxedDrive::new(&drive, &stops, &closures).unwrap();
        let [open, by_map, by_scans] =
            [&local, &relaxed.by_map.poses, &relaxed.by_scans.poses].map(|poses| apart(&truth, poses));
        assert!(open > 2.0, "{open}");
        assert!(by_map < 0.5 * open && by_map > by_scans, "{open} {by_map} {by_scans}");
        assert!(relaxed.passes > 3 * SIDE / 2 && by_scans < 0.1, "{} {by_scans}", relaxed.passes);
    }

    #[test]
    fn an_exact_way_is_not_strained() {
        let (drive, truth) = around(2, 0.0);
        let (stops, closures) = closed(&drive, &truth);
        let relaxed = RelaxedDrive::new(&drive, &stops, &closures).unwrap();
        assert!(relaxed.by_map.objective < 1e-6, "{}", relaxed.by_map.objective);
        assert!(apart(&truth, &relaxed.by_scans.poses) < 0.02);
    }

    #[test]
    fn a_way_without_frames_is_relaxed_to_nothing() {
        let relaxed = RelaxedDrive::new(&Drive::default(), &[], &[]).unwrap();
        assert!(relaxed.by_scans.poses.is_empty() && relaxed.passes == 0);
    }
}
