//! What a laser reports when nothing came back: a large number, and each log has its own.
//!
//! Told by an option, by a logged parameter or by the message, the number is known. Else it is guessed from what has
//! come so far: the no-return value of a log is the largest range that stands out as a *spike*, met many times and more
//! often than all that lies just below it, as walls do not have a distance that they keep to the last digit. Readings
//! beyond it show that it was none, unless they are so rare that they are strays. The codes of SICK lasers in
//! centimetres (81.83 to 81.91 m) are one value, and did not return even if they are too few to stand out. Read with a
//! look ahead, this needs no second reading of the log.

use std::ops::Range;

/// Ranges from this fraction of a told or guessed value on count as no return, as CARMEN's tools have it.
pub(super) const FRACTION: f64 = 0.99;
/// The codes of SICK lasers in centimetres, with half of a centimetre on both sides.
const SICK_CODES: Range<f64> = 81.825..81.915;
/// No planar laser ranges farther, metres.
const PHYSICAL_LIMIT: f64 = 1000.0;
/// A spike was met at least so often, so often for each reading beyond it, and more often than all ranges from a
/// fraction of it on.
const SPIKE_COUNT: u64 = 16;
const SPIKE_NEAR: f64 = 0.95;
/// So many of the largest values are counted.
const KEPT: usize = 16;

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
    largest: Largest,
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
            self.largest.count(if SICK_CODES.contains(&range) { SICK_CODES.start } else { range });
        }
    }

    /// The least range that means no return, by all that was seen so far.
    pub(super) fn limit(&self) -> (Option<f64>, NoReturnSource) {
        match (self.option, self.parameter, self.message) {
            (Some(limit), _, _) => (Some(limit), NoReturnSource::Option),
            (_, Some(limit), _) => (Some(limit), NoReturnSource::Parameter),
            (_, _, Some(limit)) => (Some(limit), NoReturnSource::Message),
            _ => match self.largest.spike() {
                Some(value) if value == SICK_CODES.start => (Some(value), NoReturnSource::SickCodes),
                Some(value) => (Some(FRACTION * value), NoReturnSource::Guess(value)),
                None => (None, NoReturnSource::Unknown),
            },
        }
    }
}

/// The largest values met, each with how often, in falling order. A spike stays, however many come beyond it, until
/// these are too many for it to be one.
#[derive(Clone, Debug, Default)]
struct Largest(Vec<Counted>);

/// A value, and how often it was met, a little less was, and more was. What was met before the value itself is
/// known from its neighbours, and rather too much than too little.
#[derive(Clone, Copy, Debug)]
struct Counted {
    value: f64,
    count: u64,
    near: u64,
    beyond: u64,
}

impl Counted {
    fn is_spike(&self) -> bool {
        self.count >= SPIKE_COUNT * self.beyond.max(1) && self.count > self.near
    }
}

impl Largest {
    fn spike(&self) -> Option<f64> {
        self.0.iter().find(|counted| counted.is_spike()).map(|counted| counted.value)
    }

    /// Linear in the values kept, for ranges that are not much less than them; else constant.
    fn count(&mut self, range: f64) {
        let full = self.0.len() == KEPT;
        if full && self.0.last().is_some_and(|least| range < SPIKE_NEAR * least.value) {
            return;
        }
        let at = self.0.partition_point(|counted| counted.value > range);
        let known = self.0.get(at).is_some_and(|counted| counted.value == range);
        if !known && (!full || at < KEPT) {
            self.insert(at, range);
        }
        for counted in &mut self.0 {
            if counted.value == range {
                counted.count += 1;
            } else if counted.value < range {
                counted.beyond += 1;
            } else if range >= SPIKE_NEAR * counted.value {
                counted.near += 1;
            }
        }
    }

    /// Makes room for a new value, not counted yet.
    fn insert(&mut self, at: usize, value: f64) {
        let less = self.0.get(at);
        let more = at.checked_sub(1).and_then(|at| self.0.get(at));
        let near =
            less.filter(|less| less.value >= SPIKE_NEAR * value).map_or(0, |less| less.near + less.count);
        let beyond =
            less.map(|less| less.beyond).or(more.map(|more| more.beyond + more.count)).unwrap_or_default();
        self.0.insert(at, Counted { value, count: 0, near, beyond });
        if self.0.len() > KEPT {
            let idle = self.0.iter().rposition(|counted| !counted.is_spike() && counted.value != value);
            self.0.remove(idle.unwrap_or(KEPT));
        }
    }
}

