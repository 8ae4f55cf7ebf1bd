//! Names of the things in one map.

use crate::star::SlotIndex;
use std::fmt;
use std::num::NonZeroU16;

/// A distinctive state: a place and a slot of its star, facing outward along the slot's directed path.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DstateId {
    /// The place it is at.
    pub place: PlaceId,
    /// The slot of the place's star it faces.
    pub slot: SlotIndex,
}

/// A place of a map, numbered from 0 by first visit.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PlaceId(NonZeroU16); // one more than the number: an absent dstate then costs no extra byte

/// A path segment of a map, numbered from 0 by its lower end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SegmentId(pub u32);

/// A path of a map, numbered from 0 by its lowest dstate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PathId(pub u32);

impl PlaceId {
    /// The place of the first observation.
    pub const FIRST: PlaceId = PlaceId(NonZeroU16::MIN);

    /// The most places a map may have.
    pub const LIMIT: usize = u16::MAX as usize;

    /// The place with a number below [`PlaceId::LIMIT`].
    pub fn new(index: usize) -> Option<PlaceId> {
        let next = u16::try_from(index.checked_add(1)?).ok()?;
        NonZeroU16::new(next).map(PlaceId)
    }

    /// All there may be, by number.
    pub(crate) fn all() -> impl Iterator<Item = PlaceId> {
        (0..u16::MAX).map(|number| PlaceId(NonZeroU16::MIN.saturating_add(number)))
    }

    /// Its number.
    pub fn index(self) -> usize {
        self.0.get() as usize - 1
    }
}

impl fmt::Display for PlaceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.index())
    }
}

impl fmt::Debug for PlaceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PlaceId({})", self.index())
    }
}

impl fmt::Display for DstateId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.place, self.slot.0)
    }
}

impl fmt::Debug for DstateId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DstateId({self})")
    }
}
