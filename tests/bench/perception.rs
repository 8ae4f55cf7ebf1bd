//! From grid to star on LPMs of 400 x 400 cells, as a whole and stage by stage; how both grow with the cells; and the
//! recorded log of a whole building, where it is there.

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fs::File;
use std::hint::black_box;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::Duration;
use topostar::gateway::find_gateways;
use topostar::geometry::{Point, Pose};
use topostar::grid::{DistanceField, SkeletonGraph, Surroundings, clean, skeletonize};
use topostar::lpm::Lpm;
use topostar::sensor::log::{LogOptions, carmen_scans};
use topostar::sensor::{LaserScan, LocalPose, ScanMatcher};
use topostar::star::{PerceptionParameters, describe};
use topostar::visit::{VisitDetector, VisitParameters};
use topostar::worlds::drawing::{Drawing, window};

const ARMS: [f64; 4] = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];
/// Metres across the window.
const SIDE: f64 = 20.0;

/// Turned by some angle, so that no wall runs along the grid.
fn lpm(plan: &Drawing, cells: u32) -> Option<Lpm> {
    let robot_pose = Pose::new(0.0, 0.0, 0.3);
    let info = window(SIDE, SIDE / f64::from(cells), Point::origin(), 0.0);
    let grid = plan.moved(&robot_pose).render(&info, &robot_pose.position()).ok()?;
    Some(Lpm::new(grid, robot_pose))
}

fn plus() -> Drawing {
    Drawing::new().arms((0.0, 0.0), &ARMS, 16.0, 2.2)
}

fn grid_to_star(criterion: &mut Criterion) {
    let rotunda = Drawing::new().disc((0.0, 0.0), 4.2).arms((0.0, 0.0), &ARMS, 16.0, 2.2);
    for (name, plan) in [("plus", plus()), ("rotunda", rotunda)] {
        if let Some(lpm) = lpm(&plan, 400) {
            stages(&mut group(criterion, &format!("grid to star/{name}")), "", &lpm);
        }
    }
}

/// The same place in cells half as long each time: what is linear in the cells takes as long for each of them.
fn growth(criterion: &mut Criterion) {
    let mut group = group(criterion, "growth");
    for cells in [100, 200, 400, 800, 1600] {
        if let Some(lpm) = lpm(&plus(), cells) {
            group.throughput(Throughput::Elements(u64::from(cells) * u64::from(cells)));
            stages(&mut group, &format!("{cells} x {cells} cells/"), &lpm);
        }
    }
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1)).sample_size(20);
    group
}

fn stages(group: &mut BenchmarkGroup<WallTime>, prefix: &str, lpm: &Lpm) {
    let parameters = PerceptionParameters::default();
    let robot = lpm.robot_pose.position();
    let name = |stage: &str| format!("{prefix}{stage}");
    group.bench_function(name("whole"), |b| b.iter(|| describe(black_box(lpm), &parameters)));
    group.bench_function(name("cleaning"), |b| b.iter(|| clean(black_box(&lpm.grid), &parameters.cleaning)));
    let grid = clean(&lpm.grid, &parameters.cleaning);
    group.bench_function(name("distance"), |b| b.iter(|| DistanceField::new(black_box(&grid))));
    let distance = DistanceField::new(&grid);
    let thin = || skeletonize(black_box(&grid), &distance, &Surroundings::of(robot), &parameters.skeleton);
    group.bench_function(name("skeleton"), |b| b.iter(thin));
    let Ok(skeleton) = thin() else { return };
    group.bench_function(name("graph"), |b| b.iter(|| SkeletonGraph::new(black_box(&skeleton), &distance)));
    let graph = SkeletonGraph::new(&skeleton, &distance);
    group.bench_function(name("gateways"), |b| {
        b.iter_batched_ref(
            || graph.clone(),
            |graph| find_gateways(graph, &distance, &robot, &parameters.skeleton, &parameters.gateway),
            BatchSize::SmallInput,
        )
    });
}

/// The raw ACES log to its visits: 7374 scans of 1366 s, one thread.
fn log_to_visits(criterion: &mut Criterion) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/logs/aces.clf.bz2");
    let Ok(scans) = read(&file) else {
        println!("log to visits: left out, as {} is not there", file.display());
        return;
    };
    let mut group = criterion.benchmark_group("log to visits");
    group.warm_up_time(Duration::from_millis(1)).sample_size(10);
    let poses = matched(&scans);
    group.bench_function("reading", |b| b.iter(|| read(black_box(&file))));
    group.bench_function("matching", |b| b.iter(|| matched(black_box(&scans))));
    group.bench_function("visits", |b| b.iter(|| visits(black_box(&scans), &poses)));
    group.bench_function("whole", |b| {
        b.iter(|| read(black_box(&file)).map(|scans| visits(&scans, &matched(&scans))))
    });
}

fn read(file: &PathBuf) -> std::io::Result<Vec<LaserScan>> {
    let mut packed = Vec::new();
    File::open(file)?.read_to_end(&mut packed)?;
    let log = BufReader::new(bzip2::read::MultiBzDecoder::new(packed.as_slice()));
    Ok(carmen_scans(log, LogOptions::default()).read_all().0)
}

fn matched(scans: &[LaserScan]) -> Vec<LocalPose> {
    let mut matcher = ScanMatcher::new(VisitParameters::default().matching);
    scans.iter().map(|scan| matcher.add(scan)).collect()
}

fn visits(scans: &[LaserScan], poses: &[LocalPose]) -> Option<usize> {
    let mut detector = VisitDetector::new(VisitParameters::default()).ok()?;
    let found: usize =
        scans.iter().zip(poses).map(|(scan, pose)| detector.add_placed(scan, pose).len()).sum();
    Some(found + detector.finish().len())
}

criterion_group!(benches, grid_to_star, growth, log_to_visits);
criterion_main!(benches);
