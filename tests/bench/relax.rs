//! Relaxation beside GTSAM, on the same graphs from the same start in the same run: `cargo xtask compare-relax [PART]`
//! sets GTSAM up and runs it.
//!
//! Seconds are those of one thread on the processor: of GTSAM's the least of some repetitions, of ours the mean. GTSAM's are the making of its
//! optimiser, which orders the unknowns, and its run with its own tolerances; the building of its factors, in Python, is
//! told apart. Ours are ordering and analysis, told apart too, and the relaxation with its choice of a start; the sum of
//! both is compared. Objectives are ours, of the poses that come out; GTSAM measures an error by its logarithm, so that
//! its least is another, and its own sum is shown too.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "a benchmark may fail")]

#[path = "candidate_growth.rs"]
mod candidate_growth;
#[path = "clock.rs"]
mod clock;
#[path = "../../axioms/solver.rs"]
mod solver;

use clock::{mean, processor};
use flate2::read::MultiGzDecoder;
use nalgebra::Matrix3;
use serde::Deserialize;
use serde_json::json;
use solver::{PYTHON, Solver};
use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use topostar::geometry::Pose;
use topostar::patchwork::format::read_graph;
use topostar::patchwork::{Edge, PoseGraph, PoseId, RelaxOptions, Relaxation, Relaxer, Start, relax};

/// The recorded graphs, with the best objective known.
const GRAPHS: [(&str, f64); 7] = [
    ("MIT.g2o", 41.163269),
    ("CSAIL.g2o", 40.555129),
    ("intel.g2o", 45.004696),
    ("FR079_P_toro.graph", f64::NAN),
    ("manhattan.g2o", 3549.0368),
    ("manhattanOlson3500_olson.g2o", 146.076745),
    ("city10000.g2o", 511.985164),
];
const TRUTHS: [(&str, &str); 3] = [
    ("manhattan.g2o", "manhattanOlson3500_groundtruth.txt"),
    ("manhattanOlson3500_olson.g2o", "manhattanOlson3500_groundtruth.txt"),
    ("city10000.g2o", "city10000_groundtruth.txt"),
];
const SIZES: [usize; 4] = [100, 1_000, 10_000, 100_000];
/// Repetitions go on until there are so many or they took so long.
const REPETITIONS: usize = 15;
const SECONDS: f64 = 2.0;

#[derive(Deserialize)]
struct Told {
    setup: f64,
    seconds: Option<f64>,
    error: Option<String>,
    /// The sum of squares as GTSAM counts it.
    own: f64,
    iterations: usize,
    poses: Vec<[f64; 3]>,
}

struct Ours {
    answer: Relaxation,
    setup: f64,
    relaxing: f64,
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let wants = |what: &str| asked.is_empty() || asked.iter().any(|word| word == what);
    let mut gtsam = Solver::start([format!("{}/tests/bench/relax.py", env!("CARGO_MANIFEST_DIR"))]);
    if gtsam.is_none() {
        println!("GTSAM is not compared: {PYTHON} is not set; `cargo xtask compare-relax` sets it\n");
    }
    let there = data("").is_dir();
    if wants("graphs") && there {
        recorded(gtsam.as_mut());
    }
    if wants("truth") && there {
        truth();
    }
    if wants("growing") && there {
        growing();
    }
    if wants("candidates") {
        candidate_growth::print();
    }
    if wants("growth") {
        growth(gtsam.as_mut());
    }
    if !there {
        println!("recorded graphs are left out: {} is not there", data("").display());
    }
}

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/posegraphs").join(file)
}

fn load(file: &str) -> PoseGraph {
    let content = MultiGzDecoder::new(File::open(data(&format!("{file}.gz"))).unwrap());
    read_graph(BufReader::new(content), None).unwrap().graph
}

fn recorded(mut gtsam: Option<&mut Solver>) {
    println!("milliseconds of one thread; `over` is the objective against the best known, less one");
    println!("{}", row(HEADS));
    for (file, best) in GRAPHS {
        let graph = load(file);
        compare(file, &graph, best, gtsam.as_deref_mut());
    }
}

