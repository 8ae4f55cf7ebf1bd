//! The words of a CARMEN line, taken from left to right.

use crate::geometry::Pose;
use crate::sensor::log::{LARGEST, MAX_BEAMS};

/// The words of one message behind its name.
#[derive(Debug)]
pub(super) struct Fields<'a> {
    kind: &'a str,
    words: Vec<&'a str>,
    taken: usize,
}

impl<'a> Fields<'a> {
    pub(super) fn new(kind: &'a str, words: impl Iterator<Item = &'a str>) -> Self {
        Fields { kind, words: words.collect(), taken: 0 }
    }

    /// The words not yet taken.
    pub(super) fn rest(&self) -> &[&'a str] {
        self.words.get(self.taken..).unwrap_or_default()
    }

    /// How many of the words not yet taken are numbers, up to the first that is none.
    pub(super) fn numbers_ahead(&self) -> usize {
        self.rest().iter().take_while(|word| word.parse::<f64>().is_ok()).count()
    }

    pub(super) fn word(&mut self, what: &str) -> Result<&'a str, String> {
        let word = self.rest().first().copied();
        self.taken += 1;
        word.ok_or_else(|| format!("{} ends before {what}", self.kind))
    }

    /// A finite number of a size that a robot can have.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, String> {
        let word = self.word(what)?;
        match word.parse::<f64>() {
            Ok(value) if value.abs() < LARGEST => Ok(value),
            _ => Err(format!("{} has `{word}` as {what}, expected a finite number", self.kind)),
        }
    }

    pub(super) fn pose(&mut self, what: &str) -> Result<Pose, String> {
        Ok(Pose::new(self.number(what)?, self.number(what)?, self.number(what)?))
    }

    /// The number of readings that follow.
    pub(super) fn count(&mut self) -> Result<usize, String> {
        let word = self.word("the number of readings")?;
        match word.parse::<usize>() {
            Ok(count) if count <= MAX_BEAMS => Ok(count),
            _ => Err(format!(
                "{} announces `{word}` readings, expected a whole number up to {MAX_BEAMS}",
                self.kind
            )),
        }
    }

    /// So many readings; `nan` and `inf`, which some converters write for no return, are taken as they are.
    pub(super) fn readings(&mut self, count: usize) -> Result<Vec<f64>, String> {
        let found = self.rest().len();
        if found < count {
            return Err(format!("{} announces {count} readings and has {found} words after that", self.kind));
        }
        let reading = |word: &&str| {
            word.parse::<f64>()
                .map_err(|_| format!("{} has `{word}` as a reading, expected metres", self.kind))
        };
        let readings = self.rest()[..count].iter().map(reading).collect();
        self.taken += count;
        readings
    }

    pub(super) fn skip(&mut self, words: usize) {
        self.taken += words;
    }

    /// The stamp that follows, if one does: `ipc_timestamp` before `ipc_hostname logger_timestamp`.
    pub(super) fn stamp(&self) -> Option<f64> {
        self.rest().first()?.parse().ok().filter(|stamp: &f64| stamp.abs() < LARGEST)
    }

    /// Whether a stamp follows that was not cut off itself: there is a word behind it.
    pub(super) fn is_complete(&self) -> bool {
        self.stamp().is_some() && self.rest().len() > 1
    }
}
