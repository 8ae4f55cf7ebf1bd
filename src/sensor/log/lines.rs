//! Lines of bounded length, and where they end too early.

use crate::sensor::log::LogError;
use std::borrow::Cow;
use std::io::{self, BufRead, Read};
use thiserror::Error;

/// The longest line that is read, bytes; a scan of the most beams fits.
const MAX_LINE: u64 = 4 * 1024 * 1024;

/// What a reader says that decompresses, once it has read all, of bytes behind that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the compressed stream has come to its end, and other bytes follow, expected none")]
pub struct TrailingBytes;

impl TrailingBytes {
    /// Whether this is what an error says.
    pub fn is(error: &io::Error) -> bool {
        error.get_ref().is_some_and(|cause| cause.is::<TrailingBytes>())
    }
}

/// Reads a text line by line into one buffer.
#[derive(Debug)]
pub(super) struct Lines<R> {
    input: R,
    buffer: Vec<u8>,
    /// The line last read, from 1.
    pub(super) number: u64,
    /// Whether the input broke off inside a compressed stream.
    pub(super) broken_off: bool,
    /// Whether other bytes follow the compressed stream.
    pub(super) trailing_bytes: bool,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Lines { input, buffer: Vec::new(), number: 0, broken_off: false, trailing_bytes: false }
    }

    /// Goes to the next line; false at the end of the input.
    pub(super) fn advance(&mut self) -> Result<bool, LogError> {
        self.buffer.clear();
        if self.broken_off || self.trailing_bytes {
            return Ok(false);
        }
        self.number += 1;
        let line = self.number;
        match self.input.by_ref().take(MAX_LINE + 1).read_until(b'\n', &mut self.buffer) {
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => self.broken_off = true,
            Err(error) if TrailingBytes::is(&error) => self.trailing_bytes = true,
            Err(source) => return Err(LogError::Read { line, source }),
        }
        if self.buffer.len() as u64 > MAX_LINE {
            let message = format!("is longer than {MAX_LINE} bytes, expected one message a line");
            return Err(LogError::Line { line, message });
        }
        Ok(!self.buffer.is_empty())
    }

    /// The current line, its bytes that are no UTF-8 replaced, without a byte order mark. Fails on what shows that this is
    /// no text, or text in another encoding: the mark of UTF-16, or a NUL byte.
    pub(super) fn text(&self) -> Result<Cow<'_, str>, String> {
        let first = self.number == 1;
        let utf_16 =
            first && [&b"\xff\xfe"[..], b"\xfe\xff"].iter().any(|mark| self.buffer.starts_with(mark));
        if utf_16 || self.buffer.contains(&0) {
            let found = if utf_16 { "begins with the mark of UTF-16" } else { "has a NUL byte" };
            return Err(format!(
                "{found}, expected UTF-8 text; `iconv -f UTF-16 -t UTF-8` makes that of UTF-16 text"
            ));
        }
        let mark = if first { &b"\xef\xbb\xbf"[..] } else { b"" };
        Ok(String::from_utf8_lossy(self.buffer.strip_prefix(mark).unwrap_or(&self.buffer)))
    }

    /// Whether the current line has no line end.
    pub(super) fn cut_off(&self) -> bool {
        self.buffer.last() != Some(&b'\n')
    }
}
