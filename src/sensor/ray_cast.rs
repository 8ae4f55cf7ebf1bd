//! The cells that a beam crosses.

use crate::geometry::{Point, Transform};
use crate::grid::{CellIndex, GridInfo};

/// The cells that the segment between two points of the grid's frame crosses, in order, those outside the grid
/// left out (Amanatides and Woo 1987). Ours because a query against a shape hierarchy costs several times as
/// much a ray; tested against parry's ray casting.
pub fn cells_crossed(info: &GridInfo, from: &Point, to: &Point) -> impl Iterator<Item = CellIndex> + use<> {
    Frame::new(info).crossed(from, to)
}

/// Points of a grid's frame in cells from its corner.
pub(super) struct Frame {
    cells_from_grid: Transform,
    resolution: f64,
    width: i64,
    height: i64,
}

impl Frame {
    pub(super) fn new(info: &GridInfo) -> Self {
        let cells_from_grid = info.origin.inverse().transform();
        let (width, height) = (info.width as i64, info.height as i64);
        Frame { cells_from_grid, resolution: info.resolution, width, height }
    }

    fn local(&self, point: &Point) -> [f64; 2] {
        let p = self.cells_from_grid.point(point);
        [p.x / self.resolution, p.y / self.resolution]
    }

    /// As [`GridInfo::cell_at`].
    pub(super) fn cell_at(&self, point: &Point) -> Option<CellIndex> {
        let [x, y] = self.local(point).map(f64::floor);
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then_some(CellIndex { x: x as usize, y: y as usize })
    }

    pub(super) fn crossed(&self, from: &Point, to: &Point) -> impl Iterator<Item = CellIndex> + use<> {
        let (width, height) = (self.width, self.height);
        Steps::new(self.local(from), self.local(to)).filter_map(move |[x, y]| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            inside.then_some(CellIndex { x: x as usize, y: y as usize })
        })
    }
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
}
