//! Scans to a grid: evidence in log odds along the beams.

use crate::geometry::{Point, Pose, Vector};
use crate::grid::{Cell, CellIndex, GridError, GridInfo, OccupancyGrid};
use crate::sensor::LaserScan;
use crate::sensor::ray_cast::Frame;
use std::ops::Range;

/// How scans are made evidence. One set of defaults serves all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvidenceParameters {
    /// How much a beam that passes through a cell speaks for free, in log odds. Default 0.4.
    pub passed: f64,
    /// How much a beam that ends in a cell speaks for occupied. Default 1.2.
    pub hit: f64,
    /// A cell is decided beyond this. Default 0.5: one hit is enough, one pass is not.
    pub decided: f64,
    /// A cell is never surer than this, so that it can be unlearned. Default 6.
    pub limit: f64,
    /// Beams are used up to this range, metres: further out they lie too far apart to mean free space. Default 12.
    pub max_range: f64,
}

impl Default for EvidenceParameters {
    fn default() -> Self {
        EvidenceParameters { passed: 0.4, hit: 1.2, decided: 0.5, limit: 6.0, max_range: 12.0 }
    }
}

/// Evidence of occupancy in log odds, a cell each.
///
/// The cells are a ring in either direction: a grid that moves keeps its memory where it is, and gives that of the cells
/// that go out to those that come in.
#[derive(Clone, Debug)]
pub struct EvidenceGrid {
    info: GridInfo,
    parameters: EvidenceParameters,
    cells: Vec<Evidence>,
    /// Where in the ring the first column and the first row are.
    first: [usize; 2],
    /// The cells that the last scan hit, one bit each, so that no beam of the same scan frees them again.
    hit: Vec<u64>,
    driven: f32,
    memory: f32,
}

/// What is known of one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Evidence {
    odds: f32,
    /// How far the robot had driven when a beam last met the cell, metres.
    met: f32,
}

impl EvidenceGrid {
    /// A grid without evidence, which forgets what the robot saw so many metres of driving ago: it would lie where the
    /// robot then thought it was.
    pub fn new(info: GridInfo, memory: f64, parameters: EvidenceParameters) -> Self {
        let cells = info.width * info.height;
        EvidenceGrid {
            info,
            parameters,
            cells: vec![Evidence::default(); cells],
            first: [0, 0],
            hit: vec![0; cells.div_ceil(64)],
            driven: 0.0,
            memory: memory as f32,
        }
    }

    /// Adds a scan taken at a pose of the robot in the grid's frame, when it had driven so many metres. Linear in the
    /// cells that the beams cross.
    pub fn add(&mut self, scan: &LaserScan, grid_from_robot: &Pose, driven: f64) {
        self.driven = driven as f32;
        let (passed, hit) = (-self.parameters.passed as f32, self.parameters.hit as f32);
        let (frame, grid_from_robot) = (Frame::new(&self.info), grid_from_robot.transform());
        let from = grid_from_robot.point(&scan.robot_from_laser.position());
        let max_range = self.parameters.max_range;
        let beams = scan.hits().map(|hit| shorten(&from, &grid_from_robot.point(&hit), max_range));
        let beams: Vec<(Point, Option<CellIndex>)> =
            beams.map(|(end, hit)| (end, frame.cell_at(&end).filter(|_| hit))).collect();
        let met: Vec<usize> = beams.iter().filter_map(|(_, met)| met.map(|cell| self.offset(cell))).collect();
        for &at in &met {
            self.learn(at, hit);
            self.hit[at / 64] |= 1 << (at % 64);
        }
        for (end, _) in &beams {
            for cell in frame.crossed(&from, end) {
                let at = self.offset(cell);
                if self.hit[at / 64] >> (at % 64) & 1 == 0 {
                    self.learn(at, passed);
                }
            }
        }
        met.iter().for_each(|at| self.hit[at / 64] = 0);
    }

