//! Grids of corridors and random walks that cover them.

use crate::geometry::Point;
use crate::star::{ControlLaw, SlotIndex};
use crate::worlds::random::Random;
use crate::worlds::world::{Exit, Place, PlaceSlot, SlotRef, Walk};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

/// The places of a grid of corridors that cross at right angles, so many metres apart; both numbers are at least two.
/// Every place has four slots: north, east, south, west; on the rim a corridor's end is a dead end.
pub fn corridor_grid(rows: usize, columns: usize, spacing: f64) -> Vec<Place> {
    let place = |index: usize| {
        let (row, column) = (index / columns, index % columns);
        // North, east, south, west, as the far place if there is one.
        let far = [
            (row + 1 < rows).then_some(index + columns),
            (column + 1 < columns).then_some(index + 1),
            row.checked_sub(1).map(|_| index - columns),
            column.checked_sub(1).map(|_| index - 1),
        ];
        let slot = |(way, name): (usize, &str)| PlaceSlot {
            name: name.into(),
            opposite: SlotIndex((way as u8 + 2) % 4),
            exit: far[way].map_or(Exit::Closed, |place| {
                Exit::To(SlotRef { place, slot: SlotIndex((way as u8 + 2) % 4) })
            }),
            control: if far[way].is_some() { ControlLaw::Midline } else { ControlLaw::DeadEnd },
            bearing: FRAC_PI_2 * (1.0 - way as f64),
            reach: 1.0,
        };
        Place {
            name: format!("{row}-{column}"),
            at: Point::new(column as f64 * spacing, row as f64 * spacing),
            slots: ["north", "east", "south", "west"].into_iter().enumerate().map(slot).collect(),
        }
    };
    (0..rows * columns).map(place).collect()
}

/// A random walk through connected places that travels every path segment: at each place on by a way not gone
/// before, if there is one, else the shortest way to a place that has one.
pub fn covering_walk(places: &[Place], seed: u64) -> Walk {
    let mut random = Random::new(seed);
    let start = random.below(places.len());
    let facing = random.below(places[start].slots.len());
    let mut walk = Walk { start: SlotRef { place: start, slot: SlotIndex(facing as u8) }, leave: Vec::new() };
    let mut gone: BTreeSet<(usize, usize)> = BTreeSet::new();
    let mut here = start;
    while let Some(slot) = next_way(places, &gone, here, &mut random) {
        walk.leave.push(SlotIndex(slot as u8));
        let Some(far) = far_end(places, here, slot) else { break };
        gone.insert((here, slot));
        gone.insert((far.place, far.slot.0 as usize));
        here = far.place;
    }
    walk
}

/// The first slot of a shortest way over ways gone before to one that was not; of several one at random.
fn next_way(
    places: &[Place],
    gone: &BTreeSet<(usize, usize)>,
    here: usize,
    random: &mut Random,
) -> Option<usize> {
    let ways =
        |place: usize| (0..places[place].slots.len()).filter(move |&s| far_end(places, place, s).is_some());
    // Breadth first: each place with the slot by which its way leaves from here.
    let mut reached = vec![(here, None)];
    let mut met = BTreeSet::from([here]);
    while !reached.is_empty() {
        let fresh = |&(place, first): &(usize, Option<usize>)| {
            let new: Vec<usize> = ways(place).filter(|&slot| !gone.contains(&(place, slot))).collect();
            new.into_iter().map(move |slot| first.unwrap_or(slot))
        };
        let found: Vec<usize> = reached.iter().flat_map(fresh).collect();
        if !found.is_empty() {
            return Some(found[random.below(found.len())]);
        }
        let mut next = Vec::new();
        for (place, first) in reached {
            for slot in ways(place) {
                if let Some(far) = far_end(places, place, slot).filter(|far| met.insert(far.place)) {
                    next.push((far.place, first.or(Some(slot))));
                }
            }
        }
        reached = next;
    }
    None
}

fn far_end(places: &[Place], place: usize, slot: usize) -> Option<SlotRef> {
    match places[place].slots[slot].exit {
        Exit::To(far) => Some(far),
        Exit::Open | Exit::Closed => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covering_walk_travels_every_segment() {
        let places = corridor_grid(4, 4, 10.0);
        for seed in 0..20 {
            let walk = covering_walk(&places, seed);
            let visits = walk.visits(&places);
            let mut gone = BTreeSet::new();
            for visit in &visits {
                if let Some(slot) = visit.departure {
                    let far = far_end(&places, visit.place, slot.0 as usize).unwrap();
                    gone.insert((visit.place.min(far.place), visit.place.max(far.place)));
                }
            }
            assert_eq!(gone.len(), 24);
            assert!((24..=48).contains(&walk.leave.len()), "{}", walk.leave.len());
            assert_eq!(walk, covering_walk(&places, seed));
        }
    }
}
