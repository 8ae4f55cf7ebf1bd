//! The JSON form of a star description.

use crate::star::{ControlLaw, Direction, FragmentId, GatewayId, Slot, SmallScaleStar};
use crate::trace::event_error::EventError;
use crate::trace::object;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A star description: directed path fragments, clockwise.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Star)]
#[serde(deny_unknown_fields)]
pub struct WireStar {
    /// The slots, clockwise.
    #[serde(deserialize_with = "object::list")]
    pub slots: Vec<WireSlot>,
}

/// A directed path fragment.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Slot)]
#[serde(deny_unknown_fields)]
pub struct WireSlot {
    /// The path fragment; each has exactly two slots.
    pub fragment: u32,
    /// The direction along it.
    pub direction: WireDirection,
    /// The outward-facing gateway, or null.
    pub out: Option<u32>,
    /// The inward-facing gateway, or null.
    #[serde(rename = "in")]
    pub inward: Option<u32>,
    /// How to travel away in this direction.
    pub control: WireControl,
    /// Outward direction in the frame of the observation, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<f64>,
    /// Width of the gateway, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// How far gateway and label are from being decided otherwise, as a fraction of the deciding threshold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
}

/// The direction along a path fragment.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Direction)]
pub enum WireDirection {
    /// `+`
    #[serde(rename = "+")]
    Plus,
    /// `-`
    #[serde(rename = "-")]
    Minus,
}

/// Control laws of the seed, section 4.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = ControlLaw)]
#[serde(rename_all = "snake_case")]
pub enum WireControl {
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

impl WireStar {
    /// The star, checked.
    pub fn star(self) -> Result<SmallScaleStar, EventError> {
        let slots = self.slots.into_iter().map(WireSlot::slot).collect();
        SmallScaleStar::new(slots).map_err(|error| EventError::new("/star/slots", error.to_string()))
    }

    /// The JSON form of a star.
    pub fn from_star(star: &SmallScaleStar) -> WireStar {
        WireStar { slots: star.slots().iter().map(WireSlot::from_slot).collect() }
    }
}

impl WireSlot {
    fn slot(self) -> Slot {
        Slot {
            fragment: FragmentId(self.fragment),
            direction: match self.direction {
                WireDirection::Plus => Direction::Plus,
                WireDirection::Minus => Direction::Minus,
            },
            outward: self.out.map(GatewayId),
            inward: self.inward.map(GatewayId),
            control: match self.control {
                WireControl::Midline => ControlLaw::Midline,
                WireControl::LeftWall => ControlLaw::LeftWall,
                WireControl::RightWall => ControlLaw::RightWall,
                WireControl::DeadEnd => ControlLaw::DeadEnd,
                WireControl::None => ControlLaw::None,
            },
            bearing: self.bearing,
            width: self.width,
            margin: self.margin,
        }
    }

    fn from_slot(slot: &Slot) -> WireSlot {
        WireSlot {
            fragment: slot.fragment.0,
            direction: slot.direction.into(),
            out: slot.outward.map(|g| g.0),
            inward: slot.inward.map(|g| g.0),
            control: slot.control.into(),
            bearing: slot.bearing,
            width: slot.width,
            margin: slot.margin,
        }
    }
}

impl From<Direction> for WireDirection {
    fn from(direction: Direction) -> WireDirection {
        match direction {
            Direction::Plus => WireDirection::Plus,
            Direction::Minus => WireDirection::Minus,
        }
    }
}

impl From<ControlLaw> for WireControl {
    fn from(control: ControlLaw) -> WireControl {
        match control {
            ControlLaw::Midline => WireControl::Midline,
            ControlLaw::LeftWall => WireControl::LeftWall,
            ControlLaw::RightWall => WireControl::RightWall,
            ControlLaw::DeadEnd => WireControl::DeadEnd,
            ControlLaw::None => WireControl::None,
        }
    }
}
