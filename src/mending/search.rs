//! The least doubtful changes with which some map explains a walk.

use crate::abduction::{Abduction, Assertion, AxiomSet, Limits, Visit};
use crate::mending::taking::{Taken, Takings};
use crate::mending::{Change, Reading, Sum};
use crate::metric::Measurements;
use crate::trace::Sighting;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;

/// What a search for changes may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The most beginnings of the walk that are looked at, from all observations together.
    pub max_steps: usize,
    /// The most candidates kept of each.
    pub max_candidates: usize,
}

impl Default for Bounds {
    fn default() -> Self {
        Bounds { max_steps: 20_000, max_candidates: 2_000 }
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
    /// Whether no other changes that are looked for cost less, or lead further: none was left out for want of steps or
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
/// looked for is what a later visit would have to teach for the walk to come that far. Law: with nothing to change it costs
/// one beginning a visit, and the same readings always give the same changes.
pub fn mend(readings: &[Reading], axioms: AxiomSet, bounds: Bounds) -> Mended {
    mend_within(readings, axioms, bounds).0
}

/// The same, and how many steps are left.
fn mend_within(readings: &[Reading], axioms: AxiomSet, bounds: Bounds) -> (Mended, usize) {
    let mut search = Search {
        takings: Takings::new(readings),
        agenda: BTreeMap::new(),
        offered: 0,
        steps_left: bounds.max_steps,
        whole: true,
    };
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
    let mended = Mended {
        first: 0,
        explained: taken.len(),
        told: search.takings.told(taken),
        changes: search.takings.changes(taken),
        sum: search.takings.sum(taken),
        proven: search.whole,
    };
    (mended, search.steps_left)
}

/// The longest stretch of a walk that changes as [`mend`] finds them lead some map to explain: from the first observation
/// on, or where these come to an end, from the later one that leads furthest, the first of such.
pub fn mend_longest(readings: &[Reading], axioms: AxiomSet, bounds: Bounds) -> Mended {
    let (mut longest, mut left) = mend_within(readings, axioms, bounds);
    let mut proven = longest.proven;
    for first in 1..readings.len() {
        if readings.len() - first <= longest.explained {
            break;
        }
        let mut part = readings[first..].to_vec();
        // Nothing is known of how the robot came there.
        (part[0].sighting.departure, part[0].sighting.motion) = (None, None);
        let bounds = Bounds { max_steps: left, ..bounds };
        let (found, after) = mend_within(&part, axioms, bounds);
        (left, proven) = (after, proven && found.proven);
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
}

impl Beginning {
    fn new(axioms: AxiomSet, bounds: Bounds) -> Beginning {
        let limits = Limits { max_candidates: Some(bounds.max_candidates), ..Limits::default() };
        let (abduction, measured) = (Abduction::new(axioms, limits), Measurements::default());
        Beginning { before: None, taken: Vec::new(), abduction, measured }
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

/// At most so many ways of going on wait, the most doubtful given up first: some hundreds of megabytes on the longest walks.
const MOST_DUE: usize = 20_000;

/// What comes first: the least sum, then the longest, then what was offered first.
type Key = (Sum, Reverse<usize>, usize);

/// A beginning to be made: how its visits are taken, of which some are taken as those of a known one.
struct Due {
    from: Rc<Beginning>,
    /// How many of these visits are as there.
    shared: usize,
    taken: Vec<Taken>,
}

struct Search<'a> {
    takings: Takings<'a>,
    agenda: BTreeMap<Key, Due>,
    offered: usize,
    steps_left: usize,
    /// Whether no limit has left anything out.
    whole: bool,
}

impl Search<'_> {
    /// What is due next, unless there is nothing, or the steps are used up.
    fn next(&mut self) -> Option<Due> {
        let (_, due) = self.agenda.pop_first()?;
        self.whole &= self.steps_left > 0;
        self.steps_left = self.steps_left.checked_sub(1)?;
        Some(due)
    }

    /// Puts all ways of going on by a visit on the agenda.
    fn offer(&mut self, from: &Rc<Beginning>) {
        for (shared, taken) in self.takings.next(&from.taken) {
            self.offered += 1;
            let key = (self.takings.sum(&taken), Reverse(taken.len()), self.offered);
            self.agenda.insert(key, Due { from: Rc::clone(from), shared, taken });
            if self.agenda.len() > MOST_DUE {
                self.whole = false;
                self.agenda.pop_last();
            }
        }
    }

    /// The beginning, if some map explains it.
    fn extended(&mut self, due: Due) -> Option<Rc<Beginning>> {
        let mut found = due.from;
        while found.taken.len() > due.shared {
            found = Rc::clone(found.before.as_ref()?);
        }
        for &taken in &due.taken[due.shared..] {
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
        for visits in self.takings.one_place(&found.taken, visit) {
            found.identify(visits)?;
        }
        self.whole &= found.abduction.is_complete();
        (visit == 0 || !found.abduction.is_empty()).then_some(found)
    }
}
