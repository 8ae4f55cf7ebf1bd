//! The simplest maps, without all the others.
//!
//! A search over *which visits are one place*, depth first with the most promising decision first, under a bound:
//! branch and bound (Land and Doig 1960). It differs from the breadth-first search in what it extends: not a map by
//! the next observation, but the whole walk by one more decision about one class of visits, and all that
//! follows from it ([`Quotient`]). So the class with the fewest ways left is decided first, whenever it was visited (the fail-first
//! principle, Haralick and Elliott 1980), and a wrong closure falls when it is made and not when the robot comes by again.
//! The idea is that of learning the smallest automaton from a trace by merging states and folding (Lang, Pearlmutter and Price
//! 1998); the clique bound is that of Heule and Verwer 2010.
//!
//! Axioms that folding does not know (boundaries, measurements, the operator's word) are judged by the registry, on the
//! beginning of the walk that is decided; the walk is then decided in its order. Every map found is judged by the
//! registry from its first observation on, so that folding can only ever save work.

mod bound;
mod faces;
mod quotient;
mod trailed;
mod walk;

use crate::abduction::{
    Assignment, Axiom, AxiomId, AxiomSet, Boundary, Evidence, Refutations, Simplicity, Visit, Word, judge,
};
use crate::map::PlaceId;
use bound::bound;
use faces::planar;
use quotient::{Mark, Quotient, members};
use std::sync::Arc;
use walk::Walk;

/// The axioms that folding keeps by itself, `planarity` on what is settled among them.
const FOLDED: [AxiomId; 5] =
    [AxiomId::Determinism, AxiomId::StarMatch, AxiomId::TravelMoves, AxiomId::PathOrder, AxiomId::Planarity];

/// A search for the simplest maps of one experience. It can stop at any time and go on later.
#[derive(Clone, Debug)]
pub(super) struct BestFirst {
    experience: Arc<Experience>,
    walk: Arc<Walk>,
    quotient: Quotient,
    agenda: Vec<Decision>,
    spare: Spare,
    found: Minimal,
    effort: Effort,
    /// Whether the walk is decided in its order, as some axioms are judged on its beginning.
    in_order: bool,
    /// The classes of the walk, in its order, of which it was asked whether they can lie on those before them.
    told_apart: usize,
}

/// What is to be explained, and under which laws.
#[derive(Clone, Debug)]
pub(super) struct Experience {
    pub(super) visits: Vec<Arc<Visit>>,
    pub(super) evidence: Option<Arc<dyn Evidence>>,
    pub(super) axioms: AxiomSet,
    pub(super) word: Word,
}

/// The simplest candidates found.
#[derive(Clone, Debug, Default)]
pub(super) struct Minimal {
    pub(super) simplicity: Option<Simplicity>,
    /// Their assignments, in no order.
    pub(super) candidates: Vec<Vec<Assignment>>,
    /// Whether some as simple were left out.
    pub(super) cut: bool,
}

/// What a search has done; none of it depends on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Effort {
    /// Quotients looked at.
    pub(super) steps: u64,
    /// Quotients made that no axiom refuted.
    pub(super) made: u64,
    pub(super) refuted: Refutations,
}

/// When to stop.
pub(super) struct Budget<'a> {
    /// After so many steps in all.
    pub(super) steps: Option<u64>,
    /// The most candidates kept of those that are equally simple.
    pub(super) candidates: Option<usize>,
    /// Asked now and then.
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

/// What one class is to be.
#[derive(Clone, Debug)]
struct Decision {
    class: usize,
    lists: Lists,
    mark: Mark,
    bound: Simplicity,
}

/// The classes of a quotient, and of one of them each way that is left, with the classes it leaves, the last first.
#[derive(Clone, Debug, Default)]
struct Lists {
    classes: Vec<usize>,
    settled: Vec<usize>,
    open: Vec<usize>,
    ways: Vec<(usize, Way)>,
}

