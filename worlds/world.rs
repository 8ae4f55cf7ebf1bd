//! A world: what is really there, a walk through it, and what must come out.

use crate::geometry::Point;
use crate::star::{ControlLaw, Direction, FragmentId, GatewayId, Slot, SlotIndex, SmallScaleStar, StarError};
use crate::worlds::drawing::Drawing;
use std::collections::BTreeMap;

/// A true world with a walk through it. Only the loader makes one, so places and slots referred to exist.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct World {
    /// The file it came from, without its ending.
    pub name: String,
    /// A few words.
    pub title: String,
    /// What is special about it.
    pub story: String,
    /// What is open and what is solid, world frame.
    pub drawing: Drawing,
    /// Its places, in the order of the file.
    pub places: Vec<Place>,
    /// The walk.
    pub walk: Walk,
    /// What abduction must find in profile `paper`.
    pub paper: Expectation,
    /// What abduction must find in profile `default`, without measurements.
    pub default: Expectation,
    /// What it must find in profile `default` with the measurements of a rendered trace, if that differs.
    pub measured: Option<Expectation>,
}

/// A place of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name in the file.
    pub name: String,
    /// Where it is, world frame.
    pub at: Point,
    /// Its directed path fragments, clockwise.
    pub slots: Vec<PlaceSlot>,
}

/// A directed path fragment of a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceSlot {
    /// Its name in the file.
    pub name: String,
    /// The slot of the other direction of the same fragment.
    pub opposite: SlotIndex,
    /// Where it leads.
    pub exit: Exit,
    /// How to travel away.
    pub control: ControlLaw,
    /// Outward direction in the world frame, radians.
    pub bearing: f64,
    /// How far the gateway is from the place's point, metres.
    pub reach: f64,
}

/// Where a slot leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Nowhere: the fragment ends at the place.
    Closed,
    /// Through a gateway out of the world.
    Open,
    /// Through a gateway, along a path segment, and through the gateway of this slot.
    To(SlotRef),
}

/// A slot of a place of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotRef {
    /// Index into [`World::places`].
    pub place: usize,
    /// The slot of that place.
    pub slot: SlotIndex,
}

/// A walk: where the robot starts, and how it leaves every place but the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The first place and the slot faced there.
    pub start: SlotRef,
    /// The slots by which it leaves, place by place.
    pub leave: Vec<SlotIndex>,
}

/// One visit of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Index into [`World::places`].
    pub place: usize,
    /// The directed fragment the robot came in on; at the first visit the slot it faces.
    pub arrival: SlotIndex,
    /// The slot by which it left, unless the walk ends here.
    pub departure: Option<SlotIndex>,
}

/// What abduction must find in one profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expectation {
    /// Candidates after each observation.
    pub candidates: Vec<usize>,
    /// Maps created on the way, the first included; a travel through a known gateway creates none.
    pub created: usize,
    /// The minimum.
    pub minimal: Minimal,
    /// What becomes of the true map.
    pub truth: Truth,
}

/// The least (paths, places), and how many candidates have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Minimal {
    /// Paths, travelled or not.
    pub paths: usize,
    /// Places.
    pub places: usize,
    /// Candidates that are tied.
    pub ties: usize,
}

/// What becomes of the true map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Truth {
    /// It is among the minimal candidates.
    Minimal,
    /// It is a candidate, and simpler maps remain.
    Candidate,
    /// The theory does not allow this world.
    Refuted {
        /// Id of the axiom.
        axiom: String,
        /// The observation at which the true map is refuted, counted from 0.
        observation: usize,
    },
}

impl Walk {
    /// The visits of the walk through these places, in order.
    pub fn visits(&self, places: &[Place]) -> Vec<Visit> {
        let mut at = self.start;
        let mut visits = Vec::with_capacity(self.leave.len() + 1);
        for &departure in &self.leave {
            visits.push(Visit { place: at.place, arrival: at.slot, departure: Some(departure) });
            let Exit::To(far) = places[at.place].slots[departure.0 as usize].exit else {
                return visits;
            };
            // Inside, the robot goes on in the direction opposite to the gateway's outward one.
            let slot = places[far.place].slots[far.slot.0 as usize].opposite;
            at = SlotRef { place: far.place, slot };
        }
        visits.push(Visit { place: at.place, arrival: at.slot, departure: None });
        visits
    }
}

impl World {
    /// The visits of the walk, in order.
    pub fn visits(&self) -> Vec<Visit> {
        self.walk.visits(&self.places)
    }

    /// The place of every visit, numbered by first visit.
    pub fn visited_places(&self) -> Vec<usize> {
        numbered(&self.visits())
    }
}

/// The place of every visit, numbered by first visit.
pub(super) fn numbered(visits: &[Visit]) -> Vec<usize> {
    let mut numbers = BTreeMap::new();
    let mut number = |visit: &Visit| {
        let next = numbers.len();
        *numbers.entry(visit.place).or_insert(next)
    };
    visits.iter().map(&mut number).collect()
}

impl Place {
    /// The star of the place as a listing that starts at a slot: fragments and gateways are numbered from 1 in
    /// the order in which the listing meets them, and nothing metric is given.
    pub fn star(&self, first: SlotIndex) -> Result<SmallScaleStar, StarError> {
        let n = self.slots.len();
        let position = |slot: usize| (slot + n - first.0 as usize) % n;
        let gateway = |slot: usize| {
            (self.slots[slot].exit != Exit::Closed).then(|| GatewayId(position(slot) as u32 + 1))
        };
        let mut fragments: BTreeMap<usize, FragmentId> = BTreeMap::new();
        let listed = (0..n).map(|step| {
            let at = (step + first.0 as usize) % n;
            let opposite = self.slots[at].opposite.0 as usize;
            let met = fragments.contains_key(&at.min(opposite));
            let next = FragmentId(fragments.len() as u32 + 1);
            Slot {
                fragment: *fragments.entry(at.min(opposite)).or_insert(next),
                direction: if met { Direction::Minus } else { Direction::Plus },
                outward: gateway(at),
                inward: gateway(opposite),
                control: self.slots[at].control,
                bearing: None,
                width: None,
                margin: None,
            }
        });
        SmallScaleStar::new(listed.collect())
    }
}
