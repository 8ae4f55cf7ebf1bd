//! The experience of a robot: alternating observations and actions, and its NDJSON form.
//!
//! A trace is append-only. Its events count up from 0 without gaps; an observation is followed by any number of
//! turns and one travel, which ends at the next observation; a trace may stop anywhere. [`event`] holds the
//! values, [`wire`] their JSON form, [`ndjson`] reads and writes lines, [`recording`] cuts a log into a trace, and [`experience`] checks the grammar
//! and turns grids into stars, so that what leaves this module is what the logic needs.

pub mod event;
pub mod experience;
pub mod perceive;
pub mod ndjson;
pub mod recording;
pub mod wire;
pub mod wire_grid;

pub use event::{Event, EventKind, Observation, Percept, Stamp, Travel, Turn, TurnTarget};
pub use experience::{Experience, ExperienceError, Sighting};
pub use ndjson::{EventError, TraceError, parse_event, read_trace, write_event, write_trace};
