//! How the visits of a walk may be taken, and what they tell then.

use crate::mending::joining::joined;
use crate::mending::likening::{Change, ChangeKind, Likening, likenings, passing};
use crate::mending::{Doubt, Reading, Sum, Told};
use crate::star::SlotIndex;
use crate::trace::Sighting;
use std::cell::OnceCell;

/// How a visit is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Taken {
    pub(super) choice: Choice,
    /// A place passed unseen on the way to it.
    pub(super) missed: Option<Missed>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    AsRead,
    /// To another visit, by one of the ways of doing so.
    Likened {
        target: usize,
        way: usize,
    },
    /// For none: the robot was on its way.
    Passed,
}

/// The place of a visit that is taken as it was read, passed along one of its paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Missed {
    like: usize,
    along: SlotIndex,
}

const AS_READ: Taken = Taken { choice: Choice::AsRead, missed: None };

impl Taken {
    pub(super) fn is_as_read(&self) -> bool {
        *self == AS_READ
    }
}

/// A way of going on by a visit: how the next one is taken; or how one before is, the next one then being as it was read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onward {
    /// The visit that is taken so. Those before it are as they were.
    pub(super) visit: usize,
    taken: Taken,
}

impl Onward {
    /// How all visits are taken after it.
    pub(super) fn taken(&self, before: &[Taken]) -> Vec<Taken> {
        let mut all = [before, &[AS_READ]].concat();
        all[self.visit] = self.taken;
        all
    }
}

/// All ways of taking visits.
pub(super) struct Takings<'a> {
    readings: &'a [Reading],
    /// For each visit and each other one, all ways of likening it to that, once they were asked for.
    likenings: Vec<OnceCell<Vec<Likening>>>,
    /// For each visit, what must be changed for it to be none, if it may be.
    passings: Vec<Option<Vec<Change>>>,
}

