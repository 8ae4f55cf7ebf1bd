//! The soundness of the measured axioms, counted: random walks over corridor grids with odometry that drifts badly.
//!
//! Each walk's true map is judged step by step by all axioms of profile `default`. That it is judged tells more than
//! that a search keeps it: no limit comes in between. Some walks are searched as well, as far as a limit on candidates
//! lets it. `cargo xtask evaluate [WALKS [SEED]]` runs it: 1000 walks from seed 0 unless told otherwise, with
//! odometry as bad as the worst, with errors as large that are all the same on all metres or all new on every one, and
//! with errors a fifth as large; and in corridors with detours.

#![allow(clippy::unwrap_used, reason = "an evaluation ends where something is wrong")]

mod drifting;

use drifting::{SPACING, drifting_walk, sightings};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use topostar::abduction::{
    Abduction, Assignment, AxiomId, AxiomSet, Clash, Evidence, Limits, Profile, Proposal, Refutation, Report,
    Visit, judge,
};
use topostar::map::PlaceId;
use topostar::metric::{Measurements, MetricParameters, Patience, Room};
use topostar::trace::Sighting;
use topostar::worlds::{Detours, Drift, Place, StarTrace};

/// The most candidates kept; walks that have more are counted for themselves.
const LIMIT: usize = 1000;
/// Where so many walks are searched or fewer, the candidates after each observation are printed.
const FEW: usize = 10;
/// Of the walks in the smaller grid one in so many is searched, in the larger one a tenth of these.
const SEARCHED: u64 = 10;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let number = |at: usize| arguments.get(at).and_then(|text| text.parse().ok());
    let (walks, from): (u64, u64) = (number(0).unwrap_or(1000), number(1).unwrap_or(0));
    let mut sound = true;
    let common = Drift {
        heading_bias: 0.0027,
        heading_noise: 0.0,
        length_bias: 0.0163,
        length_noise: 0.0,
        ..Drift::WORST
    };
    let own = Drift {
        heading_bias: 0.0,
        heading_noise: 0.0086,
        length_bias: 0.0,
        length_noise: 0.0515,
        ..Drift::WORST
    };
    let drifts = [
        ("as bad as the worst", Drift::WORST),
        ("as bad, all of it the same on all metres", common),
        ("as bad, all of it new on every metre", own),
        ("a fifth of that", Drift::WORST.scaled(0.2)),
    ];
    let (small, large) = (walks - walks / 2, walks / 2);
    let of = |side, share, every| drifts.map(|drift| (side, false, share, Some(every), drift));
    let straight = [of(4, small, SEARCHED), of(6, large, 10 * SEARCHED)].concat();
    // Ways up to five times as long as the line between two places drift as much more: with the worst odometry it takes too long
    // to search them.
    let half = ("half as bad as the worst", Drift::WORST.scaled(0.5));
    let detours = [(None, drifts[0]), (None, drifts[1]), (None, drifts[2]), (Some(SEARCHED), half)];
    let detours = detours.map(|(every, drift)| (4, true, small, every, drift));
    for (side, detours, share, every, (name, drift)) in [straight, detours.into()].concat() {
        let start = Instant::now();
        let searched = |seed: u64| every.is_some_and(|every| seed.is_multiple_of(every));
        let outcomes: Vec<Outcome> = (from..from + share)
            .into_par_iter()
            .map(|seed| Outcome::of(&walk(side, detours, seed, drift), seed, searched(seed)))
            .collect();
        let led = if detours { ", with detours" } else { "" };
        println!("\n{side}x{side} places, corridors of {SPACING} m{led}, odometry {name}\n  {drift:?}");
        print(&outcomes, start.elapsed().as_secs_f64());
        sound &= outcomes.iter().all(|outcome| outcome.refuted.is_none());
    }
    std::process::exit(if sound { 0 } else { 1 });
}

fn walk(side: usize, detours: bool, seed: u64, drift: Drift) -> StarTrace {
    let detours =
        |places: &[Place]| if detours { Detours::of_grid(places, seed) } else { Detours::default() };
    drifting_walk(side, detours, seed, drift)
}

/// What came of one walk.
struct Outcome {
    seed: u64,
    travels: usize,
    /// What refutes the true map, if an axiom does.
    refuted: Option<Refutation>,
    searched: Option<Found>,
}

