//! Occupancy grids and what can be computed from one grid alone.

pub mod occupancy;

pub use occupancy::{Cell, CellIndex, GridError, GridInfo, OccupancyGrid};
