//! The soundness of the measured axioms, counted: random walks over corridor grids with odometry that drifts badly.
//!
//! Each walk's true map is judged step by step by all axioms of profile `default`. That it is judged tells more than
//! that a search keeps it: no limit comes in between. Every tenth walk is searched as well, as far as a limit on
//! candidates lets it. `cargo xtask evaluate [WALKS [SEED]]` runs it: 1000 walks from seed 0 unless told otherwise, with
//! odometry as bad as the worst, with errors as large that are all the same on all metres or all new on every one, and
//! with errors a fifth as large.

#![allow(clippy::unwrap_used, reason = "an evaluation ends where something is wrong")]

use std::collections::BTreeMap;
use std::time::Instant;
use topostar::abduction::{
    Abduction, Assignment, AxiomSet, Limits, Profile, Refutation, Report, Visit, judge,
};
use topostar::map::PlaceId;
use topostar::metric::Measurements;
use topostar::trace::{Experience, Sighting};
use topostar::worlds::{Drift, StarTrace, corridor_grid, covering_walk, drifting_trace};

/// Metres from place to place.
const SPACING: f64 = 10.0;
/// The most candidates kept; walks that have more are counted for themselves.
const LIMIT: usize = 500;
/// Every so many walks one is searched.
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
    for (name, drift) in drifts {
        println!("\nodometry {name}: {drift:?}\n{walks} walks from seed {from}, corridors of {SPACING} m");
        for (side, share) in [(4, walks - walks / 2), (6, walks / 2)] {
            let mut tally = Tally::default();
            for seed in from..from + share {
                tally.add(side, seed, drift);
                if (seed + 1 - from) % 50 == 0 {
                    eprintln!("{side}x{side}: {} of {share}, {:.0} s", seed + 1 - from, tally.seconds);
                }
            }
            tally.print(&format!("{side}x{side}"));
            sound &= tally.refuted.is_empty();
        }
    }
    std::process::exit(if sound { 0 } else { 1 });
}

/// What came out of a number of walks.
#[derive(Default)]
struct Tally {
    walks: usize,
    travels: usize,
    /// Walks whose true map some axiom refutes, with that axiom.
    refuted: Vec<(usize, u64, Refutation)>,
    /// The number of candidates at the end, of walks searched whole.
    candidates: Vec<usize>,
    /// Walks that the limit cut, and of these those that kept the true map.
    cut: usize,
    cut_with_truth: usize,
    /// Walks at whose end the true map is among the preferred, and alone so.
    preferred: usize,
    alone: usize,
    by_axiom: BTreeMap<&'static str, u64>,
    seconds: f64,
}

impl Tally {
    fn add(&mut self, side: usize, seed: u64, drift: Drift) {
        let start = Instant::now();
        let places = corridor_grid(side, side, SPACING);
        let walk = covering_walk(&places, seed);
        let trace = drifting_trace(&places, &walk, drift, seed).unwrap();
        let truth = truth(&trace);
        let sightings = sightings(&trace);
        self.walks += 1;
        self.travels += sightings.len() - 1;
        let visits: Vec<Visit> = sightings.iter().map(Visit::from).collect();
        let measured = sightings.iter().fold(Measurements::default(), |measured, seen| measured.with(seen));
        let evidence = measured.evidence();
        if let Err(refutation) = judge(&visits, evidence.as_deref(), AxiomSet::of(Profile::Default), &truth) {
            self.refuted.push((side, seed, refutation));
        }
        if seed.is_multiple_of(SEARCHED) {
            self.count(&explain(&sightings), &truth);
        }
        self.seconds += start.elapsed().as_secs_f64();
    }

    fn count(&mut self, abduction: &Abduction, truth: &[Assignment]) {
        let report: Report = abduction.report();
        let kept = abduction.candidates().any(|candidate| candidate.visits == truth);
        let preferred = report.minimal.iter().any(|candidate| candidate.visits == truth);
        match report.complete {
            true => self.candidates.push(abduction.len()),
            false => {
                self.cut += 1;
                self.cut_with_truth += usize::from(kept);
            }
        }
        self.preferred += usize::from(preferred);
        self.alone += usize::from(preferred && report.minimal.len() == 1);
        for (axiom, count) in report.refuted.iter() {
            *self.by_axiom.entry(axiom.name()).or_default() += count;
        }
    }

    fn print(&mut self, name: &str) {
        self.candidates.sort_unstable();
        println!("\n{name}: {} walks, {} travels, {:.0} s", self.walks, self.travels, self.seconds);
        println!("  true map refuted {} times", self.refuted.len());
        for (side, seed, refutation) in &self.refuted {
            println!(
                "    {side}x{side} seed {seed}: {} at observation {}: {}",
                refutation.axiom.name(),
                refutation.observation,
                refutation.clash.words
            );
        }
        let at = |share: f64| {
            let last = self.candidates.len().saturating_sub(1);
            self.candidates.get((share * last as f64) as usize).copied().unwrap_or(0)
        };
        println!(
            "  of the walks searched, whole {}: candidates at the end, tenths {:?}, most {}",
            self.candidates.len(),
            (0..=9).map(|tenth| at(f64::from(tenth) / 10.0)).collect::<Vec<_>>(),
            at(1.0)
        );
        println!(
            "  cut at {LIMIT} candidates {}, the true map among those kept {}",
            self.cut, self.cut_with_truth
        );
        println!("  true map preferred {}, alone {}", self.preferred, self.alone);
        println!("  refuted by {:?}", self.by_axiom);
    }
}

fn truth(trace: &StarTrace) -> Vec<Assignment> {
    let assignment =
        |&(place, rotation): &(usize, u8)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
    trace.truth.iter().map(assignment).collect()
}

fn sightings(trace: &StarTrace) -> Vec<Sighting> {
    let mut experience = Experience::new();
    let look = |event| experience.accept(event, &|_, _| unreachable!("bare stars")).unwrap();
    trace.events.iter().filter_map(look).collect()
}

fn explain(sightings: &[Sighting]) -> Abduction {
    let limits = Limits { max_candidates: Some(LIMIT), ..Limits::default() };
    let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), limits);
    let mut measured = Measurements::default();
    for sighting in sightings {
        measured = measured.with(sighting);
        abduction.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    abduction
}
