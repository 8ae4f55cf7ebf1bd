//! What a robot's sensors gave: recorded logs, laser scans, and the grids that rays make of them.

pub mod log;
pub mod ray_cast;
pub mod scan;

pub use ray_cast::EvidenceGrid;
pub use scan::LaserScan;