/// What a search found.
struct Found {
    /// The number of candidates after each observation.
    candidates: Vec<usize>,
    /// Whether the limit cut none.
    whole: bool,
    /// Whether the true map is among those kept, among the simplest, and the simplest alone.
    kept: bool,
    preferred: bool,
    alone: bool,
    /// Of how many candidates at the end errors within a bound are found with which all places lie apart.
    roomy: usize,
    by_axiom: Vec<(&'static str, u64)>,
}

impl Outcome {
    fn of(trace: &StarTrace, seed: u64, search: bool) -> Outcome {
        let truth = truth(trace);
        let sightings = sightings(trace);
        let visits: Vec<Visit> = sightings.iter().map(|(seen, _)| Visit::from(seen)).collect();
        let evidence = sightings.last().and_then(|(_, measured)| measured.evidence());
        let judged = judge(&visits, evidence.as_deref(), AxiomSet::of(Profile::Default), &truth);
        let measured = sightings.last().map(|(_, measured)| measured.clone()).unwrap_or_default();
        let searched = search.then(|| Found::of(&explain(&sightings), &visits, &measured, &truth));
        Outcome { seed, travels: sightings.len() - 1, refuted: judged.err(), searched }
    }
}

impl Found {
    fn of(abduction: &Abduction, seen: &[Visit], measured: &Measurements, truth: &[Assignment]) -> Found {
        let report: Report = abduction.report();
        let preferred = report.minimal.iter().any(|candidate| candidate.visits == truth);
        Found {
            candidates: report.candidates_per_observation.iter().map(|count| count.value as usize).collect(),
            whole: report.complete,
            kept: abduction.candidates().any(|candidate| candidate.visits == truth),
            preferred,
            alone: preferred && report.minimal.len() == 1,
            roomy: abduction.candidates().filter(|one| has_room(seen, measured, &one.visits)).count(),
            by_axiom: report.refuted.iter().map(|(axiom, count)| (axiom.name(), count)).collect(),
        }
    }
}

/// Whether errors are found with which all places of a candidate lie apart, within the bound of some range of the share of them that
/// is the same on all travels. Of the others that is not found out.
fn has_room(seen: &[Visit], measured: &Measurements, candidate: &[Assignment]) -> bool {
    let asking = Asking { measured: measured.clone(), last: seen.len() - 1, found: AtomicBool::new(false) };
    let axioms = AxiomSet::built_in().with(AxiomId::Apart);
    judge(seen, Some(&asking), axioms, candidate).is_ok() && asking.found.into_inner()
}

/// Measurements that are asked for room at the last observation.
#[derive(Debug)]
struct Asking {
    measured: Measurements,
    last: usize,
    found: AtomicBool,
}

impl Evidence for Asking {
    fn holds(&self, _: AxiomId, proposal: &Proposal<'_>) -> bool {
        if proposal.branch.visits().len() == self.last {
            let separation = MetricParameters::default().separation;
            let room = |range| self.measured.room(proposal, range, separation, Patience::Long);
            let found = |range| matches!(room(range), Some(Room::Found(_)));
            // Errors that are mostly new on every travel, the last range, leave most room.
            self.found.store((0..Measurements::RANGES).rev().any(found), Ordering::Relaxed);
        }
        true
    }

    fn clash(&self, _: AxiomId, _: &Proposal<'_>) -> Clash {
        Clash::default()
    }
}

fn print(outcomes: &[Outcome], seconds: f64) {
    let travels: usize = outcomes.iter().map(|outcome| outcome.travels).sum();
    let refuted: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.refuted.is_some()).collect();
    println!("  {} walks from seed {}, {travels} travels, {seconds:.0} s", outcomes.len(), outcomes[0].seed);
    println!("  true map refuted {} times", refuted.len());
    for Outcome { seed, refuted, .. } in refuted {
        let Some(Refutation { axiom, observation, clash }) = refuted else { continue };
        println!("    seed {seed}: {} at observation {observation}: {}", axiom.name(), clash.words);
    }
    let found: Vec<&Found> = outcomes.iter().filter_map(|outcome| outcome.searched.as_ref()).collect();
    let count = |of: fn(&Found) -> bool| found.iter().filter(|found| of(found)).count();
    if found.is_empty() {
        return;
    }
    let few = found.len() <= FEW;
    let (left, roomy) = found.iter().fold((0, 0), |(left, roomy), found| {
        (left + found.candidates.last().copied().unwrap_or_default(), roomy + found.roomy)
    });
    for Outcome { seed, searched, .. } in outcomes.iter().filter(|_| few) {
        let Some(Found { candidates, whole, roomy, .. }) = searched else { continue };
        let counts: Vec<String> = candidates.iter().map(usize::to_string).collect();
        let whole = if *whole { "whole" } else { "cut" };
        println!("    seed {seed}, {whole}, {roomy} with room: {}", counts.join(" "));
    }
    println!(
        "  searched {}, whole within {LIMIT} candidates {}, true map kept {}, preferred {}, alone {}",
        found.len(),
        count(|found| found.whole),
        count(|found| found.kept),
        count(|found| found.preferred),
        count(|found| found.alone)
    );
    println!("  of {left} candidates left in all, errors are found with which all places lie apart: {roomy}");
    for quarter in 1..=4 {
        let at = |found: &&Found| found.candidates[(found.candidates.len() - 1) * quarter / 4];
        let mut counts: Vec<usize> = found.iter().map(at).collect();
        counts.sort_unstable();
        let (Some(least), Some(most)) = (counts.first(), counts.last()) else { continue };
        let (half, tenths) = (counts[counts.len() / 2], counts[(counts.len() - 1) * 9 / 10]);
        println!(
            "  candidates after {quarter}/4 of the walk: least {least}, half of the walks {half} or fewer, nine \
             tenths {tenths} or fewer, most {most}"
        );
    }
    let mut by_axiom: BTreeMap<&str, u64> = BTreeMap::new();
    found
        .iter()
        .flat_map(|found| &found.by_axiom)
        .for_each(|(axiom, n)| *by_axiom.entry(axiom).or_default() += n);
    println!("  refuted by {by_axiom:?}");
}

fn truth(trace: &StarTrace) -> Vec<Assignment> {
    let assignment =
        |&(place, rotation): &(usize, u8)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
    trace.truth.iter().map(assignment).collect()
}

fn explain(sightings: &[(Sighting, Measurements)]) -> Abduction {
    let limits = Limits { max_candidates: Some(LIMIT), ..Limits::default() };
    let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), limits);
    for (sighting, measured) in sightings {
        abduction.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    abduction
}
