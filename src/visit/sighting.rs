//! What the robot's surroundings look like from a point of its way.

use crate::geometry::Point;
use crate::star::{PerceptionParameters, PlaceDescription, describe};
use crate::visit::Moment;
use crate::visit::follower::Follower;

/// A point of the way, and the place seen there, if it is not just a way on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    pub(super) moment: Moment,
    pub(super) place: Option<Seen>,
}

/// A place as seen from a point of the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Its middle, local frame.
    pub(super) center: Point,
    /// The distance from there to the nearest obstacle, metres.
    pub(super) clearance: f64,
}

/// Judges the surroundings of a moment by what is known of them now.
pub(super) fn look(moment: Moment, follower: &Follower, perception: &PerceptionParameters) -> Sighting {
    let at = moment.local_from_robot;
    let place = follower
        .lpm(&at.position(), &at)
        .and_then(|lpm| describe(&lpm, perception).ok())
        .filter(|place| !is_passage(place))
        .map(|place| Seen { center: at.position() + place.center.coords, clearance: place.clearance });
    Sighting { moment, place }
}

/// Whether a place is none: a path leads through, and there is nothing else.
pub(super) fn is_passage(place: &PlaceDescription) -> bool {
    place.gateways.len() == 2 && place.fragments.len() == 1
}
