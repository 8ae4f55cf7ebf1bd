//! Why two visits are one place in a candidate, or are not, and what the rivals say.

use crate::abduction::{
    Abduction, Assertion, Assignment, Candidate, Count, Refutation, Relation, Simplicity, judge,
};
use crate::explanation::examples::last_refutation;
use crate::explanation::travels::{StepKind, Travelled, first_visit, travels};
use crate::map::{DstateId, PlaceId};
use crate::star::StarDifference;
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;

/// What a candidate, and what all candidates, say of two visits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Together {
    /// The two observations, ascending.
    pub visits: [usize; 2],
    /// What the candidate says, and why.
    pub opinion: Opinion,
    /// In how many candidates they are one place.
    pub together: Count,
    /// In how many they are not.
    pub apart: Count,
    /// The simplest candidate that says otherwise, of equally simple ones the first.
    pub rival: Option<Rival>,
    /// The positions of the minimal candidates that say otherwise.
    pub minimal_rivals: Vec<usize>,
}

/// What a candidate says of two visits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Opinion {
    /// They are one place.
    One {
        /// The place.
        place: PlaceId,
        /// Why, in the order of observations. They suffice: in every candidate that makes the same closures, with the
        /// same alignments to the first visits, the two are one place.
        reasons: Vec<Reason>,
    },
    /// They are not.
    Two {
        /// The places.
        places: [PlaceId; 2],
        /// What the later visit would be as one to the other's place, under each alignment of the stars, all before
        /// it as the candidate says; with what refutes that, or at a later observation the last of all that comes of
        /// it. Nothing does if a story that begins so obeys the axioms to the end, or if there is too much to look at.
        alternatives: Vec<Alternative>,
        /// How the stars differ, if they have no alignment.
        difference: Option<StarDifference>,
    },
}

/// What the later of two visits would be as one to the place of the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alternative {
    /// The assignment.
    pub assignment: Assignment,
    /// What refutes it, or the last of all that comes of it.
    pub refutation: Option<Refutation>,
    /// The assertions in force that do not allow it.
    pub forbidden: Vec<Assertion>,
}

/// A reason why an observation is of a known place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The robot came from the unknown, and the candidate takes what it saw for that place.
    Closure {
        /// The observation.
        observation: usize,
        /// The gateway left by.
        from: DstateId,
        /// The gateway at the far end.
        to: DstateId,
        /// The first visit to the place.
        first: usize,
        /// The rotations under which the star seen lies on that of the place, of which the candidate takes one.
        alignments: Vec<u8>,
    },
    /// The robot went along a known path segment.
    Known {
        /// The observation.
        observation: usize,
        /// The gateway left by.
        from: DstateId,
        /// The gateway at the far end.
        to: DstateId,
        /// The observation at the end of the first travel along it.
        since: usize,
    },
}

/// A candidate that says otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rival {
    /// Its position.
    pub candidate: usize,
    /// How simple it is: what the alternative costs.
    pub simplicity: Simplicity,
}

/// What the candidate at a position, and all others, say of two different visits; none if there are no such visits or
/// no such candidate. Linear in candidates times observations; reasons quadratic in the observations.
pub fn together(abduction: &Abduction, candidate: usize, visits: [usize; 2]) -> Option<Together> {
    together_each(abduction, candidate, &[visits])?.pop()
}

/// The same for several pairs of visits, in one pass over the candidates; none unless it can be said of each.
pub fn together_each(abduction: &Abduction, candidate: usize, pairs: &[[usize; 2]]) -> Option<Vec<Together>> {
    let own = abduction.candidate(candidate)?;
    if pairs.iter().any(|&[a, b]| a == b || a.max(b) >= own.visits.len()) {
        return None;
    }
    let mut tallies: Vec<Tally> =
        pairs.iter().map(|&[a, b]| Tally::new(abduction, &own, [a.min(b), a.max(b)])).collect();
    let minimal = abduction.minimal();
    for (index, other) in abduction.candidates().enumerate() {
        let is_minimal = minimal.binary_search(&index).is_ok();
        let simplicity = LazyCell::new(|| other.simplicity(abduction.axioms()));
        tallies.iter_mut().for_each(|tally| tally.count(index, &other, is_minimal, &simplicity));
    }
    Some(tallies.into_iter().map(|tally| tally.finish(abduction)).collect())
}

/// What has been counted of one pair of visits.
struct Tally {
    visits: [usize; 2],
    opinion: Opinion,
    together: u64,
    apart: u64,
    rival: Option<Rival>,
    minimal_rivals: Vec<usize>,
}

impl Tally {
    fn new(abduction: &Abduction, own: &Candidate, visits: [usize; 2]) -> Tally {
        let opinion = match is_one(own, visits) {
            true => one_place(abduction, own, visits),
            false => two_places(abduction, own, visits),
        };
        Tally { visits, opinion, together: 0, apart: 0, rival: None, minimal_rivals: Vec::new() }
    }

