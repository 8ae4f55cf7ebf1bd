//! Removal of specks: what is too small to be an obstacle or a shadow that matters.

use crate::grid::patches::Patches;
use crate::grid::plane::Plane;
use crate::grid::{Cell, GridInfo, OccupancyGrid};
use std::f64::consts::FRAC_1_SQRT_2;

/// What is too small to matter, in metres and square metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CleaningParameters {
    /// Unknown gaps up to this length between two free cells of a row or a column lie between rays that both
    /// passed. Default 0.2.
    pub gap: f64,
    /// Patches of occupied cells below this area are stray range readings. Default 0.015, which is six cells of
    /// 5 cm: a leg of a chair seen once, not a wall.
    pub stray: f64,
    /// Unknown patches without an obstacle in them below this area are shadows between rays. Default 0.25.
    pub shadow: f64,
    /// Obstacles that stand free and are nowhere longer than this do not part the ways around them: posts, legs,
    /// chairs. A wall is longer, however thin. Default 0.7.
    pub post: f64,
}

impl Default for CleaningParameters {
    fn default() -> Self {
        CleaningParameters { gap: 0.2, stray: 0.015, shadow: 0.25, post: 0.7 }
    }
}

/// The grid without specks. First gaps between rays become free, then stray occupied patches become unknown, and last
/// patches that are not free become free: shadows (cells touching by their sides) and posts (by sides or corners, as
/// the cells of thin slanting walls do). Linear in the number of cells.
pub fn clean(grid: &OccupancyGrid, parameters: &CleaningParameters) -> OccupancyGrid {
    let info = *grid.info();
    let cell_area = info.resolution * info.resolution;
    // No gap is longer than the grid, however small its cells.
    let gap = ((parameters.gap / info.resolution) + 1e-6).min(info.width.max(info.height) as f64);
    // Areas of whole cells are compared with areas in decimal metres.
    let cells_in = |area: f64| area / cell_area - 1e-6;
    let (stray, shadow) = (cells_in(parameters.stray), cells_in(parameters.shadow));
    let post = parameters.post / info.resolution + 1e-6;
    let mut cells = grid.cells().to_vec();
    let mut free = fill_gaps(&info, &mut cells, gap as usize);
    let occupied = Patches::new(&Plane::of(&cells, info.width, Cell::Occupied), true);
    occupied.cells_of(&occupied.strays(stray)).for_each(|i| cells[i] = Cell::Unknown);
    let closed = Patches::new(&free.complement(), false);
    let shadows = closed.shadows(shadow, &cells);
    closed.cells_of(&shadows).for_each(|i| {
        cells[i] = Cell::Free;
        free.insert(i);
    });
    let closed = Patches::new(&free.complement(), true);
    closed.cells_of(&closed.posts(post)).for_each(|i| cells[i] = Cell::Free);
    grid.with_cells(cells)
}

/// Frees unknown stretches of at most `most` cells between two free cells, along rows and then along columns. Cells
/// that touch an obstacle stay: they may be part of a wall seen in places only. What is free then.
fn fill_gaps(info: &GridInfo, cells: &mut [Cell], most: usize) -> Plane {
    let mut free = Plane::of(cells, info.width, Cell::Free);
    let mut unknown = Plane::of(cells, info.width, Cell::Unknown);
    for along_rows in [true, false] {
        let step = if along_rows { 1 } else { info.width };
        let starts = if along_rows { free.left_of(&unknown) } else { free.below(&unknown) };
        for start in starts {
            let end = if along_rows { start - start % info.width + info.width } else { cells.len() };
            for i in gap(cells, start, step, end, most) {
                let touches =
                    info.neighbors(info.index(i), true).any(|at| cells[info.offset(at)] == Cell::Occupied);
                if !touches {
                    cells[i] = Cell::Free;
                    free.insert(i);
                    unknown.remove(i);
                }
            }
        }
    }
    free
}

/// The unknown cells after a free one along a line of cells `step` apart that ends before `end`, if a free one comes
/// next and they are not too many.
fn gap(
    cells: &[Cell],
    start: usize,
    step: usize,
    end: usize,
    most: usize,
) -> impl Iterator<Item = usize> + use<> {
    let line = |k: usize| cells[..end].get(start + k * step);
    let count = (1..=most).take_while(|&k| line(k) == Some(&Cell::Unknown)).count();
    let closed = line(count + 1) == Some(&Cell::Free);
    (1..=if closed { count } else { 0 }).map(move |k| start + k * step)
}

