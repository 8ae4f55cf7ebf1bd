//! Scans to a grid: ray casting in log odds.

use crate::geometry::{Point, Pose, Vector};
use crate::grid::{Cell, CellIndex, GridInfo, OccupancyGrid};
use crate::sensor::LaserScan;

/// How much a beam that passes through a cell speaks for free, and one that ends in it for occupied, in log
/// odds; a cell is decided beyond the threshold and never surer than the limit, so that it can be unlearned.
const PASSED: f32 = -0.4;
const HIT: f32 = 1.2;
const DECIDED: f32 = 0.5;
const LIMIT: f32 = 6.0;

/// Beams are used up to this range, metres: further out they lie too far apart to mean free space.
pub const MAX_RANGE: f64 = 12.0;

/// Evidence of occupancy in log odds, a cell each.
#[derive(Clone, Debug)]
pub struct EvidenceGrid {
    info: GridInfo,
    odds: Vec<f32>,
    /// The scan that last hit a cell, so that no beam of the same scan frees it again.
    last_hit: Vec<u32>,
    /// How far the robot had driven when a beam last met a cell, metres.
    met: Vec<f32>,
    driven: f32,
    memory: f32,
    scans: u32,
}

impl EvidenceGrid {
    /// A grid without evidence, which forgets what the robot saw so many metres of driving ago: it would lie where the
    /// robot then thought it was.
    pub fn new(info: GridInfo, memory: f64) -> Self {
        let cells = info.width * info.height;
        EvidenceGrid {
            info,
            odds: vec![0.0; cells],
            last_hit: vec![0; cells],
            met: vec![0.0; cells],
            driven: 0.0,
            memory: memory as f32,
            scans: 0,
        }
    }

    /// Adds a scan taken at a pose of the robot in the grid's frame, when it had driven so many metres. Linear in the
    /// cells that the beams cross.
    pub fn add(&mut self, scan: &LaserScan, grid_from_robot: &Pose, driven: f64) {
        self.scans += 1;
        self.driven = driven as f32;
        let from = grid_from_robot.transform_point(&scan.robot_from_laser.position());
        let ends: Vec<(Point, bool)> =
            scan.hits().map(|hit| shorten(&from, &grid_from_robot.transform_point(&hit))).collect();
        for (end, _) in ends.iter().filter(|(_, hit)| *hit) {
            if let Some(cell) = self.info.cell_at(end) {
                self.learn(cell, HIT);
                let at = self.offset(cell);
                self.last_hit[at] = self.scans;
            }
        }
        for (end, hit) in &ends {
            let last = self.info.cell_at(end).filter(|_| *hit);
            for cell in cells_crossed(&self.info, &from, end) {
                let at = self.offset(cell);
                if Some(cell) != last && self.last_hit[at] != self.scans {
                    self.learn(cell, PASSED);
                }
            }
        }
    }

