//! Random stars, worlds and walks, drawn from a sequence of choices so that failures shrink.

use crate::reference::{End, Story};
use proptest::prelude::*;
use topostar::abduction::Visit;
use topostar::star::{
    ControlLaw, Direction, FragmentId, GatewayId, LargeScaleStar, Slot, SlotIndex, SmallScaleStar, StarError,
};

/// A walk through a world, as observed and as it was.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    pub(crate) visits: Vec<Visit>,
    pub(crate) truth: Story,
}

/// Walks through worlds whose gateways are joined at random: few kinds of places, symmetric ones among them,
/// pairing not antipodal, paths that end, dead ends. Such a world need not obey any axiom but the first two.
pub(crate) fn tangled_walks(most: usize) -> impl Strategy<Value = Walk> {
    choices().prop_map(move |mut choices| {
        let kinds: Vec<Star> = (0..1 + choices.below(3)).map(|_| Star::any(&mut choices)).collect();
        let stars = (0..1 + choices.below(5)).map(|_| kinds[choices.below(kinds.len())].clone()).collect();
        let world = World::tangled(stars, &mut choices);
        let steps = 1 + choices.below(most);
        world.walk(steps, &mut choices)
    })
}

/// Walks through corridor grids, which obey all axioms. Places differ by their blocked sides alone.
pub(crate) fn grid_walks(most: usize) -> impl Strategy<Value = Walk> {
    choices().prop_map(move |mut choices| {
        let world = World::grid(1 + choices.below(3), 2 + choices.below(2));
        let steps = 1 + choices.below(most);
        world.walk(steps, &mut choices)
    })
}

/// Observations without a world: mostly no map, or only wild ones, explain them.
pub(crate) fn lies(most: usize) -> impl Strategy<Value = Vec<Visit>> {
    choices().prop_map(move |mut choices| {
        let kinds: Vec<Star> = (0..2).map(|_| Star::any(&mut choices)).collect();
        let mut visits: Vec<Visit> = Vec::new();
        for _ in 0..1 + choices.below(most) {
            let star = kinds[choices.below(2)].relisted(choices.below(6)).large_scale();
            let arrival = choices.of(&arrivals(&star));
            let departure = visits.last().map(|last| {
                // Turning back is what shows a lie.
                let back = last.star.slots()[last.arrival.0 as usize].opposite;
                if choices.below(2) == 0 { choices.of(&navigable(&last.star)) } else { back }
            });
            visits.push(Visit { departure, star, arrival });
        }
        visits
    })
}

/// A slot number to turn the listing of each observation by.
pub(crate) fn relistings() -> impl Strategy<Value = Vec<usize>> {
    prop::collection::vec(0..6usize, 16)
}

/// The same experience, with star `k` listed from slot `by[k]` on.
pub(crate) fn relist(visits: &[Visit], by: &[usize]) -> Vec<Visit> {
    let turned = |slot: SlotIndex, k: usize| {
        let size = visits[k].star.size();
        SlotIndex(((slot.0 as usize + size - by[k] % size) % size) as u8)
    };
    let relist = |(k, visit): (usize, &Visit)| Visit {
        departure: visit.departure.map(|slot| turned(slot, k - 1)),
        star: Star::of(&visit.star).relisted(by[k]).large_scale(),
        arrival: turned(visit.arrival, k),
    };
    visits.iter().enumerate().map(relist).collect()
}

/// A star that no strategy draws: it has more fragments than any of theirs.
pub(crate) fn unheard_of() -> LargeScaleStar {
    Star((0..10).map(|slot| ((slot + 5) % 10, ControlLaw::RightWall, true)).collect()).large_scale()
}

