//! Tests on data that others recorded and that is not part of the repository: `../shared/data`.
//!
//! `cargo xtask test` runs them where the folder is there, and else names them as skipped.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a helper of tests fails the test")]

mod logs;
mod patchwork;
mod places;
mod posegraphs;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit, judge};
use topostar::export::Report;
use topostar::lpm::Lpm;
use topostar::metric::Measurements;
use topostar::sensor::LaserScan;
use topostar::service::{self, Maps, MemoryStore, app};
use topostar::star::{LargeScaleStar, PerceptionParameters};
use topostar::trace::perceive::perceive;
use topostar::trace::recording::{Arrival, Recorder};
use topostar::trace::{Event, EventKind, Experience, Percept, Sighting, read_trace, write_trace};
use topostar::visit::relations::{Reach, Relation, Track};
use topostar::visit::truth::Timetable;
use topostar::visit::{AnnotatedVisits, Stage, VisitDetector, VisitParameters};

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(file)
}

/// The scans of the log, the arrivals in it, and the trace of both.
fn aces() -> (Vec<LaserScan>, Vec<Arrival>, Vec<Event>) {
    let scans = logs::scans("aces");
    let visits = fs::read_to_string(data("logs/aces-visits.csv")).unwrap();
    let arrivals = Arrival::read_csv(&visits).unwrap();
    let marks = arrivals.iter().map(|arrival| arrival.scan).collect();
    let mut visits = AnnotatedVisits::new(marks, &VisitParameters::default()).unwrap();
    let mut stages: Vec<Stage> = scans.iter().filter_map(|scan| visits.add(scan)).collect();
    let (last, beyond) = visits.finish();
    assert_eq!(beyond, None);
    stages.extend(last);
    let mut recorder = Recorder::default();
    let events = stages.into_iter().flat_map(|stage| recorder.add(stage)).collect::<Vec<Event>>();
    (scans, arrivals, events)
}

#[test]
fn the_aces_log_is_read_whole() {
    let (scans, arrivals, events) = aces();
    assert_eq!((scans.len(), arrivals.len()), (7374, 15));
    assert!(
        scans
            .iter()
            .all(|scan| scan.ranges.len() == 180 && scan.robot_from_laser.position().coords.norm() < 1e-9)
    );
    let first = scans[0].odom_from_robot;
    assert!((first.theta + std::f64::consts::FRAC_PI_2).abs() < 1e-3 && first.position().coords.norm() < 0.1);
    let (start, end) = (scans[0].stamp, scans[7373].stamp);
    assert!((end - start - 1366.0).abs() < 2.0, "{start} {end}");
    assert_eq!(events.len(), 15 + 14 + 14);
}

/// What may be relied on without tuning: the places read alike at every visit.
#[test]
fn a_place_of_the_aces_building_reads_alike_at_every_visit() {
    let (_, arrivals, events) = aces();
    let parameters = PerceptionParameters::default();
    let mut experience = Experience::new();
    let look =
        |event: &Event| experience.accept(event, &|lpm, first| perceive(lpm, first, &parameters)).unwrap();
    let stars: Vec<LargeScaleStar> =
        events.iter().filter_map(look).map(|seen| seen.star.large_scale()).collect();
    let at = |name: &str| -> Vec<&LargeScaleStar> {
        arrivals
            .iter()
            .zip(&stars)
            .filter(|(arrival, _)| arrival.place == name)
            .map(|(_, star)| star)
            .collect()
    };
    let exits = |star: &LargeScaleStar| star.slots().iter().filter(|slot| slot.navigable).count();
    for (place, visits, ways) in [
        ("N", 2, 3),
        ("E", 2, 3),
        ("W", 2, 3),
        ("S", 2, 4),
        ("C", 3, 4),
        ("NE", 1, 2),
        ("SE", 1, 2),
        ("SW", 1, 2),
        ("NW", 1, 2),
    ] {
        let seen = at(place);
        assert_eq!(seen.len(), visits, "{place}");
        assert!(seen.iter().all(|star| exits(star) == ways && star.size() == 4), "{place}: {seen:?}");
        assert!(seen.iter().all(|star| !seen[0].alignments(star).is_empty()), "{place}: {seen:?}");
    }
}

