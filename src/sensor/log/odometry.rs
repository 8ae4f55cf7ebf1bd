//! Where the robot was at a moment between two entries of odometry.

use crate::geometry::{Pose, wrap_angle};
use std::collections::VecDeque;

/// The most entries kept: those of a look ahead of sweeps at 5 Hz with odometry at 500 Hz.
const KEPT: usize = 8192;
/// Between entries that far apart, seconds, nobody knows where the robot went.
const LONGEST_GAP: f64 = 2.0;

/// The latest odometry in the order of the log.
#[derive(Clone, Debug, Default)]
pub(super) struct Odometry {
    latest: VecDeque<(f64, Pose)>,
}

impl Odometry {
    pub(super) fn add(&mut self, stamp: f64, odom_from_robot: Pose) {
        if self.latest.len() == KEPT {
            self.latest.pop_front();
        }
        self.latest.push_back((stamp, odom_from_robot));
    }

    /// The pose at a moment, between the two neighbouring entries of the log whose stamps enclose it, the latest such
    /// two: position along the straight line, heading along the shorter turn. `None` if there are no such two.
    /// Linear in the entries that came after.
    pub(super) fn at(&self, stamp: f64) -> Option<Pose> {
        let later = self.latest.iter().rev();
        let encloses = |(before, after): &(&(f64, Pose), &(f64, Pose))| {
            before.0 <= stamp && stamp <= after.0 && after.0 - before.0 <= LONGEST_GAP
        };
        let (before, after) = later.clone().skip(1).zip(later).find(encloses)?;
        let gap = after.0 - before.0;
        let share = if gap > 0.0 { (stamp - before.0) / gap } else { 0.0 };
        let (from, to) = (before.1, after.1);
        let between = |a: f64, b: f64| a + share * (b - a);
        let turn = share * wrap_angle(to.theta - from.theta);
        Some(Pose::new(between(from.x, to.x), between(from.y, to.y), from.theta + turn))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn track(entries: &[(f64, Pose)]) -> Odometry {
        let mut odometry = Odometry::default();
        entries.iter().for_each(|(stamp, pose)| odometry.add(*stamp, *pose));
        odometry
    }

    #[test]
    fn a_heading_turns_the_shorter_way() {
        let odometry = track(&[(1.0, Pose::new(0.0, 0.0, PI - 0.1)), (2.0, Pose::new(2.0, -1.0, -PI + 0.3))]);
        let pose = odometry.at(1.25).unwrap();
        assert!((pose.x - 0.5).abs() < 1e-12 && (pose.y + 0.25).abs() < 1e-12);
        assert!((pose.theta - PI).abs() < 1e-12, "{pose:?}");
    }

    #[test]
    fn only_what_is_enclosed_is_known() {
        let odometry = track(&[(1.0, Pose::IDENTITY), (2.0, Pose::IDENTITY), (9.0, Pose::IDENTITY)]);
        assert!(odometry.at(0.99).is_none() && odometry.at(9.01).is_none() && odometry.at(5.0).is_none());
        assert!(odometry.at(1.0).is_some() && odometry.at(2.0).is_some());
        assert!(Odometry::default().at(0.0).is_none() && track(&[(1.0, Pose::IDENTITY)]).at(1.0).is_none());
    }

    #[test]
    fn a_clock_put_back_does_not_mix_two_drives() {
        let here = |x: f64| Pose::new(x, 0.0, 0.0);
        let odometry = track(&[(1.0, here(1.0)), (2.0, here(2.0)), (0.0, here(10.0)), (1.0, here(11.0))]);
        assert_eq!(odometry.at(0.5), Some(here(10.5)));
        assert_eq!(odometry.at(1.5), Some(here(1.5)));
    }

    #[test]
    fn memory_is_bounded() {
        let mut odometry = Odometry::default();
        (0..3 * KEPT).for_each(|k| odometry.add(k as f64, Pose::IDENTITY));
        assert_eq!(odometry.latest.len(), KEPT);
    }
}
