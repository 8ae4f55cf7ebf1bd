//! The places and paths that follow from a map's dstates.

use crate::classic::{Action, ClassicMap, Dstate, DstateId};
use std::collections::{BTreeMap, BTreeSet};

/// A place: a class of dstates under turns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassicPlace {
    /// Its dstates, by number. The first names it.
    pub dstates: Vec<DstateId>,
}

/// A path: a class of dstates under travels and turns around. It has no more than one dstate where nothing was
/// travelled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassicPath {
    /// The first of its dstates, whose direction is the path's.
    pub name: DstateId,
    /// Its places, by the number of each. Every travel along the path leads to a later one, against it to an
    /// earlier one; of places that travels do not order, the lower number comes first.
    pub places: Vec<usize>,
    /// The pairs of places that a travel joined, in the direction of the path, each once.
    pub segments: Vec<[usize; 2]>,
}

impl ClassicMap {
    /// The places, by number: that of the first visit to any of the dstates they are known to have.
    pub fn places(&self) -> Vec<ClassicPlace> {
        let dstates = by_name(self, |dstate| dstate.place);
        dstates.into_values().map(|dstates| ClassicPlace { dstates }).collect()
    }

    /// The paths, travelled or not, by the number of their first dstate.
    pub fn paths(&self) -> Vec<ClassicPath> {
        let names: Vec<DstateId> = by_name(self, |dstate| dstate.place).into_keys().collect();
        let place = |id: DstateId| names.partition_point(|name| *name < self.dstate(id).place);
        let paths = by_name(self, |dstate| dstate.path).into_iter();
        paths.map(|(name, dstates)| ClassicPath::of(self, name, &dstates, &place)).collect()
    }
}

impl ClassicPath {
    fn of(
        map: &ClassicMap,
        name: DstateId,
        dstates: &[DstateId],
        place: &dyn Fn(DstateId) -> usize,
    ) -> ClassicPath {
        let mut segments = BTreeSet::new();
        for &id in dstates {
            if let Some(to) = map.after(id, Action::Travel) {
                let (here, there) = (place(id), place(to));
                segments.insert(if map.dstate(id).reversed { [there, here] } else { [here, there] });
            }
        }
        let mut left: BTreeSet<usize> = dstates.iter().map(|&id| place(id)).collect();
        let mut places = Vec::with_capacity(left.len());
        let open = |left: &BTreeSet<usize>| {
            let behind = |place: &usize| segments.iter().any(|[a, b]| b == place && left.contains(a));
            left.iter().copied().find(|place| !behind(place))
        };
        // The order is strict, so that some place is always the first of those left.
        while let Some(next) = open(&left) {
            left.remove(&next);
            places.push(next);
        }
        ClassicPath { name, places, segments: segments.into_iter().collect() }
    }
}

fn by_name(map: &ClassicMap, name: fn(&Dstate) -> DstateId) -> BTreeMap<DstateId, Vec<DstateId>> {
    let mut classes: BTreeMap<DstateId, Vec<DstateId>> = BTreeMap::new();
    map.ids().for_each(|id| classes.entry(name(map.dstate(id))).or_default().push(id));
    classes
}
