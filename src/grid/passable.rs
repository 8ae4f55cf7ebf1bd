//! The cells of a window that a robot fits into, and where they lead out of it.

use crate::geometry::Point;
use crate::grid::patches::Patches;
use crate::grid::plane::Plane;
use crate::grid::window::Window;
use crate::grid::{DistanceField, SkeletonParameters};
use std::ops::Range;

/// The cells of the window where the robot's passage width fits, by their positions in its cut out part.
pub(super) struct Core<'a> {
    pub(super) window: &'a Window<'a>,
    pub(super) squared: Vec<u32>,
    pub(super) inside: Plane,
}

impl<'a> Core<'a> {
    pub(super) fn new(
        distance: &DistanceField,
        window: &'a Window<'a>,
        parameters: &SkeletonParameters,
    ) -> Self {
        let Window { info, cut, corner, .. } = *window;
        let mut squared = vec![0; cut.width * cut.height];
        let (rows, within) = (distance.squared().chunks_exact(info.width), cut.width - 2);
        for (kept, row) in
            squared.chunks_exact_mut(cut.width).skip(1).zip(rows.skip(corner.y)).take(cut.height - 2)
        {
            kept[1..=within].copy_from_slice(&row[corner.x..corner.x + within]);
        }
        // A strip of clear width w has its obstacle cells, centre to centre, w plus one cell apart.
        let least = ((parameters.passage_width / info.resolution + 1.0) / 2.0).powi(2).ceil() as u32;
        let mut inside = Plane::empty(cut.width, cut.height);
        for stretch in window.rows().map(|row| window.stretch(row)) {
            inside.insert_where(stretch.start, &squared[stretch.clone()], |&squared| squared >= least);
        }
        Core { window, squared, inside }
    }

    /// Adds the free cells that the robot has driven over.
    pub(super) fn add_trail(&mut self, trail: &[Point], half_width: f64) {
        let (info, window) = (self.window.info, self.window);
        let reach = half_width / info.resolution;
        let to_cells = info.origin.inverse().transform();
        let local = |point: &Point| to_cells.point(point) / info.resolution;
        for leg in trail.windows(2) {
            let (from, to) = (local(&leg[0]), local(&leg[1]));
            for row in window.rows_between(from.y.min(to.y) - reach, from.y.max(to.y) + reach) {
                let y = window.y(row) as f64 + 0.5;
                let (left, right) = across(&from, &to, y, reach);
                for (x, i) in window.columns_between(row, left, right) {
                    // Mostly there is room enough anyway.
                    let known = self.inside.contains(i) || self.squared[i] == 0;
                    if !known && off_segment(&Point::new(x as f64 + 0.5, y), &from, &to) <= reach {
                        self.inside.insert(i);
                    }
                }
            }
        }
    }

    /// Takes out the cells beyond the comfort distance wherever they reach the rim of the window.
    pub(super) fn remove_open_expanses(&mut self, comfort_distance: f64) {
        let most = (comfort_distance / self.window.info.resolution).powi(2) as u32;
        let mut wide = Plane::empty(self.window.cut.width, self.window.cut.height);
        self.inside.each_run(|start, end| {
            wide.insert_where(start, &self.squared[start..end], |&squared| squared > most);
        });
        let expanses = Patches::new(&wide, true);
        let mut open = vec![false; expanses.sizes().len()];
        for run in expanses.runs() {
            let inner = self.window.inner_stretch(run.start / wide.width());
            open[run.patch] |= run.start < inner.start || inner.end < run.end;
        }
        expanses.cells_of(&open).for_each(|i| self.inside.remove(i));
    }

    /// For every stretch of rim that the members reach, its cell of greatest clearance; ascending.
    pub(super) fn exits(&self, members: &[Range<usize>]) -> Vec<usize> {
        let cut = &self.window.cut;
        let mut rim = Plane::empty(cut.width, cut.height);
        for run in members {
            let inner = self.window.inner_stretch(run.start / cut.width);
            rim.insert_run(run.start..run.end.min(inner.start.max(run.start)));
            rim.insert_run(run.start.max(inner.end.min(run.end))..run.end);
        }
        let stretches = Patches::new(&rim, true);
        let mut cells = vec![Vec::new(); stretches.sizes().len()];
        stretches.runs().iter().for_each(|run| cells[run.patch].extend(run.start..run.end));
        let mut exits: Vec<usize> = cells.iter().filter_map(|stretch| self.widest(stretch)).collect();
        exits.sort_unstable();
        exits
    }

    /// The cell of greatest clearance; of several, the middle one in the order given.
    fn widest(&self, cells: &[usize]) -> Option<usize> {
        let most = cells.iter().map(|&i| self.squared[i]).max()?;
        let best: Vec<usize> = cells.iter().copied().filter(|&i| self.squared[i] == most).collect();
        best.get(best.len() / 2).copied()
    }
}

/// Between which columns, at most, points in a row are within reach of a segment.
fn across(from: &Point, to: &Point, y: f64, reach: f64) -> (f64, f64) {
    let rise = to.y - from.y;
    let share = |y: f64, level: f64| if rise == 0.0 { level } else { ((y - from.y) / rise).clamp(0.0, 1.0) };
    let [a, b] = [share(y - reach, 0.0), share(y + reach, 1.0)].map(|share| from.x + (to.x - from.x) * share);
    (a.min(b) - reach, a.max(b) + reach)
}

/// Distance of a point from a segment.
fn off_segment(point: &Point, from: &Point, to: &Point) -> f64 {
    let along = to - from;
    let share = (point - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (point - (from + along * share.clamp(0.0, 1.0))).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::grid::{Cell, CellIndex, GridInfo, OccupancyGrid};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_trail_is_every_free_cell_within_reach_of_it(
            points in prop::collection::vec((-60.0..60.0f64, -60.0..60.0f64), 0..6),
            (width, height) in (1usize..60, 1usize..60),
            turned in 0.0..6.0f64,
        ) {
            let info = GridInfo { resolution: 0.5, width, height, origin: Pose::new(-7.0, 3.0, turned) };
            let wall = |i: usize| if i.is_multiple_of(11) { Cell::Occupied } else { Cell::Free };
            let grid = OccupancyGrid::new(info, (0..width * height).map(wall).collect()).unwrap();
            let distance = DistanceField::new(&grid);
            let trail: Vec<Point> = points.into_iter().map(|(x, y)| Point::new(x, y)).collect();
            let middle = CellIndex { x: width / 3, y: height / 2 };
            let narrow = SkeletonParameters { passage_width: 1e3, scope: 9.0, ..SkeletonParameters::default() };
            let window = Window::new(&info, middle, narrow.scope, 0.0);
            let mut core = Core::new(&distance, &window, &narrow);
            core.add_trail(&trail, 0.8);
            for at in (0..width * height).map(|i| info.index(i)) {
                let off = trail.windows(2).map(|leg| off_segment(&info.center(at), &leg[0], &leg[1]));
                let off = off.fold(f64::INFINITY, f64::min);
                let within = window.contains(at) && grid.cell(at) == Cell::Free;
                // Rounding decides on the brink.
                if (off - 0.8).abs() > 1e-9 {
                    let found = window.place(at).is_some_and(|i| core.inside.contains(i));
                    prop_assert_eq!(found, within && off < 0.8);
                }
            }
        }
    }
}