fn found_visits(scans: &[LaserScan]) -> Vec<Stage> {
    let mut detector = VisitDetector::new(VisitParameters::default()).unwrap();
    let mut stages: Vec<Stage> = scans.iter().flat_map(|scan| detector.add(scan)).collect();
    stages.extend(detector.finish());
    stages
}

/// The place of each visit to the ACES building.
const ACES_PLACES: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 0, 8, 4, 8, 6, 8, 2];

/// The whole of the seed's experiment from the log alone: places, stars and map.
#[test]
fn the_aces_log_alone_gives_the_true_map() {
    let (scans, arrivals, _) = aces();
    let stages = found_visits(&scans);
    let mut timetable = Timetable::default();
    stages.iter().for_each(|stage| timetable.add(stage));
    let marks: Vec<usize> = arrivals.iter().map(|arrival| arrival.scan).collect();
    assert_eq!(timetable.visits_at(&marks), (0..15).map(Some).collect::<Vec<_>>());
    assert_eq!(stages.len(), 15);

    let mut recorder = Recorder::default();
    let (mut experience, mut measured) = (Experience::new(), Measurements::default());
    let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), Limits::default());
    let perceive = |lpm: &Lpm, first| perceive(lpm, first, &PerceptionParameters::default());
    for event in stages.into_iter().flat_map(|stage| recorder.add(stage)) {
        let Some(sighting) = experience.accept(&event, &perceive).unwrap() else { continue };
        measured = measured.with(&sighting);
        abduction.observe_measured(&Visit::from(&sighting), measured.evidence()).unwrap();
    }
    let report = abduction.report();
    assert!(report.proven && report.complete && abduction.len() <= 35);
    let [simplest] = report.minimal.as_slice() else { panic!("{} ties", report.minimal.len()) };
    assert_eq!(simplest.places(), ACES_PLACES);
    let map = &simplest.map;
    let size = [map.place_count(), map.path_count(), map.segment_count(), map.dstate_count()];
    assert_eq!(size, [9, 6, 12, 36]);
}

/// Scan matching keeps what odometry loses, as far as it remembers.
#[test]
fn local_poses_are_nearer_to_checked_relations_than_odometry() {
    for (name, most) in [("aces", 0.05), ("fr079", 0.05)] {
        let scans = logs::scans(name);
        let parameters = VisitParameters::default();
        let (mut detector, mut track) = (VisitDetector::new(parameters).unwrap(), Track::default());
        for scan in &scans {
            detector.add(scan);
            track.add(scan, detector.now().unwrap());
        }
        let text = fs::read_to_string(data(&format!("logs/{name}.relations"))).unwrap();
        let found = track.compare(&Relation::read(&text).unwrap(), parameters.matching.memory);
        assert_eq!(found.unknown, 0, "{name}");
        for (reach, row) in &found.rows {
            println!("{name} {reach:?} {row:?}");
            let [odometry, matched] = [row.odometry, row.matched].map(|[metres, _]| metres.mean);
            assert!(*reach == Reach::Within || matched < odometry / 2.0, "{name} {reach:?}");
            assert!(*reach != Reach::Within || matched < most, "{name} {reach:?}");
            assert!(row.matched[1].mean < row.odometry[1].mean, "{name} {reach:?}");
        }
    }
}

