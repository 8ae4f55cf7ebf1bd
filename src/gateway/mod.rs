//! Gateways: the boundaries of a place neighbourhood (seed, section 4.2).
//!
//! A gateway's direction is outward, always; what faces inward is its opposite.

mod constriction;
mod detection;
mod place;
mod way;

pub use detection::{Neighborhood, find_gateways};

use crate::geometry::{Point, Vector, direction};

/// A constriction of free space between a place and what lies beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Gateway {
    /// The point of the skeleton at which the constriction was found, LPM frame.
    pub center: Point,
    /// The obstacle points at its left and right end, facing outward, LPM frame. Where a coast has no obstacle on
    /// one side, that end lies at the comfort distance.
    pub ends: [Point; 2],
    /// Outward direction, radians, LPM frame.
    pub bearing: f64,
    /// How far its ends and its centre may be from where they are read, metres: half the diagonal of a cell.
    pub read_error: f64,
    /// Clear width at the constriction, metres.
    pub width: f64,
    /// Clear width of the narrowest part of the way out, metres.
    pub passage: f64,
    /// How far the gateway is from not being one: by how much the narrowest part of its way out is wider than the
    /// passage width, as a fraction of it.
    pub margin: f64,
    /// The way out from the gateway's centre along the skeleton, LPM frame.
    pub beyond: Vec<Beyond>,
}

/// A point of the way out beyond a gateway and which walls are close enough to follow there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// The point, LPM frame.
    pub at: Point,
    /// Whether there is a wall on the left within the comfort distance.
    pub left: bool,
    /// Whether there is a wall on the right within the comfort distance.
    pub right: bool,
    /// Distance to the nearest obstacle, metres.
    pub clearance: f64,
}

impl Gateway {
    /// The unit vector that points outward.
    pub fn outward(&self) -> Vector {
        direction(self.bearing)
    }

    /// How far the bearing may be off, radians: as far as the line between the ends turns when both are read wrong, which is
    /// taken for that of a way with one wall, too. On drawn forks that lie anyhow on the grid, one bearing in a hundred is off by as much.
    pub fn bearing_error(&self) -> f64 {
        let [left, right] = self.ends;
        (2.0 * self.read_error / (left - right).norm()).min(1.0)
    }
}

/// What makes a place and a gateway, metres. One set of defaults serves all grids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatewayParameters {
    /// How much a way must narrow for a constriction; never less than one cell counts. Default 0.08.
    pub constriction_depth: f64,
    /// The least distance over which a way must stay as narrow as at the gateway; scaled up with the width by
    /// 0.6 of the clearance. Default 1.
    pub look_ahead: f64,
    /// Over which length beyond a gateway its direction is measured. Default 2.
    pub direction_length: f64,
    /// How far outside the circle of clearance of a place the robot may be on arrival. Default 3.
    pub place_reach: f64,
    /// How far a way between two exits must swing out from their chord to be a bend, a place. Default 1.2.
    pub bend: f64,
    /// Where a way does not narrow at all, its gateway lies this far outside the circle of clearance of the place.
    /// Default 1.
    pub cap: f64,
}

impl Default for GatewayParameters {
    fn default() -> Self {
        GatewayParameters {
            constriction_depth: 0.08,
            look_ahead: 1.0,
            direction_length: 2.0,
            place_reach: 3.0,
            bend: 1.2,
            cap: 1.0,
        }
    }
}
