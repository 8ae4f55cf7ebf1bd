//! Odometry that drifts: errors of heading and of length, some the same all the way, some new with every metre.

use crate::geometry::{Pose, bearing, wrap_angle};
use crate::trace::event::Travel;
use crate::worlds::random::Random;

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

    /// What it tells of a turn on the spot by an angle, and then of a straight way to a pose, given in the frame of the
    /// robot as it has turned, where it turns to its heading on arrival. `from_pose` is where the robot believes to
    /// start, in the frame in which it stood unturned.
    pub fn travel(&mut self, turned: f64, end: &Pose) -> Travel {
        let believed = turned + self.turning(turned);
        let length = end.x.hypot(end.y);
        let way = bearing(&end.position().coords);
        let steps = (length / STEP).ceil().max(1.0);
        let step = length / steps;
        let mut at = Pose::new(0.0, 0.0, way);
        let mut shape = vec![[0.0, 0.0]];
        for _ in 0..steps as usize {
            let gained = self.heading * step + self.drift.heading_noise * step.sqrt() * self.random.normal();
            let gone =
                step * (1.0 + self.length) + self.drift.length_noise * step.sqrt() * self.random.normal();
            at = at.compose(&Pose::new(gone * (gained / 2.0).cos(), gone * (gained / 2.0).sin(), gained));
            shape.push([at.x, at.y]);
        }
        // The frame at the start is the one believed; the way is measured in it.
        let odometry = Pose::new(at.x, at.y, at.theta + wrap_angle(end.theta - way));
        Travel {
            odometry: Some(odometry),
            covariance: Some(self.drift.covariance(turned, length, bearing(&odometry.position().coords))),
            from_pose: Some(Pose::new(0.0, 0.0, believed)),
            shape,
        }
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

impl Drift {
    /// The covariance of a displacement by a straight way of a length, in a direction, after a turn: row-major x, y,
    /// theta. The error of the turn counts as one of the displacement, which starts with a wrong heading.
    pub fn covariance(&self, turned: f64, length: f64, way: f64) -> [f64; 9] {
        let along = (self.length_bias * length).powi(2) + self.length_noise.powi(2) * length;
        let turn = (self.turn_noise * turned).powi(2);
        let (bias, noise) = (self.heading_bias.powi(2), self.heading_noise.powi(2));
        // Heading gained evenly over the way moves its end aside by half of what it would at its beginning.
        let heading = bias * length.powi(2) + noise * length + turn;
        let both = bias * length.powi(3) / 2.0 + noise * length.powi(2) / 2.0 + turn * length;
        let aside = bias * length.powi(4) / 4.0 + noise * length.powi(3) / 3.0 + turn * length.powi(2);
        let (sin, cos) = way.sin_cos();
        let xy = (along - aside) * sin * cos;
        [
            along * cos * cos + aside * sin * sin,
            xy,
            -both * sin,
            xy,
            along * sin * sin + aside * cos * cos,
            both * cos,
            -both * sin,
            both * cos,
            heading,
        ]
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
            let travel = odometer.travel(FRAC_PI_2, &Pose::new(side, 0.0, 0.0));
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

    #[test]
    fn the_covariance_is_that_of_the_errors() {
        let (turned, end) = (FRAC_PI_2, Pose::new(6.0, 8.0, 0.3));
        let mut sum = nalgebra::Matrix3::zeros();
        let runs = 4000;
        for seed in 0..runs {
            let travel = Odometer::new(Drift::WORST, seed).travel(turned, &end);
            let start = Pose::new(0.0, 0.0, travel.from_pose.unwrap().theta - turned);
            let found = start.compose(&travel.odometry.unwrap());
            let off =
                nalgebra::Vector3::new(found.x - end.x, found.y - end.y, wrap_angle(found.theta - end.theta));
            sum += off * off.transpose() / runs as f64;
        }
        let said = Drift::WORST.covariance(turned, 10.0, 0.8_f64.atan2(0.6));
        let said = nalgebra::Matrix3::from_row_slice(&said);
        // Weighed by each other's spread, so that metres and radians count alike.
        let root = said.diagonal().map(f64::sqrt);
        let off = (sum - said).component_div(&(root * root.transpose()));
        assert!(off.amax() < 0.1, "{off}");
    }
}
