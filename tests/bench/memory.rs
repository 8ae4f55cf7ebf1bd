//! Bytes per candidate: `cargo bench --bench memory`. What an allocator counts does not depend on the machine.
//!
//! Held are the bytes of the whole search once all is observed, without those of the visits, shared equally by the
//! candidates. A node of the tree, of which a candidate has one an observation,
//! shared with those that begin alike, takes eight bytes of them.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "a benchmark may fail")]

#[path = "../../axioms/traces.rs"]
mod traces;

use rayon::ThreadPoolBuilder;
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Bytes of a node of the tree.
const NODE: usize = 8;

fn main() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    println!(
        "{:<11} {:<8} {:>10} {:>10} {:>12} {:>10} {:>10} {:>14}",
        "trace", "profile", "candidates", "nodes", "held", "each", "in maps", "allocations"
    );
    for profile in Profile::ALL {
        for trace in ["grid3x3-16", "grid4x3-20", "grid4x4-24", "grid4x4-28"] {
            pool.install(|| measure(trace, profile));
        }
    }
}

fn measure(trace: &str, profile: Profile) {
    let visits = traces::visits(trace);
    let before = ALLOCATOR.stats();
    let mut abduction = Abduction::new(AxiomSet::of(profile), Limits::default());
    for visit in &visits {
        abduction.observe(visit).unwrap();
    }
    let used = ALLOCATOR.stats() - before;
    let held = used.bytes_allocated.wrapping_sub(used.bytes_deallocated);
    let report = abduction.report();
    let nodes: u64 = report.candidates_per_observation.iter().map(|count| count.value).sum();
    let (candidates, created) = (abduction.len(), report.maps_created.value);
    let maps = held.saturating_sub(nodes as usize * NODE);
    println!(
        "{trace:<11} {:<8} {candidates:>10} {nodes:>10} {held:>12} {:>10.1} {:>10.1} {:>9.2}/map",
        profile.name(),
        held as f64 / candidates as f64,
        maps as f64 / candidates as f64,
        used.allocations as f64 / created as f64
    );
}
