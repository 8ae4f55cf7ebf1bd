//! What places look like when they are seen again: their stars and their walls.

use crate::{ACES_PLACES, found_visits, logs};
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};
use topostar::geometry::{Point, Pose};
use topostar::mending::{Bounds, Doubt, mend_longest, readings};
use topostar::metric::{Measurements, MetricParameters};
use topostar::patchwork::agreement::{Neighbourhood, Walls};
use topostar::patchwork::survey::Survey;
use topostar::sensor::LaserScan;
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};
use topostar::trace::Event;
use topostar::trace::recording::Recorder;
use topostar::visit::Stage;

/// The place of each visit to a building in which nobody has marked them: the frame of scan matching drifts by less than two
/// places are apart, so that visits near to each other in it are to one place.
fn places(stages: &[Stage]) -> Vec<usize> {
    let mut centers: Vec<Point> = Vec::new();
    let mut place = |stage: &Stage| {
        let center = stage.visit.center;
        let known = centers.iter().position(|other| (other - center).norm() < 2.5);
        known.unwrap_or_else(|| {
            centers.push(center);
            centers.len() - 1
        })
    };
    stages.iter().map(&mut place).collect()
}

/// Where the raster lies decides much in such a building, so each log is looked at as often, turned by so much more.
const LAYINGS: u32 = 6;
const TURNED: f64 = 0.7;

/// The visits that are found in the logs of two cluttered buildings, for each laying.
static CLUTTERED: LazyLock<[Log; 2]> =
    LazyLock::new(|| ["mit-csail", "fr079"].map(|name| (name, layings(name))));

