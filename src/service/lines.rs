//! Cuts a stream of bytes into lines of bounded length.

/// A line of NDJSON and its number, from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Its number.
    pub number: u64,
    /// Its bytes. One more than the bound says that the line is too long and was cut there.
    pub text: Vec<u8>,
}

/// The cutter: holds at most one unfinished line.
#[derive(Debug)]
pub struct Lines {
    bound: usize,
    number: u64,
    unfinished: Vec<u8>,
}

impl Lines {
    /// Before the first byte.
    pub fn new(bound: usize) -> Self {
        Lines { bound, number: 1, unfinished: Vec::new() }
    }

    /// Takes further bytes and gives the lines they end.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut ended = Vec::new();
        for piece in bytes.split_inclusive(|&byte| byte == b'\n') {
            let room = self.bound + 1 - self.unfinished.len();
            self.unfinished.extend_from_slice(&piece[..piece.len().min(room)]);
            if piece.ends_with(b"\n") || self.unfinished.len() > self.bound {
                ended.extend(self.take());
            }
        }
        ended
    }

    /// The line that the end of the stream ends, if there is one.
    pub fn finish(mut self) -> Option<Line> {
        self.take()
    }

    fn take(&mut self) -> Option<Line> {
        let text = std::mem::take(&mut self.unfinished);
        let number = self.number;
        self.number += 1;
        (!text.is_empty()).then_some(Line { number, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(lines: &[Line]) -> Vec<(u64, &str)> {
        lines.iter().map(|line| (line.number, std::str::from_utf8(&line.text).unwrap())).collect()
    }

    #[test]
    fn lines_are_the_same_however_the_bytes_arrive() {
        let whole = b"one\n\ntwo\nthree";
        for size in 1..=whole.len() {
            let mut lines = Lines::new(8);
            let mut ended: Vec<Line> = whole.chunks(size).flat_map(|chunk| lines.push(chunk)).collect();
            ended.extend(lines.finish());
            assert_eq!(texts(&ended), [(1, "one\n"), (2, "\n"), (3, "two\n"), (4, "three")]);
        }
    }

    #[test]
    fn a_line_too_long_is_cut_one_byte_beyond_the_bound() {
        let mut lines = Lines::new(3);
        assert_eq!(texts(&lines.push(b"abc")), []);
        assert_eq!(texts(&lines.push(b"defghi")), [(1, "abcd")]);
    }
}
