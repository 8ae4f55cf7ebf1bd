//! The measured axioms against their slow reference, and what they must and must not refute.

use crate::clingo::on_random;
use crate::engine::{names, stories};
use crate::measured_reference::{LAWS, broken, decided};
use crate::reference::Story;
use proptest::prelude::*;
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use topostar::abduction::{
    Abduction, Assignment, AxiomId, AxiomSet, Clash, Evidence, Learned, Limits, Profile, Proposal, Proposed,
    REGISTRY, Refutation, Visit, judge, proposed,
};
use topostar::map::PlaceId;
use topostar::metric::Measurements;
use topostar::trace::{Event, Experience, Sighting, write_trace};
use topostar::worlds::{
    Detours, Drift, StarTrace, corridor_grid, covering_walk, drifting_trace, drifting_trace_by,
};

/// A walk through a grid with odometry of some quality, said to be better than it is.
fn walks() -> impl Strategy<Value = Vec<Sighting>> {
    let drift = prop_oneof![Just(0.05), Just(0.2), Just(1.0)];
    let boast = prop_oneof![3 => Just(1.0), 1 => Just(0.1), 1 => Just(0.001)];
    (any::<u64>(), 2usize..4, 4.0..12.0, drift, boast, 4usize..10).prop_map(
        |(seed, columns, spacing, drift, boast, travels)| {
            let places = corridor_grid(2, columns, spacing);
            let mut walk = covering_walk(&places, seed);
            walk.leave.truncate(travels);
            let trace = drifting_trace(&places, &walk, Drift::WORST.scaled(drift), seed).unwrap();
            let mut seen = sightings(&trace.events);
            for motion in seen.iter_mut().filter_map(|sighting| sighting.motion.as_mut()) {
                motion.covariance = motion.covariance.map(|entry| entry * boast);
                motion.start_given = seed % 3 != 0;
            }
            seen
        },
    )
}

pub(crate) fn sightings(events: &[Event]) -> Vec<Sighting> {
    let mut experience = Experience::new();
    let look = |event| experience.accept(event, &|_, _| unreachable!("bare stars")).unwrap();
    events.iter().filter_map(look).collect()
}