/// Lists no longer used, whose memory is.
#[derive(Clone, Debug, Default)]
struct Spare(Vec<Lists>);

#[derive(Clone, Copy, Debug)]
enum Way {
    Merged { onto: usize, rotation: usize },
    New,
}

impl BestFirst {
    /// A search that has not begun, or the axiom that the walk breaks however it is explained. Memory is quadratic
    /// in the visits.
    pub(super) fn new(experience: Experience) -> Result<BestFirst, AxiomId> {
        let walk = Walk::new(&experience.visits);
        let quotient = Quotient::of(&walk, experience.axioms)?;
        let known = |axiom: &Axiom| FOLDED.contains(&axiom.id);
        let in_order = !experience.word.is_empty() || !experience.axioms.iter().all(known);
        Ok(BestFirst {
            experience: Arc::new(experience),
            walk: Arc::new(walk),
            quotient,
            agenda: Vec::new(),
            spare: Spare::default(),
            found: Minimal::default(),
            effort: Effort::default(),
            in_order,
            told_apart: 0,
        })
    }

    /// Goes on until all is decided or the budget is used up. It begins by asking of every two visits whether they
    /// might be one place: quadratic in the visits, times folding.
    pub(super) fn run(&mut self, budget: &Budget<'_>) {
        if !self.has_begun() {
            if budget.steps == Some(0) || !self.tell_apart(budget.interrupted) {
                return;
            }
            self.look();
        }
        while let Some(decision) = self.agenda.last_mut() {
            let spent = budget.steps.is_some_and(|steps| self.effort.steps >= steps);
            if spent || (budget.interrupted)() {
                return;
            }
            self.quotient.undo(decision.mark);
            self.quotient.list(&decision.lists.classes);
            let hopeless = self.found.simplicity.is_some_and(|least| decision.bound > least);
            match decision.lists.ways.pop().filter(|_| !hopeless) {
                None => self.agenda.pop().into_iter().for_each(|decision| self.spare.give(decision)),
                Some((_, way)) => {
                    self.take(way);
                    self.look();
                    self.found.cut_to(budget.candidates);
                }
            }
        }
    }

    /// What was found.
    pub(super) fn found(&self) -> &Minimal {
        &self.found
    }

    /// What was done.
    pub(super) fn effort(&self) -> Effort {
        self.effort
    }

    /// Whether no simpler candidate is left to be found, nor another as simple.
    pub(super) fn is_done(&self) -> bool {
        let open = |decision: &Decision| self.found.simplicity.is_none_or(|least| decision.bound <= least);
        self.has_begun()
            && !self.agenda.iter().any(|decision| !decision.lists.ways.is_empty() && open(decision))
    }

    /// Whether anything was looked at; what there was before is in no agenda.
    fn has_begun(&self) -> bool {
        self.effort.steps > 0
    }

    /// How simple the simplest map is at best: of all that is found or left open, the least bound. None before the
    /// search has begun, and where nothing is left.
    pub(super) fn bound(&self) -> Option<Simplicity> {
        let open = self.agenda.iter().filter(|decision| !decision.lists.ways.is_empty());
        open.map(|decision| decision.bound).chain(self.found.simplicity).min()
    }

    /// Asks of every two classes, under each rotation, whether they can be one place at all; whether it came to an
    /// end, or else goes on from there.
    fn tell_apart(&mut self, interrupted: &dyn Fn() -> bool) -> bool {
        let classes: Vec<usize> = self.quotient.classes(&self.walk).collect();
        while let Some(&class) = classes.get(self.told_apart) {
            if interrupted() {
                return false;
            }
            for &onto in &classes[..self.told_apart] {
                for rotation in self.rotations(class, onto) {
                    let _ = self.probe(&[], class, onto, rotation);
                }
            }
            self.told_apart += 1;
        }
        true
    }

