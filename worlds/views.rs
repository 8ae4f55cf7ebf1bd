//! Walks through a world as traces of views, turns and travels, with the true map beside them: what a robot without
//! stars has (seed, sections 3.3 and 4.4).

use crate::geometry::wrap_angle;
use crate::star::{ControlLaw, SlotIndex};
use crate::trace::event::{Event, EventKind, Observation, Percept, Turn, TurnDescription, TurnTarget};
use crate::worlds::simulator::push;
use crate::worlds::world::{Place, World};
use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// How a robot names what its range sensor sees from a dstate. A side is a quarter of the circle; what lies there is
/// a `corridor`, if a gateway leads out, `open` where the fragment ends without a wall, and else a `wall`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Naming {
    /// What lies ahead, to the left and to the right: what a sensor that sees half the circle can tell.
    #[default]
    Sides,
    /// On which of these three sides there is a wall: the other two are both called `free`.
    Walls,
    /// What lies ahead: what a sensor that looks along the way can tell.
    Ahead,
}

/// A trace of views and the assignment of its observations that is true.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewTrace {
    /// The events.
    pub events: Vec<Event>,
    /// For each observation its dstate, numbered by first visit, and the place of that, numbered by first visit.
    pub truth: Vec<(usize, usize)>,
}

/// A dstate of a world: a place and a slot faced from it.
type At = (usize, SlotIndex);

/// The walk of a world as the views seen on it. At every place the robot first turns until it has faced every slot,
/// each time by the fewest turns to one it has not, then by the fewest turns to the slot it leaves by.
///
/// A turn around leads to the other slot of the fragment; a turn left or right to the next slot on that side, unless
/// that is the other slot of the fragment. Where several turns do, the first of around, left, right is made.
pub fn view_trace(world: &World, naming: Naming) -> ViewTrace {
    let mut walk = Walk {
        world,
        naming,
        trace: ViewTrace { events: Vec::new(), truth: Vec::new() },
        met: Met::default(),
    };
    for visit in world.visits() {
        let place = &world.places[visit.place];
        let mut facing = visit.arrival;
        walk.see((visit.place, facing));
        let mut faced = vec![facing];
        while let Some(turns) = turns_until(place, facing, &|slot| !faced.contains(&slot)) {
            facing = walk.turn((visit.place, facing), &turns);
            faced.push(facing);
        }
        let Some(departure) = visit.departure else { continue };
        let turns = turns_until(place, facing, &|slot| slot == departure).unwrap_or_default();
        walk.turn((visit.place, facing), &turns);
        push(&mut walk.trace.events, EventKind::Travel(Box::default()));
    }
    walk.trace
}

struct Walk<'a> {
    world: &'a World,
    naming: Naming,
    trace: ViewTrace,
    met: Met,
}

/// The numbers of what was met.
#[derive(Default)]
struct Met {
    dstates: BTreeMap<(usize, u8), usize>,
    places: BTreeMap<usize, usize>,
}

impl Walk<'_> {
    fn see(&mut self, at: At) {
        let view = view(&self.world.places[at.0], at.1, self.naming);
        let observation = Observation { percept: Percept::View(view) };
        push(&mut self.trace.events, EventKind::Observation(Box::new(observation)));
        let Met { dstates, places } = &mut self.met;
        let (dstate, place) = (dstates.len(), places.len());
        let dstate = *dstates.entry((at.0, at.1.0)).or_insert(dstate);
        let place = *places.entry(at.0).or_insert(place);
        self.trace.truth.push((dstate, place));
    }

    /// Turns, with a view after each; the slot faced in the end.
    fn turn(&mut self, at: At, turns: &[TurnDescription]) -> SlotIndex {
        let place = &self.world.places[at.0];
        turns.iter().fold(at.1, |facing, &turn| {
            let target = TurnTarget::Described(turn);
            push(&mut self.trace.events, EventKind::Turn(Turn { target, angle: None }));
            let facing = turned(place, facing, turn).unwrap_or(facing);
            self.see((at.0, facing));
            facing
        })
    }
}

/// The slot faced after a turn, if the turn can be made.
pub fn turned(place: &Place, facing: SlotIndex, turn: TurnDescription) -> Option<SlotIndex> {
    let (size, own) = (place.slots.len(), usize::from(facing.0));
    let opposite = place.slots[own].opposite;
    let side = |step: usize| SlotIndex(((own + step) % size) as u8);
    match turn {
        TurnDescription::Around => Some(opposite),
        TurnDescription::Left => Some(side(size - 1)).filter(|&slot| slot != opposite),
        TurnDescription::Right => Some(side(1)).filter(|&slot| slot != opposite),
    }
}

/// The fewest turns that lead to a slot with a property; none if no turn leads to one.
fn turns_until(
    place: &Place,
    facing: SlotIndex,
    wanted: &dyn Fn(SlotIndex) -> bool,
) -> Option<Vec<TurnDescription>> {
    let mut reached = vec![facing];
    let mut agenda = VecDeque::from([(facing, Vec::new())]);
    while let Some((slot, turns)) = agenda.pop_front() {
        if wanted(slot) {
            return Some(turns);
        }
        for turn in [TurnDescription::Around, TurnDescription::Left, TurnDescription::Right] {
            let next = turned(place, slot, turn).filter(|next| !reached.contains(next));
            if let Some(next) = next {
                reached.push(next);
                agenda.push_back((next, [&turns[..], &[turn]].concat()));
            }
        }
    }
    None
}

fn view(place: &Place, facing: SlotIndex, naming: Naming) -> String {
    let ahead = place.slots[usize::from(facing.0)].bearing;
    let side = |turn: f64| {
        let here =
            place.slots.iter().filter(|slot| wrap_angle(slot.bearing - ahead - turn).abs() < FRAC_PI_4);
        let seen = here.map(|slot| look(slot.control)).max().unwrap_or(Look::Wall);
        if naming == Naming::Walls && seen != Look::Wall { "free" } else { seen.name() }
    };
    match naming {
        Naming::Sides | Naming::Walls => {
            format!("{} ahead, {} left, {} right", side(0.0), side(FRAC_PI_2), side(-FRAC_PI_2))
        }
        Naming::Ahead => format!("{} ahead", side(0.0)),
    }
}

/// What lies on a side. Of several things there, the greatest is what is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    Wall,
    Open,
    Corridor,
}

impl Look {
    fn name(self) -> &'static str {
        match self {
            Look::Wall => "wall",
            Look::Open => "open",
            Look::Corridor => "corridor",
        }
    }
}

fn look(control: ControlLaw) -> Look {
    match control {
        ControlLaw::DeadEnd => Look::Wall,
        ControlLaw::None => Look::Open,
        ControlLaw::Midline | ControlLaw::LeftWall | ControlLaw::RightWall => Look::Corridor,
    }
}
