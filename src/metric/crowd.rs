//! Whether all places can lie apart at once.
//!
//! Where a known building is taken for new, each of its places lies on a known one, and none of them so surely that it could not
//! lie elsewhere. But they hang together: where one moves aside all do, and not all find room between the known ones. So
//! the least chi-square is sought with which all loops close and any two places lie apart.
//!
//! That two places lie apart is that one lies beyond a side of a polygon around the other ([`crate::metric::sides`]): one
//! condition of several (disjunctive programming, Balas 1979). Branch and bound (Land and Doig 1960): least squares beyond
//! the sides chosen so far; if that takes more chi-square than their gate, by the profile of the likelihood too
//! ([`crate::metric::profile`]), the branch ends; else each side around a place comes next that lies within another's
//! polygon. If no place does, and errors within the gate are found with which that is so, all can lie apart.
//!
//! What ends a branch is kept as a conflict, of as few sides as it takes ([`crate::metric::conflicts`]).
//!
//! The gate of some sides is that of as many degrees of freedom as of them bear: of one cone and covariance, chi-square is so
//! distributed given which ones do (Wollan and Dykstra 1986). Here the sides are chosen by the data and the covariance is a
//! bound ([`crate::metric::share`]), so that it is a rule that this law suggests; how often it fails is counted, not proven
//! (`cargo xtask evaluate`).

use crate::metric::conflicts::{Choice, Look, choice};
use crate::metric::layout::{Layout, Span};
use crate::metric::profile::NEARER;
use crate::metric::sides::{Pair, Polygons, Side};
use crate::metric::uncertainty::quantile;
use crate::metric::witness::Witness;
use std::collections::{BTreeMap, BTreeSet};

/// How long to look for room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// As `apart` does: as long as it seems that there is none, up to where a visit comes to rest within a polygon though it
    /// was put beyond one of its sides. Such a branch hardly ever ends.
    Short,
    /// To the end, or ten times as long.
    Long,
}

impl Patience {
    /// At most so many sets of sides are looked at.
    fn steps(self) -> usize {
        match self {
            Patience::Short => 400,
            Patience::Long => 4_000,
        }
    }
}

/// Whether all places can lie apart at once.
#[derive(Clone, Debug, PartialEq)]
pub enum Room {
    /// Errors within the gate are found with which they do, and which hold to that as they are. Found in a range of shares, whose covariances bound those of each share
    /// in it, it says that this bound leaves room, and not that any one share does.
    Found(Witness),
    /// What that takes is more than is likely.
    Lacking(Crowd),
    /// It is not found out.
    Unknown,
}

/// What it takes at least to have all places apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Crowd {
    /// Chi-square beyond that of the loops alone.
    pub chi_square: f64,
    /// The gate that it exceeds.
    pub gate: f64,
    /// Visits to places that are in each other's way, each pair once.
    pub(super) spans: Vec<Span>,
}

impl Layout {
    /// Whether some visits, ascending and measured in between, can all lie so far from each other.
    pub(super) fn room(&self, visits: &[usize], radius: f64, patience: Patience) -> Room {
        let Some(polygons) = Polygons::new(self, visits, radius) else { return Room::Unknown };
        let mut search = Search { layout: self, polygons, patience, ended: BTreeMap::new(), witness: None };
        match choice(patience.steps(), |sides| search.look(sides)) {
            Choice::Found => search.witness.map_or(Room::Unknown, Room::Found),
            Choice::Unknown => Room::Unknown,
            Choice::Lacking => {
                let least = search.ended.into_values().flatten();
                let least = least.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
                least.map_or(Room::Unknown, Room::Lacking)
            }
        }
    }

    /// The gate of some conditions together, as far as all loops leave it.
    fn gate(&self, conditions: usize) -> f64 {
        // No less than that of one place and another, which is a position.
        let degrees = conditions.max(2);
        self.left(degrees, quantile(degrees))
    }
}

/// The search for a way to have all places apart.
struct Search<'a> {
    layout: &'a Layout,
    polygons: Polygons<'a>,
    patience: Patience,
    /// What it takes to come beyond sides that bear, if that is too much.
    ended: BTreeMap<Vec<Side>, Option<Crowd>>,
    /// What was found.
    witness: Option<Witness>,
}

