//! What lies left and right of each path of a map.

use crate::map::{DstateId, PathId, Paths, PlaceId, Stop, TopologicalMap, places_beyond};
use crate::star::SlotIndex;
use std::collections::BTreeMap;

/// The boundary regions of a map: a path divides what is right of it from what is left (Remolina, Kuipers,
/// *Towards a formalization of route and boundary relations*, AAAI FS-98-02; Kuipers, Tecuci, Stankiewicz 2003).
///
/// Where a path `pa'` leaves a place of the path `pa` by a slot to the right of `pa`, every place further on along
/// `pa'` in that direction is right of `pa`; left likewise. Left and right are those of the star (seed, section
/// 4.3). That is a default: a path that crosses twice, or curls back, is no boundary for the other.
///
/// Computed from the map alone, each dstate asking each other fragment of its place for the places beyond: the
/// dstates times the fragments of a place times the places on a path, and sorting. Laws: what a map's regions say,
/// those of every extension say too, of the paths its paths became part of; a mirror image swaps left and right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Regions {
    paths: Vec<PathRegions>,
}

/// The two sides of a path, as seen in its direction `+`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathRegions {
    /// The path.
    pub path: PathId,
    /// The places to its left, by number.
    pub left: Vec<Beside>,
    /// The places to its right, by number.
    pub right: Vec<Beside>,
    /// The places on it, in its order.
    on: Vec<PlaceId>,
}

/// A place beside a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Beside {
    /// The place.
    pub place: PlaceId,
    /// Why it is there, at least one reason; ascending.
    pub evidence: Vec<Crossing>,
}

/// A reason why a place is beside a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Crossing {
    /// The place of the path where the other one leaves it.
    pub at: PlaceId,
    /// The other path, on which the place lies further on.
    pub carrier: PathId,
}

/// Evidence about a path that cannot all be true: a place is right and left of it, or on it and beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Conflict {
    /// The path.
    pub path: PathId,
    /// The place.
    pub place: PlaceId,
    /// Why the place is beside the path; to its left, if the place is on both sides.
    pub beside: Crossing,
    /// Why it is to the right of the path, unless the conflict is that it is on the path.
    pub right: Option<Crossing>,
}

/// Places, each with its evidence.
type Side = BTreeMap<PlaceId, Vec<Crossing>>;

impl Regions {
    /// The regions of a map.
    pub fn of(map: &TopologicalMap) -> Regions {
        let paths = Paths::of(map);
        let regions = paths.iter().map(|path| {
            let (mut left, mut right) = (Side::new(), Side::new());
            for Stop { ahead, .. } in &path.stops {
                let star = map.star(ahead.place);
                gather(map, &paths, ahead.place, star.left_of(ahead.slot), &mut left);
                gather(map, &paths, ahead.place, star.right_of(ahead.slot), &mut right);
            }
            PathRegions {
                path: path.id,
                left: listed(left),
                right: listed(right),
                on: path.places().collect(),
            }
        });
        Regions { paths: regions.collect() }
    }

    /// The regions of each path, by name.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &PathRegions> {
        self.paths.iter()
    }

    /// All that cannot be true, path by path; none if and only if every path is a boundary. Once there is a conflict
    /// there is one in every extension of the map.
    pub fn conflicts(&self) -> impl Iterator<Item = Conflict> {
        self.paths.iter().flat_map(PathRegions::conflicts)
    }
}

impl PathRegions {
    /// What cannot be true of this path.
    pub fn conflicts(&self) -> impl Iterator<Item = Conflict> {
        let both = self.left.iter().flat_map(|left| {
            let right = self.right.iter().filter(|right| right.place == left.place);
            let right = right.flat_map(|right| right.evidence.iter().copied());
            right.flat_map(|right| self.against(left, Some(right)))
        });
        let beside = self.left.iter().chain(&self.right);
        let on = beside.filter(|beside| self.on.contains(&beside.place));
        on.flat_map(|beside| self.against(beside, None)).chain(both)
    }

    fn against<'a>(
        &self,
        place: &'a Beside,
        right: Option<Crossing>,
    ) -> impl Iterator<Item = Conflict> + use<'a> {
        let path = self.path;
        place.evidence.iter().map(move |&beside| Conflict { path, place: place.place, beside, right })
    }
}

/// Notes all places beyond some slots of a place.
fn gather(
    map: &TopologicalMap,
    paths: &Paths,
    at: PlaceId,
    slots: impl Iterator<Item = SlotIndex>,
    side: &mut Side,
) {
    for ahead in slots.map(|slot| DstateId { place: at, slot }) {
        let carrier = paths.along(map, ahead).path;
        for place in places_beyond(map, ahead) {
            side.entry(place).or_default().push(Crossing { at, carrier });
        }
    }
}

fn listed(side: Side) -> Vec<Beside> {
    let list = |(place, mut evidence): (PlaceId, Vec<Crossing>)| {
        evidence.sort_unstable();
        evidence.dedup();
        Beside { place, evidence }
    };
    side.into_iter().map(list).collect()
}
