//! The visits of a candidate and the frames of its places.

use crate::abduction::{Assignment, Branch, Learned, Outcome, Proposal};
use crate::geometry::wrap_angle;
use crate::map::DstateId;
use crate::metric::MetricParameters;
use crate::metric::layout::Layout;
use crate::metric::lessons::{Lessons, Taught};
use crate::metric::measurements::Stay;
use crate::metric::share::SHARES;
use crate::star::SlotIndex;
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// What a child of a candidate says of all visits up to the one proposed for, the last, with what was measured.
#[derive(Debug)]
pub(super) struct Story<'a> {
    pub(super) stays: &'a [std::sync::Arc<Stay>],
    pub(super) parameters: &'a MetricParameters,
    /// How many least-squares problems searches for room have solved.
    pub(super) problems: &'a AtomicU64,
    pub(super) outcome: Outcome,
    branch: &'a Branch<'a>,
    before: &'a [Assignment],
    last: Assignment,
    /// The first visit to each place.
    first: Vec<usize>,
}

/// What is known of a child whose axioms hold, for its own children: what was learned of it, or else of the candidate.
pub(super) fn learned(proposal: &Proposal<'_>) -> Learned {
    let taught = || {
        let layouts: &Layouts = proposal.branch.measured(Default::default)?;
        let learned = layouts.learned.borrow();
        let (last, taught) = learned.as_ref()?;
        (*last == proposal.assignment).then(|| Learned::of(taught.clone()))
    };
    taught().unwrap_or_else(|| proposal.branch.learned().clone())
}

/// The layouts asked for so far under each of [`SHARES`]: those that all children of a candidate share, and those of
/// the child asked about last.
#[derive(Debug, Default)]
struct Layouts {
    before: [OnceCell<Option<Layout>>; SHARES.len()],
    after: RefCell<Option<(Assignment, After)>>,
    /// What was learned of the child asked about last.
    learned: RefCell<Option<(Assignment, Taught)>>,
}

type After = [OnceCell<Option<Rc<Layout>>>; SHARES.len()];

impl<'a> Story<'a> {
    /// The visits of `stays`, as the branch and the proposal assign them.
    pub(super) fn new(
        stays: &'a [std::sync::Arc<Stay>],
        proposal: &Proposal<'a>,
        parameters: &'a MetricParameters,
        problems: &'a AtomicU64,
    ) -> Self {
        let (before, last) = (proposal.branch.visits(), proposal.assignment);
        let mut first: Vec<usize> = Vec::new();
        for (visit, assignment) in before.iter().chain([&last]).enumerate() {
            // Places are numbered by first visit.
            if assignment.place.index() == first.len() {
                first.push(visit);
            }
        }
        let Proposal { branch, outcome, .. } = *proposal;
        Story { stays, parameters, problems, outcome, branch, before, last, first }
    }

    /// All visits laid out by the loops closed before the latest travel, under one of [`SHARES`].
    pub(super) fn before(&self, share: usize) -> Option<&'a Layout> {
        let layouts: &Layouts = self.branch.measured(Default::default)?;
        layouts.before[share].get_or_init(|| Layout::new(self, self.latest(), SHARES[share])).as_ref()
    }

    /// The same by the loop that the latest travel closes, too.
    pub(super) fn after(&self, share: usize) -> Option<Rc<Layout>> {
        let layouts: &Layouts = self.branch.measured(Default::default)?;
        let mut after = layouts.after.borrow_mut();
        if after.as_ref().is_none_or(|(last, _)| *last != self.last) {
            *after = Some((self.last, Default::default()));
        }
        let (_, shares) = after.as_mut()?;
        let make = || Layout::new(self, self.latest() + 1, SHARES[share]).map(Rc::new);
        shares[share].get_or_init(make).clone()
    }

    /// What is known of the candidate under one of [`SHARES`].
    pub(super) fn lessons(&self, share: usize) -> Option<&'a Lessons> {
        self.branch.learned().get::<Taught>()?[share].as_deref()
    }

    /// Keeps for the child what was learned under one of [`SHARES`].
    pub(super) fn learn(&self, share: usize, lessons: Option<Lessons>) {
        let Some(layouts) = self.branch.measured::<Layouts>(Default::default) else { return };
        let mut learned = layouts.learned.borrow_mut();
        let now = learned.take().filter(|(last, _)| *last == self.last).map(|(_, taught)| taught);
        let mut taught = now.or_else(|| self.branch.learned().get().cloned()).unwrap_or_default();
        taught[share] = lessons.filter(|lessons| !lessons.is_empty()).map(Arc::new);
        *learned = Some((self.last, taught));
    }

    /// The last visit, which is the one proposed for.
    pub(super) fn latest(&self) -> usize {
        self.before.len()
    }

    /// What a visit is taken for.
    pub(super) fn assignment(&self, visit: usize) -> Assignment {
        self.before.get(visit).copied().unwrap_or(self.last)
    }

    /// The number of the place of a visit.
    pub(super) fn place(&self, visit: usize) -> usize {
        self.assignment(visit).place.index()
    }

    /// How many places there are.
    pub(super) fn places(&self) -> usize {
        self.first.len()
    }

    /// The visits to a place, the latest among them, ascending.
    pub(super) fn visits_to(&self, place: usize) -> impl Iterator<Item = usize> + '_ {
        (0..=self.latest()).filter(move |&visit| self.place(visit) == place)
    }

    /// The slot of the place that a slot of the star of a visit is.
    pub(super) fn slot(&self, visit: usize, slot: SlotIndex) -> SlotIndex {
        let size = self.stays[visit].bearings.len();
        SlotIndex(((slot.0 as usize + self.assignment(visit).rotation as usize) % size) as u8)
    }

    /// The two gateways of the travel that led to a visit but the first.
    pub(super) fn ends(&self, visit: usize) -> Option<[DstateId; 2]> {
        let from = DstateId {
            place: self.assignment(visit - 1).place,
            slot: self.slot(visit - 1, self.stays[visit].departure?),
        };
        let to = DstateId {
            place: self.assignment(visit).place,
            slot: self.slot(visit, self.stays[visit].gateway),
        };
        Some([from, to])
    }

    /// The bearings of a visit by the slots of its place.
    pub(super) fn bearings(&self, visit: usize) -> impl Iterator<Item = (SlotIndex, f64)> + '_ {
        let bearings = self.stays[visit].bearings.iter().zip(0..);
        bearings.filter_map(move |(bearing, slot)| Some((self.slot(visit, SlotIndex(slot)), (*bearing)?)))
    }

    /// The direction of the axes of a visit's frame in that of its place: how far its bearings, on average, are to be
    /// turned to lie on those of the first visit. `None` where no slot has a bearing on both.
    pub(super) fn turn(&self, visit: usize) -> Option<f64> {
        let first = self.first[self.place(visit)];
        if first == visit {
            return Some(0.0);
        }
        let known = &self.stays[first].bearings;
        let mut turns = self
            .bearings(visit)
            .filter_map(|(slot, bearing)| Some(wrap_angle(known[slot.0 as usize]? - bearing)));
        // About one of the turns, so that the mean does not depend on where angles are cut.
        let about = turns.next()?;
        let (sum, count) =
            turns.fold((0.0, 1.0), |(sum, count), turn| (sum + wrap_angle(turn - about), count + 1.0));
        Some(wrap_angle(about + sum / count))
    }
}
