//! The patchwork: local frames relaxed into one, so that the strain at their joints is least (seed, section 2.3).
//!
//! [`pose_graph`] is the solver. What stands beside it makes graphs of what a robot saw and did, for it to relax: of a
//! trace, [`survey`] tells the frames and the travels, [`agreement`] lays the LPMs of two visits to one place onto each
//! other, [`closures`] asks that of all visits to places known before, [`local_frames`] relaxes a candidate map, and [`ties`]
//! says which of several is strained least; of a log, [`drive`]
//! keeps the way and [`assembly`] closes it. Walls are laid onto walls by [`submap`] and [`alignment`]. [`merged`] makes
//! one grid of many.

pub mod agreement;
pub mod alignment;
pub mod assembly;
pub mod closures;
pub mod drive;
pub mod local_frames;
pub mod merged;
pub mod pose_graph;
pub mod submap;
pub mod survey;
pub mod ties;

pub use pose_graph::{
    Edge, GraphError, IncrementalGraph, Loss, MAX_POSES, Outcome, Part, PoseGraph, PoseId, RelaxError,
    RelaxOptions, Relaxation, Relaxer, Start, Strain, Trial, Update, format, relax, relax_until,
};
