//! Maps created per second over the recorded grid traces, by one thread and by two, and the time to the proven minimum;
//! the counts printed do not depend on the machine.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    reason = "a benchmark may fail"
)]

#[path = "../../axioms/traces.rs"]
mod traces;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};

const TRACES: [&str; 4] = ["grid3x3-16", "grid4x3-20", "grid4x4-24", "grid4x4-28"];

fn explain(visits: &[Visit], profile: Profile) -> Abduction {
    let mut abduction = Abduction::new(AxiomSet::of(profile), Limits::default());
    for visit in visits {
        abduction.observe(visit).expect("recorded traces are well-formed");
    }
    abduction
}

fn breadth_first(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("breadth_first");
    group.sample_size(10);
    for profile in Profile::ALL {
        for name in TRACES {
            let visits = traces::visits(name);
            let report = explain(&visits, profile).report();
            let (candidates, created) = (report.candidates.value, report.maps_created.value);
            let refuted = report.refuted.total();
            let profile_name = profile.name();
            println!(
                "{profile_name}/{name}: {candidates} candidates, {created} maps created, {refuted} refuted"
            );
            group.throughput(Throughput::Elements(created));
            for threads in [1, 2] {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                group.bench_function(format!("{profile_name}/{name}/threads {threads}"), |bencher| {
                    bencher.iter(|| pool.install(|| explain(&visits, profile)));
                });
            }
        }
    }
    group.finish();
}

fn settle(visits: &[Visit], profile: Profile) -> Abduction {
    let mut abduction = Abduction::best_first(AxiomSet::of(profile), Limits::default());
    for visit in visits {
        abduction.observe(visit).expect("recorded traces are well-formed");
    }
    abduction.settle(&|| false);
    abduction
}

fn best_first(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("best_first");
    group.sample_size(10);
    for profile in Profile::ALL {
        for name in TRACES.into_iter().chain(["grid6x6-64"]) {
            let visits = traces::visits(name);
            let report = settle(&visits, profile).report();
            let settlement = report.settlement.unwrap();
            let (steps, minima) = (settlement.steps, report.minimal.len());
            let profile_name = profile.name();
            println!("{profile_name}/{name}: {minima} minima, {steps} steps, proven: {}", report.proven);
            group.throughput(Throughput::Elements(steps));
            group.bench_function(format!("{profile_name}/{name}"), |bencher| {
                bencher.iter(|| settle(&visits, profile));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, breadth_first, best_first);
criterion_main!(benches);