/// Directions in which a patch is measured: a sixteenth of a turn apart, so that no length is short by more than 2 %.
const DIRECTIONS: [(f64, f64); 8] = [
    (1.0, 0.0),
    (0.923_879_532_511_286_7, 0.382_683_432_365_089_8),
    (FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    (0.382_683_432_365_089_8, 0.923_879_532_511_286_7),
    (0.0, 1.0),
    (-0.382_683_432_365_089_8, 0.923_879_532_511_286_7),
    (-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    (-0.923_879_532_511_286_7, 0.382_683_432_365_089_8),
];

/// What patches are by their size.
impl Patches {
    /// For every patch, whether it has less than so many cells.
    fn strays(&self, least: f64) -> Vec<bool> {
        self.sizes().iter().map(|&size| (size as f64) < least).collect()
    }

    /// For every patch, whether it has less than so many cells and none of them is occupied.
    fn shadows(&self, least: f64, cells: &[Cell]) -> Vec<bool> {
        let mut shadows = self.strays(least);
        for run in self.runs() {
            shadows[run.patch] = shadows[run.patch] && !cells[run.start..run.end].contains(&Cell::Occupied);
        }
        shadows
    }

    /// For every patch, whether no two of its points, sides of cells included, are further apart than so many cells.
    fn posts(&self, longest: f64) -> Vec<bool> {
        // No more cells lie within a square of that side.
        let small: Vec<bool> = self.sizes().iter().map(|&size| size as f64 <= longest * longest).collect();
        let mut reach = vec![[(f64::INFINITY, f64::NEG_INFINITY); 8]; small.len()];
        for run in self.runs().iter().filter(|run| small[run.patch]) {
            let y = (run.start / self.width()) as f64;
            for x in [run.start % self.width(), (run.end - 1) % self.width()].map(|x| x as f64) {
                for (reach, (a, b)) in reach[run.patch].iter_mut().zip(DIRECTIONS) {
                    let offset = a * x + b * y;
                    *reach = (reach.0.min(offset), reach.1.max(offset));
                }
            }
        }
        let longest_of =
            |reach: &[(f64, f64); 8]| reach.iter().map(|(low, high)| high - low + 1.0).fold(0.0, f64::max);
        small.iter().zip(&reach).map(|(&small, reach)| small && longest_of(reach) <= longest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    fn cleaned(picture: &[&str]) -> Vec<String> {
        let width = picture[0].len();
        let info = GridInfo { resolution: 0.1, width, height: picture.len(), origin: Pose::IDENTITY };
        let cell = |c: char| match c {
            '.' => Cell::Free,
            '#' => Cell::Occupied,
            _ => Cell::Unknown,
        };
        let cells = picture.iter().flat_map(|row| row.chars().map(cell)).collect();
        let grid = OccupancyGrid::new(info, cells).unwrap();
        let clean = clean(&grid, &CleaningParameters { gap: 0.1, stray: 0.02, shadow: 0.04, post: 0.2 });
        let char_of = |cell: &Cell| match cell {
            Cell::Free => '.',
            Cell::Occupied => '#',
            Cell::Unknown => '?',
        };
        clean.cells().chunks(width).map(|row| row.iter().map(char_of).collect()).collect()
    }

    #[test]
    fn strays_and_specks_vanish_and_walls_stay() {
        let found =
            cleaned(&["########", "#......#", "#.#..??#", "#.....?#", "#.##...#", "#.##...#", "########"]);
        let wanted = ["########", "#......#", "#.....?#", "#.....?#", "#.##...#", "#.##...#", "########"];
        assert_eq!(found, wanted);
    }

    #[test]
    fn a_stray_reading_in_the_unknown_stays_unknown() {
        assert_eq!(cleaned(&["??????", "??#???", "??????"]), ["??????", "??????", "??????"]);
    }

    #[test]
    fn gaps_between_rays_are_filled_and_walls_are_not() {
        assert_eq!(cleaned(&["???????", ".?.??.?", "???????"])[1], "...??.?");
        assert_eq!(cleaned(&["??.??", "?????", "??.??"]), ["??.??", "??.??", "??.??"]);
        assert_eq!(cleaned(&["??.??", "?????", "??.#."]), ["??.??", "?????", "??.?."]);
        assert_eq!(cleaned(&["#####", ".###.", ".???."]), ["#####", ".###.", ".???."]);
    }

    /// The same, cell by cell from the definitions.
    fn slowly(grid: &OccupancyGrid, gap: usize, stray: usize, shadow: usize, post: f64) -> Vec<Cell> {
        let info = *grid.info();
        let mut cells = grid.cells().to_vec();
        let touches = |cells: &[Cell], i: usize| {
            info.neighbors(info.index(i), true).any(|at| cells[info.offset(at)] == Cell::Occupied)
        };
        for (dx, dy) in [(1, 0), (0, 1)] {
            let before = cells.clone();
            let at = |i: usize, k: isize| {
                info.shifted(info.index(i), k * dx, k * dy).map(|at| before[info.offset(at)])
            };
            let to_free = |i: usize, sign: isize| {
                let steps = (1..=gap as isize).find(|&k| at(i, sign * k) != Some(Cell::Unknown))?;
                (at(i, sign * steps) == Some(Cell::Free)).then_some(steps as usize)
            };
            for i in (0..cells.len()).filter(|&i| before[i] == Cell::Unknown && !touches(&before, i)) {
                if let (Some(back), Some(on)) = (to_free(i, -1), to_free(i, 1))
                    && back + on <= gap + 1
                {
                    cells[i] = Cell::Free;
                }
            }
        }
        let patch = |cells: &[Cell], start: usize, corners: bool, chosen: fn(Cell) -> bool| {
            let mut patch = std::collections::BTreeSet::new();
            let mut open = Vec::from_iter(chosen(cells[start]).then_some(start));
            while let Some(i) = open.pop() {
                if patch.insert(i) {
                    let around = info.neighbors(info.index(i), corners).map(|at| info.offset(at));
                    open.extend(around.filter(|&j| chosen(cells[j])));
                }
            }
            patch
        };
        let mut change =
            |corners, chosen: fn(Cell) -> bool, to, small: &dyn Fn(&[Cell], &[usize]) -> bool| {
                let before = cells.clone();
                for i in (0..cells.len()).filter(|&i| chosen(before[i])) {
                    let patch: Vec<usize> = patch(&before, i, corners, chosen).into_iter().collect();
                    if small(&before, &patch) {
                        cells[i] = to;
                    }
                }
            };
        let closed = |cell| cell != Cell::Free;
        change(true, |cell| cell == Cell::Occupied, Cell::Unknown, &|_, patch| patch.len() < stray);
        change(false, closed, Cell::Free, &|cells, patch| {
            patch.len() < shadow && patch.iter().all(|&i| cells[i] == Cell::Unknown)
        });
        change(true, closed, Cell::Free, &|_, patch| {
            DIRECTIONS.iter().all(|(a, b)| {
                let along = patch.iter().map(|&i| info.index(i)).map(|at| a * at.x as f64 + b * at.y as f64);
                let (low, high) =
                    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
                high - low + 1.0 <= post
            })
        });
        cells
    }

    proptest! {
        #[test]
        fn cleaning_is_that_of_the_definitions(
            (width, cells) in (1usize..90, 1usize..14).prop_flat_map(|(width, height)| {
                let cell = prop_oneof![8 => Just(Cell::Free), 3 => Just(Cell::Unknown), 1 => Just(Cell::Occupied)];
                (Just(width), prop::collection::vec(cell, width * height))
            }),
            (gap, stray, shadow, post) in (0usize..6, 0usize..6, 0usize..9, 0u32..5),
        ) {
            let info = GridInfo { resolution: 1.0, width, height: cells.len() / width, origin: Pose::IDENTITY };
            let grid = OccupancyGrid::new(info, cells).unwrap();
            let post = f64::from(post) + 0.3;
            let parameters = CleaningParameters { gap: gap as f64, stray: stray as f64, shadow: shadow as f64, post };
            let slow = slowly(&grid, gap, stray, shadow, post);
            let cleaned = clean(&grid, &parameters);
            prop_assert_eq!(cleaned.cells(), slow);
        }
    }

    #[test]
    fn cells_may_be_far_smaller_than_a_gap() {
        let info = GridInfo { resolution: 1e-3, width: 3, height: 1, origin: Pose::IDENTITY };
        let cells = vec![Cell::Free, Cell::Unknown, Cell::Free];
        let cleaned = clean(&OccupancyGrid::new(info, cells).unwrap(), &CleaningParameters::default());
        assert_eq!(cleaned.cells(), [Cell::Free; 3]);
    }

    #[test]
    fn a_shadow_in_free_space_is_filled() {
        assert_eq!(cleaned(&[".....", "..??.", "....."]), [".....", ".....", "....."]);
        assert_eq!(cleaned(&["..?..", "....."]), [".....", "....."]);
    }
}
