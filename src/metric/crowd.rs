//! Whether all places and path segments have room at once.
//!
//! Where a known building is taken for new, each of its places lies on a known one, and none of them so surely that it could not
//! lie elsewhere. But they hang together: where one moves aside all do, and not all find room between the known ones. So
//! the least chi-square is sought with which all loops close, any two places lie apart and no segment crosses another or leads
//! past a place ([`crate::metric::segments`]).
//!
//! That two places lie apart is that one lies beyond a side of a polygon around the other ([`crate::metric::sides`]), that two
//! segments do not cross that both ends of one lie on one side of the other: one condition of several, or a few (disjunctive
//! programming, Balas 1979). Branch and bound (Land and Doig 1960): least squares under the conditions chosen so far
//! ([`crate::metric::floor`]); if that takes more chi-square than their gate by the profile of the likelihood
//! ([`crate::metric::profile`]), of those that bear to first order or where errors lead, the branch ends; else what may hold of two things on one spot comes next. If no two
//! are, and errors within the gate are found with which that is so, all have room.
//!
//! What ends a branch is kept as a conflict, of as few conditions as it takes ([`crate::metric::conflicts`]).
//!
//! The gate of some conditions is that of as many degrees of freedom as of them bear: of one cone and covariance, chi-square is so
//! distributed given which ones do (Wollan and Dykstra 1986). Here the conditions are chosen by the data and the covariance is a
//! bound ([`crate::metric::share`]), so that it is a rule that this law suggests; how often it fails is counted, not proven
//! (`cargo xtask evaluate`).

use crate::metric::conflicts::{Choice, Look, choice};
use crate::metric::floor::{Apart, Floor, Solved};
use crate::metric::layout::{Layout, Span};
use crate::metric::lessons::{Lesson, Lessons, Reason, Scope};
use crate::metric::profile::{NEARER, Reached};
use crate::metric::segments::Segments;
use crate::metric::uncertainty::quantile;
use crate::metric::witness::Witness;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// At most so many things are chosen one after the other. Random walks need some fifty.
const DEEPEST: usize = 1_000;

/// How long to look for room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// As `apart` does.
    Short,
    /// Twenty times as long.
    Long,
}

impl Patience {
    /// At most so many least-squares problems are solved, and what the last branch looked at takes.
    fn problems(self) -> usize {
        match self {
            Patience::Short => 6_000,
            Patience::Long => 120_000,
        }
    }
}

/// Whether all places and segments have room at once.
#[derive(Clone, Debug, PartialEq)]
pub enum Room {
    /// Errors within the gate are found with which they have, and which hold to that as they are. Found in a range of shares, whose covariances bound those of each share
    /// in it, it says that this bound leaves room, and not that any one share does.
    Found(Witness),
    /// What that takes is more than is likely.
    Lacking(Crowd),
    /// It is not found out.
    Unknown,
}

/// What it takes at least for all to have room.
#[derive(Clone, Debug, PartialEq)]
pub struct Crowd {
    /// Chi-square beyond that of the loops alone. Where that was learned on an earlier observation, less what the loops
    /// have taken since.
    pub chi_square: f64,
    /// The gate that it exceeds; where it was learned on an earlier observation, the gate of then, which it exceeds by more
    /// than that has grown since.
    pub gate: f64,
    /// What is in each other's way, each pair once.
    pub(super) clashing: Vec<InTheWay>,
}

/// Two things in each other's way, by visits: to places, and that segments were first travelled between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum InTheWay {
    Places(Span),
    Segments([usize; 2], [usize; 2]),
    Passing([usize; 2], usize),
}

impl InTheWay {
    /// The visits that tell where they are.
    pub(super) fn visits(&self) -> Vec<usize> {
        match *self {
            InTheWay::Places(Span { from, to }) => vec![from, to],
            InTheWay::Segments(one, other) => [one, other].concat(),
            InTheWay::Passing([from, to], visit) => vec![from, to, visit],
        }
    }
}

impl Layout {
    /// Whether first visits, measured in between, can all lie so far from each other, and segments clear of all; and what is
    /// known then, if that was known before. Adds up the problems solved.
    pub(super) fn room(
        &self,
        segments: &Segments,
        separation: f64,
        patience: Patience,
        before: Option<&Lessons>,
        problems: &AtomicU64,
    ) -> (Room, Option<Lessons>) {
        let Some(floor) = Floor::new(self, segments, separation) else { return (Room::Unknown, None) };
        let lessons = Lessons::known(before, self, Scope { since: floor.since(), separation });
        let known = lessons.conflicts().to_vec();
        let budget = patience.problems();
        let mut search =
            Search { layout: self, floor, lessons, budget, ended: BTreeMap::new(), witness: None };
        let (choice, known) = choice(known, |chosen| search.look(chosen));
        problems.fetch_add((budget - search.budget) as u64, Ordering::Relaxed);
        let room = match choice {
            Choice::Found => search.witness.map_or(Room::Unknown, Room::Found),
            Choice::Unknown => Room::Unknown,
            Choice::Lacking(conflict) => Room::Lacking(search.lessons.crowd(&conflict)),
        };
        (room, Some(search.lessons.with(known)))
    }

    /// The gate of some conditions together, as far as all loops leave it.
    fn gate(&self, conditions: usize) -> f64 {
        // No less than that of one place and another, which is a position.
        let degrees = conditions.max(2);
        self.left(degrees, quantile(degrees))
    }
}

