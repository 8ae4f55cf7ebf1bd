//! Takes a piece of a request body into a session, event by event, up to the first fault.

use crate::service::{Accepted, Line, Session, SessionError};
use crate::trace::{Event, EventError, parse_event};
use serde::de::{Deserializer, IgnoredAny, SeqAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use std::sync::Arc;
use thiserror::Error;

/// Events as they came, not parsed yet.
#[derive(Clone, Debug)]
pub enum Batch {
    /// A JSON body: one event or an array of them.
    Json(Vec<u8>),
    /// Lines of NDJSON, blank ones among them, and the most bytes one may have.
    Lines(Vec<Line>, usize),
}

/// What became of a batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Taken {
    /// Events taken for the first time.
    pub new: Vec<Arc<Event>>,
    /// Events taken once more, without effect.
    pub replayed: u64,
    /// What ended the taking before the end of the batch.
    pub fault: Option<Fault>,
}

/// An event that was not taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where in the body it is.
    pub position: Position,
    /// Its number, where that can be read.
    pub seq: Option<u64>,
    /// What is wrong.
    pub error: IntakeError,
}

/// Where in a body an event is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// It is the body.
    Whole,
    /// In an array, from 0.
    Index(u64),
    /// On a line, from 1.
    Line(u64),
}

/// Why an event was not taken.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum IntakeError {
    /// The body is not JSON; nothing in it was taken.
    #[error(
        "the body is not JSON: {0}; expected one event, an array of events, or NDJSON as application/x-ndjson"
    )]
    NotJson(String),
    /// It is not an event.
    #[error(transparent)]
    Malformed(#[from] EventError),
    /// Its line is too long.
    #[error("the line is longer than {0} bytes, expected one event a line; a grid is smallest as png_b64")]
    LineTooLong(usize),
    /// The session does not take it.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// Takes events in order until one cannot be taken.
#[derive(Debug)]
pub struct Intake<'a> {
    session: &'a mut Session,
    taken: Taken,
}

impl<'a> Intake<'a> {
    /// Takes a batch into a session.
    pub fn take(session: &'a mut Session, batch: &Batch) -> Taken {
        let mut intake = Intake { session, taken: Taken::default() };
        let outcome = match batch {
            Batch::Json(body) => intake.json(body),
            Batch::Lines(lines, bound) => intake.lines(lines, *bound),
        };
        Taken { fault: outcome.err(), ..intake.taken }
    }

    /// An array is read twice, first to see that it is JSON throughout. Its events may be many: none is held.
    fn json(&mut self, body: &[u8]) -> Result<(), Fault> {
        let not_json = |error: serde_json::Error| {
            let error = IntakeError::NotJson(error.to_string());
            Fault { position: Position::Whole, seq: None, error }
        };
        let whole: &RawValue = serde_json::from_slice(body).map_err(not_json)?;
        if !whole.get().starts_with('[') {
            return self.event(whole.get(), Position::Whole);
        }
        let mut json = serde_json::Deserializer::from_str(whole.get());
        json.deserialize_seq(Elements(self)).map_err(not_json)?
    }

    fn lines(&mut self, lines: &[Line], bound: usize) -> Result<(), Fault> {
        for line in lines {
            let position = Position::Line(line.number);
            let fault = |error| Fault { position, seq: None, error };
            if line.text.len() > bound {
                return Err(fault(IntakeError::LineTooLong(bound)));
            }
            let text = std::str::from_utf8(&line.text)
                .map_err(|error| fault(EventError::new("", format!("is not UTF-8: {error}")).into()))?;
            if !text.trim().is_empty() {
                self.event(text, position)?;
            }
        }
        Ok(())
    }

    fn event(&mut self, text: &str, position: Position) -> Result<(), Fault> {
        let malformed = |error: EventError| Fault { position, seq: seq_of(text), error: error.into() };
        let event = Arc::new(parse_event(text).map_err(malformed)?);
        let fault = |error: SessionError| Fault { position, seq: Some(event.seq), error: error.into() };
        match self.session.accept(&event).map_err(fault)? {
            Accepted::Replay => self.taken.replayed += 1,
            Accepted::New => self.taken.new.push(event),
        }
        Ok(())
    }
}

/// Takes the elements of an array of events, up to the first fault, which is its value.
struct Elements<'i, 's>(&'i mut Intake<'s>);

impl<'de> Visitor<'de> for Elements<'_, '_> {
    type Value = Result<(), Fault>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of events")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut array: A) -> Result<Self::Value, A::Error> {
        let mut index = 0;
        while let Some(event) = array.next_element::<&RawValue>()? {
            if let Err(fault) = self.0.event(event.get(), Position::Index(index)) {
                while array.next_element::<IgnoredAny>()?.is_some() {}
                return Ok(Err(fault));
            }
            index += 1;
        }
        Ok(Ok(()))
    }
}

/// The number of an event that is malformed elsewhere.
fn seq_of(text: &str) -> Option<u64> {
    #[derive(serde::Deserialize)]
    struct Numbered {
        seq: u64,
    }
    serde_json::from_str(text).ok().map(|Numbered { seq }| seq)
}
