//! How far a search looks before it begins anew and looks further.

use super::minimal::Minimal;
use crate::abduction::Simplicity;

/// One round of an iterative deepening (Korf 1985) by the number of paths.
///
/// Maps of more paths than a limit are passed over; if the simplest map is not found within it, the next round has a higher one. A
/// search without limit that comes upon no good map early looks at much that no proof needs. Only the first round
/// has no limit, and ends soon: it finds some map, if not the simplest one.
///
/// Law: what a round passes over is no simpler than `beyond`. So once that is none, or the simplest map found is simpler, the search
/// is at its end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Round {
    /// The most paths.
    paths: Option<usize>,
    /// The least bound of what was passed over.
    beyond: Option<Simplicity>,
    /// No map that is not found is simpler; known from rounds before.
    floor: Option<Simplicity>,
    /// How many paths more than the last round it allows.
    stride: usize,
    /// The steps before it, and those of the last round.
    begun: u64,
    last: u64,
}

/// A round that costs no more than so many times the last one is cheap: the next one may go further.
const CHEAP: u64 = 3;

impl Round {
    /// Whether maps of this bound are to be looked at, by themselves or by what was found; else notes what is passed over.
    pub(super) fn admits(&mut self, bound: Simplicity, found: &Minimal) -> bool {
        if !found.allows(bound) {
            return false;
        }
        let admitted = self.paths.is_none_or(|most| bound.paths <= most);
        if !admitted {
            self.beyond = self.beyond.into_iter().chain([bound]).min();
        }
        admitted
    }

    /// Whether it passes nothing over.
    pub(super) fn is_unlimited(&self) -> bool {
        self.paths.is_none()
    }

    /// No map that is not found is simpler; known from rounds before.
    pub(super) fn floor(&self) -> Option<Simplicity> {
        self.floor
    }

    /// How simple what is left is at best, if all that is on the agenda is no simpler than `open`.
    pub(super) fn least(&self, open: Option<Simplicity>) -> Option<Simplicity> {
        let ahead = open.into_iter().chain(self.beyond).min()?;
        Some(self.floor.map_or(ahead, |floor| ahead.max(floor)))
    }

    /// The round after this one has come to its end after so many steps in all; none if it left nothing.
    pub(super) fn next(&self, found: &Minimal, steps: u64) -> Option<Round> {
        let beyond = self.beyond.filter(|&beyond| found.allows(beyond))?;
        let took = steps - self.begun;
        let stride = if took <= CHEAP * self.last { 2 * self.stride } else { 1 };
        let least = self.paths.map_or(0, |paths| paths + stride);
        Some(Round {
            paths: Some(beyond.paths.max(least)),
            beyond: None,
            floor: Some(beyond),
            stride,
            begun: steps,
            last: took,
        })
    }

    /// The round after one without limit was broken off that had nothing left but maps above this bound.
    pub(super) fn after_dive(bound: Simplicity, steps: u64) -> Round {
        Round { paths: Some(bound.paths), floor: Some(bound), stride: 1, begun: steps, ..Round::default() }
    }
}
