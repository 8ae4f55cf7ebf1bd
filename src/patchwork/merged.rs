//! One occupancy grid of many local ones, each in the pose that relaxation gave it.

use crate::geometry::{Point, Pose};
use crate::grid::occupancy::MAX_SIDE;
use crate::grid::{Cell, CellIndex, GridError, GridInfo, OccupancyGrid};
use std::collections::BTreeMap;

/// A grid and the pose of its frame in that of the patchwork.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    /// What was seen.
    pub grid: &'a OccupancyGrid,
    /// `patchwork_from_grid`.
    pub pose: Pose,
}

/// What grid to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canvas {
    /// Side of a cell, metres.
    pub resolution: f64,
    /// The most cells.
    pub most_cells: usize,
}

/// Why pieces were not merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// A grid is not made like that.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// It would have too many cells.
    #[error(
        "the grid would be {width} x {height} cells, expected {most_cells} at most and {MAX_SIDE} on a side; cells of \
         {fitting} m would do"
    )]
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// The most cells.
        most_cells: usize,
        /// A resolution at which the grid is not too large, little above the finest such.
        fitting: f64,
    },
    /// The caller said so.
    #[error("it was told to stop")]
    Interrupted,
}

/// How much a piece says of a cell, in the units in which it is decided: an obstacle seen once outweighs two looks
/// through it, as a pose that is a cell off looks through walls.
const OCCUPIED: i32 = 2;
const FREE: i32 = -1;
/// Cells left free around what is known, metres.
const MARGIN: f64 = 0.5;

