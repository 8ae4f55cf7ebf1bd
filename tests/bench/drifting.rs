//! Walks over corridor grids with odometry that drifts.

use topostar::metric::Measurements;
use topostar::trace::{Experience, Sighting};
use topostar::worlds::{Detours, Drift, Place, StarTrace, corridor_grid, covering_walk, drifting_trace_by};

/// Metres from place to place.
pub(crate) const SPACING: f64 = 10.0;

/// The trace of a walk that comes by every place of a square grid, by corridors that may lead aside and back.
pub(crate) fn drifting_walk(
    side: usize,
    detours: impl Fn(&[Place]) -> Detours,
    seed: u64,
    drift: Drift,
) -> StarTrace {
    let places = corridor_grid(side, side, SPACING);
    drifting_trace_by(&places, &covering_walk(&places, seed), drift, seed, &detours(&places)).unwrap()
}

/// What is seen on a trace, each with the measurements so far.
pub(crate) fn sightings(trace: &StarTrace) -> Vec<(Sighting, Measurements)> {
    let mut experience = Experience::new();
    let mut measured = Measurements::default();
    let look = |event| experience.accept(event, &|_, _| unreachable!("bare stars")).unwrap();
    let seen = trace.events.iter().filter_map(look).map(|seen| {
        measured = measured.with(&seen);
        (seen, measured.clone())
    });
    seen.collect()
}