/// The range, if something came back from there. Where nothing told what means no return, a code of SICK lasers is one,
/// even a single one: a wall is hardly ever that far, and never in that gap alone.
pub(super) fn returned(range: f64, (limit, source): (Option<f64>, NoReturnSource)) -> Option<f64> {
    use NoReturnSource::{Guess, SickCodes, Unknown};
    let code = matches!(source, SickCodes | Guess(_) | Unknown) && SICK_CODES.contains(&range);
    let limit = limit.unwrap_or(PHYSICAL_LIMIT).min(PHYSICAL_LIMIT);
    (range > 0.0 && range < limit && !code).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
        // One reading farther away is a stray, more of them show that it was a wall.
        let mut sweeps = vec![&sweep[..]; 9];
        sweeps.push(&[31.0]);
        assert_eq!(limit_of(&sweeps).1, NoReturnSource::Guess(30.0));
        sweeps.push(&[33.0]);
        assert_eq!(limit_of(&sweeps), (None, NoReturnSource::Unknown));
    }

    #[test]
    fn strays_beyond_a_value_met_often_change_nothing() {
        let guess = (Some(0.99 * 50.0), NoReturnSource::Guess(50.0));
        for strays in [&[60.0][..], &[90.0], &[81.83, 81.91], &[50.01, 999.0, 70.0]] {
            let often = vec![&[50.0, 7.0, 49.91][..]; 100];
            assert_eq!(
                limit_of(&[&often[..], &[strays]].concat()).1,
                NoReturnSource::Unknown,
                "near: {strays:?}"
            );
            let often = vec![&[50.0, 7.0, 50.0, 12.5, 49.91][..]; 100];
            assert_eq!(limit_of(&[&often[..], &[strays]].concat()), guess, "{strays:?}");
            assert_eq!(limit_of(&[&[strays], &often[..]].concat()), guess, "before it: {strays:?}");
        }
        // More values than are kept, all different.
        let strays: Vec<f64> = (0..100).map(|k| 60.0 + f64::from(k)).collect();
        let often = vec![&[50.0][..]; 1600];
        assert_eq!(limit_of(&[&often[..], &[&strays[..]]].concat()), guess);
        assert_eq!(limit_of(&[&often[1..], &[&strays[..]]].concat()).1, NoReturnSource::Unknown);
    }

    #[test]
    fn the_codes_of_sick_lasers_are_known() {
        let codes = vec![&[2.0, 81.83, 81.91][..]; 8];
        let known = (Some(SICK_CODES.start), NoReturnSource::SickCodes);
        assert_eq!(limit_of(&codes), known);
        assert_eq!(limit_of(&codes[1..]).1, NoReturnSource::Unknown);
        assert_eq!(limit_of(&[&codes[..], &[&[90.0]]].concat()), known);
        assert_eq!(limit_of(&vec![&[81.92][..]; 40]).1, NoReturnSource::Guess(81.92));
        assert_eq!(limit_of(&vec![&[81.82][..]; 40]).1, NoReturnSource::Guess(81.82));
    }

    /// The table against all readings, where nothing had to leave it.
    fn spike_of(ranges: &[f64]) -> Option<f64> {
        let count = |wanted: &dyn Fn(f64) -> bool| ranges.iter().filter(|range| wanted(**range)).count();
        let spike = |value: &f64| {
            let met = count(&|range| range == *value);
            let near = count(&|range| range < *value && range >= SPIKE_NEAR * value);
            let beyond = count(&|range| range > *value);
            met >= SPIKE_COUNT as usize * beyond.max(1) && met > near
        };
        ranges.iter().copied().filter(spike).reduce(f64::max)
    }

    proptest! {
        #[test]
        fn the_table_finds_the_spike_of_all_readings(
            ranges in prop::collection::vec((0..8usize, 1..40usize), 1..30),
            far in 1..60usize,
        ) {
            // Apart by more than what is near, so that the neighbours tell exactly what was met before.
            let value = |k: usize| 10.0 * 1.1f64.powi(i32::try_from(k).unwrap());
            let ranges: Vec<f64> = ranges.into_iter().flat_map(|(k, n)| vec![value(k); n]).collect();
            let ranges = [ranges, vec![value(7); far]].concat();
            let mut largest = Largest::default();
            ranges.iter().for_each(|range| largest.count(*range));
            prop_assert_eq!(largest.spike(), spike_of(&ranges));
        }
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
        let told = (Some(8.0), NoReturnSource::Option);
        for range in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e5, 8.0] {
            assert_eq!(returned(range, told), None, "{range}");
        }
        assert_eq!(returned(7.9, told), Some(7.9));
        let unknown = (None, NoReturnSource::Unknown);
        assert_eq!(
            [81.82, 81.83, 81.91, 81.92, 900.0].map(|range| returned(range, unknown)),
            [Some(81.82), None, None, Some(81.92), Some(900.0)]
        );
        assert_eq!(returned(81.83, (Some(100.0), NoReturnSource::Message)), Some(81.83));
    }
}
