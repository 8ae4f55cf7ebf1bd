//! A stay of the robot at a place, and whether it came in and left by the gateways that the place has.

use crate::geometry::{Point, wrap_angle};
use crate::grid::Cell;
use crate::lpm::Lpm;
use crate::sensor::ray_cast::cells_crossed;
use crate::star::{PerceptionParameters, PlaceDescription, describe};
use crate::visit::passage::passages;
use crate::visit::sighting::is_passage;
use crate::visit::{Moment, Visit};
use std::f64::consts::FRAC_PI_3;

/// A robot that leaves more than 60 degrees beside a gateway does not leave by it.
const SIDEWAYS: f64 = FRAC_PI_3;

/// A visit that is not told yet.
#[derive(Clone, Debug)]
pub(super) struct Stay {
    pub(super) visit: Visit,
    /// The first and the last moment at which the robot was near the middle.
    pub(super) inside: [Moment; 2],
    /// The distance from the middle to the nearest obstacle, metres.
    clearance: f64,
    /// Metres driven at the arrival and the departure of the visit on which the place was read, if that was another one.
    read: Option<[f64; 2]>,
}

impl Stay {
    /// At a place that was seen so around its middle; nothing if the robot left before it came. `way` is all that is known of its
    /// way.
    pub(super) fn new(
        middle: &Point,
        seen: &Lpm,
        way: &[Moment],
        inside: [Moment; 2],
        perception: &PerceptionParameters,
    ) -> Option<Stay> {
        let place = describe(seen, perception).ok()?;
        let scans = inside.map(|moment| moment.scan);
        let [arrival, departure] = passages(way, scans, middle, &place.gateways)?;
        let robot_pose = arrival.local_from_robot.seen_from(middle);
        let visit = Visit { center: *middle, lpm: Lpm { robot_pose, ..seen.clone() }, arrival, departure };
        let stay = Stay { visit, inside, clearance: place.clearance, read: None };
        (arrival.scan <= departure.scan).then_some(stay)
    }

    /// At the same place, as it was read then.
    pub(super) fn again(
        &self,
        way: &[Moment],
        inside: [Moment; 2],
        perception: &PerceptionParameters,
    ) -> Option<Stay> {
        let Visit { center, lpm, .. } = &self.visit;
        let again = Stay::new(center, lpm, way, inside, perception)?;
        Some(Stay { read: Some(self.read()), ..again })
    }

    fn read(&self) -> [f64; 2] {
        self.read.unwrap_or([self.visit.arrival.driven, self.visit.departure.driven])
    }

    /// Whether a moment was so near to those when the place was read that one of the two remembers the walls of the other.
    pub(super) fn is_remembered(&self, at: &Moment, memory: f64) -> bool {
        let [arrival, departure] = self.read();
        (arrival - memory..=departure + memory).contains(&at.driven)
    }

    /// All stretches of a way that are near the middle, in sight of it once at least.
    pub(super) fn stretches<'a>(&self, way: &'a [Moment], presence: f64) -> Vec<&'a [Moment]> {
        let off = |moment: &Moment| moment.local_from_robot.position() - self.visit.center.coords;
        let near = |moment: &Moment| off(moment).coords.norm() <= self.clearance + presence;
        let grid = &self.visit.lpm.grid;
        let in_sight = |moment: &Moment| {
            let mut between = cells_crossed(grid.info(), &off(moment), &Point::origin());
            between.all(|cell| grid.cell(cell) != Cell::Occupied)
        };
        let all = way.chunk_by(|a, b| near(a) == near(b)).filter(|stretch| near(&stretch[0]));
        all.filter(|stretch| stretch.iter().any(in_sight)).collect()
    }

    /// Whether the robot came in by a gateway and left by one, both in the LPM, and did not just go on along a path.
    pub(super) fn is_through(&self, perception: &PerceptionParameters) -> bool {
        let Visit { center, lpm, arrival, departure } = &self.visit;
        let seen = |moment: &Moment| {
            let off = moment.local_from_robot.position() - center.coords;
            lpm.grid.info().cell_at(&off).is_some()
        };
        let came = |place: &PlaceDescription| place.arrival.is_some() && !is_passage(place);
        let through = |place: &PlaceDescription| came(place) && self.is_left(place);
        seen(arrival) && seen(departure) && describe(lpm, perception).is_ok_and(|place| through(&place))
    }

    /// Whether the robot left the place, seen so, by a gateway.
    pub(super) fn is_left(&self, place: &PlaceDescription) -> bool {
        let out = self.visit.way_out();
        let gateway = place.outward_slot_toward(out).and_then(|slot| place.star.slot(slot)?.bearing);
        gateway.is_some_and(|bearing| wrap_angle(bearing - out).abs() <= SIDEWAYS)
    }

    /// Whether the robot was no longer near when it came to the other place, and had left this one when it left that.
    pub(super) fn is_over_before(&self, next: &Stay) -> bool {
        let [stay, then] = [self, next].map(|known| &known.visit);
        self.inside[1].scan <= then.arrival.scan
            && stay.arrival.scan < then.arrival.scan
            && stay.departure.scan < then.departure.scan
    }

    /// A stay that goes on until the end of the next, at the place as it is in one of them.
    pub(super) fn prolonged(&self, next: &Stay, seen: &Stay) -> Stay {
        let arrival = self.visit.arrival;
        let center = seen.visit.center;
        let robot_pose = arrival.local_from_robot.seen_from(&center);
        let lpm = Lpm { robot_pose, ..seen.visit.lpm.clone() };
        let visit = Visit { center, lpm, arrival, departure: next.visit.departure };
        Stay { visit, inside: [self.inside[0], next.inside[1]], ..seen.clone() }
    }
}
