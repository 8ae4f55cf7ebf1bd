//! Corridors that do not lead straight from place to place.

use crate::geometry::{Point, Vector};
use crate::star::SlotIndex;
use crate::worlds::random::Random;
use crate::worlds::world::{Exit, Place};
use std::collections::BTreeMap;

/// By way of which corners the corridors between some places lead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detours {
    /// Seen from either end, world frame.
    corners: BTreeMap<(usize, SlotIndex), Vec<Point>>,
}

/// In lengths of the straight corridor: where a detour leaves it and comes back, from either end, and how far aside it leads at
/// most; within the building less than it stays away from the ends, so that it meets no other, on the rim farther.
const LEAVES: [f64; 2] = [0.35, 0.45];
const WITHIN: f64 = 0.34;
const RIM: f64 = 2.0;

impl Detours {
    /// Detours of the corridors of a grid: at right angles aside, on, and back, so that no two of them meet. On the rim half of
    /// them lead outwards, out and back up to five times as long as the straight line.
    pub fn of_grid(places: &[Place], seed: u64) -> Detours {
        let mut random = Random::new(seed);
        let mut corners = BTreeMap::new();
        for (from, place) in places.iter().enumerate() {
            for (slot, there) in (0..).map(SlotIndex).zip(&place.slots) {
                let Exit::To(to) = there.exit else { continue };
                if from < to.place {
                    let way = detour(places, [from, to.place], &mut random);
                    corners.insert((to.place, to.slot), way.iter().rev().copied().collect());
                    corners.insert((from, slot), way.into());
                }
            }
        }
        Detours { corners }
    }

    /// The corners on the way that leaves a place by a slot, in the order in which they are come to.
    pub fn corners(&self, place: usize, slot: SlotIndex) -> &[Point] {
        self.corners.get(&(place, slot)).map_or(&[], Vec::as_slice)
    }
}

fn detour(places: &[Place], ends: [usize; 2], random: &mut Random) -> [Point; 4] {
    let [from, to] = ends.map(|end| places[end].at);
    let along = to - from;
    let left = Vector::new(-along.y, along.x);
    // On the rim all places lie on one side.
    let beyond = |side: f64| !places.iter().any(|place| side * left.dot(&(place.at - from)) > 1e-6);
    let outward = [1.0, -1.0].into_iter().find(|&side| beyond(side)).filter(|_| random.unit() < 0.5);
    let aside = match outward {
        Some(outward) => outward * random.unit() * RIM,
        None => random.within(WITHIN),
    };
    let mut leaves = || along * (LEAVES[0] + random.unit() * (LEAVES[1] - LEAVES[0]));
    let (leaves, back) = (from + leaves(), to - leaves());
    [leaves, leaves + left * aside, back + left * aside, back]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::corridor_grid;

    /// Whether two straight pieces meet.
    fn meet(one: [Point; 2], other: [Point; 2]) -> bool {
        let side = |[a, b]: [Point; 2], c: Point| (b - a).perp(&(c - a));
        let across = |one: [Point; 2], other: [Point; 2]| side(one, other[0]) * side(one, other[1]) <= 0.0;
        // On one line both are across each other wherever they lie.
        let beside = |axis: usize| {
            let ends = [one, other].map(|piece| piece.map(|point| point[axis]));
            let [least, most] = [f64::min, f64::max].map(|of| ends.map(|[a, b]| of(a, b)));
            most[0] < least[1] || most[1] < least[0]
        };
        across(one, other) && across(other, one) && !beside(0) && !beside(1)
    }

    #[test]
    fn detours_meet_at_places_alone() {
        let places = corridor_grid(4, 4, 10.0);
        let mut longest = 0.0_f64;
        for seed in 0..20 {
            let detours = Detours::of_grid(&places, seed);
            let mut ways = Vec::new();
            for (from, place) in places.iter().enumerate() {
                for (slot, there) in (0..).map(SlotIndex).zip(&place.slots) {
                    let Exit::To(to) = there.exit else { continue };
                    let corners = detours.corners(from, slot).to_vec();
                    let back: Vec<Point> = detours.corners(to.place, to.slot).iter().rev().copied().collect();
                    assert_eq!(corners, back);
                    let way: Vec<Point> = [vec![place.at], corners, vec![places[to.place].at]].concat();
                    longest = longest.max(way.windows(2).map(|piece| (piece[1] - piece[0]).norm()).sum());
                    if from < to.place {
                        ways.push(([from, to.place], way));
                    }
                }
            }
            assert_eq!(ways.len(), 24);
            let pieces = |way: &[Point]| way.windows(2).map(|piece| [piece[0], piece[1]]).collect::<Vec<_>>();
            for (k, (ends, one)) in ways.iter().enumerate() {
                for (others, other) in &ways[..k] {
                    let meets = |one: &[Point; 2]| pieces(other).iter().any(|other| meet(*one, *other));
                    let met = pieces(one).iter().any(meets);
                    assert_eq!(met, ends.iter().any(|end| others.contains(end)), "{ends:?} {others:?}");
                }
            }
        }
        assert!(longest > 45.0, "{longest}");
    }
}
