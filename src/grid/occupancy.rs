//! The occupancy grid: free, occupied and unknown cells in a frame of their own.
//!
//! Conventions follow ROS `nav_msgs/OccupancyGrid`: row 0 is the bottom row, cells are row-major with x fastest,
//! -1 is unknown, 0 free and 100 occupied, and the origin is the pose of the bottom-left *corner* of cell (0, 0).

use crate::geometry::{Point, Pose};
use std::ops::RangeInclusive;
use thiserror::Error;

/// The most cells a side of a grid may have, so that indices and memory stay bounded.
pub const MAX_SIDE: usize = 8192;
/// The sides of cells there may be, metres: from what no range finder tells apart to what holds a house.
pub const RESOLUTIONS: RangeInclusive<f64> = 1e-3..=100.0;
/// How far from zero the origin of a grid may be, metres: further off, millimetres are lost to rounding.
pub const FARTHEST: f64 = 1e7;

// Those that share a side come first.
const NEIGHBORS: [(isize, isize); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// What is known of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Cell {
    /// Not seen, or seen without a decision.
    Unknown,
    /// Seen to be empty.
    Free,
    /// Seen to hold an obstacle.
    Occupied,
}

impl Cell {
    /// The cell that a grey of a `map_server` image means, in its mode `trinary` with the thresholds 0.65 and 0.196.
    pub fn from_grey(grey: u8) -> Cell {
        let occupancy = (255.0 - f64::from(grey)) / 255.0;
        if occupancy >= 0.65 {
            Cell::Occupied
        } else if occupancy <= 0.196 {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

/// A cell by column and row, counted from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellIndex {
    /// Column, 0 at the left.
    pub x: usize,
    /// Row, 0 at the bottom.
    pub y: usize,
}

/// Size, scale and place of a grid in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridInfo {
    /// Side of a cell, metres.
    pub resolution: f64,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Pose of the bottom-left corner of cell (0, 0) in the frame of the grid.
    pub origin: Pose,
}

/// Why a grid was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// The side of a cell is not within [`RESOLUTIONS`].
    #[error("resolution is {0}, expected metres per cell, 0.001 to 100")]
    Resolution(f64),
    /// A side is zero or beyond [`MAX_SIDE`].
    #[error("the grid is {width} x {height} cells, expected 1 to {MAX_SIDE} on each side")]
    Size {
        /// Columns given.
        width: usize,
        /// Rows given.
        height: usize,
    },
    /// The origin is farther off than [`FARTHEST`], or no number.
    #[error(
        "the origin is not a pose within 10000 km of zero, beyond which cells cannot be told apart; move it"
    )]
    Origin,
    /// The number of cells is not width x height.
    #[error("{found} cells, expected width x height = {expected}")]
    Length {
        /// width x height.
        expected: usize,
        /// Cells given.
        found: usize,
    },
    /// All values are -1, 0 or 1 and a 1 occurs: almost surely a grid on the wrong scale.
    #[error(
        "occupied cells are marked 1, expected 100: every value is -1, 0 or 1, which would make the whole grid free; multiply occupied cells by 100"
    )]
    OccupiedScale,
}

/// An immutable grid of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    info: GridInfo,
    cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// A grid from its cells, row-major from the bottom left.
    pub fn new(info: GridInfo, cells: Vec<Cell>) -> Result<Self, GridError> {
        check(&info, cells.len())?;
        Ok(OccupancyGrid { info, cells })
    }

    /// Whether a grid of this size, scale and place can be made.
    pub fn check(info: &GridInfo) -> Result<(), GridError> {
        check(info, info.width.saturating_mul(info.height))
    }

    /// A grid from ROS occupancy values: below 0 and above 100 unknown, up to 19 free, from 65 occupied,
    /// unknown between (the thresholds of `map_server`).
    pub fn from_occupancy(info: GridInfo, values: &[i8]) -> Result<Self, GridError> {
        check(&info, values.len())?;
        if values.contains(&1) && values.iter().all(|v| (-1..=1).contains(v)) {
            return Err(GridError::OccupiedScale);
        }
        let cells = values.iter().map(|&v| cell_from_occupancy(v)).collect();
        Ok(OccupancyGrid { info, cells })
    }

    /// The ROS occupancy values: -1, 0 or 100 a cell.
    pub fn to_occupancy(&self) -> Vec<i8> {
        let value = |cell: &Cell| match cell {
            Cell::Unknown => -1,
            Cell::Free => 0,
            Cell::Occupied => 100,
        };
        self.cells.iter().map(value).collect()
    }

    /// The same grid with other cells. There must be as many as before.
    pub(super) fn with_cells(&self, cells: Vec<Cell>) -> Self {
        debug_assert_eq!(cells.len(), self.cells.len());
        OccupancyGrid { info: self.info, cells }
    }

    /// Size, scale and place.
    pub fn info(&self) -> &GridInfo {
        &self.info
    }

    /// All cells, row-major from the bottom left.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cell at an index; unknown outside the grid.
    pub fn cell(&self, index: CellIndex) -> Cell {
        if index.x < self.info.width && index.y < self.info.height {
            self.cells[index.y * self.info.width + index.x]
        } else {
            Cell::Unknown
        }
    }
}

