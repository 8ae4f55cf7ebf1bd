//! The soundness of the measured axioms, counted: random walks over corridor grids with odometry that drifts badly.
//!
//! Each walk's true map is judged step by step by all axioms of profile `default`, and the search runs as far as its
//! limit lets it. `cargo xtask evaluate` runs it: 1000 walks unless told another number; `--from SEED` begins there.

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
const LIMIT: usize = 2000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let number = |at: usize| arguments.get(at).and_then(|text| text.parse().ok());
    let (walks, from): (u64, u64) = (number(0).unwrap_or(1000), number(1).unwrap_or(0));
    println!("{walks} walks from seed {from}, corridors of {SPACING} m, {:?}", Drift::WORST);
    let mut all = Tally::default();
    for (side, share) in [(4, walks - walks / 2), (6, walks / 2)] {
        let mut tally = Tally::default();
        for seed in from..from + share {
            tally.add(side, seed);
            if (seed + 1 - from) % 50 == 0 {
                eprintln!("{side}x{side}: {} of {share}, {:.0} s", seed + 1 - from, tally.seconds);
            }
        }
        tally.print(&format!("{side}x{side}"));
        all.join(tally);
    }
    all.print("both");
    std::process::exit(if all.refuted.is_empty() { 0 } else { 1 });
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
    fn add(&mut self, side: usize, seed: u64) {
        let start = Instant::now();
        let places = corridor_grid(side, side, SPACING);
        let walk = covering_walk(&places, seed);
        let trace = drifting_trace(&places, &walk, Drift::WORST, seed).unwrap();
        let truth = truth(&trace);
        let sightings = sightings(&trace);
        self.walks += 1;
        self.travels += sightings.len() - 1;
        let (abduction, measured) = explain(&sightings);
        let visits: Vec<Visit> = sightings.iter().map(Visit::from).collect();
        let evidence = measured.evidence();
        if let Err(refutation) = judge(&visits, evidence.as_deref(), AxiomSet::of(Profile::Default), &truth) {
            self.refuted.push((side, seed, refutation));
        }
        self.count(&abduction, &truth);
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

    fn join(&mut self, other: Tally) {
        self.walks += other.walks;
        self.travels += other.travels;
        self.refuted.extend(other.refuted);
        self.candidates.extend(other.candidates);
        self.cut += other.cut;
        self.cut_with_truth += other.cut_with_truth;
        self.preferred += other.preferred;
        self.alone += other.alone;
        self.seconds += other.seconds;
        for (axiom, count) in other.by_axiom {
            *self.by_axiom.entry(axiom).or_default() += count;
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
            "  searched whole {}: candidates at the end, tenths {:?}, most {}",
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

fn explain(sightings: &[Sighting]) -> (Abduction, Measurements) {
    let limits = Limits { max_candidates: Some(LIMIT) };
    let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), limits);
    let mut measured = Measurements::default();
    for sighting in sightings {
        measured = measured.with(sighting);
        abduction.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    (abduction, measured)
}
