//! Steps of the odometry that no robot makes: the log leaps, as where two drives were put into one, an encoder slipped or
//! the odometry was reset.

/// Faster than this is no robot that maps a building, metres per second by the stamps.
const FASTEST: f64 = 5.0;
/// What is said of speed is said of steps from here on, metres, as stamps are some hundredths of a second off.
const SHORTEST: f64 = 0.5;
/// A step of more than this in less than this time is none, whatever its speed by stamps that repeat or go back.
const LONGEST: f64 = 2.0;
const SOON: f64 = 1.0;

/// A step of the odometry from one scan to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The scan that it leads to, counted over the scans of the log from 0.
    pub scan: u64,
    /// How far, metres.
    pub metres: f64,
    /// In which time by the stamps, seconds; not above nought if they repeat or go back.
    pub seconds: f64,
}

impl Step {
    /// Whether no robot makes it. Without stamps nobody knows, unless they tell some time.
    pub(super) fn is_impossible(&self, stamped: bool) -> bool {
        let Step { metres, seconds, .. } = *self;
        let too_fast = seconds > 0.0 && metres > SHORTEST && metres > FASTEST * seconds;
        let leap = metres > LONGEST && seconds < SOON;
        too_fast || leap && (stamped || seconds != 0.0)
    }

    /// Whether it is so long besides that it tells nothing of the way: the odometry was set anew, or the log goes on
    /// elsewhere. Stamps that repeat may be no stamps.
    pub(in crate::sensor) fn is_leap(&self) -> bool {
        let Step { metres, seconds, .. } = *self;
        metres > LONGEST && seconds != 0.0 && metres > FASTEST * seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_impossible_by_its_speed_or_its_length() {
        for (metres, seconds, impossible) in [
            (0.1, 0.001, false),
            (0.94, 0.21, false),
            (1.2, 0.21, true),
            (1.9, 0.0, false),
            (2.1, 0.0, true),
            (2.1, -100.0, true),
            (2.1, 0.9, true),
            (2.1, 1.0, false),
            (40.0, 10.0, false),
            (60.0, 10.0, true),
        ] {
            let step = Step { scan: 1, metres, seconds };
            assert_eq!(step.is_impossible(true), impossible, "{step:?}");
            assert_eq!(step.is_impossible(false), impossible && seconds != 0.0, "{step:?}");
            assert!(!step.is_leap() || step.is_impossible(false), "{step:?}");
            assert_eq!(
                step.is_leap(),
                [(2.1, -100.0), (60.0, 10.0)].contains(&(metres, seconds)),
                "{step:?}"
            );
        }
    }
}
