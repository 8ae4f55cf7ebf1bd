//! What the measured axioms take from the physical world.

/// Physical bounds of the measured axioms. One set of defaults serves all data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetricParameters {
    /// How many standard deviations an interval reaches to either side. Default 5: a true measurement falls outside
    /// once in 1.7 million. A thousand walks of sixty travels make sixty thousand tests of the true map, so that one
    /// such evaluation in thirty refutes it by chance, if errors are normal and their covariances honest.
    pub sigmas: f64,
    /// Chi-square beyond which a displacement of two coordinates does not agree. Default 28.744, the quantile that
    /// is exceeded as often as five standard deviations are.
    pub position_gate: f64,
    /// The same for three coordinates, position and heading. Default 31.812.
    pub pose_gate: f64,
    /// Standard deviation of the bearing of a slot as seen on one visit, radians. Default 3 degrees: a gateway two
    /// metres wide is read off cells of 5 to 10 cm, so that its ends are known to within 10 cm.
    pub bearing_sigma: f64,
    /// Standard deviation, along each axis, of the point of a place as found on one visit, metres. Default 0.25: a
    /// robot in a corridor two metres wide stands within half a metre of the middle of a junction, and the middle
    /// of the free space around it is found as well as that.
    pub extent_sigma: f64,
    /// How near to each other, in metres, the robot may have stood at two different places. Default 5: a place is a
    /// neighbourhood, and perception looks farther than that around its middle, so that what is nearer and in sight
    /// is one place; behind a wall two corridors have a row of rooms between them. Where the trace shows a shorter
    /// travel, that length counts instead. To be lowered where corridors lie closer.
    pub separation: f64,
    /// How many metres of position a radian is worth where the least uncertain chain is looked for. Default 10. It
    /// chooses between chains, each of which is sound.
    pub lever: f64,
}

impl Default for MetricParameters {
    fn default() -> Self {
        MetricParameters {
            sigmas: 5.0,
            position_gate: 28.744,
            pose_gate: 31.812,
            bearing_sigma: 3.0_f64.to_radians(),
            extent_sigma: 0.25,
            separation: 5.0,
            lever: 10.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The probability that a chi-square variable of so many degrees of freedom exceeds a value, by integration of
    /// its density over the square root of the variable.
    fn exceeded(value: f64, degrees: u32) -> f64 {
        let radial = |r: f64| match degrees {
            1 => 2.0 / TAU.sqrt() * (-r * r / 2.0).exp(),
            2 => r * (-r * r / 2.0).exp(),
            _ => (4.0 / TAU).sqrt() * r * r * (-r * r / 2.0).exp(),
        };
        let step = 1e-4;
        (0..100_000).map(|k| value.sqrt() + (f64::from(k) + 0.5) * step).map(|r| radial(r) * step).sum()
    }

    #[test]
    fn gates_are_exceeded_as_often_as_the_interval_is_left() {
        let parameters = MetricParameters::default();
        let left = exceeded(parameters.sigmas.powi(2), 1);
        assert!((left - 5.733e-7).abs() < 1e-9, "{left}");
        for (gate, degrees) in [(parameters.position_gate, 2), (parameters.pose_gate, 3)] {
            let tail = exceeded(gate, degrees);
            assert!((tail / left - 1.0).abs() < 1e-3, "{degrees}: {tail}");
        }
    }
}
