//! The measured axioms: what odometry and bearings say of a candidate map (seed, sections 2.3 and 3.2).
//!
//! [`Measurements`] holds what was measured on a trace and judges behind [`crate::abduction::Evidence`]. An axiom
//! is a pure function of the measurements, the assignments of a candidate and what is proposed for one travel, so that every
//! order of search gives the same answer. A candidate carries nothing but what searches for room have learned (`lessons`), which
//! follows from the same. Judging the children of a
//! candidate costs about the cube of the loops it has closed, once for all (`layout`).
//!
//! All that is measured lies in a graph of two kinds of frames (`chain`): that of each visit, and that of each
//! place, which is that of its first visit. A travel joins the frames of two visits; a visit is joined to the frame
//! of its place by the rotation that lays the bearings of its slots onto those of the first visit, under the
//! alignment that the candidate assigns. Another alignment is another rotation: so heading tells apart what
//! symmetry does not.
//!
//! The bounds, once for all: a true map is refuted only where some error exceeds its gate
//! ([`MetricParameters`]), whatever share of the errors is the same on all travels (a wheel larger than the other, a
//! wrong scale) and not new on each, as long as that share does not change, and as long as no single travel errs by so much
//! that its covariance does not tell how it errs: where the heading of one is off by half a radian, a displacement is not
//! normally distributed. What is not known is not judged.

mod angle;
mod apart;
mod bound;
mod breach;
mod chain;
mod closure;
mod condition;
mod conflicts;
mod crowd;
mod distance;
mod floor;
mod frames;
mod layout;
mod leg;
mod lessons;
mod loops;
mod measurements;
mod parameters;
mod profile;
mod remainder;
mod segments;
mod share;
mod sides;
mod uncertainty;
mod witness;

pub use crowd::{Crowd, Patience, Room};
pub use measurements::Measurements;
pub use parameters::MetricParameters;
pub use witness::Witness;
