//! Gateways: the boundaries of a place neighbourhood (seed, section 4.2).
//!
//! A gateway's direction is outward, always; what faces inward is its opposite.

use crate::geometry::Point;

/// A constriction of free space between a place and what lies beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Gateway {
    /// The point of the skeleton at which the constriction was found, LPM frame.
    pub center: Point,
    /// The obstacle points at its left and right end, facing outward, LPM frame.
    pub ends: [Point; 2],
    /// Outward direction, radians, LPM frame.
    pub bearing: f64,
    /// Clear width at the constriction, metres.
    pub width: f64,
    /// How far the gateway is from not being one, as a fraction of the deciding threshold.
    pub margin: f64,
}
