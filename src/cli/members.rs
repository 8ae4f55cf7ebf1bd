//! Compressed streams one after the other, and what stands behind them.

use crate::sensor::log::TrailingBytes;
use bzip2::bufread::BzDecoder;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};
use std::marker::PhantomData;

/// One compressed stream of a file that may hold several.
pub(super) trait Member<R>: Read {
    /// Whether one may begin with these bytes, of which there may be too few to say.
    fn begins(ahead: &[u8]) -> bool;

    /// The stream that begins where the input is.
    fn begin(input: R) -> Self;

    /// The input, behind the stream if that has ended.
    fn rest(self) -> R;
}

/// Reads all members of a file as one stream. Bytes behind a whole member that do not begin another one, as tapes and
/// some copies leave them, are told of by [`TrailingBytes`] once all before them was read.
pub(super) struct Members<M, R> {
    /// `None` once the last member has ended.
    member: Option<M>,
    input: PhantomData<R>,
}

/// The members of a gzip file (RFC 1952).
pub(super) type GzipMembers<R> = Members<GzDecoder<R>, R>;
/// The members of a bzip2 file.
pub(super) type BzipMembers<R> = Members<BzDecoder<R>, R>;

impl<R: BufRead> Member<R> for GzDecoder<R> {
    fn begins(ahead: &[u8]) -> bool {
        ahead.iter().zip([0x1f, 0x8b]).all(|(&found, expected)| found == expected)
    }

    fn begin(input: R) -> Self {
        GzDecoder::new(input)
    }

    fn rest(self) -> R {
        self.into_inner()
    }
}

impl<R: BufRead> Member<R> for BzDecoder<R> {
    fn begins(ahead: &[u8]) -> bool {
        let level = ahead.get(3).is_none_or(|level| (b'1'..=b'9').contains(level));
        level && ahead.iter().zip(b"BZh").all(|(found, expected)| found == expected)
    }

    fn begin(input: R) -> Self {
        BzDecoder::new(input)
    }

    fn rest(self) -> R {
        self.into_inner()
    }
}

impl<M: Member<R>, R: BufRead> Members<M, R> {
    pub(super) fn new(input: R) -> Self {
        Members { member: Some(M::begin(input)), input: PhantomData }
    }
}

impl<M: Member<R>, R: BufRead> Read for Members<M, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let count = member.read(into)?;
            if count > 0 || into.is_empty() {
                return Ok(count);
            }
            let Some(mut rest) = self.member.take().map(M::rest) else { break };
            // The reader is in nobody's hands now: whoever tries again would find the end.
            let ahead = loop {
                match rest.fill_buf() {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    _ => break rest.fill_buf()?,
                }
            };
            if ahead.is_empty() {
                break;
            } else if !M::begins(ahead) {
                return Err(io::Error::other(TrailingBytes));
            }
            self.member = Some(M::begin(rest));
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bzip2::write::BzEncoder;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn gzip(text: &str) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap()
    }

    fn bzip(text: &str) -> Vec<u8> {
        let mut encoder = BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap()
    }

    /// What is read, and how it ends; the input comes in pieces of so many bytes.
    fn read<'a, M: Member<io::BufReader<&'a [u8]>>>(
        file: &'a [u8],
        piece: usize,
    ) -> (String, io::Result<()>) {
        let mut text = Vec::new();
        let mut input = Members::<M, _>::new(io::BufReader::with_capacity(piece, file));
        let end = input.read_to_end(&mut text).map(|_| ());
        (String::from_utf8(text).unwrap(), end)
    }

    type Gz<'a> = GzDecoder<io::BufReader<&'a [u8]>>;
    type Bz<'a> = BzDecoder<io::BufReader<&'a [u8]>>;

    #[test]
    fn members_are_read_one_after_the_other() {
        let [gzipped, bzipped] =
            [gzip, bzip].map(|member| [member("one "), member(""), member("two")].concat());
        for piece in [1, 7, 4096] {
            for (text, end) in [read::<Gz<'_>>(&gzipped, piece), read::<Bz<'_>>(&bzipped, piece)] {
                assert!(text == "one two" && end.is_ok(), "{text} {end:?}");
            }
        }
    }

    #[test]
    fn what_is_behind_the_last_member_is_told_from_an_early_end() {
        let [gzipped, bzipped] = [gzip, bzip].map(|member| [member("one "), member("two")].concat());
        for trail in [
            &b"\0"[..],
            b"\0\0\0\0\0\0\0\0",
            b"garbage of more than ten bytes",
            b"\x1f\0",
            b"BZ\0",
            b"BZhjunk",
        ] {
            let [gzipped, bzipped] = [&gzipped, &bzipped].map(|whole| [whole, trail].concat());
            for (text, end) in [read::<Gz<'_>>(&gzipped, 4096), read::<Bz<'_>>(&bzipped, 4096)] {
                assert_eq!(text, "one two");
                assert!(TrailingBytes::is(&end.unwrap_err()), "{trail:?}");
            }
        }
        let early = |(text, end): (String, io::Result<()>)| {
            text.starts_with("one ") && end.unwrap_err().kind() == io::ErrorKind::UnexpectedEof
        };
        for cut in 1..gzip("two").len() {
            assert!(early(read::<Gz<'_>>(&gzipped[..gzipped.len() - cut], 4096)), "{cut}");
        }
        for cut in 1..bzip("two").len() {
            assert!(early(read::<Bz<'_>>(&bzipped[..bzipped.len() - cut], 4096)), "{cut}");
        }
    }
}
