//! The borders between rooms in the maps that Bormann et al. segmented by hand.

use crate::doors::with_doors;
use crate::maps;
use crate::openings::{DOOR, Opening, Tally};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use topostar::geometry::{Point, Pose, Vector, bearing};
use topostar::grid::{Cell, CellIndex, DistanceField, GridInfo, OccupancyGrid};
use topostar::star::PerceptionParameters;

/// The maps by the files that show them empty, furnished, and segmented.
const MAPS: [(&str, &str); 6] = [
    ("Freiburg52_scan", "Freiburg52_scan"),
    ("Freiburg101_scan", "Freiburg101_scan"),
    ("lab_a_scan", "lab_a_scan"),
    ("lab_intel", "lab_intel"),
    ("office_a", "office_a"),
    ("office_b", "office_b"),
];
/// How far before a border the robot stands, and how much room it must have there, metres.
const BEFORE: f64 = 1.0;
const ROOM: f64 = 0.35;
/// Lines between rooms are drawn up to about so many cells thick.
const THICKNESS: isize = 4;

pub(super) fn print() {
    println!("\nborders of segmented maps");
    let parameters = with_doors(PerceptionParameters::default());
    let mut all: [Tally; 4] = Default::default();
    for (name, file) in MAPS {
        for (furnished, kind) in ["", "_furnitures"].into_iter().enumerate() {
            let map = maps::grid(&format!("rooms/{file}{kind}.png"), 0.05);
            let borders = load(file, &map);
            let (narrow, wide): (Vec<Opening>, Vec<Opening>) =
                borders.into_iter().partition(|border| border.width() <= DOOR);
            for (width, openings) in [narrow, wide].iter().enumerate() {
                let mut tally = Tally::default();
                tally.look(&map, openings, &parameters);
                let word = ["doors", "wider"][width];
                println!("  {name}{kind} {word}: {}", tally.line());
                all[2 * furnished + width].add(tally);
            }
        }
    }
    for (tally, name) in
        all.iter_mut().zip(["empty, doors", "empty, wider", "furnished, doors", "furnished, wider"])
    {
        println!("  all maps {name}: {}", tally.line());
    }
}

/// Where the segmented map closes what is free in the empty one between two rooms.
fn load(file: &str, furnished: &OccupancyGrid) -> Vec<Opening> {
    let empty = maps::grid(&format!("rooms/{file}.png"), 0.05);
    let rooms = maps::grid(&format!("rooms/{file}_gt_segmentation.png"), 0.05);
    let info = *rooms.info();
    let free = |grid: &OccupancyGrid, at: CellIndex| grid.cell(at) == Cell::Free;
    let room_of = pieces(&rooms, |at| free(&rooms, at));
    let strip_of = pieces(&rooms, |at| free(&empty, at) && !free(&rooms, at));
    let mut strips: BTreeMap<(usize, usize, usize), Vec<Point>> = BTreeMap::new();
    for (i, strip) in strip_of.iter().enumerate().filter_map(|(i, strip)| Some((i, (*strip)?))) {
        let around = neighbors_within(&info, info.index(i), THICKNESS);
        let touched: BTreeSet<usize> = around.filter_map(|at| room_of[info.offset(at)]).collect();
        let touched: Vec<usize> = touched.into_iter().collect();
        for (k, &a) in touched.iter().enumerate() {
            for &b in &touched[k + 1..] {
                strips.entry((strip, a, b)).or_default().push(info.center(info.index(i)));
            }
        }
    }
    let distance = DistanceField::new(furnished);
    strips.values().filter_map(|points| border(points, &distance)).collect()
}

/// The border that runs along some points, with the poses before it where a robot has room.
fn border(points: &[Point], distance: &DistanceField) -> Option<Opening> {
    let jambs = farthest(points)?;
    let (middle, along) = (nalgebra::center(&jambs[0], &jambs[1]), (jambs[1] - jambs[0]).normalize());
    let normal = Vector::new(-along.y, along.x);
    let pose = |out: Vector| {
        let at = middle + out * BEFORE;
        let cell = distance.info().cell_at(&at)?;
        (distance.clearance(cell) >= ROOM).then(|| Pose::new(at.x, at.y, bearing(&out) + PI))
    };
    let poses: Vec<Pose> = [normal, -normal].into_iter().filter_map(pose).collect();
    (!poses.is_empty()).then_some(Opening { jambs, poses })
}

fn neighbors_within(info: &GridInfo, at: CellIndex, reach: isize) -> impl Iterator<Item = CellIndex> + use<> {
    let info = *info;
    (-reach..=reach).flat_map(move |dy| (-reach..=reach).filter_map(move |dx| info.shifted(at, dx, dy)))
}

/// The two points that are farthest apart, if they are half a metre or more.
fn farthest(points: &[Point]) -> Option<[Point; 2]> {
    let from = |p: &Point| {
        points.iter().copied().max_by(|a, b| (a - p).norm().total_cmp(&(b - p).norm())).unwrap_or(*p)
    };
    let one = from(points.first()?);
    let other = from(&one);
    ((one - other).norm() >= 0.5).then_some([one, other])
}

/// Numbers the pieces of the chosen cells, connected by sides and corners.
fn pieces(grid: &OccupancyGrid, chosen: impl Fn(CellIndex) -> bool) -> Vec<Option<usize>> {
    let info = grid.info();
    let mut pieces = vec![None; grid.cells().len()];
    let mut count = 0;
    for start in 0..pieces.len() {
        if pieces[start].is_some() || !chosen(info.index(start)) {
            continue;
        }
        let mut stack = vec![start];
        pieces[start] = Some(count);
        while let Some(i) = stack.pop() {
            for next in info.neighbors(info.index(i), true) {
                let j = info.offset(next);
                if pieces[j].is_none() && chosen(next) {
                    pieces[j] = Some(count);
                    stack.push(j);
                }
            }
        }
        count += 1;
    }
    pieces
}
