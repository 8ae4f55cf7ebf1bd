//! Distance field, skeleton and graph beside OpenCV, scikit-image and sknw, on the same maps and in the same run: first
//! whether both give the same answers, then how long each takes. `cargo xtask compare-perception` sets them up.
//!
//! * The distance field of a grid beside `cv2.distanceTransform` with its precise mask: equal up to the rounding of the
//!   latter's single precision.
//! * Skeleton and graph beside `skeletonize` and `medial_axis` with `sknw`, all of the same cells: those within the window where
//!   the passage fits, connected to the robot. Each must be one piece with as many loops as those cells have holes.
//!   Ours keeps ways out only, theirs has a branch into every corner too; so it is told how far our cells and
//!   junctions lie from theirs at most, in cells, and not the other way round. What is counted of ours begins with the
//!   distance field: cutting out the window, finding the cells to thin and those at which ways leave it, thinning and
//!   the graph. Of theirs it begins with the cells to thin: in an array as large as the grid, or, as `cut`, in the
//!   smallest part of it that holds them, which saves most of what is not thinning. `medial_axis` computes its
//!   distances itself, so that ours are counted with it.
//!
//! Seconds are those of one thread on the processor: ours the mean, theirs the least of repetitions in a process that is
//! warm.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "a benchmark may fail")]

#[path = "clock.rs"]
mod clock;
#[path = "gateways/maps.rs"]
#[allow(dead_code, reason = "the pictures are not drawn here")]
mod maps;
#[path = "../../axioms/solver.rs"]
mod solver;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::json;
use solver::{PYTHON, Solver};
use std::f64::consts::{FRAC_PI_2, PI};
use std::hint::black_box;
use std::process::ExitCode;
use topostar::geometry::{Point, Pose};
use topostar::grid::{
    Cell, CellIndex, DistanceField, NodeKind, OccupancyGrid, SkeletonGraph, SkeletonParameters, Surroundings,
    skeletonize,
};
use topostar::worlds::drawing::{Drawing, window};

/// Repetitions go on for so many seconds.
const SECONDS: f64 = 0.5;
/// Recorded maps with the length of a cell; windows are cut around points this far apart, metres, some of each map.
const MAPS: [(&str, f64); 5] = [
    ("gdc3/3.pgm.gz", 0.05),
    ("ros/mit-stata-basement_fixed.png", 0.0504),
    ("ros/willow-full-0.05.pgm.gz", 0.05),
    ("rooms/lab_intel_furnitures.png", 0.05),
    ("rooms/office_a_furnitures.png", 0.05),
];
const LATTICE: f64 = 8.0;
const WINDOWS: usize = 2;

