//! The abduction of maps: which assignments of observations to places explain a trace, and which explains it best
//! (seed, sections 3.2, 3.3 and 4.4; Remolina and Kuipers, IJCAI-01).
//!
//! A *candidate* assigns every observation to a place and a rotation, such that the axioms hold. An observation
//! *extends* the candidates there are: travel along a known path segment keeps a map or refutes it, travel into
//! the unknown branches over every place that looks the same, in each rotation, and over a new place. *Preferred*
//! are the candidates with the fewest paths, among them those with the fewest places; before both, where boundaries are
//! held as a default, those with the fewest abnormalities.
//!
//! Symbols only. What is known of metres enters, if at all, as further axioms.

mod axiom;
mod axiom_set;
mod axioms;
mod best_first;
mod branch;
mod candidate;
mod children;
mod clash;
mod evidence;
mod judge;
mod kept;
mod leaves;
mod preference;
mod refutation;
mod report;
mod revisable;
mod search;
mod settle;
mod tree;
mod visit;
mod word;

pub use axiom::{Axiom, AxiomId, Check, Profile};
pub use axiom_set::{AxiomError, AxiomSet, Boundary};
pub use axioms::REGISTRY;
pub use branch::{Branch, Lineage, Outcome, Proposal};
pub use candidate::{Assignment, Candidate};
pub use clash::Clash;
pub use evidence::{Evidence, Learned, Lore};
pub use judge::{Proposed, Refutation, judge, proposed};
pub use preference::Simplicity;
pub use refutation::Refutations;
pub use report::{Count, Extinction, OPERATOR, Relation, Report, StopReason};
pub use revisable::Revisable;
pub use search::{Abduction, Limits};
pub use settle::{Settlement, Strategy};
pub use visit::{Visit, VisitError};
pub use word::{Assertion, Word, WordError};
