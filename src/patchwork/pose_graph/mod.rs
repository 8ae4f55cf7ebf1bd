//! The solver: poses, what was measured between them, and the layout that strains it least. It knows no place, no map and
//! no scan.
//!
//! A [`PoseGraph`] holds frames as poses, and what was measured between them as edges with information. [`relax()`] gives
//! the poses of least strain, which is the most likely layout where errors are normal (Lu and Milios 1997). It never
//! gives up with an error: the [`Relaxation`] says how it ended, which parts hang together, which poses were held and
//! which nothing determines. [`IncrementalGraph`] does the same for a graph that grows.
//!
//! The way of a relaxation: `problem` makes arrays of the edges; `structure` finds an order of elimination on poses, not
//! on numbers; `system` holds the normal equations and has faer factorise them; `start` finds headings and positions
//! that owe nothing to the guesses; `descent` goes down from the cheaper of guesses and that start. The order of
//! elimination and the symbolic analysis are made once.
//!
//! The gauge is fixed by holding poses where they are: those that the graph says, else the first of each part.

mod blocks;
mod descent;
pub mod format;
mod graph;
mod incremental;
mod loss;
mod parts;
mod problem;
mod relax;
mod relaxation;
mod singular;
mod start;
mod strain;
mod structure;
mod system;

pub use graph::{Edge, GraphError, MAX_POSES, PoseGraph, PoseId};
pub use incremental::{IncrementalGraph, Update};
pub use loss::Loss;
pub use relax::{RelaxOptions, Relaxer, Start, relax, relax_until};
pub use relaxation::{Outcome, Part, Relaxation, Trial};
pub use strain::Strain;

/// Why a graph cannot be relaxed at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RelaxError {
    /// The factor has more entries than memory or 32 bits hold.
    #[error("there is not enough memory for the normal equations; relax the graph in parts")]
    Memory,
    /// What was added to one graph is refused by another: never, as both ask the same.
    #[error(transparent)]
    Graph(#[from] GraphError),
}

#[cfg(test)]
mod tests;
