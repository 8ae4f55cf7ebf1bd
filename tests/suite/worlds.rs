//! Every bundled world: its file is sound, its walk gives the counts it promises, and what its rendered grids show
//! is what its places are said to be.

use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Report, Visit};
use topostar::star::{LargeScaleStar, SlotIndex};
use topostar::trace::event::Event;
use topostar::trace::experience::{Experience, ExperienceError, Sighting};
use topostar::trace::read_trace;
use topostar::worlds::{self, Expectation, Truth, World, star_trace};

fn all() -> impl Iterator<Item = World> {
    worlds::names().map(|name| worlds::bundled(name).unwrap().unwrap())
}

fn sightings(events: &[Event]) -> Vec<Sighting> {
    let mut experience = Experience::new();
    let blind = |_: &_, _| Err(ExperienceError::NotDescribed("a bare star was expected".into()));
    events.iter().filter_map(|event| experience.accept(event, &blind).unwrap()).collect()
}

fn explain(sightings: &[Sighting], profile: Profile) -> Abduction {
    let mut abduction = Abduction::new(AxiomSet::of(profile), Limits::default());
    for Sighting { star, arrival, departure } in sightings {
        let visit = Visit { departure: *departure, star: star.large_scale(), arrival: *arrival };
        abduction.observe(&visit).unwrap();
    }
    abduction
}

fn check(world: &World, expected: &Expectation, report: &Report) {
    let counts: Vec<usize> =
        report.candidates_per_observation.iter().map(|count| count.value as usize).collect();
    assert_eq!(counts, expected.candidates, "{}", world.name);
    let simplicity = report.simplicity.unwrap();
    let found =
        (simplicity.paths, simplicity.places, report.minimal.len(), report.maps_created.value as usize);
    let minimal = expected.minimal;
    assert_eq!(found, (minimal.paths, minimal.places, minimal.ties, expected.created), "{}", world.name);
    assert!(report.proven && report.complete);
}

fn profiles(world: &World) -> [(Profile, &Expectation); 2] {
    [(Profile::Paper, &world.paper), (Profile::Default, &world.default)]
}

#[test]
fn the_counts_are_those_promised() {
    for world in all() {
        for seed in [None, Some(1), Some(2)] {
            let seen = sightings(&star_trace(&world, seed).unwrap().events);
            for (profile, expected) in profiles(&world) {
                check(&world, expected, &explain(&seen, profile).report());
            }
        }
    }
}

#[test]
fn the_true_map_is_a_candidate_unless_the_theory_refutes_it() {
    for world in all() {
        let trace = star_trace(&world, Some(7)).unwrap();
        let seen = sightings(&trace.events);
        for (profile, expected) in profiles(&world) {
            let is_true = |visits: &[topostar::abduction::Assignment]| {
                visits.iter().map(|v| (v.place.index(), v.rotation)).eq(trace.truth.iter().copied())
            };
            let abduction = explain(&seen, profile);
            let report = abduction.report();
            let kept = abduction.candidates().any(|candidate| is_true(&candidate.visits));
            let minimal = report.minimal.iter().any(|candidate| is_true(&candidate.visits));
            match &expected.truth {
                Truth::Minimal => assert!(minimal, "{}", world.name),
                Truth::Candidate => assert!(kept && !minimal, "{}", world.name),
                Truth::Refuted { axiom, observation } => {
                    assert!(!kept, "{}", world.name);
                    let refuted = report.refuted_per_observation[*observation];
                    assert!(refuted.iter().any(|(id, _)| id.name() == axiom), "{}", world.name);
                    let before = explain(&seen[..*observation], profile);
                    let truth = &trace.truth[..*observation];
                    let alive = |visits: &[topostar::abduction::Assignment]| {
                        visits.iter().map(|v| (v.place.index(), v.rotation)).eq(truth.iter().copied())
                    };
                    assert!(before.candidates().any(|candidate| alive(&candidate.visits)), "{}", world.name);
                }
            }
        }
    }
}

#[test]
fn the_office_gives_the_stars_of_the_recorded_trace() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/worlds/aces-stars.ndjson");
    let (recorded, fault) = read_trace(std::fs::read(path).unwrap().as_slice());
    assert!(fault.is_none());
    let office = worlds::bundled("office").unwrap().unwrap();
    let bare = |events: &[Event]| -> Vec<(LargeScaleStar, SlotIndex, Option<SlotIndex>)> {
        sightings(events).into_iter().map(|s| (s.star.large_scale(), s.arrival, s.departure)).collect()
    };
    assert_eq!(bare(&star_trace(&office, None).unwrap().events), bare(&recorded));
}
