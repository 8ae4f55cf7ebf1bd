//! Maps created per second over the recorded grid traces; the counts printed do not depend on the machine.

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
            group.bench_function(format!("{profile_name}/{name}"), |bencher| {
                bencher.iter(|| explain(&visits, profile));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, breadth_first);
criterion_main!(benches);