impl Search<'_> {
    /// What there is beyond some sides. Where first order finds too much, or room for all, it is asked whether that is so.
    fn look(&mut self, sides: &[Side]) -> Look<Side> {
        let solved = self.polygons.solve(sides);
        let bearing = solved.bearing();
        if solved.chi_square <= self.layout.gate(bearing.len()) {
            match self.polygons.within(&solved, self.settled(sides), None) {
                Some(pair) => return self.next(&pair, sides),
                None if sides.is_empty() => return self.open(self.layout, 0),
                None => {}
            }
        }
        if let Some(conflict) = self.conflict(&bearing) {
            return Look::Conflict(conflict);
        }
        let gate = self.layout.gate(bearing.len());
        let Some(reached) = self.layout.to_reach(&self.polygons.lines(sides, 1.0), gate) else {
            return Look::Unknown;
        };
        match self.polygons.within(&solved, self.settled(sides), Some(&reached.layout.poses)) {
            Some(pair) => self.next(&pair, sides),
            None => self.open(&reached.layout, bearing.len()),
        }
    }

    /// That nothing is left to take beyond so many sides that bear, if that holds of the errors found as they are.
    fn open(&mut self, found: &Layout, bearing: usize) -> Look<Side> {
        let (least, _) = self.layout.chi_square();
        self.witness = self.polygons.witness(found, least, self.layout.gate(bearing));
        if self.witness.is_some() { Look::Open } else { Look::Unknown }
    }

    /// The sides of which it is not asked whether visits are beyond them: they were put there, as far as steps come to rest.
    fn settled<'s>(&self, sides: &'s [Side]) -> &'s [Side] {
        match self.patience {
            Patience::Short => &[],
            Patience::Long => sides,
        }
    }

    fn next(&self, pair: &Pair, sides: &[Side]) -> Look<Side> {
        self.polygons.ways(pair, sides).map_or(Look::Unknown, Look::Next)
    }

    /// Few of some sides that take more than their gate together, also where first order does not hold.
    fn conflict(&mut self, bearing: &[Side]) -> Option<BTreeSet<Side>> {
        let few = self.fewer(bearing);
        let conflict = [few.as_slice(), bearing].into_iter().find(|sides| self.ends(sides))?;
        Some(conflict.iter().copied().collect())
    }

    /// Without each side in turn that is not needed for them to take more than their gate, to first order.
    fn fewer(&self, bearing: &[Side]) -> Vec<Side> {
        let mut few = bearing.to_vec();
        for side in bearing {
            let rest: Vec<Side> = few.iter().copied().filter(|other| other != side).collect();
            if self.polygons.solve(&rest).chi_square > self.layout.gate(rest.len()) {
                few = rest;
            }
        }
        few
    }

    /// Whether some sides take more than their gate.
    fn ends(&mut self, sides: &[Side]) -> bool {
        if !self.ended.contains_key(sides) {
            self.ended.insert(sides.to_vec(), self.beyond(sides));
        }
        self.ended[sides].is_some()
    }

    /// What it takes at least to come beyond some sides, if that is more than their gate. Near lines are found where those far out
    /// are not.
    fn beyond(&self, sides: &[Side]) -> Option<Crowd> {
        let gate = self.layout.gate(sides.len());
        let first_order = self.polygons.solve(sides).chi_square;
        let shares = NEARER.map(|gates| (gates * gate / first_order).sqrt());
        let mut shares = shares.into_iter().filter(|&share| share < 1.0).chain([1.0]);
        let takes = |share| Some(self.layout.to_reach(&self.polygons.lines(sides, share), gate)?.chi_square);
        let takes = shares.find_map(|share| takes(share).filter(|&takes| takes > gate));
        let mut spans: Vec<Span> = sides.iter().map(|&side| self.polygons.span(side)).collect();
        // A side of a square and its part may both bear.
        spans.dedup();
        Some(Crowd { chi_square: takes?, gate, spans })
    }
}
