//! The exact Euclidean distance of every cell to the nearest cell that is not known to be free.

use crate::geometry::Vector;
use crate::grid::plane::Plane;
use crate::grid::{Cell, CellIndex, GridInfo, OccupancyGrid};

/// Clearance: distances between cell centres, exact up to rounding.
///
/// Unknown cells count as obstacles, because nothing says that the robot may drive there. What lies beyond the
/// edge of the grid does not count: a corridor that leaves the window keeps its clearance up to the edge. In a
/// grid without any obstacle every distance is infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    info: GridInfo,
    squared: Vec<u32>,
    obstacles: Plane,
}

/// The squared distance of a cell in a grid without any obstacle.
const BOUNDLESS: u32 = u32::MAX;

/// The nearest obstacles to the left and to the right of a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// Nearest on the left, if any is in reach.
    pub left: Option<CellIndex>,
    /// Nearest on the right, if any is in reach.
    pub right: Option<CellIndex>,
}

impl DistanceField {
    /// The distance field of a grid; linear in the number of cells.
    pub fn new(grid: &OccupancyGrid) -> Self {
        let info = *grid.info();
        let obstacles = Plane::of(grid.cells(), info.width, Cell::Free).complement();
        let squared = match obstacles.is_empty() {
            false => squared_distances(info.width, grid.cells()),
            true => vec![BOUNDLESS; grid.cells().len()],
        };
        DistanceField { info, squared, obstacles }
    }

    /// Size, scale and place of the grid.
    pub fn info(&self) -> &GridInfo {
        &self.info
    }

    /// Distance in metres from the centre of a cell to the centre of the nearest obstacle cell.
    /// The cell must be inside.
    pub fn clearance(&self, index: CellIndex) -> f64 {
        match self.squared[self.info.offset(index)] {
            BOUNDLESS => f64::INFINITY,
            squared => f64::from(squared).sqrt() * self.info.resolution,
        }
    }

    /// Squared distances in cells, row-major; [`u32::MAX`] in a grid without any obstacle, where nothing is a distance.
    pub fn squared(&self) -> &[u32] {
        &self.squared
    }

    /// The nearest obstacle cells left and right of a direction (given along the grid's own axes), looking no
    /// further than `slack` metres beyond the clearance and no closer to the direction, ahead or behind, than the
    /// angle of the given sine. Ties go to the cell that comes first in the grid.
    pub fn sides(&self, at: CellIndex, along: &Vector, slack: f64, least_sine: f64) -> Sides {
        let inner = match self.squared[self.info.offset(at)] {
            BOUNDLESS => return Sides::default(),
            squared => i64::from(squared),
        };
        let outer = (inner as f64).sqrt() + slack / self.info.resolution;
        // Of each side the squared distance, the row and the column of the nearest.
        // The square of a root may be less than it was.
        let mut nearest = [((outer.powi(2) as i64).max(inner), usize::MAX, usize::MAX); 2];
        // Row by row outwards, so that what is found soon spares the rest.
        let reach = (outer as i64).min(self.info.height as i64);
        for (dy, y) in (0..=reach).flat_map(|away| self.rows_beside(at.y, away)) {
            let farthest = nearest[0].0.max(nearest[1].0);
            if dy * dy > farthest {
                break;
            }
            let look = |x: usize| {
                let dx = x as i64 - at.x as i64;
                let cross = along.x * dy as f64 - along.y * dx as f64;
                let squared = dx * dx + dy * dy;
                if cross != 0.0 && cross * cross >= least_sine * least_sine * squared as f64 {
                    let side = &mut nearest[usize::from(cross < 0.0)];
                    *side = (squared, y, x).min(*side);
                }
            };
            self.each_obstacle(y, at.x, inner - dy * dy, farthest - dy * dy, look);
        }
        let [left, right] = nearest.map(|(_, y, x)| (y != usize::MAX).then_some(CellIndex { x, y }));
        Sides { left, right }
    }

    /// The rows so far below and above another, and how far up.
    fn rows_beside(&self, y: usize, away: i64) -> impl Iterator<Item = (i64, usize)> + use<> {
        let height = self.info.height as i64;
        let both = [Some(-away), (away > 0).then_some(away)].into_iter().flatten();
        both.map(move |dy| (dy, y as i64 + dy))
            .filter(move |&(_, y)| (0..height).contains(&y))
            .map(|(dy, y)| (dy, y as usize))
    }

    /// Calls with the column of each obstacle of a row whose squared distance from a column is within bounds.
    fn each_obstacle(&self, y: usize, x: usize, least: i64, most: i64, mut call: impl FnMut(usize)) {
        let (near, far) = (root_above(least) as isize, most.isqrt() as isize);
        let within = |dx: isize| (x as isize + dx).clamp(0, self.info.width as isize) as usize;
        self.obstacles.each_in_row(y, within(-far)..within(1 - near), &mut call);
        self.obstacles.each_in_row(y, within(near.max(1))..within(far + 1), &mut call);
    }
}

/// The least whole number whose square is not below a number.
fn root_above(squared: i64) -> i64 {
    let root = squared.max(0).isqrt();
    root + i64::from(root * root < squared)
}