/// The same experience as seen in a mirror: what was clockwise is counter-clockwise. Control laws are left as they
/// are, which no axiom can tell.
pub(crate) fn mirrored(visits: &[Visit]) -> Vec<Visit> {
    let image = |slot: SlotIndex, size: usize| SlotIndex(((size - slot.0 as usize) % size) as u8);
    let mut before = 0;
    let mut mirror = |visit: &Visit| {
        let size = visit.star.size();
        let departure = visit.departure.map(|slot| image(slot, before));
        before = size;
        let star = Star::of(&visit.star).mirrored().large_scale();
        Visit { departure, star, arrival: image(visit.arrival, size) }
    };
    visits.iter().map(&mut mirror).collect()
}

/// The same star with other numbers, and where a bit of `by` says so, a fragment's directions swapped.
pub(crate) fn renamed(star: &SmallScaleStar, by: u32) -> SmallScaleStar {
    let gateway = |id: GatewayId| GatewayId(id.0 ^ (by % 64));
    let rename = |slot: &Slot| Slot {
        fragment: FragmentId(slot.fragment.0 + by % 100),
        direction: match (slot.direction, by >> (slot.fragment.0 % 32) & 1) {
            (Direction::Plus, 0) | (Direction::Minus, 1) => Direction::Plus,
            _ => Direction::Minus,
        },
        outward: slot.outward.map(gateway),
        inward: slot.inward.map(gateway),
        ..slot.clone()
    };
    SmallScaleStar::new(star.slots().iter().map(rename).collect()).unwrap()
}

fn choices() -> impl Strategy<Value = Choices> {
    prop::collection::vec(any::<u16>(), 0..120).prop_map(|drawn| Choices { drawn: drawn.into_iter() })
}

fn navigable(star: &LargeScaleStar) -> Vec<SlotIndex> {
    (0..star.size() as u8).map(SlotIndex).filter(|slot| star.slots()[slot.0 as usize].navigable).collect()
}

/// The slots with an inward gateway.
fn arrivals(star: &LargeScaleStar) -> Vec<SlotIndex> {
    navigable(star).into_iter().map(|slot| star.slots()[slot.0 as usize].opposite).collect()
}

#[derive(Debug)]
struct Choices {
    drawn: std::vec::IntoIter<u16>,
}

impl Choices {
    fn below(&mut self, bound: usize) -> usize {
        self.drawn.next().unwrap_or(0) as usize % bound
    }

    fn of<T: Copy>(&mut self, options: &[T]) -> T {
        options[self.below(options.len())]
    }
}

/// A star by its slots: opposite, label, and whether there is an outward gateway.
#[derive(Clone, Debug)]
pub(crate) struct Star(Vec<(usize, ControlLaw, bool)>);

impl Star {
    /// A star written slot by slot, clockwise: the letter of the path fragment, then `!` where a wall ends it here, `?`
    /// where open space does, `<` where travel follows the wall on the left.
    pub(crate) fn written(text: &str) -> Star {
        let slots: Vec<&str> = text.split(' ').collect();
        let slot = |(at, slot): (usize, &&str)| {
            let (fragment, control) = slot.split_at(1);
            let opposite = (0..slots.len()).find(|other| *other != at && slots[*other].starts_with(fragment));
            let (control, navigable) = match control {
                "" => (ControlLaw::Midline, true),
                "<" => (ControlLaw::LeftWall, true),
                "!" => (ControlLaw::DeadEnd, false),
                "?" => (ControlLaw::None, false),
                other => panic!("`{other}` is no mark of a slot"),
            };
            (opposite.unwrap(), control, navigable)
        };
        Star(slots.iter().enumerate().map(slot).collect())
    }

    fn any(choices: &mut Choices) -> Star {
        let fragments = 1 + choices.below(3);
        let mut free: Vec<usize> = (0..2 * fragments).collect();
        let mut slots = vec![(0, ControlLaw::Midline, true); 2 * fragments];
        while let Some(a) = free.pop() {
            let b = free.swap_remove(choices.below(free.len()));
            (slots[a].0, slots[b].0) = (b, a);
            let blocked = [ControlLaw::DeadEnd, ControlLaw::DeadEnd, ControlLaw::None][choices.below(3)];
            match choices.below(8) {
                0 => (slots[a].1, slots[a].2) = (blocked, false),
                1 => (slots[b].1, slots[b].2) = (blocked, false),
                2 => slots[a].1 = ControlLaw::LeftWall,
                _ => (),
            }
        }
        Star(slots)
    }

