//! From grid to star on LPMs of 400 x 400 cells, as a whole and stage by stage.

use criterion::{Criterion, criterion_group, criterion_main};
use std::f64::consts::{FRAC_PI_2, PI};
use std::hint::black_box;
use topostar::gateway::find_gateways;
use topostar::geometry::{Point, Pose};
use topostar::grid::{DistanceField, SkeletonGraph, Surroundings, clean, skeletonize};
use topostar::lpm::Lpm;
use topostar::star::{PerceptionParameters, describe};
use topostar::worlds::drawing::{Drawing, window};

const ARMS: [f64; 4] = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];

/// Turned by some angle, so that no wall runs along the grid.
fn lpm(plan: &Drawing) -> Option<Lpm> {
    let robot_pose = Pose::new(0.0, 0.0, 0.3);
    let info = window(20.0, 0.05, Point::origin(), 0.0);
    let grid = plan.moved(&robot_pose).render(&info, &robot_pose.position()).ok()?;
    Some(Lpm::new(grid, robot_pose))
}

fn grid_to_star(criterion: &mut Criterion) {
    let plus = Drawing::new().arms((0.0, 0.0), &ARMS, 16.0, 2.2);
    let rotunda = Drawing::new().disc((0.0, 0.0), 4.2).arms((0.0, 0.0), &ARMS, 16.0, 2.2);
    for (name, plan) in [("plus", plus), ("rotunda", rotunda)] {
        let Some(lpm) = lpm(&plan) else { continue };
        stages(criterion, name, &lpm);
    }
}

fn stages(criterion: &mut Criterion, name: &str, lpm: &Lpm) {
    let parameters = PerceptionParameters::default();
    let robot = lpm.robot_pose.position();
    let mut group = criterion.benchmark_group(format!("grid to star/{name}"));
    group.bench_function("whole", |b| b.iter(|| describe(black_box(lpm), &parameters)));
    group.bench_function("cleaning", |b| b.iter(|| clean(black_box(&lpm.grid), &parameters.cleaning)));
    let grid = clean(&lpm.grid, &parameters.cleaning);
    group.bench_function("distance", |b| b.iter(|| DistanceField::new(black_box(&grid))));
    let distance = DistanceField::new(&grid);
    let thin = || skeletonize(black_box(&grid), &distance, &Surroundings::of(robot), &parameters.skeleton);
    group.bench_function("skeleton", |b| b.iter(thin));
    let Ok(skeleton) = thin() else { return };
    group.bench_function("graph", |b| b.iter(|| SkeletonGraph::new(black_box(&skeleton), &distance)));
    let graph = SkeletonGraph::new(&skeleton, &distance);
    group.bench_function("gateways", |b| {
        b.iter_batched_ref(
            || graph.clone(),
            |graph| find_gateways(graph, &distance, &robot, &parameters.skeleton, &parameters.gateway),
            criterion::BatchSize::SmallInput,
        )
    });
    group.finish();
}

criterion_group!(benches, grid_to_star);
criterion_main!(benches);