/// Squared distances in cells to the nearest cell that is not free, of which there must be one: first along columns,
/// then along rows (Meijster, Roerdink and Hesselink, A general algorithm for computing distance transforms in linear
/// time, 2000). Whole numbers throughout: sides of up to 8192 cells keep them below 2^30.
fn squared_distances(width: usize, cells: &[Cell]) -> Vec<u32> {
    // All columns at once, row by row: a column at a time would jump through memory.
    let mut columns = vec![FAR; cells.len()];
    let height = cells.len() / width;
    let mut beside = vec![FAR; width];
    for y in 0..height {
        let row = y * width..(y + 1) * width;
        for ((cell, column), beside) in cells[row.clone()].iter().zip(&mut columns[row]).zip(&mut beside) {
            *beside = if *cell == Cell::Free { beside.saturating_add(1) } else { 0 };
            *column = *beside;
        }
    }
    for y in (1..height).rev() {
        let (row, above) = columns.split_at_mut(y * width);
        relax(&mut row[(y - 1) * width..], &above[..width]);
    }
    let mut squared = vec![0; cells.len()];
    let mut envelope = Vec::with_capacity(width);
    for (column, out) in columns.chunks_exact(width).zip(squared.chunks_exact_mut(width)) {
        let mut start = 0;
        for run in column.chunk_by(|&a, &b| (a == 0) == (b == 0)) {
            if run[0] != 0 {
                along_row(column, start, start + run.len(), &mut envelope, out);
            }
            start += run.len();
        }
    }
    squared
}

/// No obstacle in the column: farther than any there can be.
const FAR: u16 = u16::MAX;

/// No cell of a row is farther from an obstacle of its column than its neighbour in the row beside is, and one cell.
fn relax(row: &mut [u16], beside: &[u16]) {
    row.iter_mut().zip(beside).for_each(|(cell, &other)| *cell = (*cell).min(other.saturating_add(1)));
}

/// Squared distances in a stretch of free cells of a row whose cells have the given distances along their columns: the
/// lower envelope of one parabola a cell, of which `envelope` holds the cells and where each begins to be lowest. What
/// lies beyond the obstacles that end the stretch is not nearer than they are.
fn along_row(column: &[u16], start: usize, end: usize, envelope: &mut Vec<(i32, i32)>, out: &mut [u32]) {
    let at = |x: i32| i32::from(column[x as usize]);
    let value = |x: i32, i: i32| (x - i) * (x - i) + at(i) * at(i);
    let (first, last) = (start.saturating_sub(1) as i32, (end + 1).min(column.len()) as i32);
    envelope.clear();
    for u in (first..last).filter(|&u| column[u as usize] != FAR) {
        while envelope.last().is_some_and(|&(i, begin)| value(begin, i) > value(begin, u)) {
            envelope.pop();
        }
        match envelope.last() {
            None => envelope.push((u, first)),
            Some(&(i, _)) => {
                let begin = 1 + (u * u - i * i + at(u) * at(u) - at(i) * at(i)).div_euclid(2 * (u - i));
                if begin < last {
                    envelope.push((u, begin));
                }
            }
        }
    }
    for (k, &(i, begin)) in envelope.iter().enumerate() {
        let next = envelope.get(k + 1).map_or(last, |next| next.1);
        (begin..next).for_each(|x| out[x as usize] = value(x, i) as u32);
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

        #[test]
        fn sides_are_those_of_brute_force(
            (width, cells) in (1usize..24, 1usize..24).prop_flat_map(|(w, h)| (Just(w), prop::collection::vec(any_cell(), w * h))),
            (pick, angle, slack, least_sine) in (0usize..1000, -3.1..3.1f64, 0.0..1.0f64, 0.0..0.9f64),
        ) {
            let grid = grid(width, cells);
            let field = DistanceField::new(&grid);
            let at = grid.info().index(pick % grid.cells().len());
            let along = crate::geometry::direction(angle);
            let farthest = field.clearance(at) / 0.1 + slack / 0.1;
            let mut best: [Option<(f64, CellIndex)>; 2] = [None; 2];
            for other in (0..grid.cells().len()).filter(|&i| grid.cells()[i] != Cell::Free).map(|i| grid.info().index(i)) {
                let (dx, dy) = (other.x as f64 - at.x as f64, other.y as f64 - at.y as f64);
                let (squared, cross) = (dx * dx + dy * dy, along.x * dy - along.y * dx);
                let near_limit = (squared.sqrt() - farthest).abs() < 1e-9;
                prop_assume!(!near_limit);
                let beside = cross != 0.0 && cross * cross >= least_sine * least_sine * squared;
                let side = &mut best[usize::from(cross < 0.0)];
                if beside && squared.sqrt() < farthest && side.is_none_or(|(nearest, _)| squared < nearest) {
                    *side = Some((squared, other));
                }
            }
            let [left, right] = best.map(|found| found.map(|(_, cell)| cell));
            prop_assert_eq!(field.sides(at, &along, slack, least_sine), Sides { left, right });
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
    fn the_nearest_obstacle_is_beside_without_slack() {
        for (x, y) in (0..20).flat_map(|y| (0..20).map(move |x| (x, y))).skip(20) {
            let mut cells = vec![Cell::Free; 400];
            cells[20 * y + x] = Cell::Occupied;
            let field = DistanceField::new(&grid(20, cells));
            let sides = field.sides(CellIndex { x: 0, y: 0 }, &Vector::new(1.0, 0.0), 0.0, 0.0);
            assert_eq!(sides, Sides { left: Some(CellIndex { x, y }), right: None });
        }
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
