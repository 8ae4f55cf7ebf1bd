//! One occupancy grid of many local ones, each in the pose that relaxation gave it.

use crate::geometry::{Point, Pose};
use crate::grid::{Cell, GridError, GridInfo, OccupancyGrid};

/// A grid and the pose of its frame in that of the patchwork.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    /// What was seen.
    pub grid: &'a OccupancyGrid,
    /// `patchwork_from_grid`.
    pub pose: Pose,
}

/// How much a piece says of a cell, in the units in which it is decided: an obstacle seen once outweighs two looks
/// through it, as a pose that is a cell off looks through walls.
const OCCUPIED: i32 = 2;
const FREE: i32 = -1;
/// Cells left free around what is known.
const MARGIN: f64 = 0.5;

/// The pieces laid over each other, in cells of `resolution` metres; `None` where nothing is known. A cell is what
/// the pieces over its middle say. Costs the cells of the rectangle around each piece.
pub fn merged(pieces: &[Piece<'_>], resolution: f64) -> Result<Option<OccupancyGrid>, GridError> {
    let corners: Vec<Point> = pieces.iter().flat_map(known_corners).collect();
    let Some([low, high]) = bounds(&corners) else { return Ok(None) };
    let cells = |from: f64, to: f64| ((to - from + 2.0 * MARGIN) / resolution).ceil().max(1.0) as usize;
    let origin = Pose::new(low.x - MARGIN, low.y - MARGIN, 0.0);
    let info = GridInfo { resolution, width: cells(low.x, high.x), height: cells(low.y, high.y), origin };
    OccupancyGrid::check(&info)?;
    let mut said = vec![0_i32; info.width * info.height];
    for piece in pieces {
        lay(piece, &info, &mut said);
    }
    let decided = |said: &i32| match said {
        0 => Cell::Unknown,
        1.. => Cell::Occupied,
        _ => Cell::Free,
    };
    OccupancyGrid::new(info, said.iter().map(decided).collect()).map(Some)
}

fn lay(piece: &Piece<'_>, info: &GridInfo, said: &mut [i32]) {
    let corners: Vec<Point> = known_corners(piece).collect();
    let Some([low, high]) = bounds(&corners) else { return };
    let grid_from_merged = piece.pose.inverse().compose(&info.origin);
    let span = |low: f64, high: f64, origin: f64, cells: usize| {
        let at = |v: f64| ((v - origin) / info.resolution).clamp(0.0, cells as f64) as usize;
        at(low)..(at(high) + 1).min(cells)
    };
    for y in span(low.y, high.y, info.origin.y, info.height) {
        for x in span(low.x, high.x, info.origin.x, info.width) {
            let middle = Point::new(x as f64 + 0.5, y as f64 + 0.5) * info.resolution;
            let there = piece.grid.info().cell_at(&grid_from_merged.transform_point(&middle));
            said[y * info.width + x] += match there.map(|at| piece.grid.cell(at)) {
                Some(Cell::Occupied) => OCCUPIED,
                Some(Cell::Free) => FREE,
                Some(Cell::Unknown) | None => 0,
            };
        }
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
        /// Every cell against the sum over all pieces at its middle.
        #[test]
        fn a_cell_is_what_the_pieces_over_its_middle_say(
            cells in prop::collection::vec((prop::collection::vec(0..3_u8, 20), -3.0..3.0f64, -3.0..3.0f64, -3.1..3.1f64), 0..5),
            resolution in 0.05..0.7f64,
        ) {
            let grids: Vec<OccupancyGrid> = cells.iter().map(|(cells, ..)| grid(cells, 5, 0.4)).collect();
            let pieces: Vec<Piece<'_>> = grids.iter().zip(&cells)
                .map(|(grid, &(_, x, y, theta))| Piece { grid, pose: Pose::new(x, y, theta) }).collect();
            let Some(all) = merged(&pieces, resolution).unwrap() else {
                prop_assert!(cells.iter().all(|(cells, ..)| cells.iter().all(|cell| *cell == 0)));
                return Ok(());
            };
            for offset in 0..all.cells().len() {
                let at = all.info().index(offset);
                let middle = all.info().center(at);
                let said: i32 = pieces.iter().map(|piece| {
                    let there = piece.pose.inverse().transform_point(&middle);
                    match piece.grid.info().cell_at(&there).map(|at| piece.grid.cell(at)) {
                        Some(Cell::Occupied) => OCCUPIED,
                        Some(Cell::Free) => FREE,
                        _ => 0,
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

    #[test]
    fn what_is_too_large_is_refused() {
        let one = grid(&[2; 20], 5, 0.4);
        let far = [
            Piece { grid: &one, pose: Pose::IDENTITY },
            Piece { grid: &one, pose: Pose::new(1e6, 0.0, 0.0) },
        ];
        assert!(merged(&far, 0.05).is_err());
        assert_eq!(merged(&[], 0.05), Ok(None));
        let nowhere = [Piece { grid: &one, pose: Pose { x: f64::NAN, ..Pose::IDENTITY } }];
        assert!(merged(&nowhere, 0.05).is_err() || merged(&nowhere, 0.05) == Ok(None));
    }
}
