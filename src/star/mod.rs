//! Star descriptions: the local topology of a place (seed, section 4.3). Metres stop here.
//!
//! A star lists the directed path fragments of a place **clockwise**. The small-scale star names gateways and
//! path fragments of one LPM and may carry bearings and widths; the large-scale star keeps only what the logic
//! compares: order, pairing, control laws and which slots can be travelled.

mod small_scale;
mod large_scale;
mod fragments;
mod projection;
mod control;
mod assembly;
mod description;
mod rejected;

pub use description::{DescribeError, FragmentTrace, PerceptionParameters, PlaceDescription, describe};
pub use fragments::FragmentParameters;
pub use large_scale::{LargeScaleStar, LargeSlot, StarDifference};
pub use rejected::{Rejected, rejected};
pub use small_scale::{
    ControlLaw, Direction, FragmentId, GatewayId, MAX_SLOTS, Slot, SlotIndex, SmallScaleStar, StarError,
};
