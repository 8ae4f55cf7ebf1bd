//! Many maps in little memory.

use crate::map::TopologicalMap;
use crate::map::topological::{Place, Way};

/// Maps one after the other, their stars from one table. Memory is taken and given back at once: twenty-four bytes a
/// map, eight a place, four a dstate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Atlas {
    sheets: Vec<Sheet>,
    places: Vec<Place>,
    ways: Vec<Way>,
}

/// All of a map but its places and dstates, which begin where those of the map before end.
#[derive(Clone, Copy, Debug)]
struct Sheet {
    places_end: usize,
    ways_end: usize,
    segments: u32,
    closed_paths: u32,
}

impl Atlas {
    /// An atlas that will have so many maps.
    pub(crate) fn with_capacity(maps: usize) -> Atlas {
        Atlas { sheets: Vec::with_capacity(maps), places: Vec::new(), ways: Vec::new() }
    }

    /// Adds a map.
    pub(crate) fn push(&mut self, map: &TopologicalMap) {
        let left = self.sheets.capacity().saturating_sub(self.sheets.len()).max(1);
        append(&mut self.places, &map.places, left);
        append(&mut self.ways, &map.ways, left);
        self.end_sheet(map.segments, map.closed_paths);
    }

    /// Leaves a position out, of which nothing will be read.
    pub(crate) fn skip(&mut self) {
        self.end_sheet(0, 0);
    }

    /// Gives back the memory that more maps would have taken.
    pub(crate) fn shrink(&mut self) {
        self.sheets.shrink_to_fit();
        self.places.shrink_to_fit();
        self.ways.shrink_to_fit();
    }

    /// Turns a map whose stars are from the same table, or one that extends it, into the one at a position.
    pub(crate) fn read(&self, index: usize, map: &mut TopologicalMap) {
        let before = index.checked_sub(1).map(|before| self.sheets[before]);
        let (places, ways) = before.map_or((0, 0), |sheet| (sheet.places_end, sheet.ways_end));
        let sheet = self.sheets[index];
        map.places.clear();
        map.places.extend_from_slice(&self.places[places..sheet.places_end]);
        map.ways.clear();
        map.ways.extend_from_slice(&self.ways[ways..sheet.ways_end]);
        (map.segments, map.closed_paths) = (sheet.segments, sheet.closed_paths);
    }

    fn end_sheet(&mut self, segments: u32, closed_paths: u32) {
        let (places_end, ways_end) = (self.places.len(), self.ways.len());
        self.sheets.push(Sheet { places_end, ways_end, segments, closed_paths });
    }
}

/// Adds items; where there is no room, room for as many again, `left` times in all.
fn append<T: Copy>(all: &mut Vec<T>, more: &[T], left: usize) {
    if all.capacity() - all.len() < more.len() {
        all.reserve_exact(left * more.len());
    }
    all.extend_from_slice(more);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{DstateId, PlaceId, StarTable};
    use crate::star::{
        ControlLaw, Direction, FragmentId, GatewayId, LargeScaleStar, Slot, SlotIndex, SmallScaleStar,
    };
    use std::sync::Arc;

    /// A star of so many fragments, one after the other.
    fn star(fragments: u32) -> LargeScaleStar {
        let slot = |slot: u32| Slot {
            fragment: FragmentId(slot / 2),
            direction: if slot.is_multiple_of(2) { Direction::Plus } else { Direction::Minus },
            outward: Some(GatewayId(slot)),
            inward: Some(GatewayId(slot ^ 1)),
            control: ControlLaw::Midline,
            bearing: None,
            width: None,
            margin: None,
        };
        SmallScaleStar::new((0..2 * fragments).map(slot).collect()).unwrap().large_scale()
    }

    #[test]
    fn what_is_read_is_what_was_added() {
        let dstate = |place, slot| DstateId { place: PlaceId::new(place).unwrap(), slot: SlotIndex(slot) };
        let (small, large) = (Arc::new(StarTable::default()).intern(&star(1)).unwrap(), star(3));
        let large = small.table.intern(&large).unwrap();
        let first = TopologicalMap::first(&small);
        let second = first.grown(dstate(0, 0), &large, dstate(1, 4));
        let third = second.joined(dstate(1, 5), dstate(0, 1));
        let maps = [&second, &first, &third, &second];
        for expected in [1, 2, 9] {
            let mut atlas = Atlas::with_capacity(expected);
            for map in maps {
                atlas.push(map);
                atlas.skip();
            }
            let mut read = TopologicalMap::blank(Arc::clone(&large.table));
            for (position, map) in (0..).step_by(2).zip(maps) {
                atlas.read(position, &mut read);
                assert_eq!(&read, map);
                assert_eq!(
                    (read.path_count(), read.segment_count()),
                    (map.path_count(), map.segment_count())
                );
            }
        }
    }
}
