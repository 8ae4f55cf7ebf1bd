//! The reasons: why a map was refuted, why two visits are one place, what sets candidates apart, what to look at next.
//!
//! Everything is found again on demand from what an abduction keeps; the search records no reasons. Counts are exact
//! over the candidates kept; where a limit cut the search they say so. Symbols only, like [`crate::abduction`].

mod branches;
mod difference;
mod examples;
mod outlook;
mod standstill;
mod together;
mod travels;
mod verdict;

pub use branches::{Ended, Ending, Node, children, ended, node};
pub use difference::{Difference, difference};
pub use examples::examples;
pub use outlook::{Outlook, Prediction, Prospect, outlook};
pub use standstill::{Dissent, standstill};
pub use together::{Alternative, Opinion, Reason, Rival, Together, closures, together, together_each};
pub use travels::{StepKind, Travelled, travels};
pub use verdict::{Verdict, verdict};
