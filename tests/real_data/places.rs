//! What places look like when they are seen again: their stars and their walls.

use crate::{ACES_PLACES, found_visits, logs};
use std::sync::Arc;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};
use topostar::geometry::Point;
use topostar::mending::{Bounds, Doubt, mend_longest, readings};
use topostar::metric::{Measurements, MetricParameters};
use topostar::patchwork::agreement::{Neighbourhood, Walls};
use topostar::patchwork::survey::Survey;
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

#[test]
fn places_of_cluttered_buildings_are_found_again() {
    for (name, least, revisited, alike) in [("mit-csail", 28, 6, 3), ("fr079", 20, 4, 2)] {
        let stages = found_visits(&logs::scans(name));
        let places = places(&stages);
        let count = places.iter().max().map_or(0, |last| last + 1);
        let mut stars: Vec<Vec<LargeScaleStar>> = vec![Vec::new(); count];
        for (Stage { visit, .. }, place) in stages.iter().zip(places) {
            let star = describe(&visit.lpm, &PerceptionParameters::default()).unwrap().star;
            stars[place].push(star.large_scale());
        }
        let again: Vec<_> = stars.iter().filter(|stars| stars.len() > 1).collect();
        let equal = |stars: &[LargeScaleStar]| stars.iter().all(|star| !stars[0].alignments(star).is_empty());
        let same = again.iter().filter(|stars| equal(stars)).count();
        println!("{name}: {} visits, {count} places, {} seen again, {same} alike", stages.len(), again.len());
        assert!(stages.len() >= least && again.len() >= revisited && same >= alike, "{name}");
    }
}

/// How far changing doubtful readings leads where no map explains them as they are.
#[test]
fn doubtful_readings_of_cluttered_buildings_are_mended_as_far_as_they_go() {
    for (name, as_read, least) in [("aces", 15, 15), ("mit-csail", 13, 18), ("fr079", 2, 8)] {
        let mut recorder = Recorder::default();
        let stages = found_visits(&logs::scans(name)).into_iter();
        let events: Vec<Event> = stages.flat_map(|stage| recorder.add(stage)).collect();
        let readings = readings(&events, &PerceptionParameters::default()).unwrap();
        let axioms = AxiomSet::of(Profile::Default);
        let (mut abduction, mut measured) =
            (Abduction::new(axioms, Limits::default()), Measurements::default());
        for reading in &readings {
            measured = measured.with(&reading.sighting);
            abduction.observe_measured(&Visit::from(&reading.sighting), measured.evidence()).unwrap();
        }
        let widths = abduction.report().candidates_per_observation;
        assert_eq!(widths.iter().filter(|count| count.value > 0).count(), as_read, "{name}");
        let found = mend_longest(&readings, axioms, Bounds::default());
        println!(
            "{name}: {as_read} of {} as read, {} from {} on with {:?}",
            readings.len(),
            found.explained,
            found.first,
            found.changes
        );
        assert!(
            found.explained >= least && found.changes.iter().all(|one| one.doubt <= Doubt::LIMIT),
            "{name}"
        );
        assert_eq!(found.changes.is_empty(), name == "aces");
    }
}

/// How often the walls of two visits lie on each other: of all pairs that may be one place by the number of slots, those
/// that are, under whichever rotation; and those that are not, under each.
#[test]
fn walls_tell_places_apart() {
    let (mut one, mut two) = ([0; 2], [0; 2]);
    for name in ["aces", "mit-csail", "fr079"] {
        let stages = found_visits(&logs::scans(name));
        let places = if name == "aces" { ACES_PLACES.to_vec() } else { places(&stages) };
        let mut recorder = Recorder::default();
        let events = stages.into_iter().flat_map(|stage| recorder.add(stage)).map(Arc::new);
        let survey = Survey::of(&events.collect::<Vec<_>>()).unwrap();
        let shows: Vec<Neighbourhood> =
            (0..survey.len()).map(|visit| survey.neighbourhood(visit, &|| false).unwrap()).collect();
        let (mut right, mut wrong) = ([0; 2], [0; 2]);
        for (later, first) in (0..shows.len()).flat_map(|later| (0..later).map(move |first| (later, first))) {
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
