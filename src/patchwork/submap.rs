//! What the robot saw around a frame: pieces of wall, one for each square of the plane and side of the wall.

use crate::geometry::{Point, Vector, direction};
use crate::grid::{Cell, CellIndex, GridInfo, OccupancyGrid};
use crate::sensor::surface::Surface;
use std::f64::consts::TAU;

/// Pieces of wall in one frame, found by where they are.
#[derive(Clone, Debug, Default)]
pub struct Submap {
    /// By row, then column, of the squares they lie in.
    surfaces: Vec<Surface>,
    squares: Vec<[i32; 2]>,
}

/// Side of a square, metres.
const SQUARE: f64 = 0.1;
/// Walls of one square that face into the same sixth of the circle are one.
const SIDES: f64 = 6.0;
/// Normals that differ by more than 45 degrees are of different walls, or of the two sides of one: the cosine.
const SAME_WALL: f64 = 0.7;
/// The wall around an occupied cell is what is occupied within so many metres.
const AROUND: f64 = 0.25;
/// What is no straight piece of wall: cells that stray more than this from a line, metres (root mean square).
const STRAIGHT: f64 = 0.06;
/// Walls are looked for in cells no smaller than that, metres: as there are hundreds of cells around each, smaller ones would
/// cost much and tell nothing more.
const FINEST: f64 = 0.02;

impl Submap {
    /// Of pieces of wall in one frame. As many steps as there are, times their logarithm.
    pub fn new(seen: impl IntoIterator<Item = Surface>) -> Submap {
        let mut keyed: Vec<([i32; 3], Surface)> =
            seen.into_iter().filter_map(|surface| Some((key(&surface)?, surface))).collect();
        keyed.sort_by_key(|(key, _)| *key);
        let mut submap = Submap::default();
        for alike in keyed.chunk_by(|a, b| a.0 == b.0) {
            let count = alike.len() as f64;
            let at = alike.iter().fold(Vector::zeros(), |sum, (_, s)| sum + s.at.coords) / count;
            let normal = alike.iter().fold(Vector::zeros(), |sum, (_, s)| sum + s.normal);
            // They face into one sixth of the circle, so that they do not cancel.
            let Some(normal) = normal.try_normalize(0.0) else { continue };
            submap.surfaces.push(Surface { at: at.into(), normal });
            submap.squares.push([alike[0].0[0], alike[0].0[1]]);
        }
        submap
    }

    /// Of the walls of a grid: occupied cells beside free ones that lie on a line, facing what is free. `None` where
    /// `interrupted` said to stop; it is asked before each row. As many steps as there are cells, and for those beside free
    /// ones as there are cells around, of 2 cm or more.
    pub fn of_grid(grid: &OccupancyGrid, interrupted: &dyn Fn() -> bool) -> Option<Submap> {
        let coarser = coarser(grid, interrupted)?;
        let grid = coarser.as_ref().unwrap_or(grid);
        let mut walls = Vec::new();
        for (y, row) in grid.cells().chunks(grid.info().width.max(1)).enumerate() {
            if interrupted() {
                return None;
            }
            let occupied = row.iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied);
            walls.extend(occupied.filter_map(|(x, _)| wall(grid, CellIndex { x, y })));
        }
        Some(Submap::new(walls))
    }

    /// The pieces of wall, row by row.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The nearest piece of wall to a surface, within reach, that faces the same way. As many steps as there are walls
    /// in reach, and a logarithm for each row of squares.
    pub fn nearest(&self, to: &Surface, reach: f64) -> Option<Surface> {
        let [row, column] = square(&to.at)?;
        let rings = (reach / SQUARE).ceil() as i32;
        let mut best: Option<(f64, Surface)> = None;
        for row in row.saturating_sub(rings)..=row.saturating_add(rings) {
            let first = self.squares.partition_point(|at| *at < [row, column.saturating_sub(rings)]);
            let last = [row, column.saturating_add(rings)];
            for (_, surface) in
                self.squares[first..].iter().zip(&self.surfaces[first..]).take_while(|(at, _)| **at <= last)
            {
                let away = (surface.at - to.at).norm();
                let same = away < reach && surface.normal.dot(&to.normal) > SAME_WALL;
                if same && best.is_none_or(|(nearest, _)| away < nearest) {
                    best = Some((away, *surface));
                }
            }
        }
        best.map(|(_, surface)| surface)
    }
}

