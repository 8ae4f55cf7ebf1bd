//! What a laser reports when nothing came back: a large number, and each log has its own.
//!
//! Told by an option, by a logged parameter or by the message, the number is known. Else the codes of SICK lasers in
//! centimetres are (81.83 to 81.91 m). Else it is guessed from what has come so far: the largest range of a log is
//! its no-return value if it stands out as a *spike*, met many times and more often than all that lies just below
//! it, as walls do not have a distance that they keep to the last digit. A later reading beyond it shows that it
//! was none. Read with a look ahead, this needs no second reading of the log.

/// Ranges from this fraction of a told or guessed value on count as no return, as CARMEN's tools have it.
pub(super) const FRACTION: f64 = 0.99;
/// The least of the codes of SICK lasers in centimetres, less half of a centimetre.
const SICK_CODES: f64 = 81.825;
/// No planar laser ranges farther, metres.
const PHYSICAL_LIMIT: f64 = 1000.0;
/// A spike was met at least so often, and more often than all ranges from a fraction of it on.
const SPIKE_COUNT: u64 = 16;
const SPIKE_NEAR: f64 = 0.95;

/// How it is known which ranges mean that nothing came back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NoReturnSource {
    /// By an option of the reader.
    Option,
    /// By a parameter in the log.
    Parameter,
    /// By the message itself.
    Message,
    /// By the codes of SICK lasers.
    SickCodes,
    /// By the spike at this range, metres.
    Guess(f64),
    /// Not at all: every finite range counts.
    #[default]
    Unknown,
}

/// Tells returns from no returns, for one laser.
#[derive(Clone, Debug, Default)]
pub(super) struct NoReturns {
    option: Option<f64>,
    parameter: Option<f64>,
    message: Option<f64>,
    sick_codes: bool,
    top: f64,
    at_top: u64,
    near_top: u64,
}

impl NoReturns {
    /// With the least range that means no return, if an option says it.
    pub(super) fn new(option: Option<f64>) -> Self {
        NoReturns { option, ..NoReturns::default() }
    }

    pub(super) fn hear_parameter(&mut self, limit: f64) {
        self.parameter = Some(limit);
    }

    /// Looks at a sweep before any decision about it is asked for.
    pub(super) fn observe(&mut self, ranges: &[f64], limit: Option<f64>) {
        self.message = limit.or(self.message);
        for &range in ranges.iter().filter(|range| **range > 0.0 && **range < PHYSICAL_LIMIT) {
            if range >= SICK_CODES {
                self.sick_codes = true;
            } else if range > self.top {
                let near = self.top >= SPIKE_NEAR * range;
                self.near_top = if near { self.near_top + self.at_top } else { 0 };
                (self.top, self.at_top) = (range, 1);
            } else if range == self.top {
                self.at_top += 1;
            } else if range >= SPIKE_NEAR * self.top {
                self.near_top += 1;
            }
        }
    }

    /// The least range that means no return, by all that was seen so far.
    pub(super) fn limit(&self) -> (Option<f64>, NoReturnSource) {
        let spike = !self.sick_codes && self.at_top >= SPIKE_COUNT && self.at_top > self.near_top;
        match (self.option, self.parameter, self.message) {
            (Some(limit), _, _) => (Some(limit), NoReturnSource::Option),
            (_, Some(limit), _) => (Some(limit), NoReturnSource::Parameter),
            (_, _, Some(limit)) => (Some(limit), NoReturnSource::Message),
            _ if self.sick_codes => (Some(SICK_CODES), NoReturnSource::SickCodes),
            _ if spike => (Some(FRACTION * self.top), NoReturnSource::Guess(self.top)),
            _ => (None, NoReturnSource::Unknown),
        }
    }
}

/// The range, if something came back from there.
pub(super) fn returned(range: f64, limit: Option<f64>) -> Option<f64> {
    let limit = limit.unwrap_or(PHYSICAL_LIMIT).min(PHYSICAL_LIMIT);
    (range > 0.0 && range < limit).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit_of(sweeps: &[&[f64]]) -> (Option<f64>, NoReturnSource) {
        let mut seen = NoReturns::default();
        sweeps.iter().for_each(|ranges| seen.observe(ranges, None));
        seen.limit()
    }

    #[test]
    fn a_value_that_stands_out_at_the_top_is_no_return() {
        let sweep = [3.0, 3.02, 4.5, 30.0, 30.0, 29.5];
        assert_eq!(limit_of(&[&sweep[..]; 3]), (None, NoReturnSource::Unknown));
        assert_eq!(limit_of(&[&sweep[..]; 9]), (Some(0.99 * 30.0), NoReturnSource::Guess(30.0)));
        assert_eq!(limit_of(&[&[3.0, 30.0, 29.9, 29.8][..]; 30]).1, NoReturnSource::Unknown);
        // Something farther away shows that it was a wall.
        let mut sweeps = vec![&sweep[..]; 9];
        sweeps.push(&[31.0]);
        assert_eq!(limit_of(&sweeps), (None, NoReturnSource::Unknown));
    }

    #[test]
    fn the_codes_of_sick_lasers_are_known() {
        assert_eq!(limit_of(&[&[2.0, 81.83]]), (Some(SICK_CODES), NoReturnSource::SickCodes));
        let wall = vec![&[40.0][..]; 40];
        assert_eq!(limit_of(&[&wall[..], &[&[81.91]]].concat()).1, NoReturnSource::SickCodes);
    }

    #[test]
    fn what_is_told_counts_before_what_is_seen() {
        let mut seen = NoReturns::new(None);
        seen.observe(&[81.91, 5.0], Some(20.0));
        assert_eq!(seen.limit(), (Some(20.0), NoReturnSource::Message));
        seen.hear_parameter(30.0);
        assert_eq!(seen.limit(), (Some(30.0), NoReturnSource::Parameter));
        let mut seen = NoReturns::new(Some(100.0));
        seen.observe(&[81.91, 5.0], Some(20.0));
        assert_eq!(seen.limit(), (Some(100.0), NoReturnSource::Option));
    }

    #[test]
    fn what_is_no_distance_did_not_return() {
        for range in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e5, 8.0] {
            assert_eq!(returned(range, Some(8.0)), None, "{range}");
        }
        assert_eq!(returned(7.9, Some(8.0)), Some(7.9));
        assert_eq!(returned(900.0, None), Some(900.0));
    }
}
