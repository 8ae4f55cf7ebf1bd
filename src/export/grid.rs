//! An occupancy grid as JSON.

use crate::grid::OccupancyGrid;
use crate::trace::wire_grid::WireGridInfo;
use serde::Serialize;
use utoipa::ToSchema;

/// A grid in the form in which a trace has LPMs, and ROS has `nav_msgs/OccupancyGrid`.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = Grid)]
pub struct GridDocument {
    /// Size, scale and place of the grid.
    pub info: WireGridInfo,
    /// Its cells: row 0 is the bottom row, x is fastest; -1 unknown, 0 free, 100 occupied.
    pub data: Vec<i8>,
}

impl GridDocument {
    /// The JSON form of a grid. Linear in its cells.
    pub fn of(grid: &OccupancyGrid) -> GridDocument {
        GridDocument { info: WireGridInfo::of(grid.info()), data: grid.to_occupancy() }
    }
}
