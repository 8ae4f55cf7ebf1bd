//! The messages of a bag, file after file, in the order of recording.

use crate::sensor::log::LogError;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use mcap::{McapError, Message};
use std::error::Error;
use std::io::{self, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The largest record that is read, bytes: an image may be in it, not a whole bag.
const MAX_RECORD: usize = 256 * 1024 * 1024;

/// Messages of all files. A file that breaks off, as after a crash, gives what had been written, and the next one
/// follows.
pub(super) struct Messages<I, R> {
    files: I,
    file: Option<MessageReader<R>>,
    pub(super) broken_off: bool,
}

impl<I: Iterator<Item = io::Result<R>>, R: Read> Messages<I, R> {
    pub(super) fn new(files: I) -> Self {
        Messages { files, file: None, broken_off: false }
    }
}

impl<I: Iterator<Item = io::Result<R>>, R: Read> Iterator for Messages<I, R> {
    type Item = Result<Message<'static>, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.file.as_mut().and_then(|file| guarded(|| file.next())) {
                Some(Ok(message)) => return Some(Ok(message)),
                Some(Err(McapError::UnexpectedEof)) => self.broken_off = true,
                Some(Err(McapError::Io(error))) if error.kind() == io::ErrorKind::UnexpectedEof => {
                    self.broken_off = true;
                }
                Some(Err(error)) => {
                    self.file = None;
                    return Some(Err(LogError::Bag(described(&error))));
                }
                None => {}
            }
            let options = LinearReaderOptions::default().with_record_length_limit(MAX_RECORD);
            match self.files.next()? {
                Ok(file) => self.file = Some(MessageReader::new_with_options(file, options)),
                Err(error) => return Some(Err(LogError::Bag(format!("cannot be opened: {error}")))),
            }
        }
    }
}

type Item = mcap::McapResult<Message<'static>>;

/// The next message of a file. The crate (0.26) subtracts the length of a record from that of its uncompressed chunk
/// unchecked, which panics on a damaged file where overflow is checked; its reader is not used after that.
fn guarded(next: impl FnOnce() -> Option<Item>) -> Option<Item> {
    catch_unwind(AssertUnwindSafe(next)).unwrap_or(Some(Err(McapError::UnexpectedEoc)))
}

fn described(error: &McapError) -> String {
    match error {
        McapError::BadMagic => "is no MCAP file, expected one as `ros2 bag record -s mcap` writes it".into(),
        error => {
            let cause = error.source().map(|cause| format!(": {cause}")).unwrap_or_default();
            format!("is damaged: {error}{cause}")
        }
    }
}
