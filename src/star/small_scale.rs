//! The small-scale star: path fragments and gateways of one LPM, clockwise.

use crate::star::{LargeScaleStar, LargeSlot};
use std::collections::BTreeMap;
use thiserror::Error;

/// The most slots a star may have, so that a slot fits a byte.
pub const MAX_SLOTS: usize = 254;

/// A path fragment of one star.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FragmentId(pub u32);

/// A gateway of one star.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GatewayId(pub u32);

/// A position in the clockwise order of a star.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SlotIndex(pub u8);

/// One of the two directions along a path fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// `+`
    Plus,
    /// `-`
    Minus,
}

/// How the robot travels away from the place along a directed path fragment (seed, section 4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ControlLaw {
    /// Between two walls.
    Midline,
    /// Along a wall on the left.
    LeftWall,
    /// Along a wall on the right.
    RightWall,
    /// The way is blocked.
    DeadEnd,
    /// Too far from any obstacle for a control law.
    None,
}

/// A directed path fragment.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// The path fragment.
    pub fragment: FragmentId,
    /// The direction along it.
    pub direction: Direction,
    /// The gateway that faces outward, if the fragment leaves the place in this direction.
    pub outward: Option<GatewayId>,
    /// The gateway that faces inward, if the fragment enters the place in this direction.
    pub inward: Option<GatewayId>,
    /// How to travel away in this direction.
    pub control: ControlLaw,
    /// Outward direction in the frame of the observation, radians.
    pub bearing: Option<f64>,
    /// Width of the outward gateway, or of the inward one where there is no outward one, metres.
    pub width: Option<f64>,
    /// How far gateway and label are from being decided otherwise, as a fraction of the deciding threshold.
    pub margin: Option<f64>,
}

/// Why a star was refused; slots are counted from 0.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum StarError {
    /// No slots at all.
    #[error("the star has no slots, expected at least one path fragment")]
    Empty,
    /// More than [`MAX_SLOTS`].
    #[error("the star has {0} slots, expected at most {MAX_SLOTS}")]
    TooManySlots(usize),
    /// A fragment does not have exactly the slots + and -.
    #[error("fragment {0} has {1}, expected exactly two slots, one + and one -")]
    FragmentSlots(u32, String),
    /// A gateway faces outward on two slots.
    #[error(
        "gateway {0} is outward on slots {1} and {2}, expected each gateway on exactly one path fragment"
    )]
    SharedGateway(u32, usize, usize),
    /// The inward gateway of a slot is not the outward gateway of its opposite direction.
    #[error(
        "slot {slot} has inward gateway {found}, expected {expected}: what faces inward in one direction faces outward in the other direction of the same fragment"
    )]
    InwardMismatch {
        /// The slot at fault.
        slot: usize,
        /// Its inward gateway.
        found: String,
        /// The outward gateway of its opposite slot.
        expected: String,
    },
    /// A fragment without any gateway.
    #[error("fragment {0} has no gateway, expected one or two")]
    NoGateway(u32),
    /// A metric annotation that is not finite.
    #[error("slot {0} has a bearing, width or margin that is not finite, or a negative width or margin")]
    NotFinite(usize),
}

/// The star description of one LPM: slots in clockwise order.
///
/// Laws, checked on construction: at least one slot; every fragment has exactly the two slots `+` and `-`, not
/// necessarily antipodal; every fragment has one or two gateways; every gateway lies on exactly one fragment,
/// outward in one direction and inward in the other.
#[derive(Clone, Debug, PartialEq)]
pub struct SmallScaleStar {
    slots: Vec<Slot>,
    opposite: Vec<SlotIndex>,
}

impl SmallScaleStar {
    /// A star from its slots in clockwise order.
    pub fn new(slots: Vec<Slot>) -> Result<Self, StarError> {
        if slots.is_empty() {
            return Err(StarError::Empty);
        }
        if slots.len() > MAX_SLOTS {
            return Err(StarError::TooManySlots(slots.len()));
        }
        let opposite = pair_slots(&slots)?;
        check_gateways(&slots, &opposite)?;
        Ok(SmallScaleStar { slots, opposite })
    }

    /// The slots, clockwise.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// The slot at an index, if in range.
    pub fn slot(&self, index: SlotIndex) -> Option<&Slot> {
        self.slots.get(index.0 as usize)
    }

    /// The slot of the other direction of the same fragment. The index must be in range.
    pub fn opposite(&self, index: SlotIndex) -> SlotIndex {
        self.opposite[index.0 as usize]
    }

    /// All slot indices in range, clockwise.
    pub fn indices(&self) -> impl Iterator<Item = SlotIndex> + use<> {
        (0..self.slots.len() as u8).map(SlotIndex)
    }

    /// What the logic compares: order, pairing, control laws and navigability, without names and metres.
    pub fn large_scale(&self) -> LargeScaleStar {
        let slot = |(slot, &opposite): (&Slot, &SlotIndex)| LargeSlot {
            control: slot.control,
            navigable: slot.outward.is_some(),
            opposite,
        };
        LargeScaleStar::new(self.slots.iter().zip(&self.opposite).map(slot).collect())
    }
}

fn pair_slots(slots: &[Slot]) -> Result<Vec<SlotIndex>, StarError> {
    let mut by_fragment: BTreeMap<FragmentId, Vec<usize>> = BTreeMap::new();
    for (index, slot) in slots.iter().enumerate() {
        by_fragment.entry(slot.fragment).or_default().push(index);
    }
    let mut opposite = vec![SlotIndex(0); slots.len()];
    for (fragment, indices) in by_fragment {
        match indices[..] {
            [a, b] if slots[a].direction != slots[b].direction => {
                opposite[a] = SlotIndex(b as u8);
                opposite[b] = SlotIndex(a as u8);
            }
            [_, _] => return Err(StarError::FragmentSlots(fragment.0, "twice the same direction".into())),
            _ => return Err(StarError::FragmentSlots(fragment.0, format!("{} slots", indices.len()))),
        }
    }
    Ok(opposite)
}

fn check_gateways(slots: &[Slot], opposite: &[SlotIndex]) -> Result<(), StarError> {
    let mut seen: BTreeMap<GatewayId, usize> = BTreeMap::new();
    for (index, slot) in slots.iter().enumerate() {
        if let Some(gateway) = slot.outward
            && let Some(other) = seen.insert(gateway, index)
        {
            return Err(StarError::SharedGateway(gateway.0, other, index));
        }
        let expected = slots[opposite[index].0 as usize].outward;
        if slot.inward != expected {
            return Err(StarError::InwardMismatch {
                slot: index,
                found: name(slot.inward),
                expected: name(expected),
            });
        }
        if slot.inward.is_none() && slot.outward.is_none() {
            return Err(StarError::NoGateway(slot.fragment.0));
        }
        let sizes = [slot.width, slot.margin].into_iter().flatten();
        if slot.bearing.is_some_and(|bearing| !bearing.is_finite())
            || sizes.into_iter().any(|v| !(v >= 0.0 && v.is_finite()))
        {
            return Err(StarError::NotFinite(index));
        }
    }
    Ok(())
}

fn name(gateway: Option<GatewayId>) -> String {
    gateway.map_or_else(|| "null".into(), |g| g.0.to_string())
}
