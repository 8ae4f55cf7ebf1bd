//! The paths of a map, the order of places on them, and the large-scale stars bound to them.

use crate::map::{DstateId, PathId, PlaceId, TopologicalMap};
use crate::star::{Direction, LargeSlot};

/// All paths of a map, travelled or not, and what each slot of each star is bound to (seed, section 4.3 and
/// Figure 3(c)). Every dstate lies on exactly one directed path, its opposite on the same one in the other
/// direction. Computed in time linear in the dstates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    paths: Vec<TopoPath>,
    bound: Vec<DirectedPath>,
}

/// A path: places in the order of its direction `+`, which is that of its lowest dstate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopoPath {
    /// Its name.
    pub id: PathId,
    /// The places on it, in the direction `+`.
    pub stops: Vec<Stop>,
    /// Whether the last place leads on to the first; never so under the axiom `path-order`.
    pub closed: bool,
}

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stop {
    /// The dstate that faces back, in the direction `-`: travel in the direction `+` comes in through its gateway.
    pub back: DstateId,
    /// The dstate that faces on, in the direction `+`.
    pub ahead: DstateId,
}

/// A path in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DirectedPath {
    /// The path.
    pub path: PathId,
    /// The direction along it.
    pub direction: Direction,
}

/// A slot of a large-scale star bound to its path, as in Figure 3(c) of the seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BoundSlot {
    /// The distinctive state.
    pub dstate: DstateId,
    /// The directed path it faces along.
    pub along: DirectedPath,
    /// Whether the path ends here in this direction: the seed writes it in parentheses.
    pub terminates: bool,
}

impl Paths {
    /// The paths of a map.
    pub fn of(map: &TopologicalMap) -> Paths {
        let mut paths: Vec<TopoPath> = Vec::with_capacity(map.path_count());
        let mut bound: Vec<Option<DirectedPath>> = vec![None; map.dstate_count()];
        for dstate in map.dstates() {
            if bound[map.index(dstate)].is_none() {
                let path = TopoPath::through(map, dstate, PathId(paths.len() as u32));
                for stop in &path.stops {
                    let along = |direction| Some(DirectedPath { path: path.id, direction });
                    bound[map.index(stop.ahead)] = along(Direction::Plus);
                    bound[map.index(stop.back)] = along(Direction::Minus);
                }
                paths.push(path);
            }
        }
        // The walk through a dstate binds that dstate, so none is left out.
        Paths { paths, bound: bound.into_iter().flatten().collect() }
    }

    /// The paths, by name.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &TopoPath> {
        self.paths.iter()
    }

    /// The directed path a dstate of the same map faces along.
    pub fn along(&self, map: &TopologicalMap, dstate: DstateId) -> DirectedPath {
        self.bound[map.index(dstate)]
    }

    /// The large-scale star of a place of the same map, clockwise.
    pub fn bound_star(&self, map: &TopologicalMap, place: PlaceId) -> Vec<BoundSlot> {
        let bind = |(dstate, slot): (DstateId, &LargeSlot)| BoundSlot {
            dstate,
            along: self.along(map, dstate),
            terminates: !slot.navigable,
        };
        map.dstates_at(place).zip(map.star(place).slots()).map(bind).collect()
    }
}

impl TopoPath {
    /// The path through a dstate, in the direction the dstate faces.
    fn through(map: &TopologicalMap, dstate: DstateId, id: PathId) -> TopoPath {
        let (start, closed) = first_ahead(map, dstate);
        let mut stops = Vec::new();
        let mut ahead = start;
        loop {
            stops.push(Stop { back: map.opposite(ahead), ahead });
            match map.far_end(ahead).map(|far| map.opposite(far)) {
                Some(next) if next != start => ahead = next,
                _ => return TopoPath { id, stops, closed },
            }
        }
    }

    /// The places on the path, in the direction `+`.
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> {
        self.stops.iter().map(|stop| stop.ahead.place)
    }
}

/// The dstate at the first place of the path through `dstate`, and whether the path is closed, in which case any
/// place is its first and `dstate`'s is taken.
fn first_ahead(map: &TopologicalMap, dstate: DstateId) -> (DstateId, bool) {
    let mut ahead = dstate;
    while let Some(before) = map.far_end(map.opposite(ahead)) {
        ahead = before;
        if ahead == dstate {
            return (dstate, true);
        }
    }
    (ahead, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapError;
    use crate::star::{ControlLaw, FragmentId, GatewayId, LargeScaleStar, Slot, SlotIndex, SmallScaleStar};

    /// Two paths that cross: slots 0 and 2 on one, 1 and 3 on the other.
    fn crossing() -> LargeScaleStar {
        let slot = |slot: u32| Slot {
            fragment: FragmentId(slot % 2),
            direction: if slot < 2 { Direction::Plus } else { Direction::Minus },
            outward: Some(GatewayId(slot)),
            inward: Some(GatewayId((slot + 2) % 4)),
            control: ControlLaw::Midline,
            bearing: None,
            width: None,
            margin: None,
        };
        SmallScaleStar::new((0..4).map(slot).collect()).unwrap().large_scale()
    }

    fn dstate(place: usize, slot: u8) -> DstateId {
        DstateId { place: PlaceId::new(place).unwrap(), slot: SlotIndex(slot) }
    }

    #[test]
    fn places_are_in_order_on_their_path() {
        let map = TopologicalMap::new(&crossing()).unwrap();
        let map = map.with_new_place(dstate(0, 0), &crossing(), SlotIndex(3)).unwrap();
        let map = map.with_new_place(dstate(0, 2), &crossing(), SlotIndex(0)).unwrap();
        let paths = Paths::of(&map);
        let line: Vec<usize> = paths.paths[0].places().map(PlaceId::index).collect();
        assert_eq!((line, map.path_count()), (vec![2, 0, 1], 4));
        let ahead = DirectedPath { path: PathId(0), direction: Direction::Plus };
        assert_eq!([dstate(0, 0), dstate(1, 1), dstate(2, 0)].map(|it| paths.along(&map, it)), [ahead; 3]);
        assert_eq!(paths.bound_star(&map, PlaceId::FIRST)[2].along.direction, Direction::Minus);
    }

    #[test]
    fn a_closed_path_is_walked_once() {
        let map = TopologicalMap::new(&crossing()).unwrap();
        let map = map.with_new_place(dstate(0, 0), &crossing(), SlotIndex(2)).unwrap();
        let map = map.with_segment(dstate(1, 0), dstate(0, 2)).unwrap();
        let paths = Paths::of(&map);
        assert_eq!((paths.paths[0].stops.len(), paths.paths[0].closed), (2, true));
        assert_eq!((paths.iter().len(), map.path_count()), (3, 3));
    }

    #[test]
    fn what_cannot_be_joined_is_refused() {
        let map = TopologicalMap::new(&crossing()).unwrap();
        assert_eq!(map.with_segment(dstate(0, 1), dstate(0, 1)), Err(MapError::OneGateway(dstate(0, 1))));
        assert_eq!(map.with_segment(dstate(0, 1), dstate(1, 1)), Err(MapError::UnknownDstate(dstate(1, 1))));
        let map = map.with_segment(dstate(0, 1), dstate(0, 2)).unwrap();
        assert_eq!(map.with_segment(dstate(0, 3), dstate(0, 2)), Err(MapError::Taken(dstate(0, 2))));
    }
}
