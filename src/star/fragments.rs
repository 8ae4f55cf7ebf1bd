//! Which gateways share a path fragment: whether a path continues through the place (seed, section 4.2).

use crate::gateway::Gateway;
use crate::geometry::Vector;

/// When two gateways are ends of one path fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentParameters {
    /// The least score of a pair; 1 is straight across and 0.5 is 60 degrees off or one width beside. Default 0.5.
    pub least_score: f64,
    /// A pair is ambiguous if the runner-up of either gateway scores more than this share of it, or may do better than
    /// it where bearings are off by what cells can make of them. Default 0.8.
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
    /// How far the pairing is from being decided otherwise, as a fraction of the least score.
    pub(super) margin: f64,
}

/// The fragments of a place, in the order of their first gateways. Gateways pair if each is the other's best, good
/// enough and without a close runner-up; all others terminate.
pub(super) fn pair(gateways: &[Gateway], parameters: &FragmentParameters) -> Vec<Fragment> {
    let ranked: Vec<Ranking> = (0..gateways.len()).map(|a| rank(a, gateways, parameters)).collect();
    let partner = |a: usize| {
        let Ranking { best, score, contest } = ranked[a];
        best.filter(|_| score >= parameters.least_score && contest < 1.0)
    };
    let mut fragments = Vec::new();
    for a in 0..gateways.len() {
        let Ranking { score, contest, .. } = ranked[a];
        match partner(a).filter(|&b| partner(b) == Some(a)) {
            Some(b) if b < a => {}
            Some(b) => {
                let contest = contest.max(ranked[b].contest);
                let margin = (score / parameters.least_score - 1.0).min(1.0 - contest);
                fragments.push(Fragment { gateway: a, partner: Some(b), margin });
            }
            None => {
                // Too low a score or a tie each suffices.
                let (low, tied) = (1.0 - score / parameters.least_score, contest - 1.0);
                let margin = low.max(tied.min(1.0)).max(0.0);
                fragments.push(Fragment { gateway: a, partner: None, margin });
            }
        }
    }
    fragments
}

/// The best partner of a gateway, its score, and how near the runner-up comes to making that ambiguous: 1 is just so.
#[derive(Clone, Copy)]
struct Ranking {
    best: Option<usize>,
    score: f64,
    contest: f64,
}

fn rank(a: usize, gateways: &[Gateway], parameters: &FragmentParameters) -> Ranking {
    let score = |b: usize| symmetric_score(&gateways[a], &gateways[b]);
    let mut others: Vec<usize> = (0..gateways.len()).filter(|&b| b != a && score(b) > 0.0).collect();
    // Of equals the first stays first.
    others.sort_by(|&b, &c| score(c).total_cmp(&score(b)));
    let Some((&best, others)) = others.split_first() else {
        return Ranking { best: None, score: 0.0, contest: 0.0 };
    };
    let [worst, _] = score_bounds(&gateways[a], &gateways[best]);
    let contest = others.iter().map(|&other| {
        let [_, likeliest] = score_bounds(&gateways[a], &gateways[other]);
        let near = score(other) / (parameters.ambiguity * score(best));
        near.max(likeliest / worst.max(f64::MIN_POSITIVE))
    });
    Ranking { best: Some(best), score: score(best), contest: contest.fold(0.0, f64::max) }
}

/// The least and the greatest score of a pair with both bearings off by their errors to either side.
fn score_bounds(a: &Gateway, b: &Gateway) -> [f64; 2] {
    let turned = |gateway: &Gateway, by: f64| Gateway { bearing: gateway.bearing + by, ..gateway.clone() };
    let either = |gateway: &Gateway| [-1.0, 1.0].map(|side| turned(gateway, side * gateway.bearing_error));
    let [first, second] = [either(a), either(b)];
    let scores = first.iter().flat_map(|a| second.iter().map(move |b| symmetric_score(a, b)));
    let exact = symmetric_score(a, b);
    scores.fold([exact; 2], |[least, most], score| [least.min(score), most.max(score)])
}

fn symmetric_score(a: &Gateway, b: &Gateway) -> f64 {
    across(a, b).min(across(b, a))
}

/// How well the straight projection inward from `a` meets `b`: opposite directions, and little offset in widths.
fn across(a: &Gateway, b: &Gateway) -> f64 {
    let (inward, line_normal): (Vector, Vector) = (-a.outward(), b.outward());
    let facing = inward.dot(&line_normal);
    let distance = (b.center - a.center).dot(&line_normal);
    if facing <= 0.0 || distance < 0.0 {
        return 0.0;
    }
    let met = a.center + inward * (distance / facing);
    let offset = (met - b.center).norm() / b.width;
    facing * (1.0 - offset / 2.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, direction};
    use std::f64::consts::PI;

    fn gateway(x: f64, y: f64, bearing: f64) -> Gateway {
        let center = Point::new(x, y);
        let left = direction(bearing + PI / 2.0);
        Gateway {
            center,
            ends: [center + left, center - left],
            bearing,
            bearing_error: 0.0,
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
                bearing_error: error,
                ..gateway(1.5 * at(k).cos(), 1.5 * at(k).sin(), at(k) + off(k))
            };
            (0..5).map(way).collect()
        };
        assert_eq!(pairs(&fork(0.0)).len(), 4, "read to the last digit it would be a pair");
        assert_eq!(pairs(&fork(0.1 / 2.0)).len(), 5, "in cells of 10 cm it is none");
        // What goes on straight is sure enough.
        let through = [gateway(2.0, 0.0, 0.0), gateway(0.0, -2.0, -PI / 2.0), gateway(-2.0, 0.0, PI)];
        let through = through.map(|one| Gateway { bearing_error: 0.1 / 2.0, ..one });
        assert_eq!(pairs(&through), [(0, Some(2)), (1, None)]);
    }

    #[test]
    fn a_near_tie_terminates_whatever_the_order() {
        let fork = [gateway(2.0, 0.0, 0.0), gateway(-2.0, 1.0, PI), gateway(-2.0, -1.0, PI)];
        assert_eq!(pairs(&fork), [(0, None), (1, None), (2, None)]);
        let [a, b, c] = fork;
        assert_eq!(pairs(&[b, c, a]), [(0, None), (1, None), (2, None)]);
    }
}
