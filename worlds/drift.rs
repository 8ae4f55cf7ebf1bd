//! Odometry that drifts: errors of heading and of length, some the same all the way, some new with every metre.

use crate::geometry::{Point, Pose, bearing, direction, lever, rotation, wrap_angle};
use crate::trace::event::Travel;
use crate::worlds::random::Random;
use nalgebra::{Matrix3, Vector3};

/// How badly wheel odometry drifts. All are standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Heading gained or lost with every metre of a whole run, radians a metre: wheels of unequal size.
    pub heading_bias: f64,
    /// The same, but new at every metre: radians after one metre, growing with the root of the distance.
    pub heading_noise: f64,
    /// Share of every length of a whole run: wheels of another size than thought.
    pub length_bias: f64,
    /// The same, but new at every metre: metres after one metre, growing with the root of the distance.
    pub length_noise: f64,
    /// Error of a turn on the spot, as a share of it.
    pub turn_noise: f64,
    /// Error of the bearing of a slot, radians.
    pub bearing_noise: f64,
}

impl Drift {
    /// As bad as odometry that leaves 14 to 25 m at the end of a loop of 80 by 25 m.
    ///
    /// A constant error of heading bends such a loop open by 8.8 m for each 0.001 radians a metre; with these figures
    /// the root of the mean square is 20 m.
    pub const WORST: Drift = Drift {
        heading_bias: 0.0022,
        heading_noise: 0.005,
        length_bias: 0.015,
        length_noise: 0.02,
        turn_noise: 0.01,
        bearing_noise: 0.035,
    };

    /// The same with all errors of odometry this many times as large; bearings are as they are.
    #[must_use]
    pub fn scaled(self, by: f64) -> Drift {
        Drift {
            heading_bias: self.heading_bias * by,
            heading_noise: self.heading_noise * by,
            length_bias: self.length_bias * by,
            length_noise: self.length_noise * by,
            turn_noise: self.turn_noise * by,
            ..self
        }
    }
}

/// The odometer of one run.
#[derive(Clone, Debug)]
pub struct Odometer {
    drift: Drift,
    random: Random,
    heading: f64,
    length: f64,
}

/// Metres over which errors are taken to be constant.
const STEP: f64 = 0.5;

impl Odometer {
    /// The odometer of a run; what is the same all the way is drawn from the seed.
    pub fn new(drift: Drift, seed: u64) -> Odometer {
        let mut random = Random::new(seed);
        let (heading, length) = (drift.heading_bias * random.normal(), drift.length_bias * random.normal());
        Odometer { drift, random, heading, length }
    }

    /// What it tells of a turn on the spot by an angle, and then of a way by straight pieces to a pose, where it turns to its
    /// heading on arrival. The pose and the corners, at which it turns on the spot, are given in the frame of the robot as it has
    /// turned. `from_pose` is where the robot believes to start, in the frame in which it stood unturned.
    pub fn travel(&mut self, turned: f64, corners: &[Point], end: &Pose) -> Travel {
        let believed = turned + self.turning(turned);
        let (mut here, mut way) = (Point::origin(), None);
        let mut at = Pose::IDENTITY;
        let mut shape = vec![[0.0, 0.0]];
        let mut pieces = Vec::new();
        for to in corners.iter().copied().chain([end.position()]) {
            let ahead = bearing(&(to - here));
            // The first piece begins where it was turned to.
            let turn = way.map_or(turned, |way| wrap_angle(ahead - way));
            at.theta += if way.is_some() { turn + self.turning(turn) } else { ahead };
            let before = at.position();
            at = self.straight(at, (to - here).norm(), &mut shape);
            pieces.push(Piece {
                turned: turn,
                length: (to - here).norm(),
                way: bearing(&(at.position() - before)),
            });
            (here, way) = (to, Some(ahead));
        }
        // The frame at the start is the one believed; the way is measured in it.
        let heading = at.theta + wrap_angle(end.theta - way.unwrap_or_default());
        Travel {
            odometry: Some(Pose::new(at.x, at.y, heading)),
            covariance: Some(self.drift.covariance(&pieces)),
            from_pose: Some(Pose::new(0.0, 0.0, believed)),
            shape,
        }
    }

    /// Where it believes to be after a straight piece of way, whose points it adds to the shape.
    fn straight(&mut self, mut at: Pose, length: f64, shape: &mut Vec<[f64; 2]>) -> Pose {
        let steps = (length / STEP).ceil().max(1.0);
        let step = length / steps;
        for _ in 0..steps as usize {
            let gained = self.heading * step + self.drift.heading_noise * step.sqrt() * self.random.normal();
            let gone =
                step * (1.0 + self.length) + self.drift.length_noise * step.sqrt() * self.random.normal();
            at = at.compose(&Pose::new(gone * (gained / 2.0).cos(), gone * (gained / 2.0).sin(), gained));
            shape.push([at.x, at.y]);
        }
        at
    }

    /// The bearing of a slot as it is seen.
    pub fn bearing(&mut self, bearing: f64) -> f64 {
        wrap_angle(bearing + self.drift.bearing_noise * self.random.normal())
    }

    /// The error of a turn on the spot.
    fn turning(&mut self, angle: f64) -> f64 {
        self.drift.turn_noise * angle.abs() * self.random.normal()
    }
}