fn main() -> ExitCode {
    let root = env!("CARGO_MANIFEST_DIR");
    let Some(mut rivals) = Solver::start([format!("{root}/tests/bench/perception_rival.py")]) else {
        println!("nothing to compare with: {PYTHON} is not set; `cargo xtask compare-perception` sets it");
        return ExitCode::SUCCESS;
    };
    println!("milliseconds of one thread on the processor; ratio: theirs to ours");
    println!("off: the greatest distance of a cell and of a junction of ours from theirs, cells");
    println!("{:38} {:23} {:>8} {:>8} {:>6}", "grid", "rival", "ours", "theirs", "ratio");
    let mut agree = true;
    for (name, grid, robot) in drawn().into_iter().chain(recorded()) {
        agree &= compare(&mut rivals, &name, &grid, robot);
    }
    println!("\n{}", if agree { "all answers agree" } else { "SOME ANSWERS DIFFER" });
    if agree { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

type Question = (String, OccupancyGrid, Option<Point>);

/// Worlds that are always there: a crossing and a round hall, turned so that no wall runs along the grid.
fn drawn() -> Vec<Question> {
    let arms = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];
    let plus = Drawing::new().arms((0.0, 0.0), &arms, 16.0, 2.2);
    let rotunda = Drawing::new().disc((0.0, 0.0), 4.2).block((-1.0, -1.0), (1.0, 0.5)).arms(
        (0.0, 0.0),
        &arms,
        16.0,
        2.2,
    );
    let mut questions = Vec::new();
    for (name, plan, robot) in [("plus", plus, Point::origin()), ("rotunda", rotunda, Point::new(0.0, 2.5))] {
        for resolution in [0.1, 0.05, 0.025] {
            let turned = Pose::new(0.0, 0.0, 0.3);
            let robot = turned.transform_point(&robot);
            let grid =
                plan.moved(&turned).render(&window(20.0, resolution, Point::origin(), 0.0), &robot).unwrap();
            questions.push((format!("{name}, {0} x {0}", grid.info().width), grid, Some(robot)));
        }
    }
    questions
}

/// Recorded maps, whole and in windows of 400 x 400 cells, where they are.
fn recorded() -> Vec<Question> {
    if !maps::data("maps").is_dir() {
        println!("recorded maps are left out, as ../shared/data is not there");
        return Vec::new();
    }
    let mut questions = Vec::new();
    for (file, resolution) in MAPS {
        let map = maps::grid(file, resolution);
        let name = file.rsplit('/').next().unwrap().split('.').next().unwrap();
        let robots: Vec<Point> = lattice(&map).into_iter().take(WINDOWS).collect();
        let windows = robots.into_iter().map(|robot| {
            let grid = maps::lpm(&map, &Pose::new(robot.x, robot.y, 0.0)).grid;
            (format!("{name}, window at {:.0},{:.0}", robot.x, robot.y), grid, Some(robot))
        });
        questions.extend(windows.collect::<Vec<_>>());
        questions.push((format!("{name}, {} x {}", map.info().width, map.info().height), map, None));
    }
    questions
}

/// Points at which a robot has room and out of whose window ways lead.
fn lattice(map: &OccupancyGrid) -> Vec<Point> {
    let distance = DistanceField::new(map);
    let info = map.info();
    let side = |cells: usize| (cells as f64 * info.resolution / LATTICE) as usize;
    let at = |k: usize| {
        let lattice = |n: usize| (n as f64 + 0.5) * LATTICE;
        Point::new(lattice(k % side(info.width)), lattice(k / side(info.width)))
    };
    let fits = |robot: &Point| {
        let room = info.cell_at(robot).is_some_and(|cell| (0.7..5.0).contains(&distance.clearance(cell)));
        room && thinned(&maps::lpm(map, &Pose::new(robot.x, robot.y, 0.0)).grid, robot).is_some()
    };
    (0..side(info.width) * side(info.height)).map(at).filter(fits).collect()
}

/// No coasts, so that all free space is thinned where the passage fits.
fn parameters() -> SkeletonParameters {
    SkeletonParameters { comfort_distance: 1e3, ..SkeletonParameters::default() }
}

fn thinned(grid: &OccupancyGrid, robot: &Point) -> Option<SkeletonGraph> {
    let distance = DistanceField::new(grid);
    let skeleton = skeletonize(grid, &distance, &Surroundings::of(*robot), &parameters()).ok()?;
    Some(SkeletonGraph::new(&skeleton, &distance))
}

#[derive(Deserialize)]
struct Answer {
    distance: String,
    distance_seconds: f64,
    holes: Option<usize>,
    #[serde(default)]
    skeletons: Vec<Rival>,
}

#[derive(Deserialize)]
struct Rival {
    name: String,
    seconds: f64,
    cells: String,
    components: usize,
    loops: usize,
    junctions: Vec<[f64; 2]>,
}

/// Whether all that is compared agrees.
fn compare(rivals: &mut Solver, name: &str, grid: &OccupancyGrid, robot: Option<Point>) -> bool {
    let info = *grid.info();
    let free: Vec<u8> = grid.cells().iter().map(|&cell| u8::from(cell == Cell::Free)).collect();
    let core = robot.map(|robot| core(grid, &robot));
    let request = json!({
        "width": info.width,
        "height": info.height,
        "free": STANDARD.encode(&free),
        "core": core.map(|core| STANDARD.encode(&core)),
        "seconds": SECONDS,
    });
    let answer: Answer = serde_json::from_value(rivals.ask(&request)).unwrap();
    let ours = seconds(|| DistanceField::new(black_box(grid)));
    let distance = DistanceField::new(grid);
    let theirs = STANDARD.decode(&answer.distance).unwrap();
    let off = theirs.chunks_exact(4).zip(distance.squared()).map(|(theirs, &ours)| {
        let theirs = f64::from(f32::from_ne_bytes([theirs[0], theirs[1], theirs[2], theirs[3]]));
        (theirs - f64::from(ours).sqrt()).abs() / theirs.max(1.0)
    });
    let off = off.fold(0.0, f64::max);
    let mut agree = off < 1e-5;
    let same = if agree { "same" } else { "DIFFERENT" };
    print_row(
        name,
        "cv2.distanceTransform",
        ours,
        answer.distance_seconds,
        &format!("{same} distances, {off:.0e}"),
    );
    if let (Some(robot), Some(holes)) = (robot, answer.holes) {
        for rival in &answer.skeletons {
            agree &= compare_skeletons(name, grid, &robot, rival, holes);
        }
    }
    agree
}

fn compare_skeletons(name: &str, grid: &OccupancyGrid, robot: &Point, rival: &Rival, holes: usize) -> bool {
    let distance = DistanceField::new(grid);
    let around = Surroundings::of(*robot);
    let thin = |distance: &DistanceField| {
        let skeleton = skeletonize(grid, distance, &around, &parameters()).unwrap();
        SkeletonGraph::new(&skeleton, distance)
    };
    let ours = match rival.name.as_str() {
        "medial_axis" => seconds(|| thin(&DistanceField::new(black_box(grid)))),
        _ => seconds(|| thin(black_box(&distance))),
    };
    let graph = thin(&distance).graph;
    let components = petgraph::algo::connected_components(&graph);
    let loops = graph.edge_count() + components - graph.node_count();
    let theirs: Vec<bool> = STANDARD.decode(&rival.cells).unwrap().iter().map(|&cell| cell != 0).collect();
    let to_theirs = to_nearest(grid, |i| theirs[i]);
    let cells = graph.edge_weights().flat_map(|edge| &edge.cells);
    let off = cells.map(|&cell| to_theirs[grid.info().offset(cell)]).fold(0.0, f64::max);
    let nodes = graph.node_weights().filter(|node| node.kind == NodeKind::Junction);
    let to_junction = |cell: CellIndex| {
        let away = |there: &[f64; 2]| (there[0] - cell.y as f64).hypot(there[1] - cell.x as f64);
        rival.junctions.iter().map(away).fold(f64::INFINITY, f64::min)
    };
    let junctions: Vec<f64> = nodes.map(|node| to_junction(node.cell)).collect();
    let junction_off = junctions.iter().copied().fold(0.0, f64::max);
    let agree = components == 1 && loops == holes;
    let word = if agree { "same" } else { "DIFFERENT" };
    let rest = format!(
        "{word}: pieces {components}, theirs {}; loops {loops}, theirs {}, holes {holes}; junctions {}, theirs {}; off {off:.1}, {junction_off:.1}",
        rival.components,
        rival.loops,
        junctions.len(),
        rival.junctions.len(),
    );
    print_row(name, &format!("{} + sknw", rival.name), ours, rival.seconds, &rest);
    agree
}

fn print_row(name: &str, rival: &str, ours: f64, theirs: f64, rest: &str) {
    let (ours, theirs) = (ours * 1e3, theirs * 1e3);
    println!("{name:38} {rival:23} {ours:8.3} {theirs:8.3} {:6.1}  {rest}", theirs / ours);
}

/// The cells that are thinned, one byte each: found by a flood from the robot.
fn core(grid: &OccupancyGrid, robot: &Point) -> Vec<u8> {
    let (info, distance, parameters) = (*grid.info(), DistanceField::new(grid), parameters());
    let (radius, least) =
        (parameters.scope / info.resolution, (parameters.passage_width / info.resolution + 1.0) / 2.0);
    let start = info.cell_at(robot).unwrap();
    let fits = |at: CellIndex| {
        let (dx, dy) = (at.x as f64 - start.x as f64, at.y as f64 - start.y as f64);
        dx * dx + dy * dy <= radius * radius
            && f64::from(distance.squared()[info.offset(at)]) >= least * least
    };
    let mut core = vec![0; grid.cells().len()];
    let mut open = Vec::from_iter(fits(start).then_some(start));
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut core[info.offset(at)], 1) == 0 {
            open.extend(info.neighbors(at, true).filter(|&next| fits(next)));
        }
    }
    core
}

/// The distance of every cell to the nearest one of which something holds, in cells.
fn to_nearest(grid: &OccupancyGrid, holds: impl Fn(usize) -> bool) -> Vec<f64> {
    let cell = |i: usize| if holds(i) { Cell::Occupied } else { Cell::Free };
    let cells = (0..grid.cells().len()).map(cell).collect();
    let field = DistanceField::new(&OccupancyGrid::new(*grid.info(), cells).unwrap());
    field.squared().iter().map(|&squared| f64::from(squared).sqrt()).collect()
}

/// The mean seconds on the processor that some work takes.
fn seconds<T>(mut work: impl FnMut() -> T) -> f64 {
    clock::mean(clock::processor, SECONDS, || drop(black_box(work())))
}
