//! Removal of specks: what is too small to be an obstacle or a shadow that matters.

use crate::grid::{Cell, GridInfo, OccupancyGrid};

/// What is too small to matter, in square metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CleaningParameters {
    /// Patches of occupied cells below this area are stray range readings. Default 0.015, which is six cells of
    /// 5 cm: a leg of a chair seen once, not a wall.
    pub stray: f64,
    /// Patches without any free cell below this area, surrounded by free space, do not part the ways around
    /// them: thin posts and shadows between rays. Default 0.25.
    pub speck: f64,
}

impl Default for CleaningParameters {
    fn default() -> Self {
        CleaningParameters { stray: 0.015, speck: 0.25 }
    }
}

/// The grid without specks. First stray occupied patches (cells touching by side or corner) become unknown, then
/// patches that are not free (cells touching by side) become free unless they touch the edge of the grid.
pub fn clean(grid: &OccupancyGrid, parameters: &CleaningParameters) -> OccupancyGrid {
    let info = *grid.info();
    let cell_area = info.resolution * info.resolution;
    let mut cells = grid.cells().to_vec();
    for patch in patches(&info, &cells, true, |cell| cell == Cell::Occupied) {
        if (patch.len() as f64) * cell_area < parameters.stray - ROUNDING {
            patch.iter().for_each(|&i| cells[i] = Cell::Unknown);
        }
    }
    for patch in patches(&info, &cells, false, |cell| cell != Cell::Free) {
        let inside = |&i: &usize| !on_edge(&info, i);
        if (patch.len() as f64) * cell_area < parameters.speck - ROUNDING && patch.iter().all(inside) {
            patch.iter().for_each(|&i| cells[i] = Cell::Free);
        }
    }
    grid.with_cells(cells)
}

// Areas of whole cells are compared with areas in decimal metres.
const ROUNDING: f64 = 1e-9;

fn on_edge(info: &GridInfo, i: usize) -> bool {
    let at = info.index(i);
    at.x == 0 || at.y == 0 || at.x + 1 == info.width || at.y + 1 == info.height
}

/// Connected patches of the chosen cells, each in the order of the flood from its first cell.
fn patches(
    info: &GridInfo,
    cells: &[Cell],
    diagonal: bool,
    chosen: impl Fn(Cell) -> bool,
) -> Vec<Vec<usize>> {
    let mut open: Vec<bool> = cells.iter().map(|&cell| chosen(cell)).collect();
    let mut patches = Vec::new();
    for start in 0..cells.len() {
        if !open[start] {
            continue;
        }
        open[start] = false;
        let mut patch = vec![start];
        let mut next = 0;
        while next < patch.len() {
            for neighbor in info.neighbors(info.index(patch[next]), diagonal) {
                let i = info.offset(neighbor);
                if open[i] {
                    open[i] = false;
                    patch.push(i);
                }
            }
            next += 1;
        }
        patches.push(patch);
    }
    patches
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
        let clean = clean(&grid, &CleaningParameters { stray: 0.02, speck: 0.04 });
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
        let wanted = ["########", "#......#", "#....??#", "#.....?#", "#.##...#", "#.##...#", "########"];
        assert_eq!(found, wanted);
    }

    #[test]
    fn a_stray_reading_in_the_unknown_stays_unknown() {
        assert_eq!(cleaned(&["??????", "??#???", "??????"]), ["??????", "??????", "??????"]);
    }

    #[test]
    fn a_shadow_in_free_space_is_filled() {
        assert_eq!(cleaned(&[".....", "..??.", "....."]), [".....", ".....", "....."]);
        assert_eq!(cleaned(&["..?..", "....."]), ["..?..", "....."]);
    }
}