    pub(crate) fn of(star: &LargeScaleStar) -> Star {
        let slot =
            |slot: &topostar::star::LargeSlot| (slot.opposite.0 as usize, slot.control, slot.navigable);
        Star(star.slots().iter().map(slot).collect())
    }

    /// Listed from another slot on.
    pub(crate) fn relisted(&self, from: usize) -> Star {
        let size = self.0.len();
        let slot = |new: usize| {
            let (opposite, control, navigable) = self.0[(new + from) % size];
            ((opposite + size - from % size) % size, control, navigable)
        };
        Star((0..size).map(slot).collect())
    }

    /// Listed the other way round from its first slot.
    fn mirrored(&self) -> Star {
        let size = self.0.len();
        let slot = |new: usize| {
            let (opposite, control, navigable) = self.0[(size - new) % size];
            ((size - opposite) % size, control, navigable)
        };
        Star((0..size).map(slot).collect())
    }

    pub(crate) fn small_scale(&self) -> Result<SmallScaleStar, StarError> {
        let gateway = |slot: usize| self.0[slot].2.then_some(GatewayId(slot as u32));
        let slot = |slot: usize| {
            let (opposite, control, _) = self.0[slot];
            Slot {
                fragment: FragmentId(slot.min(opposite) as u32),
                direction: if slot < opposite { Direction::Plus } else { Direction::Minus },
                outward: gateway(slot),
                inward: gateway(opposite),
                control,
                bearing: None,
                width: None,
                margin: None,
            }
        };
        SmallScaleStar::new((0..self.0.len()).map(slot).collect())
    }

    pub(crate) fn large_scale(&self) -> LargeScaleStar {
        self.small_scale().unwrap().large_scale()
    }
}

/// Stars, and the far end of each slot where there is one.
pub(crate) struct World {
    stars: Vec<Star>,
    far: Vec<Vec<Option<(usize, usize)>>>,
}

impl World {
    /// This world with a wall to follow on the left at some slots.
    pub(crate) fn marked(mut self, slots: &[(usize, usize)]) -> World {
        slots.iter().for_each(|&(place, slot)| self.stars[place].0[slot].1 = ControlLaw::LeftWall);
        self
    }

    /// A world of some stars, and the pairs of gateways that path segments join.
    pub(crate) fn joined(stars: &[&str], segments: &[(End, End)]) -> World {
        let mut world = World::new(stars.iter().map(|text| Star::written(text)).collect());
        segments.iter().for_each(|&(a, b)| world.join(a, b));
        world
    }

    fn new(stars: Vec<Star>) -> World {
        let far = stars.iter().map(|star| vec![None; star.0.len()]).collect();
        World { stars, far }
    }

    fn join(&mut self, a: (usize, usize), b: (usize, usize)) {
        self.far[a.0][a.1] = Some(b);
        self.far[b.0][b.1] = Some(a);
    }

    fn tangled(stars: Vec<Star>, choices: &mut Choices) -> World {
        let mut world = World::new(stars);
        let mut free: Vec<(usize, usize)> = Vec::new();
        for (place, star) in world.stars.iter().enumerate() {
            free.extend((0..star.0.len()).filter(|&slot| star.0[slot].2).map(|slot| (place, slot)));
        }
        while free.len() > 1 {
            let a = free.remove(0);
            let others: Vec<usize> = (0..free.len()).filter(|&other| free[other].0 != a.0).collect();
            // Some travels that do not leave the place, but few.
            let pick = match others.is_empty() || choices.below(12) == 11 {
                true => choices.below(free.len()),
                false => choices.of(&others),
            };
            let b = free.remove(pick);
            world.join(a, b);
        }
        world
    }

