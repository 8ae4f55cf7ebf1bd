//! Which gateways share a path fragment: whether a path continues through the place (seed, section 4.2).

use crate::gateway::Gateway;
use crate::geometry::Vector;

/// When two gateways are ends of one path fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentParameters {
    /// A pair scores more; 1 is straight across and 0.5 is 60 degrees off or one width beside. Default 0.5.
    pub least_score: f64,
    /// A pair is ambiguous if the runner-up of either gateway scores more than this share of it, or may do better than
    /// it where bearings and centres are off by what cells can make of them. Default 0.8.
    pub ambiguity: f64,
}

impl Default for FragmentParameters {
    fn default() -> Self {
        FragmentParameters { least_score: 0.5, ambiguity: 0.8 }
    }
}

/// A path fragment by the indices of its gateways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fragment {
    pub(super) gateway: usize,
    /// The gateway at the other end, unless the path terminates at the place.
    pub(super) partner: Option<usize>,
    /// How far the pairing is from being decided otherwise: by so much, a fraction of each, the least score and what a
    /// runner-up may have would have to be other than they are.
    pub(super) margin: f64,
}

/// The fragments of a place, in the order of their first gateways. Gateways pair if each is the other's best, good
/// enough and without a close runner-up; all others terminate. A pair is as sure as it pairs; a gateway that terminates is
/// as sure as it is far from the nearest pair that it would be of. Cubic in the gateways.
pub(super) fn pair(gateways: &[Gateway], parameters: &FragmentParameters) -> Vec<Fragment> {
    let scores = Scores::of(gateways);
    let mut fragments = Vec::new();
    for a in 0..gateways.len() {
        let others = (0..gateways.len()).filter(|&b| b != a).map(|b| (b, scores.sureness(a, b, parameters)));
        // At most one pairs, as it leaves all others behind.
        let nearest = others.max_by(|(_, one), (_, other)| one.total_cmp(other));
        match nearest {
            Some((b, sureness)) if sureness > 0.0 => {
                if a < b {
                    fragments.push(Fragment { gateway: a, partner: Some(b), margin: sureness });
                }
            }
            other => {
                let margin = other.map_or(1.0, |(_, sureness)| 0.0 - sureness);
                fragments.push(Fragment { gateway: a, partner: None, margin });
            }
        }
    }
    fragments
}

/// How well each two gateways are met across the place by each other.
struct Scores(Vec<Vec<Score>>);

#[derive(Clone, Copy)]
struct Score {
    exact: f64,
    /// At least and at most, with both gateways off by their errors.
    worst: f64,
    likeliest: f64,
}

impl Scores {
    fn of(gateways: &[Gateway]) -> Scores {
        let score = |a: &Gateway, b: &Gateway| {
            let [worst, likeliest] = score_bounds(a, b);
            Score { exact: symmetric_score(a, b), worst, likeliest }
        };
        Scores(gateways.iter().map(|a| gateways.iter().map(|b| score(a, b)).collect()).collect())
    }

    /// How far two gateways are from not being a pair, above nought; or from being one, below. In fractions of what decides:
    /// of the least score, and of the runner-up's share of the score; of both the less, within one.
    fn sureness(&self, a: usize, b: usize, parameters: &FragmentParameters) -> f64 {
        let own = self.0[a][b];
        let share = |rival: Score| {
            let near = rival.exact / (parameters.ambiguity * own.exact).max(f64::MIN_POSITIVE);
            near.max(rival.likeliest / own.worst.max(f64::MIN_POSITIVE))
        };
        let rivals = [a, b].into_iter().flat_map(|end| {
            let others = (0..self.0.len()).filter(move |&other| other != a && other != b);
            others.map(move |other| self.0[end][other]).filter(|rival| rival.likeliest > 0.0)
        });
        let contest = rivals.map(share).fold(0.0, f64::max);
        (own.exact / parameters.least_score - 1.0).min(1.0 - contest).max(-1.0)
    }
}

/// The least and the greatest score of a pair as read, and with bearings off by their errors to either side and centres nearer to
/// each other's line or farther from it by theirs.
fn score_bounds(a: &Gateway, b: &Gateway) -> [f64; 2] {
    let turned = |gateway: &Gateway, by: f64| Gateway { bearing: gateway.bearing + by, ..gateway.clone() };
    let either = |gateway: &Gateway| [-1.0, 1.0].map(|side| turned(gateway, side * gateway.bearing_error()));
    let [first, second] = [either(a), either(b)];
    let read_error = a.read_error + b.read_error;
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
    let scores = pairs.flat_map(|(a, b)| [-1.0, 1.0].map(|side| score_beside(a, b, side * read_error)));
    let exact = symmetric_score(a, b);
    scores.fold([exact; 2], |[least, most], score| [least.min(score), most.max(score)])
}

fn symmetric_score(a: &Gateway, b: &Gateway) -> f64 {
    score_beside(a, b, 0.0)
}

fn score_beside(a: &Gateway, b: &Gateway, farther: f64) -> f64 {
    across(a, b, farther).min(across(b, a, farther))
}