/// A log's name, and its visits in each laying.
type Log = (&'static str, Vec<Vec<Stage>>);

fn layings(name: &str) -> Vec<Vec<Stage>> {
    let scans = logs::scans(name);
    let found = |k: u32| {
        let frame = Pose::new(0.0, 0.0, f64::from(k) * TURNED);
        let turned = |scan: &LaserScan| LaserScan {
            odom_from_robot: frame.compose(&scan.odom_from_robot),
            ..scan.clone()
        };
        found_visits(&scans.iter().map(turned).collect::<Vec<_>>())
    };
    (0..LAYINGS).map(found).collect()
}

/// Visits, those to a place seen before, and those of them that have the star of the visit before, in all layings.
#[test]
fn places_of_cluttered_buildings_are_found_again() {
    for ((name, layings), least) in CLUTTERED.iter().zip([[175, 50, 35], [140, 62, 50]]) {
        let mut found = [0; 3];
        for stages in layings {
            let mut last: BTreeMap<usize, LargeScaleStar> = BTreeMap::new();
            for (Stage { visit, .. }, place) in stages.iter().zip(places(stages)) {
                let star = describe(&visit.lpm, &PerceptionParameters::default()).unwrap().star.large_scale();
                let before = last.insert(place, star.clone());
                found[0] += 1;
                found[1] += usize::from(before.is_some());
                found[2] += usize::from(before.is_some_and(|before| !before.alignments(&star).is_empty()));
            }
        }
        println!("{name}: {} visits, {} again, {} alike", found[0], found[1], found[2]);
        assert!(found.iter().zip(least).all(|(found, least)| *found >= least), "{name}: {found:?}");
    }
}

/// How far changing doubtful readings leads where no map explains them as they are: observations explained in all layings.
#[test]
fn doubtful_readings_of_cluttered_buildings_are_mended_as_far_as_they_go() {
    let aces = mended("aces", &found_visits(&logs::scans("aces")));
    assert_eq!(aces, [15, 15]);
    for ((name, layings), least) in CLUTTERED.iter().zip([[55, 125], [14, 68]]) {
        let all = layings.iter().map(|stages| mended(name, stages));
        let sum = all.fold([0; 2], |sum, found| [sum[0] + found[0], sum[1] + found[1]]);
        println!("{name}: {sum:?} as read and with changes, in {LAYINGS} layings");
        assert!(sum[0] >= least[0] && sum[1] >= least[1], "{name}: {sum:?}");
    }
}

/// How many observations are explained as they were read, and with doubtful readings changed.
fn mended(name: &str, stages: &[Stage]) -> [usize; 2] {
    let mut recorder = Recorder::default();
    let events: Vec<Event> = stages.iter().cloned().flat_map(|stage| recorder.add(stage)).collect();
    let readings = readings(&events, &PerceptionParameters::default()).unwrap();
    let axioms = AxiomSet::of(Profile::Default);
    let (mut abduction, mut measured) = (Abduction::new(axioms, Limits::default()), Measurements::default());
    for reading in &readings {
        measured = measured.with(&reading.sighting);
        abduction.observe_measured(&Visit::from(&reading.sighting), measured.evidence()).unwrap();
    }
    let widths = abduction.report().candidates_per_observation;
    let as_read = widths.iter().filter(|count| count.value > 0).count();
    let found = mend_longest(&readings, axioms, Bounds::default());
    println!(
        "{name}: {as_read} of {} as read, {} from {} on with {:?}",
        readings.len(),
        found.explained,
        found.first,
        found.changes
    );
    assert!(found.changes.iter().all(|one| one.doubt <= Doubt::LIMIT), "{name}");
    let unchanged = found.first > 0 || as_read == found.explained;
    assert!(found.changes.is_empty() <= unchanged, "{name}");
    [as_read, found.explained]
}

/// How often the walls of two visits lie on each other: of all pairs that may be one place by the number of slots, those
/// that are, under whichever rotation; and those that are not, under each. A visit that shows what one before did is not
/// counted.
#[test]
fn walls_tell_places_apart() {
    let (mut one, mut two) = ([0; 2], [0; 2]);
    for name in ["aces", "mit-csail", "fr079"] {
        let stages = found_visits(&logs::scans(name));
        let places = if name == "aces" { ACES_PLACES.to_vec() } else { places(&stages) };
        let shown =
            |visit: usize| stages[..visit].iter().any(|s| s.visit.lpm.grid == stages[visit].visit.lpm.grid);
        let read: Vec<usize> = (0..stages.len()).filter(|&visit| !shown(visit)).collect();
        let mut recorder = Recorder::default();
        let events = stages.iter().cloned().flat_map(|stage| recorder.add(stage)).map(Arc::new);
        let survey = Survey::of(&events.collect::<Vec<_>>()).unwrap();
        let shows: Vec<Neighbourhood> =
            (0..survey.len()).map(|visit| survey.neighbourhood(visit, &|| false).unwrap()).collect();
        let (mut right, mut wrong) = ([0; 2], [0; 2]);
        let pairs = (0..read.len()).flat_map(|k| (0..k).map(move |l| (k, l)));
        for (later, first) in pairs.map(|(k, l)| (read[k], read[l])) {
            let alike = alike(&shows[first], &shows[later]);
            if alike.is_empty() {
                continue;
            }
            let lie_on = alike.iter().filter(|alike| **alike).count();
            match places[first] == places[later] {
                true => right = [right[0] + usize::from(lie_on > 0), right[1] + 1],
                false => wrong = [wrong[0] + lie_on, wrong[1] + alike.len()],
            }
        }
        println!("{name}: walls alike in {right:?} of one place, in {wrong:?} of two");
        one = [one[0] + right[0], one[1] + right[1]];
        two = [two[0] + wrong[0], two[1] + wrong[1]];
    }
    assert!(one[0] * 20 >= one[1] * 17 && two[0] * 100 <= two[1], "{one:?} {two:?}");
}

/// Whether the walls of two visits lie on each other, for each rotation of the one star to the other; none where the stars
/// have not as many slots.
fn alike(first: &Neighbourhood, later: &Neighbourhood) -> Vec<bool> {
    let MetricParameters { extent_sigma, bearing_sigma, .. } = MetricParameters::default();
    let slots = first.bearings.len();
    let alike = |rotation| {
        let agreement = first.agreement(later, rotation, [extent_sigma, bearing_sigma], &|| false);
        agreement.is_some_and(|agreement| agreement.walls == Walls::Alike)
    };
    if later.bearings.len() == slots { (0..slots).map(alike).collect() } else { Vec::new() }
}