    /// The number of classes that are left if one lies on another; none if it cannot, which is noted.
    fn probe(&mut self, settled: &[usize], class: usize, onto: usize, rotation: usize) -> Option<usize> {
        let mark = self.quotient.mark();
        let axioms = self.experience.axioms;
        let merged = self.quotient.merge(&self.walk, class, onto, rotation, axioms);
        let left = self.quotient.count();
        let merged = match merged {
            Ok(()) if axioms.contains(AxiomId::Planarity) && !planar(&self.walk, &self.quotient, settled) => {
                Err(AxiomId::Planarity)
            }
            merged => merged,
        };
        self.quotient.undo(mark);
        match merged {
            Ok(()) => Some(left),
            Err(axiom) => {
                self.effort.refuted.count(axiom);
                self.quotient.refute(&self.walk, class, onto, rotation);
                None
            }
        }
    }

    /// The rotations by which a class might lie on another, ascending.
    fn rotations(&self, class: usize, onto: usize) -> impl Iterator<Item = usize> + use<> {
        let (kept, listed) = match self.walk.tracked(class) {
            true => (self.quotient.alike(class, onto), Vec::new()),
            false => (0, self.walk.matches(class, onto).to_vec()),
        };
        members(kept).chain(listed.into_iter().map(usize::from))
    }

    fn take(&mut self, way: Way) {
        let Some(decision) = self.agenda.last() else { return };
        match way {
            Way::New => self.quotient.settle(decision.class, &decision.lists.settled),
            Way::Merged { onto, rotation } => {
                let axioms = self.experience.axioms;
                // It was probed in this very state, so that it merges again.
                let _ = self.quotient.merge(&self.walk, decision.class, onto, rotation, axioms);
            }
        }
    }

    /// Judges the quotient, and puts the next decision on the agenda or, where there is none, keeps the candidate.
    fn look(&mut self) {
        self.effort.steps += 1;
        let mut lists = self.spare.take();
        lists.fill(&self.walk, &self.quotient);
        self.quotient.list(&lists.classes);
        let decided = self.judge(&lists).and_then(|bound| match self.next(&lists.settled, &lists.open) {
            Some(class) => Some((class, bound)),
            None => {
                self.keep();
                None
            }
        });
        match decided {
            Some((class, bound)) => self.decide(class, lists, bound),
            None => self.spare.0.push(lists),
        }
    }

    /// How simple the maps below the quotient can be at best; none if it is refuted or no simplest map is below it.
    fn judge(&mut self, lists: &Lists) -> Option<Simplicity> {
        let axioms = self.experience.axioms;
        if axioms.contains(AxiomId::Planarity) && !planar(&self.walk, &self.quotient, &lists.settled) {
            self.effort.refuted.count(AxiomId::Planarity);
            return None;
        }
        if self.in_order && !self.begins_well() {
            return None;
        }
        self.effort.made += 1;
        let least = bound(&self.walk, &self.quotient, &lists.classes, &lists.open);
        let abnormalities = (axioms.boundary() == Some(Boundary::Soft)).then_some(0);
        let bound = Simplicity { abnormalities, ..least };
        self.found.simplicity.is_none_or(|found| bound <= found).then_some(bound)
    }

    /// The class to decide: that with the fewest ways, of these the one of most visits; or the next on the walk.
    fn next(&self, settled: &[usize], open: &[usize]) -> Option<usize> {
        if self.in_order {
            let classes = (0..self.walk.len()).map(|visit| self.quotient.class(visit).0);
            return classes.into_iter().find(|&class| !self.quotient.is_settled(class));
        }
        let ways = |class: usize| -> u32 {
            settled.iter().map(|&onto| self.quotient.alike(class, onto).count_ones()).sum()
        };
        let visits = |class: usize| self.quotient.visits(class).count();
        let fewest = open.iter().map(|&class| (ways(class), class)).reduce(|best, next| {
            let better = next.0 < best.0 || next.0 == best.0 && visits(next.1) > visits(best.1);
            if better { next } else { best }
        });
        fewest.map(|(_, class)| class)
    }