/// A straight piece of a way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    /// The turn on the spot that it begins with, radians.
    turned: f64,
    /// Metres.
    length: f64,
    /// Its direction, in the frame of the displacement.
    way: f64,
}

impl Drift {
    /// The covariance of a displacement by a way of straight pieces: row-major x, y, theta. The errors of turns count as
    /// errors of the displacement, the first of which starts with a wrong heading; those that are the same all the way add up
    /// over its pieces.
    fn covariance(&self, pieces: &[Piece]) -> [f64; 9] {
        let (mut new, mut heading, mut length) = (Matrix3::zeros(), Vector3::zeros(), Vector3::zeros());
        for piece in pieces {
            let carried = lever(&(direction(piece.way) * piece.length));
            let turned = rotation(piece.way);
            new = carried * new * carried.transpose() + turned * self.new_errors(piece) * turned.transpose();
            // Heading gained evenly over a piece moves its end aside by half of what it would at its beginning.
            let gained = Vector3::new(0.0, piece.length.powi(2) / 2.0, piece.length) * self.heading_bias;
            heading = carried * heading + turned * gained;
            length = carried * length + turned * Vector3::new(self.length_bias * piece.length, 0.0, 0.0);
        }
        let covariance = new + heading * heading.transpose() + length * length.transpose();
        std::array::from_fn(|k| covariance[(k / 3, k % 3)])
    }

    /// The covariance of what is new on a piece, at its end and along it.
    fn new_errors(&self, piece: &Piece) -> Matrix3<f64> {
        let length = piece.length;
        let turn = (self.turn_noise * piece.turned).powi(2);
        let noise = self.heading_noise.powi(2);
        let along = self.length_noise.powi(2) * length;
        let aside = noise * length.powi(3) / 3.0 + turn * length.powi(2);
        let both = noise * length.powi(2) / 2.0 + turn * length;
        let heading = noise * length + turn;
        Matrix3::new(along, 0.0, 0.0, 0.0, aside, both, 0.0, both, heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// How far from its start a robot believes to be that has gone around a rectangle.
    fn left_over(seed: u64) -> f64 {
        let mut odometer = Odometer::new(Drift::WORST, seed);
        let mut believed = Pose::IDENTITY;
        for side in [80.0, 25.0, 80.0, 25.0] {
            let travel = odometer.travel(FRAC_PI_2, &[], &Pose::new(side, 0.0, 0.0));
            believed = believed.compose(&travel.from_pose.unwrap()).compose(&travel.odometry.unwrap());
        }
        believed.x.hypot(believed.y)
    }

    #[test]
    fn a_loop_of_80_by_25_metres_leaves_14_to_25_metres() {
        let mut left: Vec<f64> = (0..2000).map(left_over).collect();
        left.sort_by(f64::total_cmp);
        let mean_square = left.iter().map(|left| left * left).sum::<f64>() / left.len() as f64;
        let at = |share: f64| left[(share * left.len() as f64) as usize];
        println!(
            "end of an 80 m by 25 m loop: rms {:.1} m, tenth {:.1}, half {:.1}, nine tenths {:.1}, most {:.1}",
            mean_square.sqrt(),
            at(0.1),
            at(0.5),
            at(0.9),
            left[left.len() - 1]
        );
        assert!((14.0..25.0).contains(&mean_square.sqrt()));
        let as_bad = left.iter().filter(|left| **left >= 14.0).count();
        assert!(as_bad * 10 > left.len() * 4, "{as_bad} of {}", left.len());
    }

    /// Straight, around a corner, and out and back beside itself.
    #[test]
    fn the_covariance_is_that_of_the_errors() {
        let end = Pose::new(6.0, 8.0, 0.3);
        let corners: [&[[f64; 2]]; 3] =
            [&[], &[[6.0, 0.0]], &[[0.0, 30.0], [3.0, 30.0], [3.0, 2.0], [6.0, 2.0]]];
        for corners in corners {
            let corners: Vec<Point> = corners.iter().map(|&[x, y]| Point::new(x, y)).collect();
            let off = off(FRAC_PI_2, &corners, &end);
            assert!(off.amax() < 0.1, "{corners:?} {off}");
        }
    }

    /// How far the covariance of errors is from what is said, weighed by each other's spread, so that metres and radians count
    /// alike.
    fn off(turned: f64, corners: &[Point], end: &Pose) -> Matrix3<f64> {
        let (mut found, mut said) = (Matrix3::zeros(), Matrix3::zeros());
        let runs = 4000;
        for seed in 0..runs {
            let travel = Odometer::new(Drift::WORST, seed).travel(turned, corners, end);
            let start = Pose::new(0.0, 0.0, travel.from_pose.unwrap().theta - turned);
            let led = start.compose(&travel.odometry.unwrap());
            let off = Vector3::new(led.x - end.x, led.y - end.y, wrap_angle(led.theta - end.theta));
            found += off * off.transpose() / runs as f64;
            said += Matrix3::from_row_slice(&travel.covariance.unwrap()) / runs as f64;
        }
        let root = said.diagonal().map(f64::sqrt);
        (found - said).component_div(&(root * root.transpose()))
    }
}
