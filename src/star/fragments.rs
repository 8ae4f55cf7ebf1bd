//! Which gateways share a path fragment: whether a path continues through the place (seed, section 4.2).

use crate::gateway::Gateway;
use crate::geometry::Vector;

/// When two gateways are ends of one path fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentParameters {
    /// The least score of a pair; 1 is straight across and 0.5 is 60 degrees off or one width beside. Default 0.5.
    pub least_score: f64,
    /// A pair is ambiguous if the runner-up of either gateway scores more than this share of it. Default 0.8: on a
    /// grid of 10 cm, bearings are good to two degrees, which moves the scores of a fork apart by 0.1.
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
    let score = |a: usize, b: usize| symmetric_score(&gateways[a], &gateways[b]);
    let ranked: Vec<Ranking> = (0..gateways.len()).map(|a| rank(a, gateways.len(), score)).collect();
    let partner = |a: usize| {
        let Ranking { best, score, second } = ranked[a];
        let clear = score >= parameters.least_score && second < parameters.ambiguity * score;
        best.filter(|_| clear)
    };
    let mut fragments = Vec::new();
    for a in 0..gateways.len() {
        let Ranking { score, second, .. } = ranked[a];
        match partner(a).filter(|&b| partner(b) == Some(a)) {
            Some(b) if b < a => {}
            Some(b) => {
                let runner_up = second.max(ranked[b].second) / (parameters.ambiguity * score);
                let margin = (score / parameters.least_score - 1.0).min(1.0 - runner_up);
                fragments.push(Fragment { gateway: a, partner: Some(b), margin });
            }
            None => {
                // Too low a score or a tie each suffices.
                let low = 1.0 - score / parameters.least_score;
                let tied = second / (parameters.ambiguity * score.max(f64::MIN_POSITIVE)) - 1.0;
                let margin = low.max(tied).max(0.0);
                fragments.push(Fragment { gateway: a, partner: None, margin });
            }
        }
    }
    fragments
}

/// The best partner of a gateway, its score and that of the runner-up.
struct Ranking {
    best: Option<usize>,
    score: f64,
    second: f64,
}

fn rank(a: usize, count: usize, score: impl Fn(usize, usize) -> f64) -> Ranking {
    let mut ranking = Ranking { best: None, score: 0.0, second: 0.0 };
    for b in (0..count).filter(|&b| b != a) {
        let found = score(a, b);
        if found > ranking.score {
            ranking = Ranking { best: Some(b), score: found, second: ranking.score };
        } else {
            ranking.second = ranking.second.max(found);
        }
    }
    ranking
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

    #[test]
    fn a_near_tie_terminates_whatever_the_order() {
        let fork = [gateway(2.0, 0.0, 0.0), gateway(-2.0, 1.0, PI), gateway(-2.0, -1.0, PI)];
        assert_eq!(pairs(&fork), [(0, None), (1, None), (2, None)]);
        let [a, b, c] = fork;
        assert_eq!(pairs(&[b, c, a]), [(0, None), (1, None), (2, None)]);
    }
}