/// The pieces laid over each other; `None` where nothing is known. A cell is what the pieces over its middle say, and where
/// the cells of a piece are smaller, what is occupied of those whose middles lie in it, or else free: walls do not vanish,
/// though narrow ways may. Costs the cells of each piece and of the rectangle around it, and five bytes a cell;
/// `interrupted` is asked before each row of each.
pub fn merged(
    pieces: &[Piece<'_>],
    canvas: &Canvas,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<OccupancyGrid>, MergeError> {
    let corners: Vec<Point> = pieces.iter().flat_map(known_corners).collect();
    let Some([low, high]) = bounds(&corners) else { return Ok(None) };
    let low = low.map(|v| v - MARGIN);
    let info = canvas.around(low, high.map(|v| v + MARGIN))?;
    let mut said = vec![0_i32; info.width * info.height];
    for piece in pieces {
        lay(piece, &info, &mut said, interrupted)?;
    }
    let decided = |said: &i32| match said {
        0 => Cell::Unknown,
        1.. => Cell::Occupied,
        _ => Cell::Free,
    };
    Ok(Some(OccupancyGrid::new(info, said.iter().map(decided).collect())?))
}

impl Canvas {
    /// Size, scale and place of the grid over a rectangle with these corners, metres.
    pub fn around(&self, low: Point, high: Point) -> Result<GridInfo, MergeError> {
        let size = [high.x - low.x, high.y - low.y];
        let [width, height] = cells(size, self.resolution);
        let origin = Pose::new(low.x, low.y, 0.0);
        let info = GridInfo { resolution: self.resolution, width, height, origin };
        let finite = size.iter().all(|side| side.is_finite()) && self.resolution > 0.0;
        if finite && !self.holds([width, height]) {
            let fitting = self.fitting(size);
            return Err(MergeError::TooLarge { width, height, most_cells: self.most_cells, fitting });
        }
        OccupancyGrid::check(&info)?;
        Ok(info)
    }

    fn holds(&self, [width, height]: [usize; 2]) -> bool {
        width.max(height) <= MAX_SIDE && width.saturating_mul(height) <= self.most_cells
    }

    /// A resolution of two digits at which a rectangle of so many metres is not too large.
    fn fitting(&self, size: [f64; 2]) -> f64 {
        let most = self.most_cells.max(1) as f64;
        let least = (size[0] * size[1] / most).sqrt().max(size[0].max(size[1]) / MAX_SIDE as f64);
        // Two digits: so many parts of a metre, or so many metres.
        let parts = 10_f64.powf(1.0 - least.log10().floor());
        let mut count = (least * parts).ceil();
        while !self.holds(cells(size, count / parts)) && count < f64::MAX {
            // A long strip is a few cells high at most, whatever their size.
            count = (count * 1.01).ceil();
        }
        count / parts
    }
}

/// Columns and rows of a grid of so many metres.
fn cells(size: [f64; 2], resolution: f64) -> [usize; 2] {
    size.map(|side| (side / resolution).ceil().max(1.0) as usize)
}

fn lay(
    piece: &Piece<'_>,
    info: &GridInfo,
    said: &mut [i32],
    interrupted: &dyn Fn() -> bool,
) -> Result<(), MergeError> {
    let corners: Vec<Point> = known_corners(piece).collect();
    let Some([low, high]) = bounds(&corners) else { return Ok(()) };
    let grid_from_merged = piece.pose.inverse().compose(&info.origin);
    let finer = piece.grid.info().resolution < info.resolution;
    let laid = if finer { laid(piece, info, interrupted)? } else { BTreeMap::new() };
    let span = |low: f64, high: f64, origin: f64, cells: usize| {
        let at = |v: f64| ((v - origin) / info.resolution).clamp(0.0, cells as f64) as usize;
        at(low)..(at(high) + 1).min(cells)
    };
    for y in span(low.y, high.y, info.origin.y, info.height) {
        if interrupted() {
            return Err(MergeError::Interrupted);
        }
        for x in span(low.x, high.x, info.origin.x, info.width) {
            let middle = Point::new(x as f64 + 0.5, y as f64 + 0.5) * info.resolution;
            let there = piece.grid.info().cell_at(&grid_from_merged.transform_point(&middle));
            let at = y * info.width + x;
            let here = there.map_or(Cell::Unknown, |at| piece.grid.cell(at));
            said[at] += match laid.get(&at).map_or(here, |laid| known(*laid, here)) {
                Cell::Occupied => OCCUPIED,
                Cell::Free => FREE,
                Cell::Unknown => 0,
            };
        }
    }
    Ok(())
}

/// The known cells of a piece, laid into larger ones: by their offset.
fn laid(
    piece: &Piece<'_>,
    info: &GridInfo,
    interrupted: &dyn Fn() -> bool,
) -> Result<BTreeMap<usize, Cell>, MergeError> {
    let mut laid = BTreeMap::new();
    for (y, row) in piece.grid.cells().chunks(piece.grid.info().width.max(1)).enumerate() {
        if interrupted() {
            return Err(MergeError::Interrupted);
        }
        for (x, cell) in row.iter().enumerate().filter(|(_, cell)| **cell != Cell::Unknown) {
            let middle = piece.pose.transform_point(&piece.grid.info().center(CellIndex { x, y }));
            let Some(at) = info.cell_at(&middle) else { continue };
            let there = laid.entry(at.y * info.width + at.x).or_insert(*cell);
            *there = known(*there, *cell);
        }
    }
    Ok(laid)
}

/// What is known of a cell where parts of it differ.
fn known(one: Cell, other: Cell) -> Cell {
    match (one, other) {
        (Cell::Occupied, _) | (_, Cell::Occupied) => Cell::Occupied,
        (Cell::Free, _) | (_, Cell::Free) => Cell::Free,
        (Cell::Unknown, Cell::Unknown) => Cell::Unknown,
    }
}

/// The corners, in the patchwork, of the rectangle of known cells of a piece.
fn known_corners<'a>(piece: &'a Piece<'_>) -> impl Iterator<Item = Point> + 'a {
    let info = piece.grid.info();
    let known = piece.grid.cells().iter().enumerate().filter(|(_, cell)| **cell != Cell::Unknown);
    let extent = known.map(|(offset, _)| info.index(offset)).fold(None, |extent, at| {
        let [x0, y0, x1, y1] = extent.unwrap_or([at.x, at.y, at.x, at.y]);
        Some([x0.min(at.x), y0.min(at.y), x1.max(at.x), y1.max(at.y)])
    });
    let corner = |x: usize, y: usize| {
        let at = Point::new(x as f64, y as f64) * info.resolution;
        piece.pose.transform_point(&info.origin.transform_point(&at))
    };
    let corners = extent.map(|[x0, y0, x1, y1]| {
        [corner(x0, y0), corner(x1 + 1, y0), corner(x0, y1 + 1), corner(x1 + 1, y1 + 1)]
    });
    corners.into_iter().flatten()
}

fn bounds(points: &[Point]) -> Option<[Point; 2]> {
    let first = *points.first()?;
    Some(points.iter().fold([first, first], |[low, high], at| [low.inf(at), high.sup(at)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(cells: &[u8], width: usize, resolution: f64) -> OccupancyGrid {
        let info =
            GridInfo { resolution, width, height: cells.len() / width, origin: Pose::new(-1.0, 0.5, 0.3) };
        let cell = |v: &u8| [Cell::Unknown, Cell::Free, Cell::Occupied][usize::from(*v)];
        OccupancyGrid::new(info, cells.iter().map(cell).collect()).unwrap()
    }

    proptest! {
        /// Every cell against the sum over all pieces at its middle, and within it where it is larger than theirs.
        #[test]
        fn a_cell_is_what_the_pieces_over_its_middle_say(
            cells in prop::collection::vec((prop::collection::vec(0..3_u8, 20), -3.0..3.0f64, -3.0..3.0f64, -3.1..3.1f64), 0..5),
            resolution in 0.05..0.7f64,
        ) {
            let grids: Vec<OccupancyGrid> = cells.iter().map(|(cells, ..)| grid(cells, 5, 0.4)).collect();
            let pieces: Vec<Piece<'_>> = grids.iter().zip(&cells)
                .map(|(grid, &(_, x, y, theta))| Piece { grid, pose: Pose::new(x, y, theta) }).collect();
            let Some(all) = merged(&pieces, &whole(resolution), &|| false).unwrap() else {
                prop_assert!(cells.iter().all(|(cells, ..)| cells.iter().all(|cell| *cell == 0)));
                return Ok(());
            };
            for offset in 0..all.cells().len() {
                let at = all.info().index(offset);
                let middle = all.info().center(at);
                let said: i32 = pieces.iter().map(|piece| {
                    let there = piece.pose.inverse().transform_point(&middle);
                    let middle = piece.grid.info().cell_at(&there).map(|at| piece.grid.cell(at));
                    let within = piece.grid.cells().iter().enumerate().filter(|(offset, _)| {
                        let at_piece = piece.grid.info().center(piece.grid.info().index(*offset));
                        resolution > 0.4 && all.info().cell_at(&piece.pose.transform_point(&at_piece)) == Some(at)
                    });
                    let seen: Vec<Cell> = within.map(|(_, cell)| *cell).chain(middle).collect();
                    if seen.contains(&Cell::Occupied) {
                        OCCUPIED
                    } else if seen.contains(&Cell::Free) {
                        FREE
                    } else {
                        0
                    }
                }).sum();
                let decided = if said > 0 { Cell::Occupied } else if said < 0 { Cell::Free } else { Cell::Unknown };
                prop_assert_eq!(all.cell(at), decided);
            }
            // Nothing known is left outside: every occupied cell's middle lies on the grid.
            for piece in &pieces {
                for (offset, cell) in piece.grid.cells().iter().enumerate() {
                    let at = piece.pose.transform_point(&piece.grid.info().center(piece.grid.info().index(offset)));
                    prop_assert!(*cell == Cell::Unknown || all.info().cell_at(&at).is_some());
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Of a room with walls of one cell no way leads out, however large the cells of the canvas are.
        #[test]
        fn a_closed_room_stays_closed(theta in -3.1..3.1f64, resolution in 0.05..1.0f64, (x, y) in (-1.0..1.0f64, -1.0..1.0f64)) {
            let cell = |at: usize| {
                let wall = (at / 120).abs_diff(60).max((at % 120).abs_diff(60));
                if wall == 40 { 2 } else { 1 }
            };
            let cells: Vec<u8> = (0..120 * 120).map(cell).collect();
            let one = grid(&cells, 120, 0.05);
            let pose = Pose::new(x, y, theta);
            let all = merged(&[Piece { grid: &one, pose }], &whole(resolution), &|| false).unwrap().unwrap();
            let middle = pose.transform_point(&one.info().center(CellIndex { x: 60, y: 60 }));
            let mut reached = vec![all.info().cell_at(&middle).unwrap()];
            prop_assert_eq!(all.cell(reached[0]), Cell::Free);
            let mut next = 0;
            while let Some(&at) = reached.get(next) {
                next += 1;
                for beside in all.info().neighbors(at, false) {
                    if all.cell(beside) != Cell::Occupied && !reached.contains(&beside) {
                        reached.push(beside);
                    }
                }
            }
            let outside = CellIndex { x: 0, y: 0 };
            prop_assert!(!reached.contains(&outside));
        }
    }

    fn whole(resolution: f64) -> Canvas {
        Canvas { resolution, most_cells: MAX_SIDE * MAX_SIDE }
    }

    fn rejected(pieces: &[Piece<'_>], canvas: &Canvas) -> MergeError {
        merged(pieces, canvas, &|| false).unwrap_err()
    }

    #[test]
    fn what_is_too_large_is_refused() {
        let one = grid(&[2; 20], 5, 0.4);
        let far = [
            Piece { grid: &one, pose: Pose::IDENTITY },
            Piece { grid: &one, pose: Pose::new(1e6, 0.0, 0.0) },
        ];
        assert!(matches!(rejected(&far, &whole(0.05)), MergeError::TooLarge { height: 1..1000, .. }));
        assert_eq!(merged(&[], &whole(0.05), &|| false), Ok(None));
        let nowhere = [Piece { grid: &one, pose: Pose { x: f64::NAN, ..Pose::IDENTITY } }];
        let nothing = merged(&nowhere, &whole(0.05), &|| false);
        assert!(nothing.is_err() || nothing == Ok(None));
        assert!(matches!(rejected(&far[..1], &whole(0.0)), MergeError::Grid(_)));
    }

    #[test]
    fn merging_stops_when_told_to() {
        let one = grid(&[2; 20], 5, 0.4);
        let pieces = [Piece { grid: &one, pose: Pose::IDENTITY }];
        assert_eq!(merged(&pieces, &whole(0.05), &|| true), Err(MergeError::Interrupted));
    }

    proptest! {
        /// The resolution named is not too large, and hardly coarser than need be.
        #[test]
        fn where_a_grid_is_too_large_another_resolution_is_named(
            (x, y) in (0.0..500.0f64, 0.0..500.0f64),
            resolution in 0.001..0.1f64,
            most_cells in 400..1_000_000_usize,
        ) {
            let one = grid(&[2; 20], 5, 0.4);
            let pieces = [Pose::IDENTITY, Pose::new(x, y, 0.0)].map(|pose| Piece { grid: &one, pose });
            let Err(error) = merged(&pieces, &Canvas { resolution, most_cells }, &|| false) else { return Ok(()) };
            let MergeError::TooLarge { fitting, .. } = error else { return Err(TestCaseError::fail("another error")) };
            let fits = merged(&pieces, &Canvas { resolution: fitting, most_cells }, &|| false).is_ok();
            prop_assert!(fits);
            let finer = Canvas { resolution: fitting * 0.8, most_cells };
            prop_assert!(merged(&pieces, &finer, &|| false).is_err(), "{fitting}");
        }
    }
}
