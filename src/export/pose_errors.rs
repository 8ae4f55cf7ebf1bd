//! How far poses are off, beside relative poses that somebody has checked.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How far the poses of a log are off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PoseErrors {
    /// Relations at stamps that no scan has.
    pub unknown: usize,
    /// The errors of the others: of `all`, of those that close `loops` (30 s apart and more), of those `within` the
    /// metres of driving that are remembered, and `beyond`.
    pub rows: Vec<PoseErrorRow>,
}

/// The errors of some relations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PoseErrorRow {
    /// Which relations these are.
    pub relations: String,
    /// How many they are.
    pub count: usize,
    /// Of odometry.
    pub odometry: PoseError,
    /// Of the poses of scan matching.
    pub matched: PoseError,
    /// Of the patchwork that the preferred map makes of them; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_map: Option<PoseError>,
    /// Of the patchwork once scans of different passes have been laid onto each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_scans: Option<PoseError>,
}

/// How large errors of displacements are; 0 where there are none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PoseError {
    /// Mean, median and largest error of the translation, metres.
    pub metres: [f64; 3],
    /// The same of the rotation, degrees.
    pub degrees: [f64; 3],
}