fn compare(name: &str, graph: &PoseGraph, best: f64, gtsam: Option<&mut Solver>) {
    let ours = relaxed(graph);
    let best = if best.is_nan() { ours.answer.objective } else { best };
    let whole = ours.setup + ours.relaxing;
    let [poses, edges] = [graph.len(), graph.edges().len()].map(|n| n.to_string());
    let over = |objective: f64| format!("{:.1e}", objective / best - 1.0);
    let ms = |seconds: f64| format!("{:.2}", seconds * 1e3);
    println!(
        "{}",
        row([
            name,
            &poses,
            &edges,
            "topostar",
            &format!("{:.6}", ours.answer.objective),
            &over(ours.answer.objective),
            &ours.answer.iterations.to_string(),
            &ms(ours.setup),
            &ms(ours.relaxing),
            "1",
            "",
        ])
    );
    let Some(gtsam) = gtsam else { return };
    let start = Relaxer::new(graph, &RelaxOptions::default()).unwrap().guesses();
    for method in ["gauss-newton", "levenberg-marquardt"] {
        let told: Told = serde_json::from_value(gtsam.ask(&request(graph, &start, method))).unwrap();
        let solver = if method == "gauss-newton" { "GTSAM GN" } else { "GTSAM LM" };
        let Some(seconds) = told.seconds.filter(|_| told.error.is_none()) else {
            let error = told.error.unwrap_or_default();
            println!("{}", row(["", "", "", solver, "throws:", &error, "", "", "", "", ""]));
            continue;
        };
        let poses: Vec<Pose> = told.poses.iter().map(|[x, y, theta]| Pose::new(*x, *y, *theta)).collect();
        let objective: f64 = graph.strains(&poses).unwrap().iter().map(|strain| strain.chi_square).sum();
        let cells = [
            &format!("{objective:.6}"),
            &over(objective),
            &told.iterations.to_string(),
            &ms(told.setup),
            &ms(seconds),
            &format!("{:.2}", seconds / whole),
            &format!("{:.6}", told.own),
        ];
        let [a, b, c, d, e, f, g] = cells.map(String::as_str);
        println!("{}", row(["", "", "", solver, a, b, c, d, e, f, g]));
    }
}

const HEADS: [&str; 11] =
    ["graph", "poses", "edges", "solver", "objective", "over", "steps", "set-up", "run", "ratio", "its own"];

fn row(cells: [&str; 11]) -> String {
    let [a, b, c, d, e, f, g, h, i, j, k] = cells;
    format!("{a:<28} {b:>6} {c:>6} {d:<9} {e:>15} {f:>8} {g:>5} {h:>9} {i:>9} {j:>7} {k:>15}")
}

fn request(graph: &PoseGraph, start: &[Pose], method: &str) -> serde_json::Value {
    let edges = graph.edges().iter().map(|edge| {
        let [i, j] = [edge.from, edge.to].map(|id| graph.number(id).unwrap() as f64);
        let (z, w) = (&edge.displacement, &edge.information);
        let [a, b, c, d, e, f] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| w[place]);
        [i, j, z.x, z.y, z.theta, a, b, c, d, e, f]
    });
    json!({
        "poses": start.iter().map(|pose| [pose.x, pose.y, pose.theta]).collect::<Vec<_>>(),
        "edges": edges.collect::<Vec<_>>(),
        "method": method,
        "repetitions": REPETITIONS,
        "patience": SECONDS,
    })
}

fn relaxed(graph: &PoseGraph) -> Ours {
    let options = RelaxOptions::default();
    let seconds = |work: &dyn Fn()| mean(processor, SECONDS, work);
    let setup = seconds(&|| drop(black_box(Relaxer::new(graph, &options).unwrap())));
    let whole = seconds(&|| drop(black_box(relax(graph, &options).unwrap())));
    Ours { answer: relax(graph, &options).unwrap(), setup, relaxing: whole - setup }
}

/// How far relaxed poses are from where the robot was, after the rigid motion that brings them nearest.
fn truth() {
    println!("\nmetres to the ground truth, root mean square after alignment: poses at the start, relaxed");
    for (file, truth) in TRUTHS {
        let graph = load(file);
        let mut relaxer =
            Relaxer::new(&load(truth), &RelaxOptions { start: Start::Odometry, ..RelaxOptions::default() })
                .unwrap();
        let truth = relaxer.relax().unwrap().poses;
        let mut relaxer = Relaxer::new(&graph, &RelaxOptions::default()).unwrap();
        let before = relaxer.guesses();
        let after = relaxer.relax().unwrap().poses;
        println!("{file:<28} {:>9.3} {:>9.3}", distance(&before, &truth), distance(&after, &truth));
    }
}

