//! Walks through a world as traces of bare stars, with the true map beside them.

use crate::star::{SlotIndex, StarError};
use crate::trace::event::{Event, EventKind, Observation, Percept, Turn, TurnTarget};
use crate::worlds::random::Random;
use crate::worlds::world::World;
use std::collections::BTreeMap;

/// A trace of bare stars and the assignment of its observations that is true.
#[derive(Clone, Debug, PartialEq)]
pub struct StarTrace {
    /// The events.
    pub events: Vec<Event>,
    /// For each observation its place, numbered by first visit, and the rotation that lays the star seen onto
    /// that of the first visit, as in [`crate::star::LargeScaleStar::matches`].
    pub truth: Vec<(usize, u8)>,
}

/// The walk of a world as the stars seen on it. Where in the circle a star's listing starts is drawn from the
/// seed; without one every listing starts at the arrival slot.
pub fn star_trace(world: &World, seed: Option<u64>) -> Result<StarTrace, StarError> {
    let mut random = seed.map(Random::new);
    let mut events = Vec::new();
    let mut first_listing: BTreeMap<usize, usize> = BTreeMap::new();
    let mut truth = Vec::new();
    for (visit, number) in world.visits().into_iter().zip(world.visited_places()) {
        let place = &world.places[visit.place];
        let n = place.slots.len();
        let first = random.as_mut().map_or(visit.arrival.0 as usize, |random| random.below(n));
        let listed = |slot: SlotIndex| SlotIndex(((slot.0 as usize + n - first) % n) as u8);
        let star = place.star(SlotIndex(first as u8))?;
        let percept = Percept::Star { star, dstate: listed(visit.arrival), robot_pose: None };
        push(&mut events, EventKind::Observation(Box::new(Observation { percept })));
        let origin = *first_listing.entry(number).or_insert(first);
        truth.push((number, ((first + n - origin) % n) as u8));
        let Some(departure) = visit.departure else { continue };
        if departure != visit.arrival {
            let target = TurnTarget::Slot(listed(departure));
            push(&mut events, EventKind::Turn(Turn { target, angle: None }));
        }
        push(&mut events, EventKind::Travel(Box::default()));
    }
    Ok(StarTrace { events, truth })
}

/// Appends an event with the next number.
pub(super) fn push(events: &mut Vec<Event>, kind: EventKind) {
    events.push(Event { seq: events.len() as u64, stamp: None, kind });
}
