//! Whether the star of a place survives what does not change the place.

use crate::aces::same_star;
use crate::maps;
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use std::f64::consts::TAU;
use topostar::geometry::{Point, Pose, Vector, direction};
use topostar::grid::{DistanceField, OccupancyGrid};
use topostar::lpm::Lpm;
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};

/// Maps with the length of a cell, metres.
pub(super) const MAPS: [(&str, f64); 7] = [
    ("gdc3/3.pgm.gz", 0.05),
    ("ros/mit-stata-basement_fixed.png", 0.0504),
    ("ros/willow-full-0.05.pgm.gz", 0.05),
    ("rooms/lab_a_scan_furnitures.png", 0.05),
    ("rooms/lab_intel_furnitures.png", 0.05),
    ("rooms/office_a_furnitures.png", 0.05),
    ("rooms/office_b_furnitures.png", 0.05),
];
/// Places are looked for from points this far apart, and one closer than this to another is that one, metres.
const LATTICE: f64 = 4.0;
const SAME_PLACE: f64 = 2.0;
/// The robot must have this much room where it stands, metres.
const ROOM: f64 = 0.5;
/// Stars are told apart by their least margins, between these bounds.
const CLASSES: [f64; 5] = [0.0, 0.05, 0.1, 0.2, f64::INFINITY];
/// How often each place is laid anew.
const LAYINGS: usize = 2;

/// A place of a map: where its middle was found and the star seen from there.
pub(super) struct Place {
    pub(super) middle: Point,
    pub(super) star: LargeScaleStar,
    /// Where the robot stood that saw it.
    pub(super) robot: Pose,
    /// The least margin of its slots.
    margin: f64,
}

/// What is done to a window.
#[derive(Clone, Copy)]
enum Change {
    Turned,
    Shifted,
    Noisy,
    All,
    /// The robot stands elsewhere in the same place.
    Elsewhere,
}

const CHANGES: [(Change, &str); 5] = [
    (Change::Turned, "turned"),
    (Change::Shifted, "shifted"),
    (Change::Noisy, "noisy"),
    (Change::All, "all three"),
    (Change::Elsewhere, "arrival"),
];

pub(super) fn print() {
    println!("\nstars that survive, percent of {LAYINGS} changes a place; through: two gateways, one path");
    let names = CHANGES.map(|(_, name)| format!("{name:>9}")).concat();
    println!("  {:44} places {names}   centre within 0.5 m", "");
    let parameters = PerceptionParameters::default();
    let mut total = [[(0, 0); CHANGES.len() + 1]; 2];
    let mut by_margin = [[(0, 0); CHANGES.len() + 1]; CLASSES.len() - 1];
    for (file, resolution) in MAPS {
        let map = maps::grid(file, resolution);
        let places = places(&map, &parameters);
        for (class, total) in by_margin.iter_mut().enumerate() {
            let sure = |place: &&Place| CLASSES[class] <= place.margin && place.margin < CLASSES[class + 1];
            let row = survive(&map, &places.iter().filter(sure).collect::<Vec<_>>(), &parameters);
            total.iter_mut().zip(row).for_each(|(sum, one)| *sum = (sum.0 + one.0, sum.1 + one.1));
        }
        for (group, name) in ["decisions", "through"].into_iter().enumerate() {
            let group_places: Vec<&Place> =
                places.iter().filter(|place| through(place) == (group == 1)).collect();
            let row = survive(&map, &group_places, &parameters);
            total[group].iter_mut().zip(row).for_each(|(sum, one)| *sum = (sum.0 + one.0, sum.1 + one.1));
            print_row(&format!("{file} {name}"), &row);
        }
    }
    print_row("all decisions", &total[0]);
    print_row("all through", &total[1]);
    for (class, row) in by_margin.iter().enumerate() {
        print_row(&format!("least margin from {} to {}", CLASSES[class], CLASSES[class + 1]), row);
    }
}

fn print_row(name: &str, row: &[(usize, usize)]) {
    let share = |&(part, whole): &(usize, usize)| 100.0 * part as f64 / whole.max(1) as f64;
    let numbers: String = row.iter().map(|pair| format!("{:9.1}", share(pair))).collect();
    println!("  {name:44} {:6} {numbers}", row[0].1 / LAYINGS);
}

fn through(place: &Place) -> bool {
    place.star.size() == 2 && place.star.slots().iter().all(|slot| slot.navigable)
}

/// The places that a robot finds that is put down at points of a lattice.
pub(super) fn places(map: &OccupancyGrid, parameters: &PerceptionParameters) -> Vec<Place> {
    let distance = DistanceField::new(map);
    let info = map.info();
    let side = |cells: usize| (cells as f64 * info.resolution / LATTICE) as usize;
    let mut places: Vec<Place> = Vec::new();
    for k in 0..side(info.width) * side(info.height) {
        let lattice = |n: usize| (n as f64 + 0.5) * LATTICE;
        let robot = Pose::new(lattice(k % side(info.width)), lattice(k / side(info.width)), 0.0);
        let Some(cell) = info.cell_at(&robot.position()) else { continue };
        // Beyond that the robot sees no wall, and a window of an empty hall tells nothing.
        if !(ROOM..5.0).contains(&distance.clearance(cell)) {
            continue;
        }
        let Ok(first) = describe(&maps::lpm(map, &robot), parameters) else { continue };
        if places.iter().any(|place| (place.middle - first.center).norm() < SAME_PLACE) {
            continue;
        }
        let there = Pose::new(first.center.x, first.center.y, 0.0);
        let Ok(place) = describe(&maps::lpm(map, &there), parameters) else { continue };
        let margin = place.star.slots().iter().filter_map(|slot| slot.margin).fold(f64::INFINITY, f64::min);
        places.push(Place { robot: there, middle: place.center, star: place.star.large_scale(), margin });
    }
    places
}

