//! The places of the ACES building as the robot saw them on each visit.

use crate::maps::data;
use bzip2::read::MultiBzDecoder;
use std::fs::{self, File};
use std::io::BufReader;
use topostar::lpm::Lpm;
use topostar::sensor::CarmenLog;
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};
use topostar::trace::recording::{Arrival, RecordingParameters, cut};
use topostar::trace::{EventKind, Percept};

/// A visit: the place's name, and what was seen.
pub(super) struct Visit {
    pub(super) place: String,
    pub(super) lpm: Lpm,
}

/// The 15 visits of the log.
pub(super) fn load() -> Vec<Visit> {
    let file = File::open(data("logs/aces.clf.bz2")).unwrap();
    let log = CarmenLog::read(BufReader::new(MultiBzDecoder::new(file))).unwrap();
    let list = fs::read_to_string(data("logs/aces-visits.csv")).unwrap();
    let arrivals = Arrival::read_csv(&list).unwrap();
    let mut way = None;
    let mut lpms = Vec::new();
    for event in cut(&log.scans, &arrivals, &RecordingParameters::default()).unwrap() {
        match event.kind {
            EventKind::Travel(travel) => way = Some(travel),
            EventKind::Observation(seen) => {
                let Percept::Lpm(lpm) = seen.percept else { panic!("an observation without a grid") };
                let trail = way.take().map(|way| way.trail(&lpm.robot_pose)).unwrap_or_default();
                lpms.push(Lpm { trail, ..lpm });
            }
            _ => {}
        }
    }
    arrivals.into_iter().zip(lpms).map(|(arrival, lpm)| Visit { place: arrival.place, lpm }).collect()
}

pub(super) fn stars(visits: &[Visit], parameters: &PerceptionParameters) -> Vec<Option<LargeScaleStar>> {
    visits
        .iter()
        .map(|visit| describe(&visit.lpm, parameters).ok().map(|place| place.star.large_scale()))
        .collect()
}

/// How many stars have as many gateways and through paths as a person sees in the map of the building: crossings in
/// the middle and where the lobbies open, a T in the west and the east, and corners.
pub(super) fn as_seen(visits: &[Visit], stars: &[Option<LargeScaleStar>]) -> usize {
    let right = |(visit, star): (&Visit, &Option<LargeScaleStar>)| {
        let wanted = match visit.place.as_str() {
            "N" | "S" | "C" => (4, 2),
            "E" | "W" => (3, 1),
            _ => (2, 0),
        };
        star.as_ref().is_some_and(|star| shape(star) == wanted)
    };
    visits.iter().zip(stars).filter(|&pair| right(pair)).count()
}

/// How many visits have a star that lies on that of every other visit to the same place.
pub(super) fn alike(visits: &[Visit], stars: &[Option<LargeScaleStar>]) -> usize {
    let same = |k: usize| {
        let others = (0..visits.len()).filter(|&j| j != k && visits[j].place == visits[k].place);
        others.map(|j| same_star(&stars[k], &stars[j])).all(|same| same)
    };
    (0..visits.len()).filter(|&k| same(k)).count()
}

pub(super) fn same_star(a: &Option<LargeScaleStar>, b: &Option<LargeScaleStar>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => !a.alignments(b).is_empty(),
        _ => false,
    }
}

/// Gateways, and paths that go through.
fn shape(star: &LargeScaleStar) -> (usize, usize) {
    let gateways = star.slots().iter().filter(|slot| slot.navigable).count();
    let through = |slot: &&topostar::star::LargeSlot| {
        slot.navigable && star.slots()[slot.opposite.0 as usize].navigable
    };
    (gateways, star.slots().iter().filter(through).count() / 2)
}