pub(crate) fn explain(sightings: &[Sighting], axioms: AxiomSet) -> Abduction {
    let mut measured = Measurements::default();
    let mut abduction = Abduction::new(axioms, Limits::default());
    for sighting in sightings {
        measured = measured.with(sighting);
        abduction.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    abduction
}

#[test]
fn every_measured_axiom_has_one_reference() {
    let measured = REGISTRY.iter().filter(|axiom| axiom.is_measured()).map(|axiom| axiom.id);
    assert!(measured.eq(LAWS.iter().map(|(id, _)| *id)));
    assert!(names(AxiomSet::of(Profile::Default)).len() < AxiomSet::of(Profile::Default).iter().count());
}

/// With a measured axiom, exactly those candidates are left that there are without it and that obey it. Hardly any is on
/// the brink, so that it is not compared.
#[test]
fn measured_axioms_refute_exactly_what_breaks_them() {
    let (compared, on_the_brink) = (Cell::new(0), Cell::new(0));
    on_random(32, walks(), |seen| {
        let symbols = AxiomSet::of(Profile::Default).without_measured();
        let mut few = seen.len();
        while few > 1 && explain(&seen[..few], symbols).len() > 30 {
            few -= 1;
        }
        let seen = &seen[..few];
        let all = stories(&explain(seen, symbols));
        for (id, law) in LAWS {
            let found = stories(&explain(seen, symbols.with(*id)));
            prop_assert!(found.iter().all(|story| all.contains(story)));
            for story in &all {
                let expected = decided(*law, seen, story);
                prop_assert!(
                    expected.is_none_or(|kept| kept == found.contains(story)),
                    "{} {story:?}",
                    id.name()
                );
                compared.set(compared.get() + 1);
                on_the_brink.set(on_the_brink.get() + u32::from(expected.is_none()));
            }
        }
        Ok(())
    });
    assert!(
        compared.get() > 200 && 10 * on_the_brink.get() < compared.get(),
        "{on_the_brink:?} of {compared:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// The search for the simplest maps alone prefers, among what was measured too, what the exhaustive one prefers.
    #[test]
    fn best_first_finds_the_simplest_of_what_was_measured(seen in walks()) {
        let axioms = AxiomSet::of(Profile::Default);
        let mut found = Abduction::best_first(axioms, Limits::default());
        let mut measured = Measurements::default();
        for sighting in &seen {
            measured = measured.with(sighting);
            found.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
        }
        found.settle(&|| false);
        let (found, all) = (found.report(), explain(&seen, axioms).report());
        prop_assert!(found.proven);
        prop_assert_eq!(found.minimal, all.minimal);
        prop_assert_eq!(found.simplicity, all.simplicity);
    }
}

/// On walks in which two places are found to share a spot only by how chi-square grows, each child that the search
/// comes to is refuted by the axiom by which the reference refutes it.
#[test]
fn the_profile_of_chi_square_refutes_what_its_reference_refutes() {
    let axioms = AxiomSet::of(Profile::Default);
    let (mut refuted, mut on_the_brink) = (0, 0);
    for (seed, latest) in [(6, 15), (20, 14), (32, 13), (34, 15)] {
        let places = corridor_grid(3, 3, 10.0);
        let trace = drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST, seed).unwrap();
        let seen = &sightings(&trace.events)[..=latest];
        let visits: Vec<Visit> = seen.iter().map(Visit::from).collect();
        let measured = seen.iter().fold(Measurements::default(), |measured, seen| measured.with(seen));
        for candidate in explain(&seen[..latest], axioms).candidates() {
            let children = proposed(&visits, measured.evidence().as_deref(), axioms, &candidate.visits);
            for Proposed { assignment, refutation } in children.unwrap() {
                let found = refutation.map(|refutation| refutation.axiom);
                if found.is_some_and(|axiom| LAWS.iter().all(|(law, _)| *law != axiom)) {
                    continue;
                }
                let visits = candidate.visits.iter().chain([&assignment]);
                let story: Story = visits.map(|at| (at.place.index(), at.rotation as usize)).collect();
                let broken = broken(seen, &story);
                on_the_brink += usize::from(broken.is_none());
                assert!(broken.is_none_or(|broken| broken == found), "{seed} {story:?} {found:?} {broken:?}");
                refuted += usize::from(found == Some(AxiomId::Apart) && broken.is_some());
            }
        }
    }
    assert!(refuted > 0 && on_the_brink < 4, "{refuted} {on_the_brink}");
}

pub(crate) fn recorded(name: &str) -> Vec<Sighting> {
    let path = format!("{}/worlds/{name}.ndjson", env!("CARGO_MANIFEST_DIR"));
    let (events, fault) = topostar::trace::read_trace(std::fs::read(path).unwrap().as_slice());
    assert!(fault.is_none());
    sightings(&events)
}

/// Four corners that look alike, ten and thirty metres apart in turn, and no bearings: the ring of three is refuted
/// by lengths alone, those of two and of four repeat them.
#[test]
fn lengths_tell_a_ring_of_three_from_one_of_four() {
    let seen = recorded("ring-10-30");
    let symbols = AxiomSet::of(Profile::Default).without_measured();
    let three = [0, 1, 2, 0, 1, 2, 0, 1, 2, 0];
    let rings = |abduction: &Abduction| {
        abduction
            .candidates()
            .map(|candidate| candidate.places())
            .filter(|places| places[9] < 4)
            .collect::<Vec<_>>()
    };
    let with = explain(&seen, symbols.with(AxiomId::Distance));
    assert!(rings(&explain(&seen, symbols)).contains(&three.to_vec()));
    assert!(!rings(&with).contains(&three.to_vec()));
    assert!(rings(&with).contains(&vec![0, 1, 2, 3, 0, 1, 2, 3, 0, 1]));
    let report = with.report();
    assert!(report.refuted.by(AxiomId::Distance) > 0);
    // All four agree, and say so alone.
    assert!(explain(&seen, AxiomSet::of(Profile::Default)).report().refuted.by(AxiomId::Distance) > 0);
}

/// A grid walked with good odometry.
fn drifting(seed: u64) -> Vec<Event> {
    let places = corridor_grid(4, 4, 10.0);
    drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST.scaled(0.2), seed).unwrap().events
}

