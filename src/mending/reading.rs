//! What was read on each visit of a trace, and what was nearly read.

use crate::geometry::bearing;
use crate::lpm::Lpm;
use crate::mending::Doubt;
use crate::star::{
    PerceptionParameters, PlaceDescription, Rejected, SlotIndex, SmallScaleStar, describe, rejected,
};
use crate::trace::perceive::perceive;
use crate::trace::{Event, Experience, ExperienceError, Sighting};
use std::borrow::Borrow;
use std::cell::RefCell;

/// A visit as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The star, and what was measured.
    pub sighting: Sighting,
    /// The openings that are no gateways.
    pub openings: Vec<Opening>,
    /// The slots whose outward gateway is too narrow for one, and is one because the robot was seen going through.
    pub driven: Vec<SlotIndex>,
    /// Whether the place was found by perception, which may pass another one by.
    pub found: bool,
}

/// An opening that the robot fits through and that was not read as a gateway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Its direction from the middle of the place in the frame of the observation, radians.
    pub bearing: f64,
    /// Clear width of the narrowest part of the way through it, metres.
    pub width: f64,
    /// How much narrower it is than a way must be; `None` where that is no matter of doubt.
    pub doubt: Option<Doubt>,
}

impl Reading {
    /// A star that was given, of which nothing more is known.
    pub fn bare(sighting: Sighting) -> Reading {
        Reading { sighting, openings: Vec::new(), driven: Vec::new(), found: false }
    }

    fn seen(sighting: Sighting, lpm: &Lpm, parameters: &PerceptionParameters) -> Reading {
        let bare = Reading { found: true, ..Reading::bare(sighting) };
        let Ok(place) = describe(lpm, parameters) else { return bare };
        let narrow = rejected(lpm, &place, parameters);
        let openings = narrow.iter().map(|one| Opening::of(one, &place)).collect();
        let driven = driven(&bare.sighting.star, &place, parameters.skeleton.passage_width);
        Reading { openings, driven, ..bare }
    }
}

impl Opening {
    fn of(one: &Rejected, place: &PlaceDescription) -> Opening {
        let bearing = bearing(&(one.center - place.center));
        Opening { bearing, width: one.passage, doubt: Doubt::of(one.margin) }
    }
}

/// Slots whose way out is narrower than a way must be.
fn driven(star: &SmallScaleStar, place: &PlaceDescription, passage_width: f64) -> Vec<SlotIndex> {
    let narrow = |slot: &SlotIndex| {
        let gateway = star.slot(*slot)?.outward?;
        place.gateways.get((gateway.0 as usize).checked_sub(1)?)
    };
    star.indices().filter(|slot| narrow(slot).is_some_and(|one| one.passage < passage_width)).collect()
}

/// The readings of all observations among the events of a trace of stars or grids. Costs two or three descriptions of
/// each LPM.
pub fn readings(
    events: &[impl Borrow<Event>],
    parameters: &PerceptionParameters,
) -> Result<Vec<Reading>, ExperienceError> {
    let latest: RefCell<Option<Lpm>> = RefCell::new(None);
    let look = |lpm: &Lpm, first| {
        latest.replace(Some(lpm.clone()));
        perceive(lpm, first, parameters)
    };
    let mut experience = Experience::new();
    let mut readings = Vec::new();
    for event in events {
        let Some(sighting) = experience.accept(event.borrow(), &look)? else { continue };
        readings.push(match latest.take() {
            Some(lpm) => Reading::seen(sighting, &lpm, parameters),
            None => Reading::bare(sighting),
        });
    }
    Ok(readings)
}
