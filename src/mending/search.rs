//! The least doubtful changes with which some map explains a walk.

use crate::abduction::{Abduction, Assertion, AxiomSet, Limits, Visit};
use crate::mending::taking::{Onward, Taken, Takings};
use crate::mending::{Change, Reading, Sum};
use crate::metric::Measurements;
use crate::trace::Sighting;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;

/// What a search for changes may use.
///
/// Work is counted as what an observation costs that is added to a beginning of the walk: the candidates before and after
/// it, times the visits; times their square where travels were measured, as what judges a candidate by measurements looks
/// at all visits from each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The most work from all observations together, unless four times that of the walk as it was read is more.
    pub max_work: u64,
    /// The most candidates kept of each beginning, the simplest ones.
    pub max_candidates: usize,
}

impl Default for Bounds {
    fn default() -> Self {
        Bounds { max_work: 10_000_000, max_candidates: 100 }
    }
}

/// A walk, or a stretch of one, with readings changed so that some map explains it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mended {
    /// The first observation of it.
    pub first: usize,
    /// How many observations, from that one on, some map explains.
    pub explained: usize,
    /// The visits of that walk.
    pub told: Vec<Told>,
    /// What is taken otherwise than it was read, by observation.
    pub changes: Vec<Change>,
    /// What the changes cost.
    pub sum: Sum,
    /// Whether no other changes that are looked for cost less, or lead further: none was left out for want of work or
    /// candidates.
    pub proven: bool,
}

/// A visit as it is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// The observation; `None` at a place that the robot passed unseen.
    pub observation: Option<usize>,
    /// What it tells.
    pub sighting: Sighting,
}

/// Looks for the changes of least doubt with which some map explains all readings, as the axioms have it; where there are
/// none, or the bounds end the search, for those that lead furthest, the least doubtful of them.
///
/// Each visit is taken as it was read; or it is likened to another one that is taken as it was read, and the two are then
/// one place; or it is taken for none, where without doubtful gateways the robot was on its way along a path. And on the way
/// to it the robot may have passed the place of another visit unseen. Beginnings of the walk are extended by a visit at a
/// time, the least doubtful first (uniform-cost search). When a visit is added, one before may be likened to it, or its
/// place put on the way to one before: so whatever makes two visits one place is judged at once, by all axioms. What is not
/// looked for is what a later visit would have to teach for the walk to come that far, nor two changes for one visit more.
/// Law: with nothing to change it costs one beginning a visit, and the same readings always give the same changes.
///
/// Costs, beside what the bounds allow the search, one comparison of two stars for each pair of visits among those reached.
/// Memory is that of the beginnings which ways of going on wait for, each linear in its visits and candidates: up to 1.7 GB where
/// there are many ways and few candidates.
pub fn mend(readings: &[Reading], axioms: AxiomSet, bounds: Bounds) -> Mended {
    mend_within(readings, axioms, bounds, &mut Work::new(bounds))
}

fn mend_within(readings: &[Reading], axioms: AxiomSet, bounds: Bounds, work: &mut Work) -> Mended {
    let (takings, agenda) = (Takings::new(readings), BTreeMap::new());
    let mut search = Search { takings, agenda, offered: 0, work, whole: true };
    let mut best = Rc::new(Beginning::new(axioms, bounds));
    search.offer(&best);
    while best.taken.len() < readings.len()
        && let Some(due) = search.next()
    {
        let Some(found) = search.extended(due) else { continue };
        search.offer(&found);
        if found.taken.len() > best.taken.len() {
            best = found;
        }
    }
    let taken = &best.taken;
    Mended {
        first: 0,
        explained: taken.len(),
        told: search.takings.told(taken),
        changes: search.takings.changes(taken),
        sum: search.takings.sum(taken),
        proven: search.whole,
    }
}

/// The longest stretch of a walk that changes as [`mend`] finds them lead some map to explain: from the first observation
/// on, or where these come to an end, from the later one that leads furthest, the first of such.
pub fn mend_longest(readings: &[Reading], axioms: AxiomSet, bounds: Bounds) -> Mended {
    let mut work = Work::new(bounds);
    let mut longest = mend_within(readings, axioms, bounds, &mut work);
    let mut proven = longest.proven;
    for first in 1..readings.len() {
        if readings.len() - first <= longest.explained {
            break;
        }
        if !work.is_left() {
            proven = false;
            break;
        }
        let mut part = readings[first..].to_vec();
        // Nothing is known of how the robot came there.
        (part[0].sighting.departure, part[0].sighting.motion) = (None, None);
        let found = mend_within(&part, axioms, bounds, &mut work);
        proven &= found.proven;
        if found.explained > longest.explained {
            longest = found.later_by(first);
        }
    }
    Mended { proven, ..longest }
}

impl Mended {
    /// The same with observations counted from so many before.
    fn later_by(mut self, first: usize) -> Mended {
        self.first += first;
        for told in &mut self.told {
            told.observation = told.observation.map(|observation| observation + first);
        }
        for change in &mut self.changes {
            change.observation += first;
            change.like = change.like.map(|like| like + first);
        }
        self
    }
}