    /// Moves the grid by whole cells so that a point is in its middle cell; what comes in is not known, what goes out is
    /// forgotten.
    pub fn center_on(&mut self, point: &Point) {
        let GridInfo { resolution, width, height, origin } = self.info;
        let at = origin.inverse().transform_point(point);
        let cells = |length: f64, side: usize| (length / resolution).floor() as isize - side as isize / 2;
        let (dx, dy) = (cells(at.x, width), cells(at.y, height));
        if (dx, dy) == (0, 0) {
            return;
        }
        let from = |x: usize, y: usize| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (x < width && y < height).then(|| y * width + x)
        };
        let cells = || (0..height).flat_map(|y| (0..width).map(move |x| from(x, y)));
        self.odds = cells().map(|at| at.map_or(0.0, |at| self.odds[at])).collect();
        self.met = cells().map(|at| at.map_or(0.0, |at| self.met[at])).collect();
        self.last_hit = cells().map(|at| at.map_or(0, |at| self.last_hit[at])).collect();
        let corner = Point::new(dx as f64 * resolution, dy as f64 * resolution);
        let corner = origin.transform_point(&corner);
        self.info.origin = Pose { x: corner.x, y: corner.y, ..origin };
    }

    /// The middle of the grid, in its frame.
    pub fn middle(&self) -> Point {
        let half = |cells: usize| (cells / 2) as f64 * self.info.resolution;
        self.info.origin.transform_point(&Point::new(half(self.info.width), half(self.info.height)))
    }

    /// What is decided in the square of so many metres around a point, in a frame with its origin there; cells are
    /// kept as they are, and those outside the grid are unknown.
    pub fn around(&self, middle: &Point, side: f64) -> Result<OccupancyGrid, crate::grid::GridError> {
        let GridInfo { resolution, width, height, origin } = self.info;
        let corner = origin.inverse().transform_point(middle) - Vector::new(side, side) / 2.0;
        let first = [corner.x, corner.y].map(|v| (v / resolution).round() as isize);
        let cells = (side / resolution).round() as usize;
        let corner = Point::new(first[0] as f64 * resolution, first[1] as f64 * resolution);
        let corner = origin.transform_point(&corner) - middle.coords;
        let info = GridInfo {
            resolution,
            width: cells,
            height: cells,
            origin: Pose { x: corner.x, y: corner.y, ..origin },
        };
        OccupancyGrid::check(&info)?;
        let cell = |x: usize, y: usize| {
            let (x, y) = (x.checked_add_signed(first[0])?, y.checked_add_signed(first[1])?);
            (x < width && y < height).then(|| self.decided(y * width + x))
        };
        let cells = (0..cells).flat_map(|y| (0..cells).map(move |x| cell(x, y).unwrap_or(Cell::Unknown)));
        OccupancyGrid::new(info, cells.collect())
    }

    /// What is decided by now.
    pub fn occupancy(&self) -> Vec<Cell> {
        (0..self.odds.len()).map(|at| self.decided(at)).collect()
    }

    /// The decided cells as a grid.
    pub fn grid(&self) -> Result<OccupancyGrid, crate::grid::GridError> {
        OccupancyGrid::new(self.info, self.occupancy())
    }

    fn learn(&mut self, cell: CellIndex, evidence: f32) {
        let at = self.offset(cell);
        let known = if self.is_forgotten(at) { 0.0 } else { self.odds[at] };
        self.odds[at] = (known + evidence).clamp(-LIMIT, LIMIT);
        self.met[at] = self.driven;
    }

    fn decided(&self, at: usize) -> Cell {
        match self.odds[at] {
            _ if self.is_forgotten(at) => Cell::Unknown,
            odds if odds > DECIDED => Cell::Occupied,
            odds if odds < -DECIDED => Cell::Free,
            _ => Cell::Unknown,
        }
    }

    fn is_forgotten(&self, at: usize) -> bool {
        self.driven - self.met[at] > self.memory
    }

    fn offset(&self, cell: CellIndex) -> usize {
        cell.y * self.info.width + cell.x
    }
}

/// The point at which a beam ends for the grid, and whether it is a hit: beams beyond [`MAX_RANGE`] are cut.
fn shorten(from: &Point, to: &Point) -> (Point, bool) {
    let beam = to - from;
    let length = beam.norm();
    if length < MAX_RANGE { (*to, true) } else { (from + beam * (MAX_RANGE / length), false) }
}

/// The cells that the segment between two points of the grid's frame crosses, in order, those outside the grid
/// left out (Amanatides and Woo 1987). Ours because a query against a shape hierarchy costs several times as
/// much a ray; tested against parry's ray casting.
pub fn cells_crossed(info: &GridInfo, from: &Point, to: &Point) -> impl Iterator<Item = CellIndex> + use<> {
    let local = |point: &Point| {
        let p = info.origin.inverse().transform_point(point);
        [p.x / info.resolution, p.y / info.resolution]
    };
    let (start, end) = (local(from), local(to));
    let (width, height) = (info.width as i64, info.height as i64);
    let steps = Steps::new(start, end);
    steps.filter_map(move |[x, y]| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then_some(CellIndex { x: x as usize, y: y as usize })
    })
}

/// Cells from the grid's corner beyond which a segment is not walked along.
const FARTHEST: f64 = 1e9;

/// A walk over unit cells along a segment.
struct Steps {
    cell: [i64; 2],
    step: [i64; 2],
    /// Fraction of the segment at which the next cell border of each axis is met.
    next: [f64; 2],
    /// Fraction of the segment between two borders of each axis.
    delta: [f64; 2],
    left: i64,
}

