//! Which readings must be taken otherwise, so that some map explains a walk that none explains as it was read.
//!
//! A star is read off one visit with margins, and another visit to the place may read it otherwise. Where the readings
//! as they are leave no candidate, the least doubtful change of them is looked for that leaves one: a visit is likened
//! to another visit to the same place. What comes out is a list of changes and the sightings with them, which the
//! search explains in the ordinary way: every axiom stays in force, so a wrong likening is refuted like any other
//! mistake.

mod doubt;
mod joining;
mod likening;
mod reading;
mod taking;
mod search;

pub use doubt::{Doubt, Sum};
pub use likening::{Change, ChangeKind};
pub use reading::{Opening, Reading, readings};
pub use search::{Bounds, Mended, Told, mend, mend_longest};
