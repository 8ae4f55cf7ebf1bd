//! Occupancy grids and what can be computed from one grid alone.

pub mod occupancy;
pub mod cleaning;
pub mod distance;
pub mod skeleton;
pub mod skeleton_graph;
mod passable;
mod patches;
mod plane;
mod rooms;
mod thinning;
mod window;

pub use cleaning::{CleaningParameters, clean};
pub use distance::DistanceField;
pub use occupancy::{Cell, CellIndex, GridError, GridInfo, OccupancyGrid};
pub use skeleton::{Skeleton, SkeletonError, SkeletonParameters, Surroundings, skeletonize};
pub use skeleton_graph::{NodeKind, SkeletonEdge, SkeletonGraph, SkeletonNode};