impl GridInfo {
    /// The position of a cell of the grid in row-major order. The cell must be inside.
    pub fn offset(&self, index: CellIndex) -> usize {
        index.y * self.width + index.x
    }

    /// The cell at a row-major position, the inverse of [`GridInfo::offset`].
    pub fn index(&self, offset: usize) -> CellIndex {
        CellIndex { x: offset % self.width, y: offset / self.width }
    }

    /// The cell so many columns and rows away, if it is inside the grid.
    pub fn shifted(&self, index: CellIndex, dx: isize, dy: isize) -> Option<CellIndex> {
        let (x, y) = (index.x.checked_add_signed(dx)?, index.y.checked_add_signed(dy)?);
        (x < self.width && y < self.height).then_some(CellIndex { x, y })
    }

    /// The cells inside the grid that share a side (and, for `diagonal`, a corner) with a cell.
    pub fn neighbors(&self, index: CellIndex, diagonal: bool) -> impl Iterator<Item = CellIndex> + use<> {
        let info = *self;
        let count = if diagonal { 8 } else { 4 };
        NEIGHBORS[..count].iter().filter_map(move |&(dx, dy)| info.shifted(index, dx, dy))
    }

    /// The point at the centre of a cell, in the frame of the grid.
    pub fn center(&self, index: CellIndex) -> Point {
        let local =
            Point::new((index.x as f64 + 0.5) * self.resolution, (index.y as f64 + 0.5) * self.resolution);
        self.origin.transform_point(&local)
    }

    /// The cell that holds a point of the grid's frame, if any.
    pub fn cell_at(&self, point: &Point) -> Option<CellIndex> {
        let local = self.origin.inverse().transform_point(point);
        let (x, y) = ((local.x / self.resolution).floor(), (local.y / self.resolution).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then_some(CellIndex { x: x as usize, y: y as usize })
    }
}

fn check(info: &GridInfo, cells: usize) -> Result<(), GridError> {
    let GridInfo { resolution, width, height, origin } = *info;
    if !RESOLUTIONS.contains(&resolution) {
        return Err(GridError::Resolution(resolution));
    }
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(GridError::Size { width, height });
    }
    if !origin.is_finite() || origin.x.abs().max(origin.y.abs()) > FARTHEST {
        return Err(GridError::Origin);
    }
    if cells != width * height {
        return Err(GridError::Length { expected: width * height, found: cells });
    }
    Ok(())
}

fn cell_from_occupancy(value: i8) -> Cell {
    match value {
        0..=19 => Cell::Free,
        65..=100 => Cell::Occupied,
        _ => Cell::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(width: usize, height: usize) -> GridInfo {
        GridInfo { resolution: 0.5, width, height, origin: Pose::new(1.0, -1.0, std::f64::consts::FRAC_PI_2) }
    }

    #[test]
    fn row_zero_is_the_bottom_row() {
        let grid = OccupancyGrid::from_occupancy(info(2, 2), &[100, 0, -1, 50]).unwrap();
        assert_eq!(grid.cell(CellIndex { x: 0, y: 0 }), Cell::Occupied);
        assert_eq!(grid.cell(CellIndex { x: 1, y: 0 }), Cell::Free);
        assert_eq!(grid.cell(CellIndex { x: 1, y: 1 }), Cell::Unknown);
        assert_eq!(grid.cell(CellIndex { x: 2, y: 0 }), Cell::Unknown);
    }

    #[test]
    fn a_cell_holds_its_center_in_a_turned_frame() {
        let info = info(4, 3);
        for y in 0..3 {
            for x in 0..4 {
                let index = CellIndex { x, y };
                assert_eq!(info.cell_at(&info.center(index)), Some(index));
            }
        }
        assert_eq!(info.cell_at(&Point::new(100.0, 0.0)), None);
        assert_eq!(info.cell_at(&Point::new(f64::NAN, 0.0)), None);
    }

    #[test]
    fn malformed_grids_are_refused() {
        let refused =
            |info: GridInfo, values: &[i8]| OccupancyGrid::from_occupancy(info, values).unwrap_err();
        assert_eq!(refused(info(2, 1), &[0]), GridError::Length { expected: 2, found: 1 });
        assert_eq!(refused(info(0, 1), &[]), GridError::Size { width: 0, height: 1 });
        assert_eq!(refused(info(2, 1), &[0, 1]), GridError::OccupiedScale);
        for resolution in [f64::NAN, f64::INFINITY, 0.0, -1.0, 1e-200, 1e200] {
            let odd = GridInfo { resolution, ..info(1, 1) };
            assert!(matches!(refused(odd, &[0]), GridError::Resolution(_)));
        }
        for x in [f64::NAN, 1e15] {
            let odd = GridInfo { origin: Pose { x, y: 0.0, theta: 0.0 }, ..info(1, 1) };
            assert_eq!(refused(odd, &[0]), GridError::Origin);
        }
    }
}
