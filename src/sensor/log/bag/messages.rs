//! The messages of a bag, file after file, in the order of recording.

use crate::sensor::log::LogError;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use mcap::{MAGIC, McapError, Message};
use std::error::Error;
use std::io::{self, Chain, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The largest record that is read, bytes: an image may be in it, not a whole bag.
const MAX_RECORD: usize = 256 * 1024 * 1024;

/// Messages of all files. A file that breaks off, as after a crash, gives what had been written, and the next one
/// follows.
pub(super) struct Messages<I, R> {
    files: I,
    file: Option<File<R>>,
    /// Whether a file was opened.
    begun: bool,
    pub(super) broken_off: bool,
}

/// A file whose first bytes have been looked at.
type File<R> = MessageReader<Chain<&'static [u8], R>>;

impl<I: Iterator<Item = io::Result<R>>, R: Read> Messages<I, R> {
    pub(super) fn new(files: I) -> Self {
        Messages { files, file: None, begun: false, broken_off: false }
    }

    /// Goes to the next file, `None` if there is none. A file shorter than the magic bytes that every MCAP file begins
    /// with is none, except that a recorder may have just begun the last file of a bag when it crashed.
    fn open_next(&mut self) -> Option<Result<(), LogError>> {
        self.file = None;
        let mut file = match self.files.next()? {
            Ok(file) => file,
            Err(error) => return Some(Err(LogError::Bag(format!("cannot be opened: {error}")))),
        };
        let after_another = std::mem::replace(&mut self.begun, true);
        let mut head = Vec::new();
        Some(match file.by_ref().take(MAGIC.len() as u64).read_to_end(&mut head) {
            Err(error) => Err(LogError::Bag(described(&McapError::Io(error)))),
            Ok(_) if head == MAGIC => {
                let options = LinearReaderOptions::default().with_record_length_limit(MAX_RECORD);
                self.file = Some(MessageReader::new_with_options(MAGIC.chain(file), options));
                Ok(())
            }
            Ok(_) if after_another && MAGIC.starts_with(&head) => {
                self.broken_off = true;
                Ok(())
            }
            Ok(_) => Err(LogError::Bag(described(&McapError::BadMagic))),
        })
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
            if let Err(error) = self.open_next()? {
                return Some(Err(error));
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