    fn count(
        &mut self,
        index: usize,
        other: &Candidate,
        is_minimal: bool,
        simplicity: &impl Deref<Target = Simplicity>,
    ) {
        let one = is_one(other, self.visits);
        *(if one { &mut self.together } else { &mut self.apart }) += 1;
        if one == matches!(self.opinion, Opinion::One { .. }) {
            return;
        }
        if is_minimal {
            self.minimal_rivals.push(index);
        }
        let simplicity = **simplicity;
        if self.rival.as_ref().is_none_or(|rival| simplicity < rival.simplicity) {
            self.rival = Some(Rival { candidate: index, simplicity });
        }
    }

    fn finish(self, abduction: &Abduction) -> Together {
        Together {
            visits: self.visits,
            opinion: self.opinion,
            together: counted(abduction, self.together),
            apart: counted(abduction, self.apart),
            rival: self.rival,
            minimal_rivals: self.minimal_rivals,
        }
    }
}

fn is_one(candidate: &Candidate, [a, b]: [usize; 2]) -> bool {
    candidate.visits[a].place == candidate.visits[b].place
}

/// The observations at which a candidate came from the unknown to a known place, each with the first visit to it.
pub fn closures(abduction: &Abduction, candidate: &Candidate) -> Vec<[usize; 2]> {
    let closed = |travel: &Travelled| travel.kind == StepKind::Closure;
    let closures = travels(abduction.visits(), candidate).into_iter().filter(closed);
    closures
        .filter_map(|travel| Some([first_visit(&candidate.visits, travel.to.place)?, travel.observation]))
        .collect()
}

/// A number of candidates kept, exact unless the search was cut.
pub(super) fn counted(abduction: &Abduction, value: u64) -> Count {
    let relation = if abduction.is_complete() { Relation::Equal } else { Relation::AtLeast };
    Count { value, relation }
}

/// Each pair of visits that has to be one place leads to pairs whose later visit is earlier, until only closures are
/// left: the place come to by a known path segment is the one first come to by it, if the places left are one too.
fn one_place(abduction: &Abduction, own: &Candidate, visits: [usize; 2]) -> Opinion {
    let travels = travels(abduction.visits(), own);
    let mut reasons: BTreeMap<usize, Reason> = BTreeMap::new();
    let mut open = vec![visits];
    let mut asked: BTreeSet<[usize; 2]> = BTreeSet::new();
    while let Some([a, b]) = open.pop() {
        if a == b || !asked.insert([a, b]) {
            continue;
        }
        // The later of two visits to one place was come to by a travel.
        let travel = travels[b - 1];
        let mut ask = |x: usize, y: usize| open.push([x.min(y), x.max(y)]);
        let reason = match travel.kind {
            StepKind::Known { since } if travels[since - 1].from == travel.from => {
                ask(since - 1, b - 1);
                ask(since, a);
                known(&travel, since)
            }
            StepKind::Known { since } => {
                ask(since, b - 1);
                ask(since - 1, a);
                known(&travel, since)
            }
            StepKind::Closure | StepKind::NewPlace => {
                let first = first_visit(&own.visits, travel.to.place).unwrap_or(a);
                ask(first, a);
                closure(abduction, own, &travel, first)
            }
        };
        reasons.insert(b, reason);
    }
    Opinion::One { place: own.visits[visits[0]].place, reasons: reasons.into_values().collect() }
}

fn known(travel: &Travelled, since: usize) -> Reason {
    Reason::Known { observation: travel.observation, from: travel.from, to: travel.to, since }
}

fn closure(abduction: &Abduction, own: &Candidate, travel: &Travelled, first: usize) -> Reason {
    let &Travelled { observation, from, to, .. } = travel;
    let alignments = own.map.star(to.place).alignments(&abduction.visits()[observation].star);
    Reason::Closure { observation, from, to, first, alignments }
}

fn two_places(abduction: &Abduction, own: &Candidate, [a, b]: [usize; 2]) -> Opinion {
    let [place, other] = [a, b].map(|visit| own.visits[visit].place);
    let (star, seen) = (own.map.star(place), &abduction.visits()[b].star);
    let alternative = |rotation| {
        let assignment = Assignment { place, rotation };
        let whole = [&own.visits[..b], &[assignment]].concat();
        let judged = judge(abduction.visits(), abduction.evidence(), abduction.axioms(), &whole);
        let forbidden = abduction.word().broken_by(&whole);
        let refutation = judged.err().or_else(|| last_refutation(abduction, whole));
        Alternative { assignment, refutation, forbidden }
    };
    let alternatives: Vec<Alternative> = star.alignments(seen).into_iter().map(alternative).collect();
    let difference = if alternatives.is_empty() { star.difference(seen, 0) } else { None };
    Opinion::Two { places: [place, other], alternatives, difference }
}
