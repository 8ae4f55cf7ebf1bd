//! The large-scale star: what two visits must agree on to be one place.

use crate::star::{ControlLaw, SlotIndex};
use std::fmt;

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

/// What two stars differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StarDifference {
    /// The number of slots.
    Size {
        /// Of this star.
        here: usize,
        /// Of the one seen.
        seen: usize,
    },
    /// A slot.
    Slot {
        /// The slot of this star.
        slot: SlotIndex,
        /// As it is here.
        here: LargeSlot,
        /// As it was seen.
        seen: LargeSlot,
    },
}

impl fmt::Display for StarDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            StarDifference::Size { here, seen } => write!(f, "it has {here} slots, and {seen} were seen"),
            StarDifference::Slot { slot, here, seen } if here.opposite != seen.opposite => write!(
                f,
                "its slot {} is on one path with slot {}, and was seen on one with slot {}",
                slot.0, here.opposite.0, seen.opposite.0
            ),
            StarDifference::Slot { slot, here, seen } => {
                write!(f, "its slot {} is {}, and was seen as {}", slot.0, Way(here), Way(seen))
            }
        }
    }
}

/// A slot in words.
struct Way(LargeSlot);

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let law = match self.0.control {
            ControlLaw::Midline => "a way along the middle",
            ControlLaw::LeftWall => "a way along the left wall",
            ControlLaw::RightWall => "a way along the right wall",
            ControlLaw::DeadEnd => "blocked",
            ControlLaw::None => "open without a way",
        };
        let leads = matches!(self.0.control, ControlLaw::DeadEnd | ControlLaw::None) != self.0.navigable;
        f.write_str(law)?;
        if leads {
            Ok(())
        } else if self.0.navigable {
            f.write_str(" with a gateway")
        } else {
            f.write_str(" without a gateway")
        }
    }
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

    /// What differs first when `seen` is turned by `rotation` slots onto this star, if anything does.
    pub fn difference(&self, seen: &LargeScaleStar, rotation: u8) -> Option<StarDifference> {
        let n = self.slots.len();
        if seen.slots.len() != n {
            return Some(StarDifference::Size { here: n, seen: seen.slots.len() });
        }
        let turned = |slot: usize| SlotIndex(((slot + rotation as usize) % n) as u8);
        seen.slots.iter().enumerate().find_map(|(j, slot)| {
            let mine = self.slots[turned(j).0 as usize];
            let theirs = LargeSlot { opposite: turned(slot.opposite.0 as usize), ..*slot };
            (mine != theirs).then_some(StarDifference::Slot { slot: turned(j), here: mine, seen: theirs })
        })
    }

    /// The same star listed from another slot of it on.
    #[must_use]
    pub fn listed_from(&self, first: SlotIndex) -> LargeScaleStar {
        let n = self.slots.len();
        let counted = |slot: SlotIndex| SlotIndex(((slot.0 as usize + n - first.0 as usize % n) % n) as u8);
        let slot = |j: usize| {
            let slot = self.slots[(j + first.0 as usize) % n];
            LargeSlot { opposite: counted(slot.opposite), ..slot }
        };
        LargeScaleStar { slots: (0..n).map(slot).collect() }
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
