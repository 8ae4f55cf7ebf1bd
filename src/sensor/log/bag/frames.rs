//! Where frames of the robot sit on each other for good: the static transforms.

use crate::geometry::Pose;
use crate::sensor::log::bag::message::Transform;
use nalgebra::{Isometry3, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// A laser sweeps a plane of the floor if its axis is no further from the vertical than this, radians.
const MOST_TILT: f64 = 0.1;
/// The most frames that are kept.
const MAX_FRAMES: usize = 4096;

/// A forest of frames.
#[derive(Clone, Debug, Default)]
pub(super) struct StaticFrames {
    parents: BTreeMap<String, (String, Isometry3<f64>)>,
}

/// A laser on a robot, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlanarMount {
    pub(super) robot_from_laser: Pose,
    /// Whether the laser hangs upside down, so that its angles go clockwise.
    pub(super) upside_down: bool,
}

impl StaticFrames {
    /// A later transform of a frame replaces the earlier one.
    pub(super) fn add(&mut self, transform: Transform) {
        if self.parents.len() < MAX_FRAMES || self.parents.contains_key(&transform.child) {
            self.parents.insert(transform.child, (transform.parent, transform.parent_from_child));
        }
    }

    /// Whether a frame has a place on another one, or is one's place.
    pub(super) fn knows(&self, frame: &str) -> bool {
        self.parents.contains_key(frame) || self.parents.values().any(|(parent, _)| parent == frame)
    }

    /// The pose of a laser's frame in the robot's, along the chain of transforms through their first common frame.
    pub(super) fn mount(&self, robot: &str, laser: &str) -> Result<PlanarMount, String> {
        let from_robot = self.ancestors(robot);
        let from_laser = self.ancestors(laser);
        let meeting = from_laser.iter().find_map(|(name, root_from_laser)| {
            let (_, root_from_robot) = from_robot.iter().find(|(other, _)| other == name)?;
            Some(root_from_robot.inverse() * root_from_laser)
        });
        let robot_from_laser = meeting.ok_or_else(|| {
            format!(
                "no chain of static transforms leads from {robot} to {laser}, expected one on /tf_static, or the \
                 laser's pose by --mount; {}",
                self.known()
            )
        })?;
        planar(&robot_from_laser).ok_or_else(|| {
            format!(
                "{laser} is tilted on {robot}, expected a laser that sweeps a plane parallel to the floor"
            )
        })
    }

    /// A frame and those above it, with the transform from the frame to each.
    fn ancestors<'a>(&'a self, frame: &'a str) -> Vec<(&'a str, Isometry3<f64>)> {
        let mut chain = vec![(frame, Isometry3::identity())];
        let mut at = (frame, Isometry3::identity());
        while let Some((parent, parent_from_child)) = self.parents.get(at.0) {
            if chain.iter().any(|(name, _)| name == parent) {
                break;
            }
            at = (parent, parent_from_child * at.1);
            chain.push(at);
        }
        chain
    }

    fn known(&self) -> String {
        let children = self.parents.keys();
        let parents = self.parents.values().map(|(parent, _)| parent);
        let names: BTreeSet<&str> = children.chain(parents).map(String::as_str).collect();
        match names.len() {
            0 => "the bag has no static transform".into(),
            _ => format!(
                "the static transforms know {}",
                names.into_iter().take(20).collect::<Vec<_>>().join(", ")
            ),
        }
    }
}

fn planar(robot_from_laser: &Isometry3<f64>) -> Option<PlanarMount> {
    let up = robot_from_laser.rotation * Vector3::z();
    let ahead = robot_from_laser.rotation * Vector3::x();
    let level = up.z.abs() >= MOST_TILT.cos();
    let at = robot_from_laser.translation;
    let robot_from_laser = Pose::new(at.x, at.y, ahead.y.atan2(ahead.x));
    level.then_some(PlanarMount { robot_from_laser, upside_down: up.z < 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn frames(transforms: &[(&str, &str, [f64; 6])]) -> StaticFrames {
        let mut frames = StaticFrames::default();
        for (parent, child, [x, y, z, roll, pitch, yaw]) in transforms {
            let rotation = UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw);
            let parent_from_child = Isometry3::from_parts([*x, *y, *z].into(), rotation);
            frames.add(Transform { parent: (*parent).into(), child: (*child).into(), parent_from_child });
        }
        frames
    }

    fn near(a: &Pose, b: &Pose) -> bool {
        let off = a.inverse().compose(b);
        off.x.hypot(off.y) < 1e-9 && off.theta.abs() < 1e-9
    }

    #[test]
    fn a_chain_goes_up_and_down_through_several_frames() {
        let frames = frames(&[
            ("base_footprint", "base_link", [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
            ("base_link", "mast", [0.2, 0.0, 0.5, 0.0, 0.0, FRAC_PI_2]),
            ("mast", "laser", [0.1, 0.0, 0.0, 0.0, 0.0, FRAC_PI_2]),
            ("base_link", "wheel", [0.0, 0.3, 0.0, 0.0, 0.0, FRAC_PI_2]),
        ]);
        let mount = frames.mount("base_footprint", "laser").unwrap();
        assert!(near(&mount.robot_from_laser, &Pose::new(0.2, 0.1, PI)) && !mount.upside_down);
        let mount = frames.mount("wheel", "laser").unwrap();
        assert!(near(&mount.robot_from_laser, &Pose::new(-0.2, -0.2, FRAC_PI_2)), "{mount:?}");
        assert_eq!(frames.mount("laser", "laser").unwrap().robot_from_laser, Pose::IDENTITY);
    }

    #[test]
    fn a_laser_may_hang_but_not_lean() {
        let frames = frames(&[
            ("base", "hanging", [0.1, 0.0, 0.0, PI, 0.0, 0.5]),
            ("base", "leaning", [0.1, 0.0, 0.0, 0.0, 0.3, 0.0]),
        ]);
        let mount = frames.mount("base", "hanging").unwrap();
        assert!(mount.upside_down && near(&mount.robot_from_laser, &Pose::new(0.1, 0.0, 0.5)));
        assert!(frames.mount("base", "leaning").unwrap_err().contains("tilted"));
        let error = frames.mount("odom", "hanging").unwrap_err();
        assert!(error.ends_with("the static transforms know base, hanging, leaning"), "{error}");
    }

    #[test]
    fn a_circle_of_frames_ends() {
        let shift = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let frames = frames(&[("a", "b", shift), ("b", "a", shift)]);
        assert!(frames.mount("a", "b").is_ok() && frames.mount("a", "c").is_err());
    }
}