/// The route as it was listed by hand, with the travels and poses of the visits found in the log.
fn aces_stars_measured() -> Vec<Sighting> {
    let mut recorder = Recorder::default();
    let stages = found_visits(&logs::scans("aces")).into_iter();
    let found: Vec<Event> = stages.flat_map(|stage| recorder.add(stage)).collect();
    let text = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/aces-stars.ndjson")).unwrap();
    let (listed, fault) = read_trace(text.as_slice());
    assert!(fault.is_none());
    let mut poses = found.iter().filter_map(|event| match &event.kind {
        EventKind::Observation(seen) => match &seen.percept {
            Percept::Lpm(lpm) => Some(lpm.robot_pose),
            Percept::Star { .. } | Percept::View(_) => None,
        },
        _ => None,
    });
    let mut travels = found.iter().filter_map(|event| match &event.kind {
        EventKind::Travel(travel) => Some(travel.clone()),
        _ => None,
    });
    let mut experience = Experience::new();
    let measured = listed.into_iter().map(|mut event| {
        match &mut event.kind {
            EventKind::Observation(seen) => {
                let Percept::Star { robot_pose, .. } = &mut seen.percept else { panic!("no bare star") };
                *robot_pose = poses.next();
            }
            EventKind::Travel(travel) => *travel = travels.next().unwrap(),
            _ => {}
        }
        experience.accept(&event, &|_, _| unreachable!("bare stars")).unwrap()
    });
    measured.flatten().collect()
}

/// Position alone closes loops here, as the stars listed by hand have no bearings.
#[test]
fn what_is_measured_keeps_the_true_map_of_the_aces_building() {
    let sightings = aces_stars_measured();
    let axioms = AxiomSet::of(Profile::Default);
    let (mut bare, mut found) =
        (Abduction::new(axioms, Limits::default()), Abduction::new(axioms, Limits::default()));
    let mut measured = Measurements::default();
    for sighting in &sightings {
        let visit = Visit::from(sighting);
        measured = measured.with(sighting);
        bare.observe(&visit).unwrap();
        found.observe_measured(&visit, measured.evidence()).unwrap();
    }
    let truth = &bare.report().minimal[0];
    let report = found.report();
    let counts: Vec<u64> = report.candidates_per_observation.iter().map(|count| count.value).collect();
    println!("candidates {counts:?}, refuted {:?}", report.refuted.iter().collect::<Vec<_>>());
    let visits: Vec<Visit> = sightings.iter().map(Visit::from).collect();
    for candidate in bare.candidates() {
        match judge(&visits, measured.evidence().as_deref(), axioms, &candidate.visits) {
            Ok(_) => println!("{:?} remains", candidate.places()),
            Err(why) => println!(
                "{:?} falls at {} by {}: {}",
                candidate.places(),
                why.observation,
                why.axiom.name(),
                why.clash.words
            ),
        }
    }
    assert_eq!(report.minimal.iter().map(|minimal| &minimal.visits).collect::<Vec<_>>(), [&truth.visits]);
}

#[test]
fn the_grids_of_the_aces_log_are_taken_over_http() {
    let (_, _, events) = aces();
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let listener = runtime.block_on(tokio::net::TcpListener::bind("127.0.0.1:0")).unwrap();
    let url = format!("http://{}/v1/maps/aces", listener.local_addr().unwrap());
    let limits = service::Limits::default();
    let maps = Maps::new(Arc::new(MemoryStore::new(limits.maps)), limits);
    runtime.spawn(async { axum::serve(listener, app(maps)).await });
    ureq::put(&url).send_empty().unwrap();
    let mut body = Vec::new();
    write_trace(&mut body, &events).unwrap();
    ureq::post(format!("{url}/events"))
        .header("content-type", "application/x-ndjson")
        .send(&body[..])
        .unwrap();
    let report: Report = ureq::get(&url).call().unwrap().body_mut().read_json().unwrap();
    assert_eq!(report.candidates_per_observation.len(), 15);
    assert!(report.complete && report.preferred.is_some_and(|preferred| preferred.proven));
}

#[test]
fn the_bundled_traces_are_the_recorded_ones() {
    for name in ["aces-stars", "grid3x3-16", "grid4x3-20", "grid4x4-24", "grid4x4-28", "grid6x6-64"] {
        let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("worlds/{name}.ndjson"));
        let recorded = data(&format!("traces/{name}.ndjson"));
        assert_eq!(fs::read(bundled).unwrap(), fs::read(recorded).unwrap(), "{name}");
    }
}