/// Each of the other three refutes something in it that those before it leave; `UPDATE_GOLDEN=1` writes the trace anew.
#[test]
fn angle_closure_and_apart_refute_on_a_grid() {
    const NAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/worlds/grid4x4-drift.ndjson");
    let mut written = Vec::new();
    write_trace(&mut written, &drifting(SEED)).unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(NAME, &written).unwrap();
    }
    assert!(std::fs::read(NAME).unwrap() == written, "the simulator no longer walks as recorded");
    let report = explain(&recorded("grid4x4-drift"), AxiomSet::of(Profile::Default)).report();
    for axiom in [AxiomId::Angle, AxiomId::Closure, AxiomId::Apart] {
        assert!(report.refuted.by(axiom) > 0, "{}: {:?}", axiom.name(), report.refuted);
    }
}

/// A walk in which all three refute.
const SEED: u64 = 0;

/// A sample of `cargo xtask evaluate`: no axiom refutes the true map, with odometry as bad as the worst and better.
#[test]
fn the_true_map_is_never_refuted() {
    let mut preferred = 0;
    for (side, seed, by) in (0..12).flat_map(|seed| [(4, seed, 1.0), (6, seed, 1.0), (4, seed, 0.2)]) {
        let places = corridor_grid(side, side, 10.0);
        let walk = covering_walk(&places, 7000 + seed);
        let trace = drifting_trace(&places, &walk, Drift::WORST.scaled(by), 7000 + seed).unwrap();
        let seen = sightings(&trace.events);
        let truth = truth(&trace);
        let judged = judged(&seen, &truth);
        assert!(judged.is_ok(), "{side} {seed} {by}: {judged:?}");
        if side == 4 && by < 1.0 {
            let found = explain(&seen, AxiomSet::of(Profile::Default)).report();
            preferred += usize::from(found.minimal.len() == 1 && found.minimal[0].visits == truth);
        }
    }
    assert_eq!(preferred, 12);
}

/// Nor where corridors do not lead straight, and on the rim are up to five times as long as the line between two places; and what
/// their ways tell refutes there too.
#[test]
fn the_true_map_of_corridors_with_detours_is_never_refuted() {
    let (mut with, mut without) = (0, 0);
    for (seed, by) in (0..16).flat_map(|seed| [(seed, 1.0), (seed, 0.5)]) {
        let places = corridor_grid(4, 4, 10.0);
        let detours = Detours::of_grid(&places, seed);
        let walk = covering_walk(&places, seed);
        let trace = drifting_trace_by(&places, &walk, Drift::WORST.scaled(by), seed, &detours).unwrap();
        let mut seen = sightings(&trace.events);
        let judged = judged(&seen, &truth(&trace));
        assert!(judged.is_ok(), "{seed} {by}: {judged:?}");
        let axioms = AxiomSet::of(Profile::Default);
        if seed < 4 && by < 1.0 {
            with += explain(&seen, axioms).len();
            seen.iter_mut().filter_map(|seen| seen.motion.as_mut()).for_each(|motion| motion.shape.clear());
            without += explain(&seen, axioms).len();
        }
    }
    println!("{with} of {without} candidates with detours");
    assert!(with < without, "{with} of {without}");
}

fn truth(trace: &StarTrace) -> Vec<Assignment> {
    let assignment =
        |&(place, rotation): &(usize, u8)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
    trace.truth.iter().map(assignment).collect()
}

/// What refutes a map by all axioms of the profile, if any does.
fn judged(seen: &[Sighting], map: &[Assignment]) -> Result<(), Refutation> {
    let visits: Vec<Visit> = seen.iter().map(Visit::from).collect();
    let measured = seen.iter().fold(Measurements::default(), |measured, seen| measured.with(seen));
    judge(&visits, measured.evidence().as_deref(), AxiomSet::of(Profile::Default), map).map(|_| ())
}

/// Measurements that count how often they refute since places and segments have no room beside all others.
#[derive(Debug)]
struct Crowding {
    measured: Arc<dyn Evidence>,
    crowded: Arc<AtomicUsize>,
}

