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

    /// The slots to the right of one who faces along `slot`, clockwise: those met before the opposite of `slot`
    /// (seed, section 4.3). Law: right of `slot` is left of its opposite, and the two sets and the two slots are
    /// the whole star.
    pub fn right_of(&self, slot: SlotIndex) -> impl Iterator<Item = SlotIndex> + use<'_> {
        let opposite = self.slots[slot.0 as usize].opposite;
        self.from(slot).skip(1).take_while(move |&next| next != opposite)
    }

    /// The slots to the left of one who faces along `slot`, clockwise: those met after the opposite of `slot`.
    pub fn left_of(&self, slot: SlotIndex) -> impl Iterator<Item = SlotIndex> + use<'_> {
        let opposite = self.slots[slot.0 as usize].opposite;
        self.from(slot).skip_while(move |&next| next != opposite).skip(1)
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

    /// All slots, clockwise from one of them.
    fn from(&self, slot: SlotIndex) -> impl Iterator<Item = SlotIndex> + use<'_> {
        let n = self.slots.len();
        (0..n).map(move |step| SlotIndex(((slot.0 as usize + step) % n) as u8))
    }

    /// All rotations under which `seen` lies on this star, ascending. A symmetric star has several.
    /// Quadratic in the number of slots.
    pub fn alignments(&self, seen: &LargeScaleStar) -> Vec<u8> {
        (0..self.slots.len() as u8).filter(|&rotation| self.matches(seen, rotation)).collect()
    }
}
