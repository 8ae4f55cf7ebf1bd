//! The patchwork.

mod descent;
pub mod format;
mod graph;
mod loss;
mod parts;
mod problem;
mod relax;
mod singular;
mod start;
mod strain;
mod structure;
mod system;

pub use graph::{Edge, GraphError, MAX_POSES, PoseGraph, PoseId};
pub use loss::Loss;
pub use relax::{Outcome, Part, RelaxOptions, Relaxation, Relaxer, Start, Trial, relax};
pub use strain::Strain;

/// Why a graph cannot be relaxed at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RelaxError {
    /// The factor has more entries than memory or 32 bits hold.
    #[error("there is not enough memory for the normal equations; relax the graph in parts")]
    Memory,
}
