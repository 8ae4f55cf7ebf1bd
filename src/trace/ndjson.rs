//! Lines of NDJSON to events and back.

use crate::trace::event::Event;
use crate::trace::event_error::EventError;
use crate::trace::experience::Experience;
use crate::trace::experience_error::ExperienceError;
use crate::trace::wire::WireEvent;
use std::io::{self, BufRead, Read, Write};
use thiserror::Error;

/// The longest line that is read, bytes; a grid of the largest posted size as a list of numbers fits.
pub const MAX_LINE: u64 = 32 * 1024 * 1024;

/// Why a trace could not be read further. Everything before the line stands.
#[derive(Debug, Error)]
pub enum TraceError {
    /// A line that is not an event, or not one that may come here.
    #[error("line {line}: {error}")]
    Line {
        /// Line number, from 1.
        line: usize,
        /// What is wrong with it.
        error: EventError,
    },
    /// The input could not be read.
    #[error("line {line}: cannot be read: {source}")]
    Read {
        /// Line number, from 1.
        line: usize,
        /// The cause.
        source: io::Error,
    },
}

/// The event written in one JSON text.
pub fn parse_event(text: &str) -> Result<Event, EventError> {
    if !text.trim_start().starts_with('{') {
        return Err(EventError::new("", "is no JSON object, expected one event: {\"seq\":0,\"kind\":..."));
    }
    let mut json = serde_json::Deserializer::from_str(text);
    let wire: WireEvent = serde_path_to_error::deserialize(&mut json).map_err(|e| EventError::from(&e))?;
    json.end().map_err(|e| {
        EventError::new("", format!("more text after the event: {e}; expected one object a line"))
    })?;
    wire.into_event()
}

/// The event held by a JSON value.
pub fn event_from_value(value: serde_json::Value) -> Result<Event, EventError> {
    let wire: WireEvent = serde_path_to_error::deserialize(value).map_err(|e| EventError::from(&e))?;
    wire.into_event()
}

/// Reads a whole trace and checks that its grammar holds, without looking into grids.
///
/// Gives the events before the first fault, and the fault. Blank lines are skipped.
pub fn read_trace(input: impl BufRead) -> (Vec<Event>, Option<TraceError>) {
    let (events, fault) = read_lines(input);
    (events.into_iter().map(|(_, event)| event).collect(), fault)
}

/// The same with the number of each event's line, from 1.
pub fn read_lines(mut input: impl BufRead) -> (Vec<(usize, Event)>, Option<TraceError>) {
    let mut events = Vec::new();
    let mut grammar = Experience::new();
    for line in 1.. {
        match next_line(&mut input) {
            Err(source) => return (events, Some(TraceError::Read { line, source })),
            Ok(text) if text.is_empty() => break,
            Ok(text) => match next_event(&text, line, &mut grammar) {
                Ok(None) => {}
                Ok(Some(event)) => events.push((line, event)),
                Err(error) => return (events, Some(TraceError::Line { line, error })),
            },
        }
    }
    (events, None)
}

/// A line with its end, cut one byte beyond the longest that may be; empty at the end of the input.
fn next_line(input: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    input.take(MAX_LINE + 1).read_until(b'\n', &mut text)?;
    Ok(text)
}

/// One event as a line of NDJSON.
pub fn write_event(mut output: impl Write, event: &Event) -> io::Result<()> {
    serde_json::to_writer(&mut output, &WireEvent::from_event(event))?;
    output.write_all(b"\n")
}

/// A whole trace as NDJSON.
pub fn write_trace(mut output: impl Write, events: &[Event]) -> io::Result<()> {
    events.iter().try_for_each(|event| write_event(&mut output, event))
}

fn next_event(text: &[u8], line: usize, grammar: &mut Experience) -> Result<Option<Event>, EventError> {
    if text.len() as u64 > MAX_LINE {
        let longer = format!("is longer than {MAX_LINE} bytes, expected one event a line");
        return Err(EventError::new("", longer));
    }
    let text = std::str::from_utf8(text).map_err(|e| EventError::new("", format!("is not UTF-8: {e}")))?;
    // Some editors begin a file with a byte order mark.
    let text = if line == 1 { text.trim_start_matches('\u{feff}') } else { text };
    if text.trim().is_empty() {
        return Ok(None);
    }
    let event = parse_event(text)?;
    grammar.check(&event).map_err(|e: ExperienceError| e.at())?;
    Ok(Some(event))
}

impl From<&serde_path_to_error::Error<serde_json::Error>> for EventError {
    fn from(error: &serde_path_to_error::Error<serde_json::Error>) -> EventError {
        use serde_path_to_error::Segment;
        let pointer = error.path().iter().fold(String::new(), |mut pointer, segment| {
            match segment {
                Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
                Segment::Map { key } => {
                    pointer.push_str(&format!("/{}", key.replace('~', "~0").replace('/', "~1")))
                }
                Segment::Enum { variant } => pointer.push_str(&format!("/{variant}")),
                Segment::Unknown => {}
            }
            pointer
        });
        EventError::new(pointer, error.inner().to_string())
    }
}
