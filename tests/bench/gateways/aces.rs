//! The places of the ACES building as the robot saw them on each visit.

use crate::maps::data;
use bzip2::read::MultiBzDecoder;
use std::fs::{self, File};
use std::io::BufReader;
use topostar::export::Mark;
use topostar::lpm::Lpm;
use topostar::sensor::LaserScan;
use topostar::sensor::log::{LogOptions, carmen_scans};
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};
use topostar::trace::recording::Arrival;
use topostar::visit::{AnnotatedVisits, Stage, VisitParameters};

/// A visit: the place's name, and what was seen.
pub(super) struct Visit {
    pub(super) place: String,
    pub(super) lpm: Lpm,
}

/// The scans of a recorded log.
pub(super) fn scans(name: &str) -> Vec<LaserScan> {
    let file = File::open(data(&format!("logs/{name}.clf.bz2"))).unwrap();
    let log = BufReader::new(MultiBzDecoder::new(file));
    let (scans, fault) = carmen_scans(log, LogOptions::default()).read_all();
    assert!(fault.is_none(), "{fault:?}");
    scans
}

/// The true arrivals.
pub(super) fn marks() -> Vec<Mark> {
    let list = fs::read_to_string(data("logs/aces-visits.csv")).unwrap();
    let arrivals = Arrival::read_csv(&list).unwrap().into_iter();
    arrivals.map(|Arrival { place, scan }| Mark { place, scan }).collect()
}

/// The 15 visits of the log, at the arrivals that the list marks.
pub(super) fn load() -> Vec<Visit> {
    let (scans, marks) = (scans("aces"), marks());
    let arrivals = marks.iter().map(|mark| mark.scan).collect();
    let mut visits = AnnotatedVisits::new(arrivals, &VisitParameters::default()).unwrap();
    let mut stages: Vec<Stage> = scans.iter().filter_map(|scan| visits.add(scan)).collect();
    stages.extend(visits.finish().0);
    let visit = |(mark, stage): (Mark, Stage)| Visit { place: mark.place, lpm: stage.visit.lpm };
    marks.into_iter().zip(stages).map(visit).collect()
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
        let mut others = (0..visits.len()).filter(|&j| j != k && visits[j].place == visits[k].place);
        others.all(|j| same_star(&stars[k], &stars[j]))
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