/// The row and column of the square of a point, if it is one that can be counted.
fn square(at: &Point) -> Option<[i32; 2]> {
    let square = [at.y, at.x].map(|v| (v / SQUARE).floor());
    square.iter().all(|v| v.abs() < 1e9).then(|| square.map(|v| v as i32))
}

fn key(surface: &Surface) -> Option<[i32; 3]> {
    let [row, column] = square(&surface.at)?;
    let facing = surface.normal.y.atan2(surface.normal.x).rem_euclid(TAU) / TAU * SIDES;
    facing.is_finite().then_some([row, column, facing as i32])
}

/// The grid in cells of [`FINEST`] or little more, if its own are smaller: what is occupied anywhere in a cell wins, then what
/// is free. The outer `None` where it was told to stop.
fn coarser(grid: &OccupancyGrid, interrupted: &dyn Fn() -> bool) -> Option<Option<OccupancyGrid>> {
    let info = grid.info();
    // The slack keeps cells of 2 cm that rounding made smaller.
    let times = (FINEST / info.resolution - 1e-6).ceil();
    if times <= 1.0 {
        return Some(None);
    }
    let times = times as usize;
    let coarse = GridInfo {
        resolution: info.resolution * times as f64,
        width: info.width.div_ceil(times),
        height: info.height.div_ceil(times),
        origin: info.origin,
    };
    let mut cells = vec![Cell::Unknown; coarse.width * coarse.height];
    for (y, row) in grid.cells().chunks(info.width.max(1)).enumerate() {
        if interrupted() {
            return None;
        }
        for (x, cell) in row.iter().enumerate() {
            let known = &mut cells[y / times * coarse.width + x / times];
            *known = match (*known, *cell) {
                (Cell::Occupied, _) | (_, Cell::Occupied) => Cell::Occupied,
                (Cell::Free, _) | (_, Cell::Free) => Cell::Free,
                (Cell::Unknown, Cell::Unknown) => Cell::Unknown,
            };
        }
    }
    Some(OccupancyGrid::new(coarse, cells).ok())
}

