//! What is wrong with one event, and where in it.

use thiserror::Error;

/// What is wrong with one event.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}{message}", if pointer.is_empty() { String::new() } else { format!("{pointer} ") })]
pub struct EventError {
    /// JSON pointer to the value at fault; empty for the whole object.
    pub pointer: String,
    /// What was found, what was expected, how to mend it.
    pub message: String,
}

impl EventError {
    /// An error at a JSON pointer.
    pub fn new(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        EventError { pointer: pointer.into(), message: message.into() }
    }
}
