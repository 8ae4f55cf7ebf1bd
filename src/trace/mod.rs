//! The experience of a robot: alternating observations and actions, and its NDJSON form.
//!
//! A trace is append-only. Its events count up from 0 without gaps; an observation is followed by any number of
//! turns and one travel, which ends at the next observation; an operator's word may stand between any two events;
//! a trace may stop anywhere. A trace of [`views`] has an observation after every turn and travel. [`event`] holds the
//! values, [`wire`] their JSON form with [`wire_star`] and [`wire_grid`], [`ndjson`] reads and writes lines, and
//! [`recording`] makes a trace of visits found in a log. [`experience`] checks the grammar and turns grids into stars
//! ([`perceive`]), so that what leaves this module is what the logic needs.

pub mod event;
mod event_error;
mod experience_error;
mod object;
mod sighting;
pub mod wire_star;
pub mod wire_grid;
pub mod wire;
pub mod views;
pub mod experience;
pub mod perceive;
pub mod ndjson;
pub mod recording;

pub use event::{
    Assert, Event, EventKind, Observation, Percept, Stamp, Travel, Turn, TurnDescription, TurnTarget,
};
pub use event_error::EventError;
pub use experience::Experience;
pub use experience_error::ExperienceError;
pub use ndjson::{TraceError, parse_event, read_lines, read_trace, write_event, write_trace};
pub use sighting::{Described, Motion, Sighting};
pub use views::{ViewExperience, ViewSighting};
