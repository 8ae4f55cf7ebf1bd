//! Walks through a world as traces of bare stars, with the true map beside them.

use crate::geometry::{Point, Pose, wrap_angle};
use crate::star::{Slot, SlotIndex, SmallScaleStar, StarError};
use crate::trace::event::{Event, EventKind, Observation, Percept, Turn, TurnTarget};
use crate::worlds::detours::Detours;
use crate::worlds::drift::{Drift, Odometer};
use crate::worlds::random::Random;
use crate::worlds::world::{Place, Visit, Walk, World, numbered};
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
    let visits = world.visits();
    let truth = truth(&world.places, &visits, |visit| match &mut random {
        Some(random) => random.below(world.places[visit.place].slots.len()),
        None => visit.arrival.0 as usize,
    });
    let mut events = Vec::new();
    for (visit, seen) in visits.iter().zip(&truth) {
        let place = &world.places[visit.place];
        let star = place.star(SlotIndex(seen.first as u8))?;
        let percept = Percept::Star { star, dstate: seen.listed(visit.arrival), robot_pose: None };
        push(&mut events, EventKind::Observation(Box::new(Observation { percept })));
        let Some(departure) = visit.departure else { continue };
        if departure != visit.arrival {
            let target = TurnTarget::Slot(seen.listed(departure));
            push(&mut events, EventKind::Turn(Turn { target, angle: None }));
        }
        push(&mut events, EventKind::Travel(Box::default()));
    }
    Ok(StarTrace { events, truth: truth.iter().map(|seen| seen.assigned).collect() })
}

/// How far from the point of a place the robot stands on arrival, along each axis at most, metres: as far as a
/// corridor two metres wide and its own size let it.
const ASTRAY: f64 = 0.4;
/// How far its heading is from that of the path it came by, radians at most.
const ASKEW: f64 = 0.1;

/// A walk through places as the stars seen on it, with the bearings of their slots, and odometry that drifts, along
/// corridors that lead straight from place to place. Each frame is the robot's pose on arrival, somewhere in the place and
/// about in the direction of its path.
pub fn drifting_trace(
    places: &[Place],
    walk: &Walk,
    drift: Drift,
    seed: u64,
) -> Result<StarTrace, StarError> {
    drifting_trace_by(places, walk, drift, seed, &Detours::default())
}

/// As [`drifting_trace`], where corridors may lead by way of corners.
pub fn drifting_trace_by(
    places: &[Place],
    walk: &Walk,
    drift: Drift,
    seed: u64,
    detours: &Detours,
) -> Result<StarTrace, StarError> {
    let mut random = Random::new(seed);
    let mut odometer = Odometer::new(drift, random.bits());
    let visits = walk.visits(places);
    let truth = truth(places, &visits, |visit| random.below(places[visit.place].slots.len()));
    let arrivals: Vec<Pose> =
        visits.iter().map(|visit| somewhere(&places[visit.place], visit.arrival, &mut random)).collect();
    let mut events = Vec::new();
    for (step, (visit, seen)) in visits.iter().zip(&truth).enumerate() {
        let place = &places[visit.place];
        let arrival = &arrivals[step];
        let bare = place.star(SlotIndex(seen.first as u8))?;
        let slot = |(at, slot): (usize, &Slot)| {
            let bearing = place.slots[(at + seen.first) % place.slots.len()].bearing - arrival.theta;
            Slot { bearing: Some(odometer.bearing(bearing)), ..slot.clone() }
        };
        let star = SmallScaleStar::new(bare.slots().iter().enumerate().map(slot).collect())?;
        let percept = Percept::Star { star, dstate: seen.listed(visit.arrival), robot_pose: None };
        push(&mut events, EventKind::Observation(Box::new(Observation { percept })));
        let (Some(departure), Some(next)) = (visit.departure, arrivals.get(step + 1)) else { continue };
        let turned = wrap_angle(place.slots[departure.0 as usize].bearing - arrival.theta);
        if departure != visit.arrival {
            let target = TurnTarget::Slot(seen.listed(departure));
            push(&mut events, EventKind::Turn(Turn { target, angle: None }));
        }
        let start = Pose::new(arrival.x, arrival.y, arrival.theta + turned);
        let corners = detours.corners(visit.place, departure).iter();
        let corners: Vec<Point> = corners.map(|corner| start.inverse().transform_point(corner)).collect();
        let travel = odometer.travel(turned, &corners, &start.inverse().compose(next));
        push(&mut events, EventKind::Travel(Box::new(travel)));
    }
    Ok(StarTrace { events, truth: truth.iter().map(|seen| seen.assigned).collect() })
}

fn somewhere(place: &Place, arrival: SlotIndex, random: &mut Random) -> Pose {
    let (x, y) = (random.within(ASTRAY), random.within(ASTRAY));
    // The outward bearing of the slot faced is the heading of the robot that came in along it.
    Pose::new(place.at.x + x, place.at.y + y, place.slots[arrival.0 as usize].bearing + random.within(ASKEW))
}

/// How a star is listed on a visit, and what the visit is truly.
struct Seen {
    /// The slot of the place that the listing starts with.
    first: usize,
    size: usize,
    assigned: (usize, u8),
}

impl Seen {
    /// A slot of the place in the listing.
    fn listed(&self, slot: SlotIndex) -> SlotIndex {
        SlotIndex(((slot.0 as usize + self.size - self.first) % self.size) as u8)
    }
}

/// What is true of each visit, where `first` chooses the slot that its listing starts with.
fn truth(places: &[Place], visits: &[Visit], mut first: impl FnMut(&Visit) -> usize) -> Vec<Seen> {
    let mut first_listing: BTreeMap<usize, usize> = BTreeMap::new();
    let seen = |(visit, number): (&Visit, usize)| {
        let (first, size) = (first(visit), places[visit.place].slots.len());
        let origin = *first_listing.entry(number).or_insert(first);
        Seen { first, size, assigned: (number, ((first + size - origin) % size) as u8) }
    };
    visits.iter().zip(numbered(visits)).map(seen).collect()
}

/// Appends an event with the next number.
pub(super) fn push(events: &mut Vec<Event>, kind: EventKind) {
    events.push(Event { seq: events.len() as u64, stamp: None, kind });
}
