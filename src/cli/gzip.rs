//! Compressed streams one after the other, and what stands behind them.

use crate::sensor::log::TrailingBytes;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};

/// What every member of a gzip file begins with.
const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads all members of a gzip file as one stream. Bytes behind a whole member that do not begin another one, as tapes and
/// some copies leave them, are told of by [`TrailingBytes`] once all before them was read.
pub(super) struct GzipMembers<R> {
    /// `None` once the last member has ended.
    member: Option<GzDecoder<R>>,
}

impl<R: BufRead> GzipMembers<R> {
    pub(super) fn new(input: R) -> Self {
        GzipMembers { member: Some(GzDecoder::new(input)) }
    }
}

impl<R: BufRead> Read for GzipMembers<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let count = member.read(into)?;
            if count > 0 || into.is_empty() {
                return Ok(count);
            }
            let Some(mut rest) = self.member.take().map(GzDecoder::into_inner) else { break };
            // The reader is in nobody's hands now: whoever tries again would find the end.
            let ahead = loop {
                match rest.fill_buf() {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    _ => break rest.fill_buf()?,
                }
            };
            if ahead.is_empty() {
                break;
            } else if ahead.iter().zip(MAGIC).any(|(found, expected)| *found != expected) {
                return Err(io::Error::other(TrailingBytes));
            }
            self.member = Some(GzDecoder::new(rest));
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn member(text: &str) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap()
    }

    /// What is read, and how it ends; the input comes in pieces of so many bytes.
    fn read(file: &[u8], piece: usize) -> (String, io::Result<()>) {
        let mut text = Vec::new();
        let mut input = GzipMembers::new(io::BufReader::with_capacity(piece, file));
        let end = input.read_to_end(&mut text).map(|_| ());
        (String::from_utf8(text).unwrap(), end)
    }

    #[test]
    fn members_are_read_one_after_the_other() {
        let file = [member("one "), member(""), member("two")].concat();
        for piece in [1, 7, 4096] {
            let (text, end) = read(&file, piece);
            assert!(text == "one two" && end.is_ok(), "{text} {end:?}");
        }
    }

    #[test]
    fn what_is_behind_the_last_member_is_told_from_an_early_end() {
        let whole = [member("one "), member("two")].concat();
        for trail in [&b"\0"[..], b"\0\0\0\0\0\0\0\0", b"garbage of more than ten bytes", b"\x1f\0"] {
            let (text, end) = read(&[&whole, trail].concat(), 4096);
            assert_eq!(text, "one two");
            assert!(TrailingBytes::is(&end.unwrap_err()), "{trail:?}");
        }
        for cut in 1..member("two").len() {
            let (text, end) = read(&whole[..whole.len() - cut], 4096);
            assert!(
                text.starts_with("one ") && end.unwrap_err().kind() == io::ErrorKind::UnexpectedEof,
                "{cut}"
            );
        }
    }
}