/// How well the straight projection inward from `a` meets `b`: opposite directions, and little offset in widths, which is so much
/// farther than it seems.
fn across(a: &Gateway, b: &Gateway, farther: f64) -> f64 {
    let (inward, line_normal): (Vector, Vector) = (-a.outward(), b.outward());
    let facing = inward.dot(&line_normal);
    let distance = (b.center - a.center).dot(&line_normal);
    if facing <= 0.0 || distance < 0.0 {
        return 0.0;
    }
    let met = a.center + inward * (distance / facing);
    let offset = ((met - b.center).norm() + farther).max(0.0) / b.width;
    facing * (1.0 - offset / 2.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, direction};
    use proptest::prelude::*;
    use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
    use std::cell::Cell;
    use std::f64::consts::{PI, SQRT_2};

    fn gateway(x: f64, y: f64, bearing: f64) -> Gateway {
        let center = Point::new(x, y);
        let left = direction(bearing + PI / 2.0);
        Gateway {
            center,
            ends: [center + left, center - left],
            bearing,
            read_error: 0.0,
            width: 2.0,
            passage: 2.0,
            margin: 1.0,
            beyond: Vec::new(),
        }
    }

    fn pairs(gateways: &[Gateway]) -> Vec<(usize, Option<usize>)> {
        let fragments = pair(gateways, &FragmentParameters::default());
        fragments.iter().map(|f| (f.gateway, f.partner)).collect()
    }

    #[test]
    fn straight_across_pairs_and_sideways_terminates() {
        let gateways = [gateway(2.0, 0.0, 0.0), gateway(0.0, -2.0, -PI / 2.0), gateway(-2.0, 0.0, PI)];
        assert_eq!(pairs(&gateways), [(0, Some(2)), (1, None)]);
    }

    #[test]
    fn lateral_offset_counts_in_widths() {
        let with_offset = |y: f64| pairs(&[gateway(2.0, 0.0, 0.0), gateway(-2.0, y, PI)]);
        assert_eq!(with_offset(1.9), [(0, Some(1))]);
        assert_eq!(with_offset(2.1), [(0, None), (1, None)]);
    }

    /// Five ways, evenly: each is 36 degrees off straight across from two others. Two are read 3 degrees off.
    #[test]
    fn what_cells_can_make_of_bearings_makes_no_pair() {
        let fork = |error: f64| -> Vec<Gateway> {
            let off = |k: usize| [-3.2_f64, 0.0, 2.4, 0.0, 0.0][k].to_radians();
            let at = |k: usize| 0.4 * PI * k as f64;
            let way = |k: usize| Gateway {
                read_error: error,
                ..gateway(1.5 * at(k).cos(), 1.5 * at(k).sin(), at(k) + off(k))
            };
            (0..5).map(way).collect()
        };
        assert_eq!(pairs(&fork(0.0)).len(), 4, "read to the last digit it would be a pair");
        assert_eq!(pairs(&fork(0.1 / SQRT_2)).len(), 5, "in cells of 10 cm it is none");
        // What goes on straight is sure enough.
        let through = [gateway(2.0, 0.0, 0.0), gateway(0.0, -2.0, -PI / 2.0), gateway(-2.0, 0.0, PI)];
        let through = through.map(|one| Gateway { read_error: 0.1 / SQRT_2, ..one });
        assert_eq!(pairs(&through), [(0, Some(2)), (1, None)]);
    }

    /// A way that is read two widths aside scores nothing, and yet may go on as another where centres are off.
    #[test]
    fn what_scores_nothing_may_be_ambiguous_too() {
        let across = |aside: f64| {
            let doors = [gateway(5.0, 0.0, 0.0), gateway(-5.0, 0.0, PI), gateway(-5.0, aside, PI)];
            doors.map(|one| Gateway { read_error: 0.25, ..one })
        };
        let found = |aside: f64| pair(&across(aside), &FragmentParameters::default())[0];
        // Two widths aside is where the score comes to nothing.
        let [nearly, none] = [3.999, 4.001].map(found);
        assert_eq!([nearly.partner, none.partner], [None; 2]);
        assert!((nearly.margin - none.margin).abs() < 0.01, "{nearly:?} {none:?}");
    }

    /// Whether two gateways pair, word for word, where what decides is stricter by a fraction, or laxer.
    fn pairs_if_stricter(gateways: &[Gateway], [a, b]: [usize; 2], by: f64) -> bool {
        let FragmentParameters { least_score, ambiguity } = FragmentParameters::default();
        let score = |a: usize, b: usize| symmetric_score(&gateways[a], &gateways[b]);
        let bounds = |a: usize, b: usize| score_bounds(&gateways[a], &gateways[b]);
        let leaves_behind = |end: usize, other: usize| {
            score(end, other) < (1.0 - by) * ambiguity * score(a, b)
                && bounds(end, other)[1] < (1.0 - by) * bounds(a, b)[0]
        };
        let rivals = (0..gateways.len()).filter(|&other| other != a && other != b);
        let mut rivals = rivals
            .flat_map(|other| [(a, other), (b, other)])
            .filter(|&(end, other)| bounds(end, other)[1] > 0.0);
        score(a, b) > (1.0 + by) * least_score && rivals.all(|(end, other)| leaves_behind(end, other))
    }

    fn partner(gateways: &[Gateway], a: usize, by: f64) -> Option<usize> {
        (0..gateways.len()).find(|&b| b != a && pairs_if_stricter(gateways, [a, b], by))
    }

    /// What decides is made stricter where gateways pair and laxer where they do not, a thousandth at a time, until a
    /// gateway is decided otherwise.
    #[test]
    fn margins_are_what_must_change_for_another_decision() {
        let [pairs, ends, taken] = [Cell::new(0), Cell::new(0), Cell::new(0)];
        let count = |cell: &Cell<usize>, so: bool| cell.set(cell.get() + usize::from(so));
        let way = (0.0..2.0 * PI, 1.0..3.0, -0.4..0.4, 0.0..0.06);
        let way = way.prop_map(|(at, far, off, error): (f64, f64, f64, f64)| Gateway {
            read_error: error,
            ..gateway(far * at.cos(), far * at.sin(), at + off)
        });
        let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let outcome = runner.run(&prop::collection::vec(way, 1..6), |gateways| {
            let found = pair(&gateways, &FragmentParameters::default());
            let mut met: Vec<usize> =
                found.iter().flat_map(|one| [Some(one.gateway), one.partner]).flatten().collect();
            met.sort_unstable();
            prop_assert_eq!(met, (0..gateways.len()).collect::<Vec<_>>());
            for Fragment { gateway, partner: with, margin } in found {
                prop_assert_eq!(with, partner(&gateways, gateway, 0.0));
                let step = if with.is_some() { 0.001 } else { -0.001 };
                let otherwise = |k: &i32| partner(&gateways, gateway, f64::from(*k) * step) != with;
                let slow = (0..1000).find(otherwise).map_or(1.0, |k| f64::from(k) / 1000.0);
                prop_assert!(
                    (margin - slow).abs() < 0.0011,
                    "{} of {:?}: {} {}",
                    gateway,
                    with,
                    margin,
                    slow
                );
                count(&pairs, with.is_some());
                count(&ends, with.is_none());
                // The one that it faces best goes on with another one.
                let faced = (0..gateways.len()).filter(|&b| b != gateway);
                let score = |b: usize| symmetric_score(&gateways[gateway], &gateways[b]);
                let best = faced.max_by(|&b, &c| score(b).total_cmp(&score(c))).filter(|&b| score(b) > 0.5);
                let goes_on = best.is_some_and(|b| partner(&gateways, b, 0.0).is_some());
                count(&taken, with.is_none() && goes_on && margin > 0.05);
            }
            Ok(())
        });
        outcome.unwrap();
        let all = [pairs.get(), ends.get(), taken.get()];
        assert!(all[0] > 50 && all[1] > 100 && all[2] > 5, "{all:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2048, failure_persistence: None, ..ProptestConfig::default() })]

        /// Ends and centres are moved to either side by as much as they may be read wrong. The least score is that of a corner of these
        /// errors; the greatest may lie between corners, and be a little more than any of theirs.
        #[test]
        fn what_is_read_wrong_scores_within_its_bounds(
            (offset, turned) in (-2.0..2.0, -0.5..0.5),
            sides in prop::collection::vec(prop::sample::select(vec![-0.1 / SQRT_2, 0.0, 0.1 / SQRT_2]), 6),
        ) {
            let read = |one: Gateway| Gateway { read_error: 0.1 / SQRT_2, ..one };
            let [a, b] = [gateway(2.0, 0.0, 0.0), gateway(-2.0, offset, PI + turned)].map(read);
            // What turns its line moves an end along the way, what shifts it moves its centre across.
            let [along, across] = [Vector::new(1.0, 0.0), Vector::new(0.0, 1.0)];
            let moved = |one: &Gateway, k: usize| {
                let ends = [one.ends[0] + along * sides[k], one.ends[1] + along * sides[k + 1]];
                let line = ends[0] - ends[1];
                Gateway { center: one.center + across * sides[k + 2], ends, bearing: (-line.x).atan2(line.y), ..one.clone() }
            };
            let score = symmetric_score(&moved(&a, 0), &moved(&b, 3));
            let [least, most] = score_bounds(&a, &b);
            prop_assert!(least - 0.015 <= score && score <= most + 0.05, "{} not in {} to {}", score, least, most);
        }
    }

    #[test]
    fn a_near_tie_terminates_whatever_the_order() {
        let fork = [gateway(2.0, 0.0, 0.0), gateway(-2.0, 1.0, PI), gateway(-2.0, -1.0, PI)];
        assert_eq!(pairs(&fork), [(0, None), (1, None), (2, None)]);
        let [a, b, c] = fork;
        assert_eq!(pairs(&[b, c, a]), [(0, None), (1, None), (2, None)]);
    }
}
