//! The straight projection of an inward-facing gateway across the LPM (seed, footnote 4).

use crate::gateway::Gateway;
use crate::geometry::Point;
use crate::grid::{Cell, DistanceField, OccupancyGrid};
use crate::star::ControlLaw;

/// Where a terminating path would go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Projection {
    /// The first point that is not free, or the last one in the grid, LPM frame.
    pub(super) end: Point,
    /// What the robot could do there: `DeadEnd` or `None`.
    pub(super) control: ControlLaw,
    /// How far the label is from the other, as a fraction of the comfort distance.
    pub(super) margin: f64,
}

/// Projects a gateway inward: `None` if it gets farther than the comfort distance from all obstacles or leaves the
/// grid, `DeadEnd` if an obstacle stops it before.
pub(super) fn project(
    gateway: &Gateway,
    grid: &OccupancyGrid,
    distance: &DistanceField,
    comfort_distance: f64,
) -> Projection {
    let info = grid.info();
    let step = -gateway.outward() * (info.resolution / 2.0);
    let mut end = gateway.center;
    let mut widest: f64 = 0.0;
    let mut stopped = false;
    // No way across the grid has more steps.
    for _ in 0..2 * (info.width + info.height) {
        let Some(cell) = info.cell_at(&end) else { break };
        if grid.cell(cell) != Cell::Free {
            stopped = true;
            break;
        }
        widest = widest.max(distance.clearance(cell));
        end += step;
    }
    let lost = widest > comfort_distance || !stopped;
    let control = if lost { ControlLaw::None } else { ControlLaw::DeadEnd };
    let margin = if stopped { (widest / comfort_distance - 1.0).abs() } else { 1.0 };
    Projection { end, control, margin }
}
