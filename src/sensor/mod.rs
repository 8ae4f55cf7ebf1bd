//! What a robot's sensors gave: recorded logs, laser scans, and the grids that rays make of them.

pub mod log;
pub mod evidence;
pub mod ray_cast;
pub mod scan;
pub mod scan_matching;
pub mod surface;
mod walls;

pub use evidence::{EvidenceGrid, EvidenceParameters};
pub use scan::LaserScan;
pub use scan_matching::{LocalPose, MatchingParameters, ScanMatcher};