fn distance(poses: &[Pose], truth: &[Pose]) -> f64 {
    let count = poses.len().min(truth.len()) as f64;
    let pairs = || poses.iter().zip(truth).map(|(a, b)| (a.position().coords, b.position().coords));
    let (sum_a, sum_b) = pairs()
        .fold(Default::default(), |(s, t): (nalgebra::Vector2<f64>, nalgebra::Vector2<f64>), (a, b)| {
            (s + a, t + b)
        });
    let centred = || pairs().map(|(a, b)| (a - sum_a / count, b - sum_b / count));
    let (dot, cross) = centred().fold((0.0, 0.0), |(d, c), (a, b)| (d + a.dot(&b), c + a.perp(&b)));
    let turn = nalgebra::Rotation2::new(f64::atan2(cross, dot));
    (centred().map(|(a, b)| (turn * a - b).norm_squared()).sum::<f64>() / count).sqrt()
}

/// A graph fed pose by pose, as a robot drives.
fn growing() {
    println!(
        "\nfed pose by pose, milliseconds for each on the processor: median, 99 %, worst; objective at the end, over the best"
    );
    for (file, best) in [GRAPHS[1], GRAPHS[2], GRAPHS[4]] {
        let graph = load(file);
        let (times, objective) = candidate_growth::grown(&graph);
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1e3;
        println!(
            "{file:<28} {:>8.3} {:>8.3} {:>8.3}  {objective:.6} {:.1e}",
            at(0.5),
            at(0.99),
            at(1.0),
            objective / best - 1.0
        );
    }
}

/// Cost by size, on walks through a city of square blocks.
fn growth(mut gtsam: Option<&mut Solver>) {
    println!("\ngrowth: random walks through square blocks, loops where the walk crosses itself");
    println!("{}", row(HEADS));
    for size in SIZES {
        compare(&format!("blocks-{size}"), &city(size), f64::NAN, gtsam.as_deref_mut());
    }
}

/// A walk of steps of a metre on a grid, straight on or around a corner every ten, its odometry noisy, closed wherever it
/// comes within a metre of a pose that is long past.
fn city(count: usize) -> PoseGraph {
    let mut chance = Chance(7);
    let side = (count as f64).sqrt();
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut truth = vec![Pose::IDENTITY];
    for k in 1..count {
        let here = truth[k - 1];
        let mut turn = if k % 10 == 0 { [0.0, 0.0, quarter, -quarter][chance.below(4)] } else { 0.0 };
        let ahead = here.compose(&Pose::new(0.0, 0.0, turn)).compose(&Pose::new(10.0, 0.0, 0.0));
        if k % 10 == 0 && ahead.x.abs().max(ahead.y.abs()) > side / 2.0 + 10.0 {
            turn += 2.0 * quarter;
        }
        truth.push(here.compose(&Pose::new(0.0, 0.0, turn)).compose(&Pose::new(1.0, 0.0, 0.0)));
    }
    let mut graph = PoseGraph::new();
    (0..count as u64).for_each(|id| graph.add_pose(PoseId(id), None).unwrap());
    let mut seen: std::collections::BTreeMap<(i64, i64), usize> = std::collections::BTreeMap::new();
    let information = Matrix3::from_diagonal(&nalgebra::Vector3::new(400.0, 400.0, 2500.0));
    for k in 1..count {
        let cell = (truth[k].x.round() as i64, truth[k].y.round() as i64);
        let past = seen.insert(cell, k).filter(|past| k - past > 20);
        for from in [Some(k - 1), past].into_iter().flatten() {
            let noise = Pose::new(0.05 * chance.normal(), 0.05 * chance.normal(), 0.02 * chance.normal());
            let displacement = truth[from].between(&truth[k]).compose(&noise);
            let [from, to] = [from, k].map(|k| PoseId(k as u64));
            graph.add_edge(Edge { from, to, displacement, information }).unwrap();
        }
    }
    graph
}

/// Seeded chance (Steele, Lea and Flood 2014).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn normal(&mut self) -> f64 {
        let [a, b] = [self.next(), self.next()].map(|n| ((n >> 11) as f64 + 0.5) / (1_u64 << 53) as f64);
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}
