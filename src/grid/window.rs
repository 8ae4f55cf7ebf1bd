//! The disc around a place within which the grid is looked at.

use crate::grid::{CellIndex, GridInfo};
use std::ops::Range;

/// The part of the grid in which free space counts as settled. Lengths are in cells.
pub(super) struct Window<'a> {
    pub(super) info: &'a GridInfo,
    center: CellIndex,
    /// The greatest squared distance from the middle at which a cell is in the window, and at which it is not on its rim.
    most: [u64; 2],
    rim: f64,
    /// The smallest part of the grid that holds the window, with a frame of one cell around it, which may lie beyond the
    /// grid; indices of cells are positions in it.
    pub(super) cut: GridInfo,
    /// Its first cell within the frame.
    pub(super) corner: CellIndex,
}

impl<'a> Window<'a> {
    pub(super) fn new(info: &'a GridInfo, center: CellIndex, radius: f64, rim: f64) -> Self {
        let (radius, rim) = (radius / info.resolution, rim / info.resolution);
        // Casts saturate: no part of a grid is larger than the grid.
        let reach = radius.max(0.0) as usize;
        let corner = CellIndex { x: center.x.saturating_sub(reach), y: center.y.saturating_sub(reach) };
        let end = |at: usize, side: usize| side.min(at.saturating_add(reach).saturating_add(1));
        let cut = GridInfo {
            width: end(center.x, info.width) - corner.x + 2,
            height: end(center.y, info.height) - corner.y + 2,
            ..*info
        };
        // Of whole numbers, those up to the square are those up to its whole part.
        let most = [radius, (radius - rim).max(0.0)].map(|radius| (radius * radius) as u64);
        Window { info, center, most, rim, cut, corner }
    }

    pub(super) fn contains(&self, at: CellIndex) -> bool {
        self.squared_offset(at) <= self.most[0]
    }

    /// Whether a cell of the window is nearer to what is not in the window than the depth of the rim.
    pub(super) fn on_rim(&self, at: CellIndex) -> bool {
        let edge = at.x.min(at.y).min(self.info.width - 1 - at.x).min(self.info.height - 1 - at.y);
        (edge as f64) < self.rim || self.squared_offset(at) > self.most[1]
    }

    fn squared_offset(&self, at: CellIndex) -> u64 {
        (at.x.abs_diff(self.center.x) as u64).pow(2) + (at.y.abs_diff(self.center.y) as u64).pow(2)
    }

    /// Where in the cut out part a cell is, if it is there.
    pub(super) fn place(&self, at: CellIndex) -> Option<usize> {
        let (x, y) = (at.x.checked_sub(self.corner.x)?, at.y.checked_sub(self.corner.y)?);
        (x + 2 < self.cut.width && y + 2 < self.cut.height).then_some((y + 1) * self.cut.width + x + 1)
    }

    /// The inverse of `place`.
    pub(super) fn cell(&self, place: usize) -> CellIndex {
        let at = self.cut.index(place);
        CellIndex { x: at.x + self.corner.x - 1, y: at.y + self.corner.y - 1 }
    }

    /// Rows of the cut out part within the frame.
    pub(super) fn rows(&self) -> Range<usize> {
        1..self.cut.height - 1
    }

    /// Those of the rows that some between two heights in cells are among.
    pub(super) fn rows_between(&self, low: f64, high: f64) -> Range<usize> {
        let rows = self.rows();
        // Casts saturate: what lies beyond the window is cut off.
        let row = |y: f64| (y.max(0.0) as usize).saturating_add(1).saturating_sub(self.corner.y);
        row(low).max(rows.start)..row(high.ceil()).min(rows.end)
    }

    /// The cells of a row that are in the window and between two abscissas in cells: their columns in the grid, and their
    /// positions.
    pub(super) fn columns_between(
        &self,
        row: usize,
        left: f64,
        right: f64,
    ) -> impl Iterator<Item = (usize, usize)> {
        let (stretch, first, corner) = (self.stretch(row), row * self.cut.width + 1, self.corner.x);
        let place = |x: f64| first + (x.max(0.0) as usize).saturating_sub(corner).min(self.cut.width);
        let places = place(left).max(stretch.start)..place(right.ceil()).min(stretch.end);
        places.map(move |place| (place - first + corner, place))
    }

    /// The row of the grid that a row of the cut out part is.
    pub(super) fn y(&self, row: usize) -> usize {
        row + self.corner.y - 1
    }

    /// Positions in one of the rows that are in the window.
    pub(super) fn stretch(&self, row: usize) -> Range<usize> {
        self.disc(row, self.most[0])
    }

    /// Those of them that are not on the rim.
    pub(super) fn inner_stretch(&self, row: usize) -> Range<usize> {
        // The nearest cells that are as far from the edge of the grid as the rim is deep.
        let depth = self.rim.ceil() as usize;
        let (y, first) = (self.y(row), row * self.cut.width + 1);
        if y < depth || y.saturating_add(depth) >= self.info.height {
            return first..first;
        }
        let disc = self.disc(row, self.most[1]);
        let place = |x: usize| first + x.saturating_sub(self.corner.x);
        let start = disc.start.max(place(depth));
        start..disc.end.min(place(self.info.width.saturating_sub(depth))).max(start)
    }

    /// Positions in one of the rows that are in a disc around the middle of the window of so great a squared radius.
    fn disc(&self, row: usize, most: u64) -> Range<usize> {
        let (y, first) = (self.y(row), row * self.cut.width + 1);
        let Some(left) = most.checked_sub((y.abs_diff(self.center.y) as u64).pow(2)) else {
            return first..first;
        };
        // No root of a number below 2^52 is rounded up to a whole one, and no grid is as wide as that of a greater.
        let half = (left as f64).sqrt() as usize;
        let middle = self.center.x - self.corner.x;
        first + middle.saturating_sub(half)..first + (middle + half + 1).min(self.cut.width - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_stretches_of_a_window_are_its_cells(
            (width, height) in (1usize..30, 1usize..30), (x, y) in (0usize..1000, 0usize..1000),
            radius in prop_oneof![0.0..40.0f64, Just(1e30)], rim in 0.0..12.0f64,
        ) {
            let info = GridInfo { resolution: 1.0, width, height, origin: crate::geometry::Pose::IDENTITY };
            let window = Window::new(&info, CellIndex { x: x % width, y: y % height }, radius, rim);
            let rows = window.rows().flat_map(|row| window.stretch(row));
            let found: Vec<CellIndex> = rows.map(|place| window.cell(place)).collect();
            let all = (0..width * height).map(|i| info.index(i));
            prop_assert_eq!(found, all.clone().filter(|&at| window.contains(at)).collect::<Vec<_>>());
            let rows = window.rows().flat_map(|row| window.inner_stretch(row));
            let inner: Vec<CellIndex> = rows.map(|place| window.cell(place)).collect();
            let settled = all.filter(|&at| window.contains(at) && !window.on_rim(at));
            prop_assert_eq!(inner, settled.collect::<Vec<_>>());
            for at in (0..width * height).map(|i| info.index(i)) {
                prop_assert!(window.place(at).is_none_or(|place| window.cell(place) == at));
                prop_assert!(window.place(at).is_some() || !window.contains(at));
            }
        }
    }
}
