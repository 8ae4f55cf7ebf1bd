//! A map without the numbers of its places.

use crate::map::{DstateId, PlaceId, TopologicalMap};
use crate::star::{LargeSlot, SlotIndex};
use std::collections::BTreeMap;

/// What two maps have in common if and only if they differ by numbering places and rotating stars alone.
///
/// A rotation system has no other freedom: once one dstate is laid onto another, all else follows. So of the
/// descriptions that start at each dstate, the least is canonical (Weinberg 1966, for planar maps).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CanonicalMap(Vec<CanonicalSlot>);

/// A slot with its opposite, and the place and slot at its far end, counted from where the description came in.
type CanonicalSlot = (LargeSlot, Option<(usize, SlotIndex)>);

impl CanonicalMap {
    /// The canonical form of a connected map. Quadratic in the dstates.
    pub fn of(map: &TopologicalMap) -> CanonicalMap {
        CanonicalMap(map.dstates().map(|root| describe(map, root)).min().unwrap_or_default())
    }
}

/// The map as seen from a dstate: places in the order in which a breadth-first walk finds them, slots clockwise
/// from the one by which it came.
fn describe(map: &TopologicalMap, root: DstateId) -> Vec<CanonicalSlot> {
    let mut entries = vec![root];
    let mut numbers = BTreeMap::from([(root.place, 0)]);
    let mut description = Vec::with_capacity(map.dstate_count());
    let mut described = 0;
    while let Some(&entry) = entries.get(described) {
        let mut at = entry;
        for _ in 0..map.star(entry.place).size() {
            let far = map.far_end(at).map(|far| far_slot(map, far, &mut entries, &mut numbers));
            let slot = map.star(at.place).slots()[at.slot.0 as usize];
            description.push((LargeSlot { opposite: counted(map, entry, slot.opposite), ..slot }, far));
            at = map.clockwise(at);
        }
        described += 1;
    }
    description
}

fn far_slot(
    map: &TopologicalMap,
    far: DstateId,
    entries: &mut Vec<DstateId>,
    numbers: &mut BTreeMap<PlaceId, usize>,
) -> (usize, SlotIndex) {
    let number = *numbers.entry(far.place).or_insert_with(|| {
        entries.push(far);
        entries.len() - 1
    });
    (number, counted(map, entries[number], far.slot))
}

/// A slot of the place of `entry`, counted clockwise from `entry`.
fn counted(map: &TopologicalMap, entry: DstateId, slot: SlotIndex) -> SlotIndex {
    let size = map.star(entry.place).size();
    SlotIndex(((slot.0 as usize + size - entry.slot.0 as usize) % size) as u8)
}
