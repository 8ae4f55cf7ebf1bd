//! Recorded logs: entries in file order, and the scans that they make.
//!
//! A *source* turns a file into [`Entry`] values: [`CarmenEntries`] for CARMEN logs, [`BagEntries`] for ROS 2 bags.
//! One [`ScanReader`] turns the entries of any source into [`LaserScan`](crate::sensor::LaserScan) values, each at
//! the robot's odometry and with what came back told from what did not, and keeps a [`LogReport`] of what was
//! read, passed over and guessed. Both are iterators; memory is bounded by a scan and a short look ahead, not by
//! the length of the log.

mod bag;
mod carmen;
mod entry;
mod fields;
mod geometry;
mod laser;
mod lines;
mod mount;
mod no_return;
mod odometry;
mod reader;
mod report;
mod steps;

pub use bag::{BagEntries, BagSurvey, Topic, bag_scans};
pub use carmen::{CarmenEntries, carmen_scans};
pub use entry::{Content, CutOff, Entry, LaserNumber, Sweep, SweepPoses};
pub use lines::TrailingBytes;
pub use no_return::NoReturnSource;
pub use reader::{LogOptions, PoseChoice, ScanReader};
pub use report::{Geometry, GeometrySource, LaserReport, LogReport, MountSource};
pub use steps::Step;

use std::io;
use thiserror::Error;

/// The most beams that a scan may have.
pub const MAX_BEAMS: usize = 1 << 15;
/// Coordinates in metres and stamps in seconds are below this, either sign; no robot has been further.
const LARGEST: f64 = 1e12;

/// Why a log cannot be read on. What came before is good.
#[derive(Debug, Error)]
pub enum LogError {
    /// A malformed line.
    #[error("line {line}: {message}")]
    Line {
        /// Line number, from 1.
        line: u64,
        /// What was found and expected.
        message: String,
    },
    /// The input could not be read.
    #[error("line {line}: cannot be read: {source}")]
    Read {
        /// Line number, from 1.
        line: u64,
        /// The cause.
        source: io::Error,
    },
    /// A bag that is not as expected.
    #[error("{0}")]
    Bag(String),
    /// The log came to its end without a scan.
    #[error("no scan in the log: {0}")]
    NoScans(String),
}
