//! Errors with which all places and segments have room, held to the definition: as they are, without derivatives.
//!
//! A search for room goes by linearised conditions, and does not look again at visits that it put beyond a side. So what it
//! finds is looked at once more: where the errors put the visits, how far apart these are, and what chi-square the errors and
//! what they leave open of the loops take.

use crate::geometry::{Pose, wrap_angle};
use crate::metric::layout::{Layout, Loop};
use crate::metric::segments::Segments;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// How much nearer to each other than asked visits may lie, metres: what the last step of a descent leaves.
const NEARER: f64 = 0.01;

/// Errors with which all places lie apart, and no segment crosses another or leads past a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Witness {
    /// What chi-square they take beyond the least with which all loops close.
    pub chi_square: f64,
    /// What they may take.
    pub gate: f64,
    /// Where they put each visit, in the frame of the first one since the last travel that was not measured.
    pub poses: Vec<Pose>,
}

impl Witness {
    /// The errors of a layout, if they put first visits so far apart, any two of them, and segments clear, and take at most a gate
    /// more than the least. As many steps as there are pairs.
    pub(super) fn new(
        found: &Layout,
        segments: &Segments,
        apart: f64,
        least: f64,
        gate: f64,
    ) -> Option<Witness> {
        let at = |visit: usize| found.poses[visit].position();
        let firsts = &segments.firsts;
        let mut pairs =
            (0..firsts.len()).flat_map(|to| (0..to).map(move |from| (firsts[from].0, firsts[to].0)));
        let chi_square = found.errors().norm_squared() + open(found) - least;
        let holds = chi_square <= gate
            && pairs.all(|(from, to)| (at(to) - at(from)).norm() >= apart - NEARER)
            && segments.obstructions(&found.poses, NEARER).is_empty();
        holds.then(|| Witness { chi_square, gate, poses: found.poses.clone() })
    }
}

/// What it takes, over the spread of visits within their places, that loops end where they do: the least over where in its
/// place the first visit was. Spread is the same along both axes, so that it does not matter how frames are turned.
fn open(layout: &Layout) -> f64 {
    let mut places: BTreeMap<usize, Vec<&Loop>> = BTreeMap::new();
    layout.loops.iter().for_each(|closed| places.entry(closed.span.from).or_default().push(closed));
    let of_place = |loops: &Vec<&Loop>| {
        let offs: Vec<Vector3<f64>> = loops.iter().map(|closed| off(layout, closed)).collect();
        let turned = |off: &Vector3<f64>| off.z.is_finite();
        let [x, y] = [0, 1].map(|axis| spread(offs.iter().map(|off| off[axis])));
        x + y + spread(offs.iter().filter(|off| turned(off)).map(|off| off.z))
    };
    places.values().map(of_place).sum()
}

/// How far the later visit of a loop is from the first, in standard deviations of either; heading is not a number where
/// bearings do not tell.
fn off(layout: &Layout, closed: &Loop) -> Vector3<f64> {
    let seen = layout.poses[closed.span.from].inverse().compose(&layout.poses[closed.span.to]);
    let turn = closed.turn.map_or(f64::NAN, |turn| wrap_angle(seen.theta - turn));
    Vector3::new(seen.x, seen.y, turn).component_div(&closed.stay.map(f64::sqrt))
}

/// The least sum of squares of numbers and of one of spread one that is taken from all of them.
fn spread(offs: impl Iterator<Item = f64>) -> f64 {
    let (count, sum, squares) = offs
        .fold((0.0, 0.0, 0.0), |(count, sum, squares), off| (count + 1.0, sum + off, squares + off * off));
    squares - sum * sum / (count + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_common_to_all_is_the_first_one_s() {
        let by_steps = |offs: &[f64]| {
            let sum = |first: f64| first * first + offs.iter().map(|off| (off - first).powi(2)).sum::<f64>();
            (-5000..5000).map(|step| sum(f64::from(step) * 1e-3)).fold(f64::INFINITY, f64::min)
        };
        for offs in [vec![], vec![2.0], vec![1.0, -1.0], vec![1.5, 2.5, 0.5]] {
            let found = spread(offs.iter().copied());
            assert!((found - by_steps(&offs)).abs() < 1e-5, "{offs:?} {found}");
        }
    }
}
