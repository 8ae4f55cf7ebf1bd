//! Connected patches of cells, run by run.

use crate::grid::plane::Plane;
use std::ops::Range;

/// A horizontal run of cells, `start..end` in row-major order.
pub(super) struct Run {
    pub(super) start: usize,
    pub(super) end: usize,
    /// The run of its patch that comes first, or one on the way to it; once all runs are joined, the patch's number.
    pub(super) patch: usize,
}

/// Patches of the chosen cells that touch one another by their sides, or by corners too.
pub(super) struct Patches {
    width: usize,
    runs: Vec<Run>,
    /// The cells of each patch.
    sizes: Vec<usize>,
}

impl Patches {
    /// Linear in the runs, but for a logarithm.
    pub(super) fn new(chosen: &Plane, corners: bool) -> Self {
        let mut patches = Patches { width: chosen.width(), runs: Vec::new(), sizes: Vec::new() };
        let reach = usize::from(corners);
        // The first run of the row below that may touch the next one.
        let mut below = 0;
        chosen.each_run(|start, end| {
            patches.runs.push(Run { start, end, patch: patches.runs.len() });
            below = patches.join(below, reach);
        });
        patches.number();
        patches
    }

    /// Joins the last run with those of the row below that it touches, of which none comes before `below`. The first
    /// that the next run may touch.
    fn join(&mut self, mut below: usize, reach: usize) -> usize {
        let (last, width) = (self.runs.len() - 1, self.width);
        let (start, end) = (self.runs[last].start, self.runs[last].end);
        let (row, row_below) = (start / width, |run: &Run| run.start / width + 1);
        while row_below(&self.runs[below]) < row
            || (row_below(&self.runs[below]) == row && self.runs[below].end + width + reach <= start)
        {
            below += 1;
        }
        let mut run = below;
        while row_below(&self.runs[run]) == row && self.runs[run].start + width < end + reach {
            let (a, b) = (self.root(run), self.root(last));
            self.runs[a.max(b)].patch = a.min(b);
            run += 1;
        }
        below
    }

    /// The first run of a patch, from any of its runs; the way there is made half as long.
    fn root(&mut self, mut run: usize) -> usize {
        while self.runs[run].patch != run {
            let above = self.runs[run].patch;
            self.runs[run].patch = self.runs[above].patch;
            run = above;
        }
        run
    }

    /// Numbers the patches in the order of their first runs.
    fn number(&mut self) {
        for run in 0..self.runs.len() {
            // A run is linked to one before it, which has its number already.
            let link = self.runs[run].patch;
            let patch = if link == run { self.sizes.len() } else { self.runs[link].patch };
            if link == run {
                self.sizes.push(0);
            }
            self.sizes[patch] += self.runs[run].end - self.runs[run].start;
            self.runs[run].patch = patch;
        }
    }

    /// Cells of a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// All runs, ascending.
    pub(super) fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The cells of each patch.
    pub(super) fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The runs of the patch that holds a cell, ascending; none if no patch does.
    pub(super) fn around(&self, cell: usize) -> Vec<Range<usize>> {
        let at = self.runs.partition_point(|run| run.end <= cell);
        let Some(found) = self.runs.get(at).filter(|run| run.start <= cell) else { return Vec::new() };
        self.runs.iter().filter(|run| run.patch == found.patch).map(|run| run.start..run.end).collect()
    }

    /// The cells of all patches that are as wanted.
    pub(super) fn cells_of(&self, wanted: &[bool]) -> impl Iterator<Item = usize> {
        let runs = self.runs.iter().filter(|run| wanted[run.patch]);
        runs.flat_map(|run| run.start..run.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::grid::{Cell, GridInfo};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn patches_are_those_of_a_flood(
            filled in prop::collection::vec(prop::bool::weighted(0.5), 1..200), width in 1usize..80, corners: bool,
        ) {
            let height = filled.len().div_ceil(width);
            let info = GridInfo { resolution: 1.0, width, height, origin: Pose::IDENTITY };
            let kind = |i: usize| if filled.get(i) == Some(&true) { Cell::Free } else { Cell::Unknown };
            let cells: Vec<Cell> = (0..width * height).map(kind).collect();
            let patches = Patches::new(&Plane::of(&cells, width, Cell::Free), corners);
            let mut seen = 0;
            for start in 0..cells.len() {
                let found: Vec<usize> = patches.around(start).into_iter().flatten().collect();
                let mut flood = BTreeSet::new();
                let mut open = Vec::from_iter((cells[start] == Cell::Free).then_some(start));
                while let Some(i) = open.pop() {
                    if flood.insert(i) {
                        let around = info.neighbors(info.index(i), corners).map(|at| info.offset(at));
                        open.extend(around.filter(|&j| cells[j] == Cell::Free));
                    }
                }
                prop_assert_eq!(&found, &flood.iter().copied().collect::<Vec<_>>());
                if flood.first() == Some(&start) {
                    prop_assert_eq!(patches.sizes()[seen], flood.len());
                    let wanted: Vec<bool> = (0..patches.sizes().len()).map(|patch| patch == seen).collect();
                    prop_assert_eq!(patches.cells_of(&wanted).collect::<Vec<_>>(), found);
                    seen += 1;
                }
            }
            prop_assert_eq!(seen, patches.sizes().len());
        }
    }
}
