//! Walks over a map: along a path, and around a face of the rotation system.

use crate::map::place_set::BitSet;
use crate::map::{DstateId, PlaceId, TopologicalMap};
use std::iter;

/// The dstates without far end that share a face with a given one.
///
/// The faces of the rotation system are the orbits of "go clockwise to the next slot, and if it has a far end,
/// cross" (Edmonds 1960; Savelli and Kuipers, IROS 2004). Joining two such dstates of one connected map keeps its
/// genus if and only if they share a face.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    open: BitSet,
}

impl Face {
    /// The face that holds `corner`, a dstate without far end. Linear in the length of the face.
    pub(crate) fn around(map: &TopologicalMap, corner: DstateId) -> Face {
        let mut open = BitSet::default();
        let mut at = corner;
        // The step is a permutation of the dstates, so that the walk comes back to where it began.
        loop {
            at = map.clockwise(at);
            match map.far_end(at) {
                Some(far) => at = far,
                None => open.insert(map.index(at)),
            }
            if at == corner {
                return Face { open };
            }
        }
    }

    /// Whether a dstate of the same map lies in the face and has no far end.
    pub(crate) fn holds(&self, map: &TopologicalMap, dstate: DstateId) -> bool {
        self.open.contains(map.index(dstate))
    }
}

/// The path segments around the face that holds `corner`, a dstate without far end, the lower end first; one that
/// has the face on both sides comes twice.
pub(crate) fn face_segments(map: &TopologicalMap, corner: DstateId) -> impl Iterator<Item = [DstateId; 2]> {
    let crossed = |at: DstateId| map.far_end(map.clockwise(at)).map(|far| (map.clockwise(at), far));
    let step = move |&at: &DstateId| Some(crossed(at).map_or_else(|| map.clockwise(at), |(_, far)| far));
    let walk = iter::successors(Some(corner), step).enumerate();
    walk.take_while(move |&(steps, at)| steps == 0 || at != corner)
        .filter_map(move |(_, at)| crossed(at).map(|(near, far)| [near.min(far), near.max(far)]))
}

/// The places of the path that ends at `end`, a dstate without far end, from there on. A place is named as often
/// as the path passes it.
pub(crate) fn path_from_end(map: &TopologicalMap, end: DstateId) -> impl Iterator<Item = PlaceId> {
    iter::successors(Some(end), |&outward| map.far_end(map.opposite(outward))).map(|dstate| dstate.place)
}

/// The places met by travelling on from `ahead` along its path, in their order. A closed path is followed until it
/// comes back to `ahead`, so that it meets the place of `ahead` too.
pub(crate) fn places_beyond(map: &TopologicalMap, ahead: DstateId) -> impl Iterator<Item = PlaceId> {
    let on = move |&far: &DstateId| Some(map.opposite(far)).filter(|&next| next != ahead);
    iter::successors(map.far_end(ahead), move |far| on(far).and_then(|next| map.far_end(next)))
        .map(|dstate| dstate.place)
}