/// The piece of wall in an occupied cell.
fn wall(grid: &OccupancyGrid, at: CellIndex) -> Option<Surface> {
    if !grid.info().neighbors(at, true).any(|beside| grid.cell(beside) == Cell::Free) {
        return None;
    }
    let rings = (AROUND / grid.info().resolution).round().max(1.0) as isize;
    let around = (-rings..=rings).flat_map(|dy| (-rings..=rings).map(move |dx| [dx, dy]));
    let (mut count, mut sum, mut free) = (0.0, [0.0; 5], Vector::zeros());
    for offset in around {
        let Some(index) = grid.info().shifted(at, offset[0], offset[1]) else { continue };
        let away = Vector::new(offset[0] as f64, offset[1] as f64) * grid.info().resolution;
        match grid.cell(index) {
            Cell::Occupied => {
                count += 1.0;
                let terms = [away.x, away.y, away.x * away.x, away.x * away.y, away.y * away.y];
                sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            }
            Cell::Free => free += away,
            Cell::Unknown => {}
        }
    }
    if count < 3.0 {
        return None;
    }
    let [x, y, xx, xy, yy] = sum.map(|sum| sum / count);
    let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
    let along = direction(0.5 * (2.0 * xy).atan2(xx - yy));
    let across = Vector::new(-along.y, along.x);
    let stray = across.x * across.x * xx + 2.0 * across.x * across.y * xy + across.y * across.y * yy;
    let facing = grid.info().origin.rotate(&if across.dot(&free) > 0.0 { across } else { -across });
    (stray.max(0.0).sqrt() <= STRAIGHT).then_some(Surface { at: grid.info().center(at), normal: facing })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_is_that_of_brute_force(
            points in prop::collection::vec((-2.0..2.0f64, -2.0..2.0f64, -3.1..3.1f64), 0..60),
            (x, y, angle) in (-2.0..2.0f64, -2.0..2.0f64, -3.1..3.1f64),
            reach in 0.05..1.5f64,
        ) {
            let surface = |(x, y, angle): (f64, f64, f64)| Surface { at: Point::new(x, y), normal: direction(angle) };
            let submap = Submap::new(points.iter().copied().map(surface));
            let to = surface((x, y, angle));
            let fits = submap.surfaces().iter().filter(|s| s.normal.dot(&to.normal) > SAME_WALL);
            let nearest = fits.map(|s| (s.at - to.at).norm()).filter(|&away| away < reach).min_by(f64::total_cmp);
            prop_assert_eq!(submap.nearest(&to, reach).map(|s| (s.at - to.at).norm()), nearest);
        }

        /// A wall at any angle is found where it is, facing what is free, and what is behind it is not.
        #[test]
        fn the_walls_of_a_grid_lie_where_they_are(angle in -3.1..3.1f64, offset in -1.0..1.0f64) {
            let facing = direction(angle);
            let info = GridInfo { resolution: 0.05, width: 80, height: 80, origin: Pose::new(-2.0, -2.0, 0.0) };
            let cell = |offset_in_grid: usize| {
                let away = info.center(info.index(offset_in_grid)).coords.dot(&facing) - offset;
                if away > 0.05 { Cell::Free } else if away > -0.05 { Cell::Occupied } else { Cell::Unknown }
            };
            let grid = OccupancyGrid::new(info, (0..6400).map(cell).collect()).unwrap();
            let walls = Submap::of_grid(&grid, &|| false).unwrap();
            prop_assert!(walls.surfaces().len() > 10);
            for surface in walls.surfaces() {
                prop_assert!((surface.at.coords.dot(&facing) - offset).abs() < 0.06);
                prop_assert!(surface.normal.dot(&facing) > 0.9, "{surface:?}");
            }
        }
    }

    /// A square room in cells of 1 mm has the walls that it has in larger ones, and the search for them can be stopped.
    #[test]
    fn the_walls_of_a_fine_grid_are_found_in_larger_cells() {
        let info =
            GridInfo { resolution: 0.001, width: 1005, height: 1005, origin: Pose::new(-0.5, -0.5, 0.0) };
        let cell = |offset: usize| {
            let at = info.center(info.index(offset)).coords.amax();
            if at < 0.4 {
                Cell::Free
            } else if at < 0.45 {
                Cell::Occupied
            } else {
                Cell::Unknown
            }
        };
        let grid = OccupancyGrid::new(info, (0..1005 * 1005).map(cell).collect()).unwrap();
        let asked = std::cell::Cell::new(0);
        let walls = Submap::of_grid(&grid, &|| asked.replace(asked.get() + 1) > 2000).unwrap();
        assert!((10..200).contains(&walls.surfaces().len()), "{}", walls.surfaces().len());
        for wall in walls.surfaces() {
            assert!((wall.at.coords.amax() - 0.41).abs() < 0.03, "{wall:?}");
            assert!(wall.at.coords.dot(&wall.normal) < 0.0, "{wall:?}");
        }
        for most in [0, 500, asked.get() - 1] {
            asked.set(0);
            assert!(Submap::of_grid(&grid, &|| asked.replace(asked.get() + 1) >= most).is_none());
        }
    }

    #[test]
    fn what_is_nowhere_is_left_out() {
        let nowhere = Surface { at: Point::new(f64::NAN, 0.0), normal: direction(0.0) };
        let far = Surface { at: Point::new(1e300, 0.0), normal: direction(0.0) };
        let submap = Submap::new([nowhere, far]);
        assert!(submap.surfaces().is_empty() && submap.nearest(&nowhere, 1.0).is_none());
    }
}
