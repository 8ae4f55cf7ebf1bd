//! The large-scale star: what two visits must agree on to be one place.

use crate::star::{ControlLaw, SlotIndex};

/// A slot of the large-scale star: a distinctive state of the place, facing outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LargeSlot {
    /// How to travel away in this direction.
    pub control: ControlLaw,
    /// Whether an outward gateway exists.
    pub navigable: bool,
    /// The slot of the other direction of the same path.
    pub opposite: SlotIndex,
}

/// The circular order of directed paths at a place, clockwise (seed, Figures 3(c) and 3(f)).
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LargeScaleStar {
    slots: Vec<LargeSlot>,
}

impl LargeScaleStar {
    /// Only [`super::SmallScaleStar`] makes stars, so that pairing is known to be an involution.
    pub(super) fn new(slots: Vec<LargeSlot>) -> Self {
        LargeScaleStar { slots }
    }

    /// The slots, clockwise.
    pub fn slots(&self) -> &[LargeSlot] {
        &self.slots
    }

    /// The number of slots, which is the number of distinctive states of the place.
    pub fn size(&self) -> usize {
        self.slots.len()
    }

    /// The number of path fragments.
    pub fn fragments(&self) -> usize {
        self.slots.len() / 2
    }

    /// Whether turning `seen` by `rotation` slots lays it onto this star with order, pairing, control laws and
    /// navigability kept: slot `j` of `seen` is slot `(j + rotation) mod n` of `self`.
    pub fn matches(&self, seen: &LargeScaleStar, rotation: u8) -> bool {
        let n = self.slots.len();
        if seen.slots.len() != n {
            return false;
        }
        let turned = |slot: SlotIndex| SlotIndex(((slot.0 as usize + rotation as usize) % n) as u8);
        seen.slots.iter().enumerate().all(|(j, slot)| {
            let mine = self.slots[(j + rotation as usize) % n];
            mine == LargeSlot { opposite: turned(slot.opposite), ..*slot }
        })
    }

    /// All rotations under which `seen` lies on this star, ascending. A symmetric star has several.
    /// Quadratic in the number of slots.
    pub fn alignments(&self, seen: &LargeScaleStar) -> Vec<u8> {
        (0..self.slots.len() as u8).filter(|&rotation| self.matches(seen, rotation)).collect()
    }
}
