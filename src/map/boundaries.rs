//! The sides of each path as sets of places: what the regions say, without the evidence.

use crate::map::{DstateId, PathId, Paths, PlaceSet, Stop, TopologicalMap, places_beyond};
use crate::star::{Direction, SlotIndex};

/// The places on, left of and right of every path of a map; where [`crate::map::Regions`] says why, this is quick.
#[derive(Clone, Debug)]
pub(crate) struct Boundaries {
    paths: Paths,
    sides: Vec<Sides>,
}

/// What lies on and beside one path.
#[derive(Clone, Debug)]
struct Sides {
    on: PlaceSet,
    left: PlaceSet,
    right: PlaceSet,
}

impl Boundaries {
    /// Those of a map: the dstates times the fragments of a place times the places on a path.
    pub(crate) fn of(map: &TopologicalMap) -> Boundaries {
        let paths = Paths::of(map);
        let beside = |ahead: DstateId, slots: &mut dyn Iterator<Item = SlotIndex>, side: &mut PlaceSet| {
            let beyond = slots.flat_map(|slot| places_beyond(map, DstateId { slot, ..ahead }));
            beyond.for_each(|place| side.insert(place));
        };
        let sides = paths.iter().map(|path| {
            let (mut left, mut right) = (PlaceSet::default(), PlaceSet::default());
            for &Stop { ahead, .. } in &path.stops {
                let star = map.star(ahead.place);
                beside(ahead, &mut star.left_of(ahead.slot), &mut left);
                beside(ahead, &mut star.right_of(ahead.slot), &mut right);
            }
            Sides { on: path.places().collect(), left, right }
        });
        let sides = sides.collect();
        Boundaries { paths, sides }
    }

    /// Whether no place is on two of left, right and the path itself, for any path.
    pub(crate) fn agree(&self) -> bool {
        let agree = |it: &Sides| {
            !it.left.intersects(&it.right) && !it.on.intersects(&it.left) && !it.on.intersects(&it.right)
        };
        self.sides.iter().all(agree)
    }

    /// Whether they still agree once `from` and `to`, two dstates of this map without far end, are joined, given that
    /// they agree now. The places on both paths times the fragments of a place.
    ///
    /// The paths `a`, which ends at `from`, and `b`, which begins at `to`, become one, and where another path crosses
    /// one of them, the whole other one is added to what lies beyond.
    pub(crate) fn agree_joined(&self, map: &TopologicalMap, from: DstateId, to: DstateId) -> bool {
        let (a, b) = (self.end(map, from), self.end(map, to));
        if a.path == b.path {
            // A closed path leads from each place back to it, so that it lies beside and on every path it crosses.
            return self.along(map, from).all(|ahead| map.star(ahead.place).fragments() == 1);
        }
        // As seen by one who comes along `a` to `from` and goes on along `b`.
        let ((a, left, right), (b, right_b, left_b)) = (a.sides(), b.sides());
        let apart =
            [(a, b), (left, right_b), (right, left_b), (a, left_b), (a, right_b), (b, left), (b, right)];
        apart.iter().all(|(one, other)| !one.intersects(other))
            && self.carries(map, from, b)
            && self.carries(map, to, a)
    }

    /// Whether the paths crossed by the one that ends at `end` can have all these places where it leads.
    fn carries(&self, map: &TopologicalMap, end: DstateId, places: &PlaceSet) -> bool {
        self.along(map, end).all(|ahead| {
            let crossed = map.dstates_at(ahead.place).filter(|&it| it != ahead && it != map.opposite(ahead));
            crossed.into_iter().all(|facing| {
                let (on, left, _) = self.end(map, facing).sides();
                // One who faces so has `ahead` to the right; the other direction of the same path is judged by itself.
                let right = map.star(ahead.place).right_of(facing.slot).any(|slot| slot == ahead.slot);
                !(right && (places.intersects(on) || places.intersects(left)))
            })
        })
    }

    /// The dstates that face the way of `end`, a dstate without far end, along its path, the last one first.
    fn along<'a>(&self, map: &'a TopologicalMap, end: DstateId) -> impl Iterator<Item = DstateId> + use<'a> {
        std::iter::successors(Some(end), |&ahead| map.far_end(map.opposite(ahead)))
    }

    fn end(&self, map: &TopologicalMap, dstate: DstateId) -> End<'_> {
        let along = self.paths.along(map, dstate);
        End { path: along.path, direction: along.direction, sides: &self.sides[along.path.0 as usize] }
    }
}

/// A path in a direction.
struct End<'a> {
    path: PathId,
    direction: Direction,
    sides: &'a Sides,
}

impl<'a> End<'a> {
    /// The places on the path, left and right of it as seen in the direction.
    fn sides(&self) -> (&'a PlaceSet, &'a PlaceSet, &'a PlaceSet) {
        let Sides { on, left, right } = self.sides;
        match self.direction {
            Direction::Plus => (on, left, right),
            Direction::Minus => (on, right, left),
        }
    }
}