impl Steps {
    fn new(start: [f64; 2], end: [f64; 2]) -> Steps {
        let first = start.map(|v| v.floor() as i64);
        let last = end.map(|v| v.floor() as i64);
        let axis = |a: usize| {
            let d = end[a] - start[a];
            if d == 0.0 {
                return (0, f64::INFINITY, f64::INFINITY);
            }
            let border = if d > 0.0 { first[a] as f64 + 1.0 } else { first[a] as f64 };
            (d.signum() as i64, (border - start[a]) / d, 1.0 / d.abs())
        };
        let ((sx, nx, dx), (sy, ny, dy)) = (axis(0), axis(1));
        // Cells that far from the grid are not countable, and none of them is in it.
        let near = start.iter().chain(&end).all(|v| v.abs() < FARTHEST);
        let left = if near { (last[0] - first[0]).abs() + (last[1] - first[1]).abs() + 1 } else { 0 };
        Steps { cell: first, step: [sx, sy], next: [nx, ny], delta: [dx, dy], left }
    }
}

impl Iterator for Steps {
    type Item = [i64; 2];

    fn next(&mut self) -> Option<[i64; 2]> {
        if self.left <= 0 {
            return None;
        }
        self.left -= 1;
        let here = self.cell;
        let axis = usize::from(self.next[1] < self.next[0]);
        self.cell[axis] += self.step[axis];
        self.next[axis] += self.delta[axis];
        Some(here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry2d_f64::bounding_volume::Aabb;
    use parry2d_f64::math::Vector as ParryVector;
    use parry2d_f64::query::{Ray, RayCast};
    use proptest::prelude::*;

    fn info() -> GridInfo {
        GridInfo { resolution: 0.25, width: 20, height: 12, origin: Pose::new(-1.0, 0.5, 0.7) }
    }

    /// Whether the segment passes through the inside of the cell, by parry.
    fn crosses(cell: [i64; 2], start: [f64; 2], end: [f64; 2], slack: f64) -> bool {
        let corner = |d: f64| ParryVector::new(cell[0] as f64 + d, cell[1] as f64 + d);
        let square = Aabb::new(corner(-slack), corner(1.0 + slack));
        let ray = Ray::new(
            ParryVector::new(start[0], start[1]),
            ParryVector::new(end[0] - start[0], end[1] - start[1]),
        );
        square.cast_local_ray(&ray, 1.0, true).is_some()
    }

    proptest! {
        #[test]
        fn the_walk_meets_just_the_cells_that_parry_meets(
            sx in 0.0..20.0, sy in 0.0..12.0, ex in 0.0..20.0, ey in 0.0..12.0,
        ) {
            let (start, end) = ([sx, sy], [ex, ey]);
            let walked: Vec<[i64; 2]> = Steps::new(start, end).collect();
            for x in 0..20 {
                for y in 0..12 {
                    if crosses([x, y], start, end, -1e-9) {
                        prop_assert!(walked.contains(&[x, y]), "missed {x} {y}");
                    }
                }
            }
            prop_assert!(walked.iter().all(|&c| crosses(c, start, end, 1e-9)));
            prop_assert_eq!(walked.last().copied(), Some(end.map(|v: f64| v.floor() as i64)));
        }
    }

    #[test]
    fn a_segment_beyond_all_bounds_crosses_no_cell() {
        for far in [1e10, 1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(Steps::new([far, -far], [-far, far]).count(), 0);
            assert_eq!(Steps::new([0.5, 0.5], [far, 0.5]).count(), 0);
        }
    }

    #[test]
    fn a_wall_ahead_is_occupied_and_the_way_to_it_free() {
        let mut grid = EvidenceGrid::new(info(), 10.0);
        let scan = LaserScan {
            laser: crate::sensor::log::LaserNumber::FRONT,
            stamp: 0.0,
            odom_from_robot: Pose::IDENTITY,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.0,
            ranges: vec![Some(2.0), None, Some(2.0)],
        };
        let pose = info().origin.compose(&Pose::new(1.1, 1.1, 0.0));
        grid.add(&scan, &pose, 0.0);
        grid.add(&scan, &pose, 1.0);
        let occupancy = grid.grid().unwrap();
        let at = |x: f64| {
            occupancy.cell(occupancy.info().cell_at(&pose.transform_point(&Point::new(x, 0.0))).unwrap())
        };
        assert_eq!(
            (at(0.0), at(1.5), at(2.0), at(2.5)),
            (Cell::Free, Cell::Free, Cell::Occupied, Cell::Unknown)
        );
        // Far away, and long ago: one glance is not enough to decide anything.
        let glance = LaserScan { ranges: vec![Some(2.0)], ..scan };
        grid.add(&glance, &pose, 12.0);
        assert!(grid.occupancy().iter().all(|cell| *cell != Cell::Free));
    }
}
