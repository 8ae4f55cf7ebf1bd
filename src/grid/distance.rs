//! The exact Euclidean distance of every cell to the nearest cell that is not known to be free.

use crate::geometry::Vector;
use crate::grid::{Cell, CellIndex, GridInfo, OccupancyGrid};
use image::{GrayImage, Luma};
use imageproc::definitions::Image;
use imageproc::distance_transform::euclidean_squared_distance_transform;

/// Clearance: distances between cell centres, exact up to rounding.
///
/// Unknown cells count as obstacles, because nothing says that the robot may drive there. What lies beyond the
/// edge of the grid does not count: a corridor that leaves the window keeps its clearance up to the edge. In a
/// grid without any obstacle every distance is infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    info: GridInfo,
    squared: Vec<f64>,
}

/// The nearest obstacles to the left and to the right of a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// Nearest on the left, if any is in reach.
    pub left: Option<CellIndex>,
    /// Nearest on the right, if any is in reach.
    pub right: Option<CellIndex>,
}

impl DistanceField {
    /// The distance field of a grid; linear in the number of cells (Felzenszwalb and Huttenlocher).
    pub fn new(grid: &OccupancyGrid) -> Self {
        let info = *grid.info();
        let obstacle = |cell: &Cell| u8::from(*cell != Cell::Free);
        let bytes: Vec<u8> = grid.cells().iter().map(obstacle).collect();
        let field = |image: GrayImage| -> Image<Luma<f64>> { euclidean_squared_distance_transform(&image) };
        let squared = match GrayImage::from_raw(info.width as u32, info.height as u32, bytes) {
            Some(image) if image.iter().any(|&byte| byte > 0) => field(image).into_raw(),
            _ => vec![f64::INFINITY; info.width * info.height],
        };
        DistanceField { info, squared }
    }

    /// Size, scale and place of the grid.
    pub fn info(&self) -> &GridInfo {
        &self.info
    }

    /// Distance in metres from the centre of a cell to the centre of the nearest obstacle cell.
    /// The cell must be inside.
    pub fn clearance(&self, index: CellIndex) -> f64 {
        self.squared[self.info.offset(index)].sqrt() * self.info.resolution
    }

    /// Squared distances in cells, row-major: whole numbers, or infinity.
    pub fn squared(&self) -> &[f64] {
        &self.squared
    }

    /// The nearest obstacle cells left and right of a direction (given along the grid's own axes), looking no
    /// further than `slack` metres beyond the clearance and no closer to the direction, ahead or behind, than the
    /// angle of the given sine. Ties go to the cell that comes first in the grid.
    pub fn sides(&self, at: CellIndex, along: &Vector, slack: f64, least_sine: f64) -> Sides {
        let inner = self.squared[self.info.offset(at)];
        let mut sides = Sides::default();
        let mut best = [f64::INFINITY; 2];
        if !inner.is_finite() {
            return sides;
        }
        let outer = (inner.sqrt() + slack / self.info.resolution).powi(2);
        let reach = outer.sqrt() as isize;
        for dy in -reach..=reach {
            let row = (dy * dy) as f64;
            let far = (outer - row).max(0.0).sqrt() as isize;
            let near = (inner - row).max(0.0).sqrt().ceil() as isize;
            for dx in (-far..=-near).chain(near.max(1 - near)..=far) {
                let squared = (dx * dx + dy * dy) as f64;
                let cross = along.x * dy as f64 - along.y * dx as f64;
                let side = usize::from(cross < 0.0);
                let beside = cross != 0.0 && cross * cross >= least_sine * least_sine * squared;
                if squared >= best[side] || !beside {
                    continue;
                }
                let Some(cell) = self.info.shifted(at, dx, dy) else { continue };
                if self.squared[self.info.offset(cell)] == 0.0 {
                    best[side] = squared;
                    if side == 0 { sides.left = Some(cell) } else { sides.right = Some(cell) }
                }
            }
        }
        sides
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    fn grid(width: usize, cells: Vec<Cell>) -> OccupancyGrid {
        let info = GridInfo { resolution: 0.1, width, height: cells.len() / width, origin: Pose::IDENTITY };
        OccupancyGrid::new(info, cells).unwrap()
    }

    fn brute_force(grid: &OccupancyGrid, at: CellIndex) -> f64 {
        let far = |i: usize| {
            let other = grid.info().index(i);
            (other.x as f64 - at.x as f64).powi(2) + (other.y as f64 - at.y as f64).powi(2)
        };
        let obstacles = (0..grid.cells().len()).filter(|&i| grid.cells()[i] != Cell::Free);
        obstacles.map(far).fold(f64::INFINITY, f64::min).sqrt() * 0.1
    }

    fn any_cell() -> impl Strategy<Value = Cell> {
        prop_oneof![20 => Just(Cell::Free), 1 => Just(Cell::Occupied), 1 => Just(Cell::Unknown)]
    }

    proptest! {
        #[test]
        fn distances_are_those_of_brute_force(
            (width, cells) in (1usize..24, 1usize..24).prop_flat_map(|(w, h)| (Just(w), prop::collection::vec(any_cell(), w * h)))
        ) {
            let grid = grid(width, cells);
            let field = DistanceField::new(&grid);
            for i in 0..grid.cells().len() {
                let at = grid.info().index(i);
                let (found, expected) = (field.clearance(at), brute_force(&grid, at));
                prop_assert!(found == expected || (found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    #[test]
    fn distances_do_not_saturate() {
        let mut cells = vec![Cell::Free; 1000];
        cells[0] = Cell::Unknown;
        let field = DistanceField::new(&grid(1000, cells));
        assert!((field.clearance(CellIndex { x: 999, y: 0 }) - 99.9).abs() < 1e-9);
    }

    #[test]
    fn left_and_right_are_seen_from_the_direction() {
        let mut cells = vec![Cell::Free; 25];
        (cells[2], cells[22]) = (Cell::Occupied, Cell::Occupied);
        let field = DistanceField::new(&grid(5, cells));
        let center = CellIndex { x: 2, y: 2 };
        let sides = field.sides(center, &Vector::new(1.0, 0.0), 0.1, 0.5);
        assert_eq!(sides.left, Some(CellIndex { x: 2, y: 4 }));
        assert_eq!(sides.right, Some(CellIndex { x: 2, y: 0 }));
        assert_eq!(field.sides(center, &Vector::new(-1.0, 0.0), 0.1, 0.5).left, sides.right);
        assert_eq!(field.sides(center, &Vector::new(0.3, 1.0), 0.1, 0.5), Sides::default());
    }
}
