//! The original SSH: which assignments of views to distinctive states explain a trace of turns and travels, and
//! which explains it best (seed, sections 3.1 to 3.3; Remolina and Kuipers, IJCAI-01).
//!
//! The robot has no star here, only a *view* at each dstate. A *candidate* assigns every observation to a dstate.
//! All else follows from the assignment: the causal schemas, the places (classes of dstates joined by turns), the
//! directed paths (classes of dstates joined by travels and turns around), the order of places on paths. What the
//! axioms say and what they leave open is written in [`AXIOMS`].
//!
//! A schema that a map already holds explains an observation or discards the map; any other observation branches
//! over every known dstate with its view and a new one. [`breadth_first()`] follows all candidates, [`best_first()`]
//! the simplest or the most promising.
//!
//! Symbols only, and values only: a map is never changed once made.

mod action;
mod axiom;
mod preference;
mod map;
mod order;
mod place;
mod canonical;
mod candidate;
mod history;
mod refutation;
mod report;
mod children;
mod bound;
mod breadth_first;
mod best_first;

pub use action::{Action, Sight, Sights, TooMany, ViewId};
pub use axiom::{AXIOMS, Axiom, AxiomId};
pub use best_first::{Guide, best_first};
pub use breadth_first::{Exhaustive, breadth_first};
pub use candidate::Candidate;
pub use map::{ClassicMap, Dstate, DstateId};
pub use place::{ClassicPath, ClassicPlace};
pub use preference::Simplicity;
pub use refutation::Refutations;
pub use report::{Extinction, Report, StopReason};