impl Evidence for Crowding {
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool {
        let holds = self.measured.holds(axiom, proposal);
        let words = || self.clash(axiom, proposal).words;
        let crowded = !holds && words().contains("leave no room") && words().contains("m apart");
        self.crowded.fetch_add(usize::from(crowded), Ordering::Relaxed);
        holds
    }

    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash {
        self.measured.clash(axiom, proposal)
    }

    fn learned(&self, proposal: &Proposal<'_>) -> Learned {
        self.measured.learned(proposal)
    }
}

/// The ways that the robot went rule out candidates whose segments would cross, and nothing else: where the trace does not tell
/// them the same candidates are left and more, the true one among all.
#[test]
fn candidates_fall_whose_segments_cross() {
    let (mut fewer, mut told) = (0, 0);
    for seed in 0..12 {
        let places = corridor_grid(4, 4, 10.0);
        let trace = drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST, seed).unwrap();
        let mut seen = sightings(&trace.events);
        let axioms = AxiomSet::of(Profile::Default);
        let with = stories(&explain(&seen, axioms));
        seen.iter_mut().filter_map(|seen| seen.motion.as_mut()).for_each(|motion| motion.shape.clear());
        let without = stories(&explain(&seen, axioms));
        assert!(with.iter().all(|story| without.contains(story)), "{seed}");
        let truth = trace.truth.iter().map(|&(place, rotation)| (place, rotation as usize)).collect();
        assert!(with.contains(&truth), "{seed}");
        (fewer, told) = (fewer + with.len(), told + without.len());
    }
    println!("{fewer} of {told}");
    assert!(4 * fewer < 3 * told, "{fewer} of {told}");
}

/// With odometry as bad as the worst some candidates fall only as their places have no room together, and few are left.
#[test]
fn candidates_fall_whose_places_have_no_room() {
    let crowded = Arc::new(AtomicUsize::new(0));
    for seed in [0, 10, 20, 30] {
        let places = corridor_grid(4, 4, 10.0);
        let trace = drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST, seed).unwrap();
        let mut measured = Measurements::default();
        let mut found = Abduction::new(AxiomSet::of(Profile::Default), Limits::default());
        for sighting in sightings(&trace.events) {
            measured = measured.with(&sighting);
            let evidence = measured.evidence().map(|measured| {
                Arc::new(Crowding { measured, crowded: Arc::clone(&crowded) }) as Arc<dyn Evidence>
            });
            found.observe_measured(&Visit::from(&sighting), evidence).unwrap();
        }
        assert!((1..=6).contains(&found.len()), "{seed}: {}", found.len());
    }
    assert!(crowded.load(Ordering::Relaxed) >= 4, "{crowded:?}");
}

/// Where errors lead more bounds bear than to first order, and a descent that goes to and fro between bounds is held still by
/// more of them: if a search leaves out either, one candidate more is left of each of these walks, whose ways are not told.
#[test]
fn a_branch_ends_or_goes_on_by_where_errors_lead() {
    assert_eq!([(18, 13), (36, 15)].map(|(seed, observations)| left_of(seed, observations, false)), [2, 3]);
}

/// If a search asks first what takes most to come apart, whatever it has learned, two candidates are left.
#[test]
fn a_search_for_room_ends_that_asks_first_what_has_the_fewest_ways() {
    assert_eq!(left_of(3, usize::MAX, true), 1);
}

/// How many candidates are left after some observations of a walk whose ways are told or not; the true map is among them.
fn left_of(seed: u64, observations: usize, told: bool) -> usize {
    let places = corridor_grid(4, 4, 10.0);
    let trace = drifting_trace(&places, &covering_walk(&places, seed), Drift::WORST, seed).unwrap();
    let mut seen = sightings(&trace.events);
    seen.truncate(observations);
    if !told {
        seen.iter_mut().filter_map(|seen| seen.motion.as_mut()).for_each(|motion| motion.shape.clear());
    }
    let found = explain(&seen, AxiomSet::of(Profile::Default));
    let truth = truth(&trace);
    assert!(found.candidates().any(|candidate| candidate.visits == truth[..seen.len()]), "seed {seed}");
    found.len()
}
