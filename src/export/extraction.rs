//! What was read off one grid, as JSON.

use crate::geometry::Point;
use crate::star::{PlaceDescription, Rejected};
use crate::trace::wire_star::WireStar;
use serde::Serialize;

/// Gateways and star of one LPM. Points and directions are in its frame, metres and radians.
#[derive(Clone, Debug, Serialize)]
pub struct Extraction {
    /// Which of the grids given, counted from 0.
    pub observation: usize,
    /// The star, clockwise from the slot on which the robot came in, else from the one it faces.
    pub star: WireStar,
    /// The slot on which the robot came in; null if its pose fits no gateway.
    pub arrival: Option<u8>,
    /// The outward slot nearest to the robot's heading.
    pub facing: u8,
    /// The gateways, numbered as in the star.
    pub gateways: Vec<ExtractedGateway>,
    /// Openings that the robot fits through and that are too narrow to be gateways.
    pub rejected: Vec<RejectedOpening>,
    /// The middle of the place.
    pub center: [f64; 2],
    /// Distance from the middle to the nearest obstacle.
    pub clearance: f64,
}

/// A gateway.
#[derive(Clone, Debug, Serialize)]
pub struct ExtractedGateway {
    /// Its number in the star.
    pub id: usize,
    /// Its middle.
    pub center: [f64; 2],
    /// The obstacles at its left and right end, facing outward.
    pub ends: [[f64; 2]; 2],
    /// Outward direction.
    pub bearing: f64,
    /// Clear width.
    pub width: f64,
    /// How far it is from not being one, as a fraction of the deciding threshold.
    pub margin: f64,
}

/// An opening that is no gateway.
#[derive(Clone, Debug, Serialize)]
pub struct RejectedOpening {
    /// Its middle.
    pub center: [f64; 2],
    /// The obstacles at its ends.
    pub ends: [[f64; 2]; 2],
    /// Clear width of the narrowest part of the way through it.
    pub passage: f64,
    /// How far it is from being a gateway, as a fraction of the passage width.
    pub margin: f64,
}

impl Extraction {
    /// The JSON form of a described place.
    pub fn of(observation: usize, place: &PlaceDescription, rejected: &[Rejected]) -> Extraction {
        let opening = |one: &Rejected| RejectedOpening {
            center: pair(&one.center),
            ends: one.ends.map(|end| pair(&end)),
            passage: one.passage,
            margin: one.margin,
        };
        let gateway = |(index, gateway): (usize, &crate::gateway::Gateway)| ExtractedGateway {
            id: index + 1,
            center: pair(&gateway.center),
            ends: gateway.ends.map(|end| pair(&end)),
            bearing: gateway.bearing,
            width: gateway.width,
            margin: gateway.margin,
        };
        Extraction {
            observation,
            star: WireStar::from_star(&place.star),
            arrival: place.arrival.map(|slot| slot.0),
            facing: place.facing.0,
            gateways: place.gateways.iter().enumerate().map(gateway).collect(),
            rejected: rejected.iter().map(opening).collect(),
            center: pair(&place.center),
            clearance: place.clearance,
        }
    }
}

fn pair(point: &Point) -> [f64; 2] {
    [point.x, point.y]
}