impl<'a> Takings<'a> {
    pub(super) fn new(readings: &'a [Reading]) -> Takings<'a> {
        let visits = 0..readings.len();
        Takings {
            readings,
            likenings: vec![OnceCell::new(); readings.len().pow(2)],
            passings: visits.map(|visit| passing(readings, visit)).collect(),
        }
    }

    /// All ways of likening a visit to another one.
    fn likenings(&self, visit: usize, target: usize) -> &[Likening] {
        let likenings = || likenings(self.readings, visit, target);
        self.likenings
            .get(visit * self.readings.len() + target)
            .map_or(&[], |known| known.get_or_init(likenings))
    }

    fn likened(&self, visit: usize, target: usize) -> impl Iterator<Item = Choice> {
        (0..self.likenings(visit, target).len()).map(move |way| Choice::Likened { target, way })
    }

    /// All ways of going on by a visit: the next one is taken in any way, or as it was read, and one before is likened to it
    /// or comes behind its place.
    pub(super) fn next(&self, taken: &[Taken]) -> Vec<Onward> {
        let visit = taken.len();
        if visit == self.readings.len() {
            return Vec::new();
        }
        let free = |other: usize| taken.get(other).is_some_and(|one| one.choice == Choice::AsRead);
        let likened = (0..visit).filter(|&other| free(other)).flat_map(|other| self.likened(visit, other));
        let passed = self.passings[visit].as_ref().map(|_| Choice::Passed);
        let choices = likened.chain(passed).map(|choice| Taken { choice, ..AS_READ });
        let known = (0..visit).filter(|&other| free(other));
        let missed = known.flat_map(|like| self.passed_along(like));
        let missed = missed.map(|missed| Taken { missed: Some(missed), ..AS_READ });
        let ahead = [AS_READ].into_iter().chain(choices).chain(missed);
        let ahead = ahead.map(|taken| Onward { visit, taken });
        ahead.chain(self.revisions(taken)).collect()
    }

    /// What the next visit may teach about those before: how one of them is taken instead.
    fn revisions(&self, taken: &[Taken]) -> Vec<Onward> {
        let visit = taken.len();
        let mut found = Vec::new();
        for (at, &before) in taken.iter().enumerate() {
            let mut instead = |taken| found.push(Onward { visit: at, taken });
            if before.choice == Choice::AsRead && !self.is_target(taken, at) {
                self.likened(at, visit).for_each(|choice| instead(Taken { choice, ..before }));
            }
            if at > 0 && before.choice != Choice::Passed && before.missed.is_none() {
                let missed = self.passed_along(visit).into_iter();
                missed.for_each(|missed| instead(Taken { missed: Some(missed), ..before }));
            }
        }
        found
    }

    /// The ways of passing the place of a visit along a path unseen.
    fn passed_along(&self, like: usize) -> Vec<Missed> {
        if !self.readings.iter().all(|reading| reading.found) {
            return Vec::new();
        }
        let star = &self.readings[like].sighting.star;
        let through =
            star.indices().zip(star.slots()).filter(|(_, s)| s.outward.is_some() && s.inward.is_some());
        through.map(|(along, _)| Missed { like, along }).collect()
    }

    /// Whether something is like a visit.
    fn is_target(&self, taken: &[Taken], visit: usize) -> bool {
        let likened = |at: usize| self.likening(taken, at).is_some_and(|one| one.target == visit);
        let missed = |one: &Taken| one.missed.is_some_and(|missed| missed.like == visit);
        taken.iter().any(missed) || (0..taken.len()).any(likened)
    }

    fn likening(&self, taken: &[Taken], visit: usize) -> Option<&Likening> {
        match taken.get(visit)?.choice {
            Choice::Likened { target, way } => self.likenings(visit, target).get(way),
            Choice::AsRead | Choice::Passed => None,
        }
    }

    pub(super) fn changes(&self, taken: &[Taken]) -> Vec<Change> {
        (0..taken.len()).flat_map(|visit| self.changes_at(taken, visit)).collect()
    }

    fn changes_at(&self, taken: &[Taken], visit: usize) -> Vec<Change> {
        let missed = taken[visit].missed.map(|Missed { like, .. }| Change {
            observation: visit,
            slot: None,
            bearing: None,
            kind: ChangeKind::Missed,
            doubt: Doubt::LIMIT,
            like: Some(like),
        });
        missed.into_iter().chain(self.own_changes(taken, visit).iter().cloned()).collect()
    }

    /// What is taken otherwise of the visit itself.
    fn own_changes(&self, taken: &[Taken], visit: usize) -> &[Change] {
        match taken[visit].choice {
            Choice::Passed => self.passings[visit].as_deref().unwrap_or_default(),
            _ => self.likening(taken, visit).map_or(&[], |likening| &likening.changes),
        }
    }

    /// What the changes cost. Linear in the visits.
    pub(super) fn sum(&self, taken: &[Taken]) -> Sum {
        let missed = taken.iter().filter(|one| one.missed.is_some()).map(|_| Doubt::LIMIT);
        let own = (0..taken.len()).flat_map(|visit| self.own_changes(taken, visit));
        Sum::default().and(own.map(|change| change.doubt).chain(missed))
    }

    /// The visits of a walk as they are taken.
    pub(super) fn told(&self, taken: &[Taken]) -> Vec<Told> {
        (0..taken.len()).flat_map(|visit| self.told_at(taken, visit)).collect()
    }

    /// What an observation tells, after the place that was passed on the way to it; nothing where it is none.
    pub(super) fn told_at(&self, taken: &[Taken], visit: usize) -> Vec<Told> {
        let Taken { choice, missed } = taken[visit];
        if choice == Choice::Passed {
            return Vec::new();
        }
        let mut sighting = self.sighting(taken, visit);
        let passed = missed.map(|Missed { like, along }| {
            // The odometry of the whole way tells nothing of either part of it, and measurements are kept by travels from one
            // visit to the next: there is no word for what two of them are together. So less is refuted than could be.
            let departure = sighting.departure.replace(along);
            sighting.motion = None;
            let place = self.readings[like].sighting.clone();
            Told {
                observation: None,
                sighting: Sighting { arrival: along, departure, motion: None, ..place },
            }
        });
        passed.into_iter().chain([Told { observation: Some(visit), sighting }]).collect()
    }

    /// An observation with the travel from the last one that is taken for a visit to a place.
    fn sighting(&self, taken: &[Taken], visit: usize) -> Sighting {
        let read = &self.readings[visit].sighting;
        let mut sighting = self.likening(taken, visit).map_or(read, |likening| &likening.sighting).clone();
        sighting.departure = read.departure;
        for before in (0..visit).rev() {
            if taken[before].choice != Choice::Passed {
                let likening = self.likening(taken, before);
                sighting.departure = likening.map_or(sighting.departure, |likening| likening.departure);
                break;
            }
            let passed = &self.readings[before].sighting;
            sighting.departure = passed.departure;
            sighting.motion = sighting.motion.and_then(|motion| joined(passed, &motion));
        }
        sighting
    }

    /// The pairs of visits told that are one place as the latest observation is taken, or those before for its sake.
    pub(super) fn one_place(&self, taken: &[Taken], visit: usize) -> Vec<[usize; 2]> {
        let told = |visit: usize| self.position(taken, visit);
        let target = |at: usize| self.likening(taken, at).map(|one| one.target);
        let mut pairs: Vec<[usize; 2]> =
            (0..visit).filter(|&at| target(at) == Some(visit)).map(|at| [told(at), told(visit)]).collect();
        pairs.extend(target(visit).filter(|&other| other < visit).map(|other| [told(other), told(visit)]));
        for (at, one) in taken.iter().enumerate() {
            let Some(Missed { like, .. }) = one.missed else { continue };
            if (like == visit && at <= visit) || (at == visit && like < visit) {
                pairs.push([told(at) - 1, told(like)]);
            }
        }
        pairs
    }

    /// Which of the visits told an observation is, if it is one.
    fn position(&self, taken: &[Taken], visit: usize) -> usize {
        let places = taken[..=visit].iter().filter(|one| one.choice != Choice::Passed).count();
        let missed = taken[..=visit].iter().filter(|one| one.missed.is_some()).count();
        (places + missed).saturating_sub(1)
    }
}