    /// Moves the grid by whole cells so that a point is in its middle cell; what comes in is not known, what goes out is
    /// forgotten. Linear in the cells that come in.
    pub fn center_on(&mut self, point: &Point) {
        let GridInfo { resolution, width, height, origin } = self.info;
        let at = origin.inverse().transform_point(point);
        let cells = |length: f64, side: usize| (length / resolution).floor() as isize - side as isize / 2;
        let (dx, dy) = (cells(at.x, width), cells(at.y, height));
        let come_in = |moved: isize, side: usize| match moved {
            0.. => side.saturating_sub(moved as usize)..side,
            _ => 0..moved.unsigned_abs().min(side),
        };
        let turned = |first: usize, moved: isize, side: usize| {
            (first as isize + moved % side as isize).rem_euclid(side as isize) as usize
        };
        self.first = [turned(self.first[0], dx, width), turned(self.first[1], dy, height)];
        for y in come_in(dy, height) {
            self.forget(y, 0..width);
        }
        for y in 0..height {
            self.forget(y, come_in(dx, width));
        }
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
    pub fn around(&self, middle: &Point, side: f64) -> Result<OccupancyGrid, GridError> {
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
        let last = |side: usize, first: isize| (side as isize).min(first.saturating_add(cells as isize));
        let known = first[0].max(0)..last(width, first[0]);
        let mut decided = vec![Cell::Unknown; cells * cells];
        for (y, out) in decided.chunks_exact_mut(cells.max(1)).enumerate() {
            let Some(row) = y.checked_add_signed(first[1]).filter(|&y| y < height && !known.is_empty())
            else {
                continue;
            };
            let out = &mut out[(known.start - first[0]) as usize..];
            let [before, behind] = self.row(row, known.start as usize..known.end as usize);
            let (left, right) = out.split_at_mut(before.len());
            left.iter_mut().zip(before).for_each(|(out, cell)| *out = self.decided(cell));
            right.iter_mut().zip(behind).for_each(|(out, cell)| *out = self.decided(cell));
        }
        OccupancyGrid::new(info, decided)
    }

    /// What is decided by now.
    pub fn occupancy(&self) -> Vec<Cell> {
        let rows = (0..self.info.height).flat_map(|y| self.row(y, 0..self.info.width));
        rows.flatten().map(|cell| self.decided(cell)).collect()
    }

    /// The decided cells as a grid.
    pub fn grid(&self) -> Result<OccupancyGrid, GridError> {
        OccupancyGrid::new(self.info, self.occupancy())
    }

    fn learn(&mut self, at: usize, evidence: f32) {
        let limit = self.parameters.limit as f32;
        let cell = &mut self.cells[at];
        let known = if self.driven - cell.met > self.memory { 0.0 } else { cell.odds };
        *cell = Evidence { odds: (known + evidence).clamp(-limit, limit), met: self.driven };
    }

    fn decided(&self, cell: &Evidence) -> Cell {
        let decided = self.parameters.decided as f32;
        let odds = if self.driven - cell.met > self.memory { 0.0 } else { cell.odds };
        if odds > decided {
            Cell::Occupied
        } else if odds < -decided {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }

    /// Where a cell is in the ring.
    fn offset(&self, cell: CellIndex) -> usize {
        let wrapped = |at: usize, side: usize| if at < side { at } else { at - side };
        let row = wrapped(cell.y + self.first[1], self.info.height);
        row * self.info.width + wrapped(cell.x + self.first[0], self.info.width)
    }

    /// The pieces of the ring that are some cells of a row, in their order.
    fn pieces(&self, y: usize, columns: Range<usize>) -> [Range<usize>; 2] {
        let width = self.info.width;
        let start = self.offset(CellIndex { x: 0, y }) - self.first[0];
        let (from, to) = (columns.start + self.first[0], columns.end + self.first[0]);
        let before = start + from.min(width)..start + to.min(width);
        let behind = start + from.max(width) - width..start + to.max(width) - width;
        [before, behind]
    }

    fn row(&self, y: usize, columns: Range<usize>) -> [&[Evidence]; 2] {
        self.pieces(y, columns).map(|piece| &self.cells[piece])
    }

    fn forget(&mut self, y: usize, columns: Range<usize>) {
        for piece in self.pieces(y, columns) {
            self.cells[piece].fill(Evidence::default());
        }
    }
}

/// The point at which a beam ends for the grid, and whether it is a hit: beams beyond the greatest range are cut.
fn shorten(from: &Point, to: &Point, max_range: f64) -> (Point, bool) {
    let beam = to - from;
    let length = beam.norm();
    if length < max_range { (*to, true) } else { (from + beam * (max_range / length), false) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::ray_cast::cells_crossed;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn info() -> GridInfo {
        GridInfo { resolution: 0.25, width: 20, height: 12, origin: Pose::new(-1.0, 0.5, 0.7) }
    }

    /// The same evidence without a ring: cells by their place in a plane without end.
    struct Plain {
        known: BTreeMap<[isize; 2], Evidence>,
        corner: [isize; 2],
    }

    impl Plain {
        fn add(&mut self, info: &GridInfo, scan: &LaserScan, pose: &Pose, driven: f32, memory: f32) {
            let EvidenceParameters { passed, hit, limit, max_range, .. } = EvidenceParameters::default();
            let from = pose.transform_point(&scan.robot_from_laser.position());
            let there = |at: CellIndex| [self.corner[0] + at.x as isize, self.corner[1] + at.y as isize];
            let (mut hits, mut crossed) = (Vec::new(), Vec::new());
            for end in scan.hits().map(|end| pose.transform_point(&end)) {
                let (end, met) = shorten(&from, &end, max_range);
                hits.extend(info.cell_at(&end).filter(|_| met).map(there));
                crossed.extend(cells_crossed(info, &from, &end).map(there));
            }
            crossed.retain(|at| !hits.contains(at));
            let learned = hits
                .iter()
                .map(|&at| (at, hit as f32))
                .chain(crossed.into_iter().map(|at| (at, -passed as f32)));
            for (at, evidence) in learned {
                let cell = self.known.entry(at).or_default();
                let known = if driven - cell.met > memory { 0.0 } else { cell.odds };
                *cell = Evidence { odds: (known + evidence).clamp(-limit as f32, limit as f32), met: driven };
            }
        }

        fn move_to(&mut self, before: &GridInfo, now: &GridInfo) {
            let moved = before.origin.inverse().transform_point(&now.origin.position()) / before.resolution;
            self.corner =
                [self.corner[0] + moved.x.round() as isize, self.corner[1] + moved.y.round() as isize];
            let [x, y] = self.corner;
            let (width, height) = (now.width as isize, now.height as isize);
            self.known.retain(|at, _| (x..x + width).contains(&at[0]) && (y..y + height).contains(&at[1]));
        }
    }

    proptest! {
        #[test]
        fn a_ring_of_cells_knows_what_a_plane_knows(
            steps in prop::collection::vec(
                (prop::option::of((-9.0..9.0f64, -9.0..9.0f64)), (0.0..4.0f64, 0.0..2.0f64, -3.0..3.0f64), prop::collection::vec(0.1..6.0f64, 1..6), 0.0..4.0f64),
                1..12,
            ),
            side in 0.25..6.0f64,
        ) {
            let memory = 10.0;
            let mut grid = EvidenceGrid::new(info(), memory, EvidenceParameters::default());
            let mut plain = Plain { known: BTreeMap::new(), corner: [0, 0] };
            let mut driven = 0.0;
            for (moved, (x, y, theta), ranges, step) in steps {
                driven += step;
                if let Some((x, y)) = moved {
                    let before = grid.info;
                    grid.center_on(&(before.origin.position() + Vector::new(x, y)));
                    plain.move_to(&before, &grid.info);
                }
                let pose = grid.info.origin.compose(&Pose::new(x, y, theta));
                let scan = LaserScan {
                    laser: crate::sensor::log::LaserNumber::FRONT,
                    stamp: 0.0,
                    odom_from_robot: Pose::IDENTITY,
                    robot_from_laser: Pose::new(0.1, 0.0, 0.0),
                    start_angle: -0.3,
                    angle_increment: 0.2,
                    ranges: ranges.into_iter().map(Some).collect(),
                };
                grid.add(&scan, &pose, driven);
                plain.add(&grid.info, &scan, &pose, driven as f32, memory as f32);
                let known = |x: isize, y: isize| {
                    let cell = plain.known.get(&[plain.corner[0] + x, plain.corner[1] + y]);
                    cell.map_or(Cell::Unknown, |cell| grid.decided(cell))
                };
                let wanted: Vec<Cell> = (0..12).flat_map(|y| (0..20).map(move |x| (x, y))).map(|(x, y)| known(x, y)).collect();
                prop_assert_eq!(grid.occupancy(), wanted);
                let middle = pose.position();
                let around = grid.around(&middle, side).unwrap();
                for (i, &cell) in around.cells().iter().enumerate() {
                    let center = around.info().center(around.info().index(i)) + middle.coords;
                    let local = grid.info.origin.inverse().transform_point(&center) / grid.info.resolution;
                    prop_assert_eq!(cell, known(local.x.floor() as isize, local.y.floor() as isize));
                }
            }
        }
    }

    #[test]
    fn a_wall_ahead_is_occupied_and_the_way_to_it_free() {
        let mut grid = EvidenceGrid::new(info(), 10.0, EvidenceParameters::default());
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
