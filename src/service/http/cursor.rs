//! The opaque cursor of a page of candidates.

use crate::service::View;
use crate::service::problem::{Problem, ProblemKind};
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Where a page starts, and the candidates among which that meant something.
pub(super) struct Cursor {
    candidates: u64,
    start: usize,
}

impl Cursor {
    /// The cursor of a position among the candidates of a view.
    pub(super) fn at(view: &View, start: usize) -> Cursor {
        Cursor { candidates: generation(view), start }
    }

    /// Where the page of a cursor starts in a view.
    pub(super) fn start(text: &str, view: &View) -> Result<usize, Problem> {
        let invalid = "the cursor is not one this service gave; leave it out for the first page";
        let cursor = Cursor::parse(text).ok_or_else(|| Problem::new(ProblemKind::InvalidQuery, invalid))?;
        if cursor.candidates != generation(view) {
            let stale = "the candidates have changed since; begin again without cursor";
            return Err(Problem::new(ProblemKind::StaleCursor, stale));
        }
        Ok(cursor.start)
    }

    fn parse(text: &str) -> Option<Cursor> {
        let text = String::from_utf8(URL_SAFE_NO_PAD.decode(text).ok()?).ok()?;
        let (candidates, start) = text.split_once('.')?;
        Some(Cursor { candidates: candidates.parse().ok()?, start: start.parse().ok()? })
    }
}

/// A number for what the candidates of a view follow from: the observations, the operator's word, and how far a search
/// for the simplest ones has come. Other candidates have another.
fn generation(view: &View) -> u64 {
    let mut hasher = DefaultHasher::new();
    let searched = view.abduction.settlement().map(|settlement| settlement.steps);
    (view.abduction.observations(), view.abduction.word(), searched).hash(&mut hasher);
    hasher.finish()
}

impl fmt::Display for Cursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&URL_SAFE_NO_PAD.encode(format!("{}.{}", self.candidates, self.start)))
    }
}
