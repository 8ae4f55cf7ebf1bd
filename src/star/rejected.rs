//! Openings around a place that are too narrow to be gateways.

use crate::geometry::Point;
use crate::grid::SkeletonParameters;
use crate::lpm::Lpm;
use crate::star::description::{PerceptionParameters, PlaceDescription, describe};

/// A robot fits where it has a cell of 5 cm to spare.
const TO_SPARE: f64 = 0.05;

/// An opening that the robot fits through and that is no gateway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejected {
    /// Its middle, LPM frame.
    pub center: Point,
    /// The obstacle points at its ends, LPM frame.
    pub ends: [Point; 2],
    /// Clear width of the narrowest part of the way through it, metres.
    pub passage: f64,
    /// How far it is from being a gateway: by how much it is narrower than the passage width, as a fraction of it.
    pub margin: f64,
}

/// The openings that a place would have for a robot that goes wherever it fits, into rooms as well, and that are no
/// gateways of it. Reads the place a second time; empty where that is another place, or where it cannot be read.
pub fn rejected(lpm: &Lpm, place: &PlaceDescription, parameters: &PerceptionParameters) -> Vec<Rejected> {
    let skeleton = parameters.skeleton;
    let passage_width = skeleton.robot_width + TO_SPARE;
    let room_ratio = skeleton.room_ratio.or(SkeletonParameters::for_doors().room_ratio);
    let thin = PerceptionParameters {
        skeleton: SkeletonParameters { passage_width, room_ratio, ..skeleton },
        ..*parameters
    };
    let there = Lpm { middle: Some(place.center), ..lpm.clone() };
    let Ok(seen) = describe(&there, &thin) else { return Vec::new() };
    if (seen.center - place.center).norm() > place.clearance {
        return Vec::new();
    }
    let known = |center: &Point, width: f64| {
        place.gateways.iter().any(|one| (one.center - center).norm() <= (one.width + width) / 2.0)
    };
    let narrow = seen.gateways.iter().filter(|one| one.passage < skeleton.passage_width);
    narrow
        .filter(|one| !known(&one.center, one.width))
        .map(|one| Rejected {
            center: one.center,
            ends: one.ends,
            passage: one.passage,
            margin: 1.0 - one.passage / skeleton.passage_width,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::worlds::drawing::{Drawing, window};

    /// A crossing of corridors, one arm of which is as wide as asked for.
    fn crossing(width: f64) -> (usize, Vec<Rejected>) {
        let plan = Drawing::new()
            .corridor((-12.0, 0.0), (12.0, 0.0), 2.0)
            .corridor((0.0, 0.0), (0.0, -12.0), 2.0)
            .corridor((0.0, 0.0), (0.0, 12.0), width);
        let grid = plan.render(&window(12.0, 0.05, Point::origin(), 0.0), &Point::origin()).unwrap();
        let lpm = Lpm::new(grid, Pose::new(0.0, 0.0, 0.1));
        let parameters = PerceptionParameters::default();
        let place = describe(&lpm, &parameters).unwrap();
        (place.gateways.len(), rejected(&lpm, &place, &parameters))
    }

    #[test]
    fn an_opening_too_narrow_is_told_by_how_much() {
        let (gateways, found) = crossing(0.8);
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!(gateways, 3);
        assert!((one.passage - 0.8).abs() < 0.11 && (one.margin - 0.27).abs() < 0.1, "{one:?}");
        assert!(one.center.y > 0.5 && one.center.x.abs() < 0.3, "{one:?}");
    }

    #[test]
    fn what_is_a_gateway_or_no_way_for_the_robot_is_not_rejected() {
        assert_eq!(crossing(1.6), (4, Vec::new()));
        assert_eq!(crossing(0.4), (3, Vec::new()));
    }
}
