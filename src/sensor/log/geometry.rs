//! The angles of beams where the message does not say them.
//!
//! `FLASER` and `RLASER` give a number of readings and no angles. CARMEN's own reader takes a field of view that starts
//! at -90 degrees, in steps of 1 degree for 180 and 181 readings, 0.5 for 360 and 361, 0.25 for 400 and 401, else
//! of 180 / (n - 1) degrees; so with 180 readings the last beam of 181 is missing. A logged field of view and
//! resolution are better, where they fit the number of readings.

use std::f64::consts::{FRAC_PI_2, TAU};

/// How far beyond a turn angles may be, as a fraction: they are rounded, and some drivers give nominal ones.
const ROUNDING: f64 = 0.01;
/// The least angle that a sweep covers, radians.
const LEAST_VIEW: f64 = 1e-6;

/// A field of view and a resolution from the log's parameters, both in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ViewParameters {
    pub(super) field_of_view: Option<f64>,
    pub(super) resolution: Option<f64>,
}

/// Start angle and increment, radians, guessed from the number of readings alone.
pub(super) fn guessed(beams: usize) -> (f64, f64) {
    let degrees = match beams {
        180 | 181 => 1.0,
        360 | 361 => 0.5,
        400 | 401 => 0.25,
        n => 180.0 / n.saturating_sub(1).max(1) as f64,
    };
    (-FRAC_PI_2, f64::to_radians(degrees))
}

/// Refuses angles that no laser has: beams are on one turn, and not all in one direction. The angle of the first one
/// may be anything where the user tells it (`--start-angle`).
pub(super) fn check(
    (start_angle, angle_increment): (f64, f64),
    beams: usize,
    start_told: bool,
) -> Result<(), String> {
    let turn = TAU * (1.0 + ROUNDING);
    let on_a_turn = start_angle.abs() <= turn;
    if !start_told && !on_a_turn {
        return Err(format!(
            "has a first beam at {start_angle:?} radians, expected an angle within a turn; --start-angle tells the right one"
        ));
    }
    let view = angle_increment.abs() * beams.saturating_sub(1) as f64;
    if beams > 1 && !(LEAST_VIEW..=turn).contains(&view) {
        return Err(format!(
            "has {beams} beams in steps of {angle_increment:?} radians, expected them to cover at most a turn and more \
             than {LEAST_VIEW:?}; mend the driver's resolution, which is in radians"
        ));
    }
    Ok(())
}

impl ViewParameters {
    /// Start angle and increment, radians, where the parameters fit so many beams, to two beams.
    pub(super) fn angles(&self, beams: usize) -> Option<(f64, f64)> {
        let (view, step) = (self.field_of_view?, self.resolution?);
        let fits = step > 0.0 && view <= 360.0 && (view / step - beams as f64).abs() < 2.0;
        fits.then(|| (f64::to_radians(-view / 2.0), f64::to_radians(step)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angles_of_carmen() {
        let degrees = |n: usize| {
            let (start, step) = guessed(n);
            (start.to_degrees(), (step * 1e9).to_degrees().round() / 1e9)
        };
        for (n, step) in [(180, 1.0), (181, 1.0), (360, 0.5), (361, 0.5), (400, 0.25), (401, 0.25), (91, 2.0)]
        {
            assert_eq!(degrees(n), (-90.0, step), "{n}");
        }
        assert!(guessed(2).1 > 3.1 && guessed(0).1.is_finite() && guessed(1).1.is_finite());
    }

    #[test]
    fn angles_of_no_laser_are_refused() {
        let degrees =
            |start: f64, step: f64, beams| check((start.to_radians(), step.to_radians()), beams, false);
        for (start, step, beams) in [
            (-90.0, 1.0, 181),
            (-180.0, 1.0, 361),
            (360.0, -1.0, 360),
            (0.0, 360.0 / 32768.0, 32768),
            (0.0, 1.005, 360),
            (10.0, 1e30, 1),
            (10.0, 0.0, 0),
        ] {
            assert_eq!(degrees(start, step, beams), Ok(()), "{start} {step} {beams}");
        }
        for (start, step, beams) in [
            (0.0, 1.1, 361),
            (0.0, 1e30, 2),
            (0.0, 1e-30, 360),
            (0.0, 0.0, 2),
            (0.0, f64::NAN, 2),
            (0.0, -90.0, 6),
        ] {
            assert!(degrees(start, step, beams).unwrap_err().contains("at most a turn"), "{step} {beams}");
        }
        for start in [1e38, -370.0, f64::NAN, f64::INFINITY] {
            let error = degrees(start, 1.0, 2).unwrap_err();
            assert!(error.contains("first beam at") && error.contains("--start-angle"), "{error}");
            assert_eq!(check((start, 0.1), 2, true), Ok(()));
        }
    }

    #[test]
    fn parameters_hold_where_they_fit() {
        let wide = ViewParameters { field_of_view: Some(270.0), resolution: Some(0.25) };
        let (start, step) = wide.angles(1081).unwrap();
        assert!((start.to_degrees() + 135.0).abs() < 1e-9 && (step.to_degrees() - 0.25).abs() < 1e-9);
        assert_eq!(wide.angles(180), None);
        let broken = ViewParameters { field_of_view: Some(180.0), resolution: Some(0.0) };
        assert_eq!(broken.angles(180), None);
        assert_eq!(ViewParameters::default().angles(180), None);
    }
}
