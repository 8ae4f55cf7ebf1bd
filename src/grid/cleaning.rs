//! Removal of specks: what is too small to be an obstacle or a shadow that matters.

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
    let mut cells = grid.cells().to_vec();
    // No gap is longer than the grid, however small its cells.
    let gap = ((parameters.gap / info.resolution) + 1e-6).min(info.width.max(info.height) as f64);
    fill_gaps(&info, &mut cells, gap as usize);
    // Areas of whole cells are compared with areas in decimal metres.
    let cells_in = |area: f64| area / cell_area - 1e-6;
    let (stray, shadow) = (cells_in(parameters.stray), cells_in(parameters.shadow));
    let post = parameters.post / info.resolution + 1e-6;
    let occupied = Patches::new(&info, &cells, true, |cell| cell == Cell::Occupied);
    occupied.of(|patch| (patch.cells as f64) < stray).for_each(|i| cells[i] = Cell::Unknown);
    let closed = Patches::new(&info, &cells, false, |cell| cell != Cell::Free);
    let shadows = closed.of(|patch| !patch.occupied && (patch.cells as f64) < shadow);
    shadows.for_each(|i| cells[i] = Cell::Free);
    let closed = Patches::new(&info, &cells, true, |cell| cell != Cell::Free);
    closed.of(|patch| patch.length() <= post).for_each(|i| cells[i] = Cell::Free);
    grid.with_cells(cells)
}

/// Frees unknown stretches of at most `most` cells between two free cells, along rows and then along columns. Cells
/// that touch an obstacle stay: they may be part of a wall seen in places only.
fn fill_gaps(info: &GridInfo, cells: &mut [Cell], most: usize) {
    let wall = |cells: &[Cell], i: usize| {
        info.neighbors(info.index(i), true).any(|at| cells[info.offset(at)] == Cell::Occupied)
    };
    for y in 0..info.height {
        let mut last_free = None;
        for i in y * info.width..(y + 1) * info.width {
            close_gap(cells, &mut last_free, i, 1, most, wall);
        }
    }
    // All columns at once, row by row: a column at a time would jump through memory.
    let mut last_free = vec![None; info.width];
    for y in 0..info.height {
        for (x, last) in last_free.iter_mut().enumerate() {
            close_gap(cells, last, y * info.width + x, info.width, most, wall);
        }
    }
}

/// Goes one cell on along a line of cells `step` apart: at a free cell, frees the unknown ones since the last.
fn close_gap(
    cells: &mut [Cell],
    last_free: &mut Option<usize>,
    i: usize,
    step: usize,
    most: usize,
    wall: impl Fn(&[Cell], usize) -> bool,
) {
    match cells[i] {
        Cell::Unknown => {}
        Cell::Occupied => *last_free = None,
        Cell::Free => {
            if let Some(last) = last_free.replace(i)
                && last + step < i
                && i <= last + (most + 1) * step
            {
                for j in (last + step..i).step_by(step) {
                    cells[j] = if wall(cells, j) { Cell::Unknown } else { Cell::Free };
                }
            }
        }
    }
}

/// A horizontal run of cells, `start..end` in row-major order.
struct Run {
    start: usize,
    end: usize,
    /// The run of its patch that comes first, or one on the way to it.
    parent: usize,
    occupied: bool,
}

/// Patches of the chosen cells that touch one another by their sides, or by corners too.
struct Patches {
    width: usize,
    runs: Vec<Run>,
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

/// What a patch amounts to.
#[derive(Clone)]
struct Patch {
    cells: usize,
    /// Whether any of its cells is occupied.
    occupied: bool,
    /// The least and the greatest offset of its cells in each direction, cells.
    reach: [(f64, f64); 8],
}

impl Patch {
    const EMPTY: Patch = Patch { cells: 0, occupied: false, reach: [(f64::INFINITY, f64::NEG_INFINITY); 8] };

    fn add(&mut self, run: &Run, width: usize) {
        self.cells += run.end - run.start;
        self.occupied |= run.occupied;
        let y = (run.start / width) as f64;
        for x in [run.start % width, (run.end - 1) % width].map(|x| x as f64) {
            for (reach, (a, b)) in self.reach.iter_mut().zip(DIRECTIONS) {
                let offset = a * x + b * y;
                *reach = (reach.0.min(offset), reach.1.max(offset));
            }
        }
    }

    /// The greatest distance between two of its points, sides of cells included, in cells.
    fn length(&self) -> f64 {
        self.reach.iter().map(|(low, high)| high - low + 1.0).fold(0.0, f64::max)
    }
}

impl Patches {
    fn new(info: &GridInfo, cells: &[Cell], corners: bool, chosen: impl Fn(Cell) -> bool) -> Self {
        let mut patches = Patches { width: info.width, runs: Vec::new() };
        let reach = usize::from(corners);
        let mut above = 0..0;
        for (y, row) in cells.chunks(info.width).enumerate() {
            let first = patches.runs.len();
            let mut start = y * info.width;
            for stretch in row.chunk_by(|&a, &b| chosen(a) == chosen(b)) {
                let end = start + stretch.len();
                if chosen(stretch[0]) {
                    let occupied = stretch.contains(&Cell::Occupied);
                    patches.runs.push(Run { start, end, parent: patches.runs.len(), occupied });
                    patches.join(above.clone(), reach);
                }
                start = end;
            }
            above = first..patches.runs.len();
        }
        patches
    }

    /// Joins the last run with those of the row below that it touches.
    fn join(&mut self, below: std::ops::Range<usize>, reach: usize) {
        let last = self.runs.len() - 1;
        let (start, end) = (self.runs[last].start, self.runs[last].end);
        for run in below {
            let other = &self.runs[run];
            if other.start + self.width < end + reach && start < other.end + self.width + reach {
                let (a, b) = (self.root(run), self.root(last));
                self.runs[a.max(b)].parent = a.min(b);
            }
        }
    }

    fn root(&self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            run = self.runs[run].parent;
        }
        run
    }

    /// The cells of all patches that are as wanted.
    fn of(&self, wanted: impl Fn(&Patch) -> bool) -> impl Iterator<Item = usize> {
        let mut patches = vec![Patch::EMPTY; self.runs.len()];
        let roots: Vec<usize> = (0..self.runs.len()).map(|run| self.root(run)).collect();
        for (run, &root) in self.runs.iter().zip(&roots) {
            patches[root].add(run, self.width);
        }
        let wanted: Vec<bool> = patches.iter().map(|patch| patch.cells > 0 && wanted(patch)).collect();
        let runs = self.runs.iter().zip(roots).filter(move |&(_, root)| wanted[root]);
        runs.flat_map(|(run, _)| run.start..run.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

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

    #[test]
    fn cells_may_be_as_small_as_they_like() {
        let info = GridInfo { resolution: 1e-300, width: 3, height: 1, origin: Pose::IDENTITY };
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
