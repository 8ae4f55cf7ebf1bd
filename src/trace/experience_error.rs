//! Why a trace may not go on with an event.

use crate::trace::event_error::EventError;
use thiserror::Error;

/// Why an event may not come here.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ExperienceError {
    /// `seq` is not the next number.
    #[error("is {found}, expected {expected}: events count up from 0 without gaps")]
    Sequence {
        /// The number expected.
        expected: u64,
        /// The number given.
        found: u64,
    },
    /// Something else must come first.
    #[error("a {found} may not come here, expected {expected}")]
    Order {
        /// The kind given.
        found: &'static str,
        /// What may come.
        expected: &'static str,
    },
    /// The arrival slot has no inward gateway.
    #[error(
        "is {0}, a slot without an inward gateway; expected the directed fragment that the robot came in on"
    )]
    ArrivalNotInward(u8),
    /// The slot the robot faces has no outward gateway.
    #[error(
        "leaves by slot {0}, which has no outward gateway; expected a turn to a slot that has one before the travel"
    )]
    TravelNotOutward(u8),
    /// The turn's slot is not one of the star's.
    #[error("is {found}, expected a slot of the latest star, 0 to {last}")]
    TurnOutOfRange {
        /// The slot given.
        found: u8,
        /// The last slot of the star.
        last: u8,
    },
    /// Something of a trace of views in a trace of stars or grids, or the other way round.
    #[error(
        "belongs to a trace of {found}, but this is a trace of {expected}; a trace holds views throughout or nowhere"
    )]
    Mixed {
        /// JSON pointer to what does not belong here.
        pointer: &'static str,
        /// What it belongs to.
        found: &'static str,
        /// What the trace began with.
        expected: &'static str,
    },
    /// A view where only stars and grids can be taken.
    #[error("is a view, which profile classic alone explains; expected a star or an lpm")]
    ViewRefused,
    /// A turn in radians at a star that has no bearings.
    #[error("turns in radians, but the latest star has no bearings; expected `to`, a slot of the star")]
    NoBearings,
    /// No gateway near the heading.
    #[error(
        "faces {0} rad in the frame of the latest observation, and no outward gateway lies within 1.05 rad of that"
    )]
    NoGatewayThere(String),
    /// A word on an observation that was not made yet.
    #[error(
        "is {found}, but {observations} observations have been made; expected one of them, counted from 0"
    )]
    NotSeen {
        /// Which of the two.
        position: usize,
        /// The observation given.
        found: usize,
        /// How many have been made.
        observations: usize,
    },
    /// A word on one observation.
    #[error("names observation {0} twice, expected two different ones")]
    OneVisit(usize),
    /// A word taken back that is not in force.
    #[error("is {found}, expected the seq of an assert in force: {in_force}")]
    NotInForce {
        /// The number given.
        found: u64,
        /// Those that could be given.
        in_force: String,
    },
    /// The grid gave no star.
    #[error("gives no star: {0}")]
    NotDescribed(String),
}

impl ExperienceError {
    /// The same with the JSON pointer of the field at fault.
    pub fn at(&self) -> EventError {
        let pointer = match self {
            ExperienceError::Sequence { .. } => "/seq",
            ExperienceError::Order { .. } => "/kind",
            ExperienceError::ArrivalNotInward(_) => "/dstate",
            ExperienceError::TurnOutOfRange { .. } => "/to",
            ExperienceError::NotDescribed(_) => "/lpm",
            ExperienceError::NotSeen { position: 0, .. } => "/visits/0",
            ExperienceError::NotSeen { .. } => "/visits/1",
            ExperienceError::OneVisit(_) => "/visits",
            ExperienceError::NotInForce { .. } => "/assert",
            ExperienceError::Mixed { pointer, .. } => pointer,
            ExperienceError::ViewRefused => "/view",
            ExperienceError::TravelNotOutward(_)
            | ExperienceError::NoBearings
            | ExperienceError::NoGatewayThere(_) => "",
        };
        EventError::new(pointer, self.to_string())
    }
}