    /// Corridors along all lines of a grid; slots are north, east, south, west.
    pub(crate) fn grid(rows: usize, columns: usize) -> World {
        let side = |open| if open { (ControlLaw::Midline, true) } else { (ControlLaw::DeadEnd, false) };
        let mut stars = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                // North, east, south, west. A blocked corridor has no path, so a lone row has bare sides.
                let open = [row > 0, column + 1 < columns, row + 1 < rows, column > 0];
                let ways = if open[0] || open[2] { vec![0, 1, 2, 3] } else { vec![1, 3] };
                let slots = ways.iter().enumerate().map(|(slot, &way)| {
                    let (control, navigable) = side(open[way]);
                    ((slot + ways.len() / 2) % ways.len(), control, navigable)
                });
                stars.push(Star(slots.collect()));
            }
        }
        let mut world = World::new(stars);
        for place in 0..rows * columns {
            let (east, west) = if rows > 1 { (1, 3) } else { (0, 1) };
            if (place + 1) % columns != 0 {
                world.join((place, east), (place + 1, west));
            }
            if place + columns < rows * columns {
                world.join((place, 2), (place + columns, 0));
            }
        }
        world
    }

    /// The walk that starts at a dstate and leaves each place by the slot said, stars listed as they are.
    pub(crate) fn follow(&self, start: (usize, usize), leave: &[usize]) -> Walk {
        let mut numbers: Vec<usize> = Vec::new();
        let mut walk = Walk { visits: Vec::new(), truth: Vec::new() };
        let (mut place, mut arrival) = start;
        let mut departures = leave.iter();
        let mut departure = None;
        loop {
            if !numbers.contains(&place) {
                numbers.push(place);
            }
            walk.truth.push((numbers.iter().position(|own| *own == place).unwrap(), 0));
            let star = self.stars[place].large_scale();
            walk.visits.push(Visit { departure, star, arrival: SlotIndex(arrival as u8) });
            let Some(&slot) = departures.next() else { return walk };
            departure = Some(SlotIndex(slot as u8));
            let far = self.far[place][slot].unwrap_or_else(|| panic!("no way leads from {place} by {slot}"));
            (place, arrival) = (far.0, self.stars[far.0].0[far.1].0);
        }
    }

    /// A walk that stops early where nothing leads on. Each observation is listed from a slot of its own.
    fn walk(&self, steps: usize, choices: &mut Choices) -> Walk {
        let mut walk = Walk { visits: Vec::new(), truth: Vec::new() };
        // For each place its number and from where its star was first listed.
        let mut numbers: Vec<Option<(usize, usize)>> = vec![None; self.stars.len()];
        let mut place = choices.below(self.stars.len());
        let mut ahead = choices.below(self.stars[place].0.len());
        let mut departure = None;
        loop {
            let size = self.stars[place].0.len();
            let listed = choices.below(size);
            let met = numbers.iter().flatten().count();
            let (number, first) = *numbers[place].get_or_insert((met, listed));
            let seen = |slot: usize| SlotIndex(((slot + size - listed) % size) as u8);
            walk.visits.push(Visit {
                departure,
                star: self.stars[place].relisted(listed).large_scale(),
                arrival: seen(ahead),
            });
            walk.truth.push((number, (listed + size - first) % size));
            let ways: Vec<usize> = (0..size).filter(|&slot| self.far[place][slot].is_some()).collect();
            if walk.visits.len() > steps || ways.is_empty() {
                return walk;
            }
            let slot = choices.of(&ways);
            departure = Some(seen(slot));
            let far = self.far[place][slot].unwrap();
            place = far.0;
            ahead = self.stars[place].0[far.1].0;
        }
    }
}
