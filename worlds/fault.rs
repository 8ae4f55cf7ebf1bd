//! What is wrong with a world file, and where.

/// A fault before the file is named.
pub(super) struct Fault {
    /// The field at fault.
    pub(super) field: String,
    /// What was found and what was expected.
    pub(super) message: String,
}

/// Refuses a field.
pub(super) fn fault<T>(field: impl Into<String>, message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { field: field.into(), message: message.into() })
}
