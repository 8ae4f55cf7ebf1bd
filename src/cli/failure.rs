//! How a verb ends when it does not end well.

use std::fmt::Display;
use std::io;
use std::path::Path;
use std::process::ExitCode;

/// The end of a verb: a message for people and the exit code of its kind.
#[derive(Debug)]
pub(super) enum Failure {
    /// Something that should work did not.
    Broken(String),
    /// The options do not go together.
    Usage(String),
    /// The input is malformed.
    Input(String),
    /// The axioms allow no map.
    NoMap(String),
    /// A limit cut the search; what was found has been printed.
    Limit(String),
    /// The reader of standard output has gone: nobody to tell.
    ClosedPipe,
}

impl Failure {
    /// An error in reading a file's content.
    pub(super) fn input(file: &Path, error: impl Display) -> Failure {
        Failure::Input(format!("{}: {error}", file.display()))
    }

    /// An error in writing a file.
    pub(super) fn writing(file: &Path, error: impl Display) -> Failure {
        Failure::Broken(format!("{}: cannot be written: {error}", file.display()))
    }

    /// Tells people and gives the code.
    pub(super) fn report(self) -> ExitCode {
        let (message, code) = match self {
            Failure::Broken(message) => (message, 1),
            Failure::Usage(message) => (message, 2),
            Failure::Input(message) => (message, 3),
            Failure::NoMap(message) => (message, 4),
            Failure::Limit(message) => (message, 5),
            Failure::ClosedPipe => return ExitCode::SUCCESS,
        };
        eprintln!("topostar: {message}");
        ExitCode::from(code)
    }
}

impl From<io::Error> for Failure {
    /// An error in writing to standard output.
    fn from(error: io::Error) -> Failure {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::ClosedPipe,
            _ => Failure::Broken(error.to_string()),
        }
    }
}
