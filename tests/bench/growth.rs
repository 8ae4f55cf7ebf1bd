//! What one more observation costs as the walk grows: `cargo bench --bench growth`.
//!
//! Exhaustively, on the recorded grids, the time of each observation and that of each map it creates; on the large grid
//! under a limit, since nothing holds all its candidates. Best-first, the steps and the time from one more observation to
//! the next proven minimum, or to the limit on steps, where that is said. With odometry that drifts as badly as the worst,
//! in corridor grids of two sizes, the time of each observation, that of each candidate it extends and how many least-squares
//! problems it takes to find out whether all has room. Times are the least of a few repetitions by one thread; counts do not depend
//! on the machine.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "a benchmark may fail")]

mod drifting;
#[path = "../../axioms/traces.rs"]
mod traces;

use rayon::ThreadPoolBuilder;
use std::time::Instant;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};
use topostar::metric::Measurements;
use topostar::worlds::{Detours, Drift};

const REPETITIONS: usize = 3;
/// Of the candidates of the large grid.
const LIMIT: usize = 20_000;
/// Of the candidates where odometry drifts.
const MEASURED: usize = 200;
/// Of a search for the simplest alone, after each observation.
const STEPS: u64 = 100_000;

fn main() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let limited = Limits { max_candidates: Some(LIMIT), ..Limits::default() };
    let steps = Limits { max_steps: Some(STEPS), ..Limits::default() };
    for profile in Profile::ALL {
        let axioms = AxiomSet::of(profile);
        let runs = [
            ("exhaustive", "grid4x4-28", Abduction::new(axioms, Limits::default())),
            ("at most 20,000 candidates", "grid6x6-64", Abduction::new(axioms, limited)),
            ("best-first", "grid4x4-28", Abduction::best_first(axioms, steps)),
            ("best-first", "grid6x6-64", Abduction::best_first(axioms, steps)),
        ];
        for (how, trace, start) in runs {
            println!("\n{trace}, {}, {how}", profile.name());
            let seen: Vec<Seen> =
                traces::visits(trace).into_iter().map(|visit| (visit, Measurements::default())).collect();
            pool.install(|| grow(&start, &seen));
        }
    }
    let measured = Limits { max_candidates: Some(MEASURED), ..Limits::default() };
    for side in [4, 6] {
        println!(
            "\n{side}x{side} places, default, odometry as bad as the worst, at most {MEASURED} candidates"
        );
        let start = Abduction::new(AxiomSet::of(Profile::Default), measured);
        pool.install(|| grow(&start, &measured_walk(side)));
    }
}

/// What is observed, and what was measured so far.
type Seen = (Visit, Measurements);

fn measured_walk(side: usize) -> Vec<Seen> {
    let seen = drifting::sightings(&drifting::drifting_walk(side, |_| Detours::default(), 0, Drift::WORST));
    seen.into_iter().map(|(seen, measured)| (Visit::from(&seen), measured)).collect()
}

fn grow(start: &Abduction, seen: &[Seen]) {
    let mut grown: Vec<Event> = walk(start, seen);
    for _ in 1..REPETITIONS {
        let again = walk(start, seen);
        grown
            .iter_mut()
            .zip(again)
            .for_each(|(event, again)| event.seconds = event.seconds.min(again.seconds));
    }
    let unit = if grown.iter().any(|event| event.settled) { "steps" } else { "created" };
    println!(
        "{:>11} {:>10} {:>10} {:>12} {:>12} {:>9}",
        "observation", "candidates", unit, "seconds", "ns for each", "problems"
    );
    for (observation, event) in grown.iter().enumerate() {
        let each = event.seconds * 1e9 / event.done.max(1) as f64;
        let end = if event.settled && !event.proven { " not proven" } else { "" };
        println!(
            "{observation:>11} {:>10} {:>10} {:>12.6} {each:>12.0} {:>9}{end}",
            event.candidates, event.done, event.seconds, event.problems
        );
    }
    let (seconds, problems) = grown
        .iter()
        .fold((0.0, 0), |(seconds, problems), event| (seconds + event.seconds, problems + event.problems));
    println!("{:>11} {:>10} {:>10} {seconds:>12.6} {:>12} {problems:>9}", "in all", "", "", "");
}

/// What one observation took.
struct Event {
    candidates: usize,
    /// Maps created, or steps until all is settled.
    done: u64,
    settled: bool,
    proven: bool,
    seconds: f64,
    /// Solved in searches for room.
    problems: u64,
}

fn walk(start: &Abduction, seen: &[Seen]) -> Vec<Event> {
    let mut abduction = start.clone();
    let mut created = 0;
    let extend = |(visit, measured): &Seen| {
        let (evidence, before) = (measured.evidence(), measured.problems());
        let begun = Instant::now();
        abduction.observe_measured(visit, evidence).unwrap();
        abduction.settle(&|| false);
        let seconds = begun.elapsed().as_secs_f64();
        let settlement = abduction.settlement();
        let report = abduction.report();
        let now = report.maps_created.value;
        let done = settlement.map_or(now - created, |settlement| settlement.steps);
        created = now;
        let settled = settlement.is_some();
        Event {
            candidates: abduction.len(),
            done,
            settled,
            proven: report.proven,
            seconds,
            problems: measured.problems() - before,
        }
    };
    seen.iter().map(extend).collect()
}
