//! What was measured, in whole numbers, as answer-set programs have no others.

use crate::abduction::Visit;
use crate::reference::{Interval, Measured, Story, travels};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Bounds of lengths in micrometres and of bearings in microradians.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bounds {
    /// For each observation those of the length of the travel that led to it.
    pub lengths: Vec<Option<(i32, i32)>>,
    /// For each observation and slot those of the bearing in the frame of the observation.
    pub bearings: Vec<Vec<Option<(i32, i32)>>>,
}

/// Which way bounds are rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Apart: what the whole numbers refute, the measured ones refute.
    Outward,
    /// Together: what two measured bounds refute, the whole numbers refute.
    Inward,
}

/// A full turn. It is 0.3 more; bounds of bearings are a whole number wider, or narrower, to make up for it.
const TURN: i64 = 6_283_185;

impl Bounds {
    /// The bounds of a trace. One too large for whole numbers of 30 bits, a kilometre, is left out, so that nothing is
    /// said of it.
    pub fn of(measured: &Measured, rounding: Rounding) -> Bounds {
        let interval = |margin: f64| {
            move |(least, most): Interval| {
                let (low, high) = (least * MILLION, most * MILLION);
                let (low, high) = match rounding {
                    Rounding::Outward => (low.floor() - margin, high.ceil() + margin),
                    Rounding::Inward => (low.ceil() + margin, high.floor() - margin),
                };
                let fits = |bound: f64| bound.abs() < LARGEST;
                (fits(low) && fits(high)).then_some((low as i32, high as i32))
            }
        };
        let lengths = measured.lengths().iter().map(|length| length.and_then(interval(0.0))).collect();
        // Within a turn of nothing, so that sums of four stay whole numbers of 32 bits.
        let wrapped = |(least, most): Interval| {
            let turns = ((least + most) / 2.0 / TAU).round() * TAU;
            (least - turns, most - turns)
        };
        let slots = |slots: &Vec<Option<Interval>>| {
            slots.iter().map(|bearing| bearing.map(wrapped).and_then(interval(1.0))).collect()
        };
        Bounds { lengths, bearings: measured.bearings().iter().map(slots).collect() }
    }

    /// The bounds of the first observations.
    #[must_use]
    pub fn first(&self, observations: usize) -> Bounds {
        let lengths = self.lengths.iter().take(observations).copied().collect();
        Bounds { lengths, bearings: self.bearings.iter().take(observations).cloned().collect() }
    }

    /// The facts, in the words of `axioms/metrical.lp`.
    pub fn facts(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        for (k, length) in self.lengths.iter().enumerate() {
            let _ = length.map(|(low, high)| writeln!(text, "length({k},{low},{high})."));
        }
        for (k, slots) in self.bearings.iter().enumerate() {
            for (slot, bearing) in slots.iter().enumerate() {
                let _ = bearing.map(|(low, high)| write!(text, "bearing({k},{slot},{low},{high}). "));
            }
            if slots.iter().any(Option::is_some) {
                text = text.trim_end().to_owned() + "\n";
            }
        }
        text
    }

    /// Whether the rules of `axioms/metrical.lp` refute a story by an axiom: two travels along one path segment whose
    /// lengths do not meet, or two visits to one place from which two slots lie at angles that do not meet. What else
    /// measurements refute is to be handed in as nogoods.
    pub fn refute(&self, visits: &[Visit], story: &Story, axiom: &str) -> bool {
        let pairs = || (0..story.len()).flat_map(|k| (0..k).map(move |i| (k, i)));
        match axiom {
            "distance" => {
                let segments: Vec<_> =
                    travels(visits, story).into_iter().map(|(a, b)| (a.min(b), a.max(b))).collect();
                let apart = |k: usize, i: usize| {
                    let lengths =
                        self.lengths.get(k).copied().flatten().zip(self.lengths.get(i).copied().flatten());
                    lengths.is_some_and(|(a, b)| a.0 > b.1 || b.0 > a.1)
                };
                pairs().any(|(k, i)| i > 0 && segments[k - 1] == segments[i - 1] && apart(k, i))
            }
            "angle" => pairs().any(|(k, i)| story[k].0 == story[i].0 && self.askew(story, k, i)),
            _ => false,
        }
    }

    /// Whether two visits to a place, both tied to its first by some slot, see two slots at angles that do not meet.
    fn askew(&self, story: &Story, k: usize, i: usize) -> bool {
        let first = story.iter().position(|visit| visit.0 == story[k].0).unwrap_or(k);
        let [first, k, i] = [first, k, i].map(|visit| self.of_place(story, visit));
        let tied = |visit: &[(usize, (i32, i32))]| {
            visit.iter().any(|(slot, _)| first.iter().any(|(other, _)| other == slot))
        };
        let turn = |from: (i32, i32), to: (i32, i32)| {
            (i64::from(to.0) - i64::from(from.1), i64::from(to.1) - i64::from(from.0))
        };
        let both = |slot: usize, bounds| {
            Some((bounds, i.iter().find(|(other, _)| *other == slot).map(|(_, bounds)| *bounds)?))
        };
        let common: Vec<_> = k.iter().filter_map(|&(slot, bounds)| both(slot, bounds)).collect();
        let mut pairs = common.iter().flat_map(|from| common.iter().map(move |to| (from, to)));
        let askew = pairs.any(|(from, to)| !meet(turn(from.0, to.0), turn(from.1, to.1)));
        askew && tied(&k) && tied(&i)
    }

    /// The bounds of a visit's bearings by the slots of its place.
    fn of_place(&self, story: &Story, visit: usize) -> Vec<(usize, (i32, i32))> {
        let own = self.bearings.get(visit).map_or(&[][..], Vec::as_slice);
        let on = |slot: usize| (slot + story[visit].1) % own.len();
        own.iter().enumerate().filter_map(|(slot, bounds)| Some((on(slot), (*bounds)?))).collect()
    }
}

const MILLION: f64 = 1e6;
const LARGEST: f64 = (1 << 30) as f64;

/// Whether two intervals have an angle in common, modulo a turn.
fn meet(a: (i64, i64), b: (i64, i64)) -> bool {
    (-4..=4).any(|turns| a.0 <= b.1 + TURN * turns && b.0 + TURN * turns <= a.1)
}