/// A beginning of the walk that some map explains.
#[derive(Clone, Debug)]
struct Beginning {
    /// Without its last visit.
    before: Option<Rc<Beginning>>,
    taken: Vec<Taken>,
    abduction: Abduction,
    measured: Measurements,
    /// The work on it from the first visit on.
    work: u64,
}

impl Beginning {
    fn new(axioms: AxiomSet, bounds: Bounds) -> Beginning {
        let limits = Limits { max_candidates: Some(bounds.max_candidates), ..Limits::default() };
        let (abduction, measured) = (Abduction::new(axioms, limits), Measurements::default());
        Beginning { before: None, taken: Vec::new(), abduction, measured, work: 0 }
    }

    /// With one visit more, which may be that no candidate explains.
    fn observe(&mut self, sighting: &Sighting) -> Option<()> {
        self.measured = self.measured.with(sighting);
        self.abduction.observe_measured(&Visit::from(sighting), self.measured.evidence()).ok()
    }

    /// Keeps the candidates that have two visits in one place.
    fn identify(&mut self, visits: [usize; 2]) -> Option<()> {
        let id = self.abduction.word().assertions().len() as u64;
        self.abduction.assert(Assertion { id, visits, same: true }).ok()
    }
}

/// The work that was done, and how much may be: see [`Bounds`].
struct Work {
    done: u64,
    /// Of the stretch that cost most as it was read.
    as_read: u64,
    most: u64,
}

/// So many times the work on the walk as it was read may be done at least.
const TIMES_AS_READ: u64 = 4;

impl Work {
    fn new(bounds: Bounds) -> Work {
        Work { done: 0, as_read: 0, most: bounds.max_work }
    }

    fn is_left(&self) -> bool {
        self.done <= self.most.max(TIMES_AS_READ.saturating_mul(self.as_read))
    }

    /// Counts an observation, after which there are so many visits, and candidates before and after it.
    fn count(&mut self, visits: usize, candidates: usize, measured: bool) -> u64 {
        let work = (visits as u64).pow(if measured { 2 } else { 1 }) * (candidates as u64).max(1);
        self.done += work;
        work
    }
}

/// At most so many ways of going on wait, the most doubtful given up first.
const MOST_DUE: usize = 20_000;

/// What comes first: the least sum, then the longest, then what was offered first.
type Key = (Sum, Reverse<usize>, usize);

/// A beginning to be made: a known one, and a way of going on from it.
struct Due {
    from: Rc<Beginning>,
    on: Onward,
}

struct Search<'a> {
    takings: Takings<'a>,
    agenda: BTreeMap<Key, Due>,
    offered: usize,
    work: &'a mut Work,
    /// Whether no limit has left anything out.
    whole: bool,
}

impl Search<'_> {
    /// What is due next, unless there is nothing, or no work is left.
    fn next(&mut self) -> Option<Due> {
        let (_, due) = self.agenda.pop_first()?;
        let left = self.work.is_left();
        self.whole &= left;
        left.then_some(due)
    }

    /// Puts all ways of going on by a visit on the agenda.
    fn offer(&mut self, from: &Rc<Beginning>) {
        for on in self.takings.next(&from.taken) {
            self.offered += 1;
            let taken = on.taken(&from.taken);
            let key = (self.takings.sum(&taken), Reverse(taken.len()), self.offered);
            self.agenda.insert(key, Due { from: Rc::clone(from), on });
            if self.agenda.len() > MOST_DUE {
                self.whole = false;
                self.agenda.pop_last();
            }
        }
    }

    /// The beginning, if some map explains it.
    fn extended(&mut self, Due { from, on }: Due) -> Option<Rc<Beginning>> {
        let taken = on.taken(&from.taken);
        let mut found = from;
        while found.taken.len() > on.visit {
            found = Rc::clone(found.before.as_ref()?);
        }
        for &taken in &taken[on.visit..] {
            found = Rc::new(self.with(&found, taken)?);
        }
        Some(found)
    }

    /// A beginning with one visit more, if some map explains it.
    fn with(&mut self, from: &Rc<Beginning>, taken: Taken) -> Option<Beginning> {
        let mut found = Beginning { before: Some(Rc::clone(from)), ..(**from).clone() };
        let visit = found.taken.len();
        found.taken.push(taken);
        for told in self.takings.told_at(&found.taken, visit) {
            found.observe(&told.sighting)?;
        }
        let candidates = from.abduction.len() + found.abduction.len();
        let measured = found.abduction.evidence().is_some();
        found.work += self.work.count(visit + 1, candidates, measured);
        if found.taken.iter().all(|taken| taken.is_as_read()) {
            self.work.as_read = self.work.as_read.max(found.work);
        }
        for visits in self.takings.one_place(&found.taken, visit) {
            found.identify(visits)?;
        }
        self.whole &= found.abduction.is_complete();
        (visit == 0 || !found.abduction.is_empty()).then_some(found)
    }
}