/// For every change how many stars survive it, of how many; and how often the middle stays where it was.
fn survive(
    map: &OccupancyGrid,
    places: &[&Place],
    parameters: &PerceptionParameters,
) -> [(usize, usize); CHANGES.len() + 1] {
    let mut row = [(0, 0); CHANGES.len() + 1];
    let mut random = Random::new();
    for place in places {
        for (column, (change, name)) in CHANGES.into_iter().enumerate() {
            for laying in 0..LAYINGS {
                let lpm = changed(map, place, change, &mut random);
                let seen = describe(&lpm, parameters).ok();
                let star = seen.as_ref().map(|seen| seen.star.large_scale());
                let same = same_star(&Some(place.star.clone()), &star);
                if let (false, Some(seen)) = (same, &seen) {
                    let at = format!("{:.1},{:.1}", place.middle.x, place.middle.y);
                    if let Ok(before) = describe(&maps::lpm(map, &place.robot), parameters) {
                        maps::draw(&before, &place.robot, &format!("{at}-before"));
                    }
                    maps::draw(seen, &lpm.robot_pose, &format!("{at}-{name}-{laying}"));
                }
                row[column] = (row[column].0 + usize::from(same), row[column].1 + 1);
                let middle = seen.is_some_and(|seen| (seen.center - place.middle).norm() <= 0.5);
                let last = &mut row[CHANGES.len()];
                *last = (last.0 + usize::from(middle), last.1 + 1);
            }
        }
    }
    row
}

fn changed(map: &OccupancyGrid, place: &Place, change: Change, random: &mut Random) -> Lpm {
    let turned = match change {
        Change::Turned | Change::All => random.within(TAU / 2.0),
        _ => 0.0,
    };
    let half = map.info().resolution / 2.0;
    let shift = match change {
        Change::Shifted | Change::All => Vector::new(random.within(half), random.within(half)),
        _ => Vector::zeros(),
    };
    let noise = match change {
        Change::Noisy | Change::All => 2.0 * map.info().resolution,
        _ => 0.0,
    };
    let mut robot = place.robot.position();
    if let Change::Elsewhere = change {
        robot = (0..100)
            .map(|_| place.middle + direction(random.within(TAU / 2.0)) * (0.3 + random.within(0.3)))
            .find(|at| {
                map.info().cell_at(at).is_some_and(|cell| map.cell(cell) == topostar::grid::Cell::Free)
            })
            .unwrap_or(robot);
    }
    let waves = Waves::new(noise, random);
    let jitter = |point: Point| waves.moved(point);
    let snap = |v: f64| (v / 0.05).round() * 0.05;
    let middle = Point::new(snap(robot.x), snap(robot.y)) + shift;
    Lpm::new(maps::window(map, &middle, turned, jitter), Pose::new(robot.x, robot.y, 0.0))
}

/// The same random numbers at every run.
struct Random(TestRng);

impl Random {
    fn new() -> Self {
        Random(TestRng::deterministic_rng(RngAlgorithm::ChaCha))
    }

    /// Uniform between minus and plus a bound.
    fn within(&mut self, bound: f64) -> f64 {
        (self.0.next_u32() as f64 / f64::from(u32::MAX) * 2.0 - 1.0) * bound
    }
}

/// Walls that are not where they should be: every point is moved by up to so many cells, smoothly over the distance
/// between the beams of a scanner, so that walls stay whole. Between nodes of a lattice the shift is interpolated.
struct Waves {
    nodes: Vec<Vector>,
}

impl Waves {
    /// Nodes a side, and the distance between them, metres.
    const SIDE: usize = 64;
    const LENGTH: f64 = 0.25;

    fn new(bound: f64, random: &mut Random) -> Self {
        let mut node = |_| Vector::new(random.within(bound), random.within(bound));
        Waves { nodes: (0..Self::SIDE * Self::SIDE).map(&mut node).collect() }
    }

    fn moved(&self, point: Point) -> Point {
        let at = point.coords / Self::LENGTH;
        let (x, y) = (at.x.floor(), at.y.floor());
        let (u, v) = (at.x - x, at.y - y);
        let node = |dx: f64, dy: f64| {
            let wrapped = |k: f64| k.rem_euclid(Self::SIDE as f64) as usize;
            self.nodes[wrapped(y + dy) * Self::SIDE + wrapped(x + dx)]
        };
        let low = node(0.0, 0.0) * (1.0 - u) + node(1.0, 0.0) * u;
        let high = node(0.0, 1.0) * (1.0 - u) + node(1.0, 1.0) * u;
        point + low * (1.0 - v) + high * v
    }
}
