//! The route of the seed's experiment in profile `classic`: the figures of `worlds/README.md`.

use crate::reference::views::{self as reference, LAWS};
use std::fs::File;
use std::io::BufReader;
use topostar::abduction::Relation;
use topostar::classic::{Action, Guide, Report, Sights, StopReason, best_first, breadth_first};
use topostar::service::ViewSession;
use topostar::trace::{Event, read_trace};
use topostar::worlds::{self, Naming, view_trace};

fn recorded() -> Vec<Event> {
    let path = format!("{}/worlds/aces-views.ndjson", env!("CARGO_MANIFEST_DIR"));
    let (events, fault) = read_trace(BufReader::new(File::open(path).unwrap()));
    assert!(fault.is_none(), "{fault:?}");
    events
}

/// What was seen on the recorded route.
pub(crate) fn recorded_views() -> Sights {
    session(&recorded()).seen().clone()
}

fn session(events: &[Event]) -> ViewSession {
    let mut session = ViewSession::new();
    events.iter().for_each(|event| session.accept(event).unwrap());
    session
}

fn office(naming: Naming) -> Sights {
    session(&view_trace(&worlds::bundled("office").unwrap(), naming).events).seen().clone()
}

/// What was seen before the travel of a number, from 1.
fn before_travel(seen: &Sights, travel: usize) -> Sights {
    let travels =
        seen.as_slice().iter().enumerate().skip(1).filter(|(_, sight)| sight.action == Action::Travel);
    let end = travels.map(|(observation, _)| observation).nth(travel - 1).unwrap();
    let mut before = Sights::default();
    seen.as_slice()[..end].iter().for_each(|&sight| before.push(sight).unwrap());
    before
}

/// Candidates left and maps made before each travel up to one, by exhaustive search.
fn counts(seen: &Sights, last: usize) -> Vec<(u64, u64)> {
    let count = |travel| {
        let report = breadth_first(&before_travel(seen, travel), usize::MAX).report();
        assert!(report.complete);
        (report.candidates.value, report.maps_created.value)
    };
    (1..=last).map(count).collect()
}

fn size(report: &Report) -> (usize, usize) {
    report.simplicity.map(|simplicity| (simplicity.paths, simplicity.places)).unwrap()
}

#[test]
fn the_recorded_trace_is_that_of_the_simulator() {
    let trace = view_trace(&worlds::bundled("office").unwrap(), Naming::Sides);
    assert_eq!(recorded(), trace.events);
    let session = session(&trace.events);
    assert_eq!((session.seen().as_slice().len(), session.view_names().len()), (73, 11));
    let met = |part: fn(&(usize, usize)) -> usize| trace.truth.iter().map(part).max().map(|last| last + 1);
    assert_eq!((met(|at| at.0), met(|at| at.1)), (Some(36), Some(9)));
}

/// In every bundled world but the one whose path crosses itself.
#[test]
fn the_true_map_obeys() {
    for name in worlds::names() {
        let trace = view_trace(&worlds::bundled(name).unwrap(), Naming::Sides);
        let seen = session(&trace.events).seen().clone();
        let story: Vec<usize> = trace.truth.iter().map(|at| at.0).collect();
        let places: Vec<usize> = trace.truth.iter().map(|at| at.1).collect();
        assert_eq!(reference::places(seen.as_slice(), &story), places, "{name}");
        let broken: Vec<&str> =
            LAWS.into_iter().filter(|law| !reference::obeys(seen.as_slice(), &story, law)).collect();
        let crossing = ["turn-path", "one-dstate", "path-order"];
        let expected: &[&str] = if name == "crossing" { &crossing } else { &[] };
        assert_eq!(broken, expected, "{name}");
    }
    let trace = view_trace(&worlds::bundled("office").unwrap(), Naming::Sides);
    let seen = session(&trace.events).seen().clone();
    let story: Vec<usize> = trace.truth.iter().map(|at| at.0).collect();
    assert_eq!(reference::size(seen.as_slice(), &story), (6, 9));
}

#[test]
fn exhaustive_search_grows_with_fewer_views() {
    let sides =
        [(2, 6), (2, 16), (4, 30), (6, 60), (30, 120), (59, 247), (157, 506), (203, 961), (371, 2207)];
    assert_eq!(counts(&office(Naming::Sides), 9), sides);
    let walls = [
        (3, 7),
        (3, 22),
        (8, 56),
        (110, 355),
        (1100, 2273),
        (2537, 10_084),
        (11_740, 41_268),
        (18_098, 85_050),
    ];
    assert_eq!(counts(&office(Naming::Walls), 8), walls);
    let ahead = [(3, 7), (3, 22), (34, 90), (56, 397), (1396, 2949), (4447, 19_721)];
    assert_eq!(counts(&office(Naming::Ahead), 6), ahead);
}

/// The true map has 6 paths and 9 places.
#[test]
fn simplest_first_ends_at_a_map_with_too_few_places() {
    for (naming, made, expected) in
        [(Naming::Sides, 572, (9, 7)), (Naming::Walls, 17_270, (6, 5)), (Naming::Ahead, 2938, (5, 3))]
    {
        let report = best_first(&office(naming), Guide::Simplest, usize::MAX);
        assert_eq!((report.maps_created.value, size(&report)), (made, expected));
        assert!(report.stop_reason == StopReason::Found && !report.proven);
    }
}

#[test]
fn the_proven_minimum_is_simpler_than_the_truth() {
    let report = best_first(&office(Naming::Sides), Guide::Bound, usize::MAX);
    assert_eq!((size(&report), report.minimal.len(), report.minimal_maps()), ((6, 7), 192, 192));
    assert!(report.proven && !report.unique);
    assert_eq!(report.candidates.relation, Relation::AtLeast);
}
