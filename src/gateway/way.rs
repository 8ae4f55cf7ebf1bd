//! A way along the skeleton from the middle of a place to an exit.

use crate::geometry::{Point, Vector};
use crate::grid::{CellIndex, DistanceField};

/// Cells of a way with what is measured along it. Points are metres along the grid's own axes.
pub(super) struct Way {
    pub(super) cells: Vec<CellIndex>,
    pub(super) points: Vec<Point>,
    /// Length from the start, metres.
    pub(super) arc: Vec<f64>,
    /// Distance to the nearest obstacle, metres.
    pub(super) clearance: Vec<f64>,
}

impl Way {
    pub(super) fn new(cells: Vec<CellIndex>, distance: &DistanceField) -> Self {
        let resolution = distance.info().resolution;
        let points: Vec<Point> = cells.iter().map(|&cell| local(cell, resolution)).collect();
        let mut arc = Vec::with_capacity(points.len());
        let mut length = 0.0;
        for (i, point) in points.iter().enumerate() {
            length += if i > 0 { (point - points[i - 1]).norm() } else { 0.0 };
            arc.push(length);
        }
        let clearance = cells.iter().map(|&cell| distance.clearance(cell)).collect();
        Way { cells, points, arc, clearance }
    }

    /// The least clearance on the way, metres.
    pub(super) fn narrowest(&self) -> f64 {
        self.clearance.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The last index no further than `length` beyond index `from`.
    pub(super) fn ahead(&self, from: usize, length: f64) -> usize {
        let limit = self.arc[from] + length;
        let beyond = self.arc[from..].partition_point(|&s| s <= limit);
        from + beyond.saturating_sub(1)
    }

    /// The unit vector of the best straight line (total least squares) through the stretch from `from` to `to`,
    /// pointing along the way. Nothing if the stretch has no length.
    pub(super) fn direction(&self, from: usize, to: usize) -> Option<Vector> {
        let stretch = &self.points[from..=to];
        let chord = self.points[to] - self.points[from];
        let count = stretch.len() as f64;
        let mean = stretch.iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / count;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for point in stretch {
            let d = point.coords - mean;
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let line = Vector::new(angle.cos(), angle.sin());
        if chord.norm() == 0.0 {
            None
        } else if line.dot(&chord) < 0.0 {
            Some(-line)
        } else {
            Some(line)
        }
    }
}

/// The centre of a cell, metres along the grid's own axes.
pub(super) fn local(cell: CellIndex, resolution: f64) -> Point {
    Point::new((cell.x as f64 + 0.5) * resolution, (cell.y as f64 + 0.5) * resolution)
}
