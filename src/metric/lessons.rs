//! What searches for room have learned of a candidate, for those on its next observations.
//!
//! A conflict is some conditions that take more chi-square beyond that of the loops than their gate. Conditions are about
//! visits and segments that all children share. One observation later there may be one loop more: the least chi-square
//! with which loops close and conditions hold falls by none. So what conditions take beyond the loops falls by no more
//! than what the loops take has grown; and a conflict stays one until by that, and by what its gate has grown, as much is
//! lost as it was beyond. Where a place is new no loop comes, and all stay.
//!
//! The gate is that of the conditions that bore when the conflict was learned. That others bear now changes nothing: by
//! themselves these still take more than it, and of them no more can bear.

use crate::abduction::Lore;
use crate::metric::conflicts::Conflict;
use crate::metric::crowd::{Crowd, InTheWay};
use crate::metric::floor::Apart;
use crate::metric::layout::Layout;
use crate::metric::loops::{Loops, Lost};
use crate::metric::share::SHARES;
use std::collections::HashSet;
use std::sync::Arc;

/// Conflicts are kept for the next observation as long as so many conditions bear at most.
const DEGREES: usize = 32;
/// At most so many conflicts are kept, those of the fewest ways. Of 300 and of 2,000 searches make as much, to 3 %.
const MOST: usize = 1_000;
/// By less a conflict is not known to be one: what descents leave of chi-square.
const LEFT: f64 = 0.01;

/// Conditions that cannot all hold, and why.
pub(super) type Lesson = Conflict<Apart, Arc<Reason>>;

/// What the conditions of a conflict take, by which reasons are ordered.
#[derive(Clone, Debug)]
pub(super) struct Reason {
    /// Chi-square, and what may be lost of it since the first of the lessons.
    takes: f64,
    /// As it was learned.
    crowd: Crowd,
}

impl PartialEq for Reason {
    fn eq(&self, other: &Reason) -> bool {
        self.takes == other.takes
    }
}

impl PartialOrd for Reason {
    fn partial_cmp(&self, other: &Reason) -> Option<std::cmp::Ordering> {
        self.takes.partial_cmp(&other.takes)
    }
}

/// What is known of a candidate under one range of shares.
#[derive(Clone, Debug)]
pub(super) struct Lessons {
    scope: Scope,
    loops: Loops,
    /// How much may be lost since the first of them. Each holds until that is more than it has.
    lost: Lost,
    conflicts: Vec<Arc<Lesson>>,
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
    pub(super) fn known(before: Option<&Lessons>, layout: &Layout, scope: Scope) -> Lessons {
        let loops = layout.loops_together();
        let Some(before) = before.filter(|before| before.scope == scope) else {
            return Lessons { scope, loops, lost: Lost::default(), conflicts: Vec::new() };
        };
        let since = before.loops.lost_to(&loops, DEGREES);
        let lost = Lost { takes: before.lost.takes + since.takes, beyond: before.lost.beyond + since.beyond };
        Lessons { scope, loops, lost, conflicts: Vec::new() }.with(before.conflicts.clone())
    }

    /// The conflicts.
    pub(super) fn conflicts(&self) -> &[Arc<Lesson>] {
        &self.conflicts
    }

    /// That what takes more than its gate does so in some ways, each of which is two bounds at most.
    pub(super) fn lesson(&self, ways: &[Apart], crowd: &Crowd) -> Lesson {
        let kept = 2 * ways.len() <= DEGREES;
        let holds = if kept { self.lost.beyond + crowd.chi_square - crowd.gate } else { f64::NEG_INFINITY };
        let takes = self.lost.takes + crowd.chi_square;
        Lesson { ways: ways.into(), holds, reason: Arc::new(Reason { takes, crowd: crowd.clone() }) }
    }

    /// What a conflict takes at least by all that it follows from.
    pub(super) fn crowd(&self, conflict: &Lesson) -> Crowd {
        let Reason { takes, crowd } = &*conflict.reason;
        Crowd { chi_square: takes - self.lost.takes, ..crowd.clone() }
    }

    /// These conflicts instead, as far as they hold and are kept.
    pub(super) fn with(self, mut conflicts: Vec<Arc<Lesson>>) -> Lessons {
        conflicts.retain(|lesson| lesson.holds > self.lost.beyond + LEFT);
        conflicts.sort_by_key(|lesson| lesson.ways.len());
        conflicts.truncate(MOST);
        Lessons { conflicts, ..self }
    }

    /// Whether there are any.
    pub(super) fn is_empty(&self) -> bool {
        self.conflicts.is_empty()
    }

    /// The bytes of all but those counted before.
    fn bytes(&self, counted: &mut HashSet<usize>) -> usize {
        let fresh = |lesson: &&Arc<Lesson>| counted.insert(Arc::as_ptr(lesson).addr());
        let bytes = |lesson: &Arc<Lesson>| {
            let clashing = size_of_val::<[InTheWay]>(&lesson.reason.crowd.clashing);
            size_of::<Lesson>() + size_of_val::<[Apart]>(&lesson.ways) + size_of::<Reason>() + clashing
        };
        let new: usize = self.conflicts.iter().filter(fresh).map(bytes).sum();
        size_of::<Lessons>() + size_of_val(self.conflicts.as_slice()) + new
    }
}

/// Lessons by [`SHARES`].
pub(super) type Taught = [Option<Arc<Lessons>>; SHARES.len()];

impl Lore for Taught {
    fn bytes(&self, counted: &mut HashSet<usize>) -> usize {
        let fresh: Vec<&Arc<Lessons>> =
            self.iter().flatten().filter(|lessons| counted.insert(Arc::as_ptr(lessons).addr())).collect();
        size_of::<Taught>() + fresh.into_iter().map(|lessons| lessons.bytes(counted)).sum::<usize>()
    }
}