    /// Puts the ways that are left for a class on the agenda: those that fold most are taken first, a new place last.
    fn decide(&mut self, class: usize, mut lists: Lists, bound: Simplicity) {
        lists.ways.clear();
        for &onto in &lists.settled {
            for rotation in self.rotations(class, onto) {
                let left = self.probe(&lists.settled, class, onto, rotation);
                lists.ways.extend(left.map(|left| (left, Way::Merged { onto, rotation })));
            }
        }
        lists.ways.sort_by_key(|&(left, _)| left);
        // A place of its own folds nothing.
        lists.ways.push((usize::MAX, Way::New));
        lists.ways.reverse();
        self.agenda.push(Decision { class, lists, mark: self.quotient.mark(), bound });
    }

    /// Whether all axioms and the operator's word allow the decided beginning of the walk.
    fn begins_well(&mut self) -> bool {
        let beginning = self.assignments();
        let Experience { visits, evidence, axioms, word } = self.experience.as_ref();
        match judge(visits, evidence.as_deref(), *axioms, &beginning) {
            Err(refutation) => self.effort.refuted.count(refutation.axiom),
            Ok(_) if !word.allows(&beginning) => self.effort.refuted.count_operator(1),
            Ok(_) => return true,
        }
        false
    }

    /// Keeps the candidate that the quotient is, all decided, if no simpler one is known.
    fn keep(&mut self) {
        let assignments = self.assignments();
        let Experience { visits, evidence, axioms, .. } = self.experience.as_ref();
        match judge(visits, evidence.as_deref(), *axioms, &assignments) {
            Err(refutation) => self.effort.refuted.count(refutation.axiom),
            Ok(candidate) => {
                let simplicity = candidate.map(|candidate| candidate.simplicity(*axioms));
                simplicity.into_iter().for_each(|simplicity| self.found.keep(simplicity, &assignments));
            }
        }
    }

    /// What the visits are taken for, up to the first that is not decided. Places are numbered by first visit, and
    /// rotations are onto the star of the first visit.
    fn assignments(&self) -> Vec<Assignment> {
        let mut firsts: Vec<(usize, usize)> = Vec::new();
        let assign = |visit: usize| {
            let (class, turn) = self.quotient.class(visit);
            let number = firsts.iter().position(|&(first, _)| first == class).unwrap_or_else(|| {
                firsts.push((class, turn));
                firsts.len() - 1
            });
            let size = self.walk.size(visit);
            let rotation = ((turn + size - firsts[number].1) % size) as u8;
            // None: there are no more places than visits, and these have a limit.
            PlaceId::new(number).map(|place| Assignment { place, rotation })
        };
        let decided = |&visit: &usize| self.quotient.is_settled(self.quotient.class(visit).0);
        (0..self.walk.len()).take_while(decided).filter_map(assign).collect()
    }
}

impl Lists {
    fn fill(&mut self, walk: &Walk, quotient: &Quotient) {
        let Lists { classes, settled, open, ways: _ } = self;
        [&mut *classes, &mut *settled, &mut *open].into_iter().for_each(Vec::clear);
        for class in quotient.classes(walk) {
            classes.push(class);
            if quotient.is_settled(class) { &mut *settled } else { &mut *open }.push(class);
        }
    }
}

impl Spare {
    fn take(&mut self) -> Lists {
        self.0.pop().unwrap_or_default()
    }

    fn give(&mut self, decision: Decision) {
        self.0.push(decision.lists);
    }
}

impl Minimal {
    fn keep(&mut self, simplicity: Simplicity, assignments: &[Assignment]) {
        if self.simplicity.is_none_or(|least| simplicity < least) {
            *self = Minimal { simplicity: Some(simplicity), ..Minimal::default() };
        }
        if self.simplicity == Some(simplicity) {
            self.candidates.push(assignments.to_vec());
        }
    }

    fn cut_to(&mut self, limit: Option<usize>) {
        let limit = limit.unwrap_or(usize::MAX);
        self.cut |= self.candidates.len() > limit;
        self.candidates.truncate(limit);
    }
}