/// The search for room.
struct Search<'a> {
    layout: &'a Layout,
    floor: Floor<'a>,
    /// What was known before.
    lessons: Lessons,
    /// How many problems may be solved yet.
    budget: usize,
    /// What it takes to have things apart in some ways, if that is too much.
    ended: BTreeMap<Vec<Apart>, Option<Crowd>>,
    /// What was found.
    witness: Option<Witness>,
}

impl Search<'_> {
    /// What there is beyond some choices. Where first order finds too much, or room for all, it is asked whether that is so.
    fn look(&mut self, chosen: &[Apart]) -> Look<Apart, Arc<Reason>> {
        if self.budget == 0 || chosen.len() > DEEPEST {
            return Look::Unknown;
        }
        let solved = self.solve(chosen);
        if solved.chi_square <= self.layout.gate(solved.degrees()) {
            let clashes = self.floor.clashes(&solved, chosen, None);
            if !clashes.is_empty() {
                return Look::Next(clashes);
            }
            if chosen.is_empty() {
                return self.open(self.layout, 0);
            }
        }
        if let Some(conflict) = self.conflict(&solved.bearing()) {
            return Look::Conflict(conflict);
        }
        let reached = self.reach(chosen, 1.0);
        // What bears where errors lead may be more than first order has.
        if let Some(reached) = reached.as_ref().filter(|reached| self.is_beyond(reached))
            && let Some(conflict) = self.conflict(&self.floor.bearing(chosen, reached))
        {
            return Look::Conflict(conflict);
        }
        // Where errors do not come to rest they may with more chosen.
        let poses = reached.as_ref().map(|reached| reached.layout.poses.as_slice());
        let clashes = self.floor.clashes(&solved, chosen, poses);
        match reached {
            _ if !clashes.is_empty() => Look::Next(clashes),
            Some(reached) => self.open(&reached.layout, reached.bearing.len()),
            None => Look::Unknown,
        }
    }

    /// That nothing is left to choose beyond so many bounds that bear, if that holds of the errors found as they are.
    fn open(&mut self, found: &Layout, bearing: usize) -> Look<Apart, Arc<Reason>> {
        let (least, _) = self.layout.chi_square();
        self.witness = self.floor.witness(found, least, self.layout.gate(bearing));
        if self.witness.is_some() { Look::Open } else { Look::Unknown }
    }

    /// Few of some that take more than their gate together, also where first order does not hold.
    fn conflict(&mut self, bearing: &[Apart]) -> Option<Lesson> {
        let few = self.fewer(bearing);
        [few.as_slice(), bearing].into_iter().find_map(|chosen| {
            let crowd = self.ends(chosen)?;
            Some(self.lessons.lesson(chosen, &crowd))
        })
    }

    /// Without each in turn that is not needed for them to take more than their gate, to first order.
    fn fewer(&mut self, bearing: &[Apart]) -> Vec<Apart> {
        let mut few = bearing.to_vec();
        for one in bearing {
            let rest: Vec<Apart> = few.iter().copied().filter(|other| other != one).collect();
            let solved = self.solve(&rest);
            if solved.chi_square > self.layout.gate(solved.degrees()) {
                few = rest;
            }
        }
        few
    }

    /// What some take, if that is more than their gate.
    fn ends(&mut self, chosen: &[Apart]) -> Option<Crowd> {
        if !self.ended.contains_key(chosen) {
            let beyond = self.beyond(chosen);
            self.ended.insert(chosen.to_vec(), beyond);
        }
        self.ended[chosen].clone()
    }

    /// What it takes at least to have things apart in some ways, if that is more than their gate. Near bounds are found where those
    /// far out are not, and have the gate of those of them that bear: what is beyond a bound is beyond every one before it.
    fn beyond(&mut self, chosen: &[Apart]) -> Option<Crowd> {
        let solved = self.solve(chosen);
        let gate = self.layout.gate(solved.degrees());
        let shares = NEARER.map(|gates| (gates * gate / solved.chi_square).sqrt());
        let mut shares = shares.into_iter().filter(|&share| share < 1.0).chain([1.0]);
        let reached =
            shares.find_map(|share| self.reach(chosen, share).filter(|reached| self.is_beyond(reached)));
        Some(self.crowd(chosen, &reached?))
    }

    /// What it takes to first order to have things apart in some ways.
    fn solve(&mut self, chosen: &[Apart]) -> Solved {
        self.budget = self.budget.saturating_sub(1);
        self.floor.solve(chosen)
    }

    /// What it takes to go a share of the way to where things are apart in some ways.
    fn reach(&mut self, chosen: &[Apart], share: f64) -> Option<Reached> {
        let bounds = self.floor.bounds(chosen, share);
        let descent = self.layout.to_reach(&bounds, |bearing| self.layout.gate(bearing));
        self.budget = self.budget.saturating_sub(descent.rounds);
        descent.end
    }

    fn is_beyond(&self, reached: &Reached) -> bool {
        reached.chi_square > self.layout.gate(reached.bearing.len())
    }

    fn crowd(&self, chosen: &[Apart], reached: &Reached) -> Crowd {
        let mut clashing: Vec<InTheWay> = chosen.iter().map(|apart| self.floor.otherwise(apart)).collect();
        // A side of a square and its part may both bear.
        clashing.dedup();
        let gate = self.layout.gate(reached.bearing.len());
        Crowd { chi_square: reached.chi_square, gate, clashing }
    }
}
