//! What searches for room have learned of a candidate, for those on its next observations.
//!
//! A conflict is some conditions that take more chi-square beyond that of the loops than their gate. Conditions are about visits
//! and segments that all children share. One observation later there may be one loop more: the least chi-square
//! with which loops close and conditions hold falls by none. So what conditions take beyond the loops falls by no more than what
//! the loops take has grown; and a conflict stays one until by that, and by what its gate has grown, as much is lost as it was
//! beyond. Where a place is new no loop comes, and all stay.

use crate::metric::conflicts::Conflict;
use crate::metric::crowd::Crowd;
use crate::metric::floor::Apart;
use crate::metric::layout::Layout;
use crate::metric::loops::Loops;
use std::sync::Arc;

/// Conflicts are kept for the next observation as long as so many conditions bear at most.
const DEGREES: usize = 32;
/// At most so many conflicts are kept, those of the fewest ways: about a megabyte, of which a child shares what it did not learn.
const MOST: usize = 2_000;
/// By less a conflict is not known to be one: rounding.
const ROUNDING: f64 = 1e-6;

/// Conditions that cannot all hold, and why.
pub(super) type Lesson = Conflict<Apart, Arc<Crowd>>;

/// What is known of a candidate under one range of shares.
#[derive(Clone, Debug)]
pub(super) struct Lessons {
    floor: Scope,
    loops: Loops,
    /// How much of what conflicts were beyond their gates may be lost since the first of them. Each holds until that is more than it has.
    lost: f64,
    known: Vec<Arc<Lesson>>,
}

/// What conditions depend on, beside the visits that they are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scope {
    /// The first visit that all is seen from.
    pub(super) since: usize,
    /// How far apart places are, metres.
    pub(super) separation: f64,
}

impl Lessons {
    /// What of some lessons is known in a layout.
    pub(super) fn known(before: Option<&Lessons>, layout: &Layout, floor: Scope) -> Lessons {
        let loops = layout.loops_together();
        let Some(before) = before.filter(|before| before.floor == floor) else {
            return Lessons { floor, loops, lost: 0.0, known: Vec::new() };
        };
        let lost = before.lost + before.loops.lost_to(&loops, DEGREES);
        let holds = |lesson: &&Arc<Lesson>| lesson.holds > lost + ROUNDING;
        let known = before.known.iter().filter(holds).cloned().collect();
        Lessons { floor, loops, lost, known }
    }

    /// The conflicts.
    pub(super) fn conflicts(&self) -> &[Arc<Lesson>] {
        &self.known
    }

    /// How far a conflict holds that so many conditions are in, and which is so.
    pub(super) fn hold(&self, degrees: usize, crowd: &Crowd) -> f64 {
        if degrees > DEGREES { f64::NEG_INFINITY } else { self.lost + crowd.chi_square - crowd.gate }
    }

    /// These conflicts instead, as far as they are kept.
    pub(super) fn with(self, mut known: Vec<Arc<Lesson>>) -> Lessons {
        known.sort_by_key(|lesson| lesson.ways.len());
        known.truncate(MOST);
        Lessons { known, ..self }
    }

    /// Whether there are any.
    pub(super) fn is_empty(&self) -> bool {
        self.known.is_empty()
    }
}
