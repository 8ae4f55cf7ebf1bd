//! The simplest maps, without all the others.
//!
//! A search over *which visits are one place*, depth first with the most promising decision first, under a bound:
//! branch and bound (Land and Doig 1960). It differs from the breadth-first search in what it extends: not a map by
//! the next observation, but the whole walk by one more decision about one class of visits, and all that
//! follows from it (`Quotient`). So the class with the fewest ways left is decided first, whenever it was visited (the fail-first
//! principle, Haralick and Elliott 1980), and a wrong closure falls when it is made and not when the robot comes by again.
//! The idea is that of learning the smallest automaton from a trace by merging states and folding (Lang, Pearlmutter and Price
//! 1998); the clique bound is that of Heule and Verwer 2010. After each decision what is settled rules out more of the
//! rest ([`Location`]). It looks at maps of few paths first, in rounds ([`Round`]).
//!
//! Axioms that folding does not know (boundaries, measurements, the operator's word) are judged by the registry, on the
//! beginning of the walk that is decided; the walk is then decided in its order. Every map found is judged by the
//! registry from its first observation on, so that folding can only ever save work.

mod agenda;
mod bound;
mod faces;
mod ground;
mod location;
mod minimal;
mod quotient;
mod rotations;
mod round;
mod trailed;
mod walk;

use crate::abduction::{
    Assignment, Axiom, AxiomId, AxiomSet, Boundary, Evidence, Refutations, Simplicity, Visit, Word, judge,
};
use crate::map::PlaceId;
use agenda::{Decision, Lists, Spare, Way};
use bound::{Bounds, bounds};
use faces::Faces;
use ground::Ground;
use location::Location;
use minimal::Minimal;
use round::Round;
use std::sync::Arc;

/// The axioms that folding keeps by itself, `planarity` on what is settled among them.
const FOLDED: [AxiomId; 5] =
    [AxiomId::Determinism, AxiomId::StarMatch, AxiomId::TravelMoves, AxiomId::PathOrder, AxiomId::Planarity];

/// The most steps to each visit of the first round.
const DIVE: u64 = 16;

/// A search for the simplest maps of one experience. It can stop at any time and go on later, and what it knows of a
/// walk serves when the walk goes on.
#[derive(Clone, Debug)]
pub(super) struct BestFirst {
    experience: Experience,
    ground: Ground,
    round: Round,
    state: State,
    agenda: Vec<Decision>,
    spare: Spare,
    faces: Faces,
    location: Location,
    found: Minimal,
    effort: Effort,
    /// Whether the walk is decided in its order, as some axioms are judged on its beginning.
    in_order: bool,
}

/// What is to be explained, and under which laws.
#[derive(Clone, Debug)]
pub(super) struct Experience {
    pub(super) visits: Vec<Arc<Visit>>,
    pub(super) evidence: Option<Arc<dyn Evidence>>,
    pub(super) axioms: AxiomSet,
    pub(super) word: Word,
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
    /// The most bytes held.
    pub(super) memory: Option<usize>,
    /// Asked now and then.
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

/// Where a search is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Nothing of the round was looked at.
    Ready,
    Running,
    Done,
}

impl BestFirst {
    /// A search that has not begun.
    pub(super) fn new(experience: Experience) -> BestFirst {
        let in_order = experience.in_order();
        BestFirst {
            experience,
            ground: Ground::default(),
            round: Round::default(),
            state: State::Ready,
            agenda: Vec::new(),
            spare: Spare::default(),
            faces: Faces::default(),
            location: Location::default(),
            found: Minimal::default(),
            effort: Effort::default(),
            in_order,
        }
    }

    /// A search that has not begun, of an experience that begins with this one's visits under the same axioms, but for
    /// measured ones. What is known of the walk stays.
    pub(super) fn go_on_to(&mut self, experience: Experience) {
        self.begin(Round::default());
        self.in_order = experience.in_order();
        (self.experience, self.found, self.effort) = (experience, Minimal::default(), Effort::default());
    }

    /// Goes on until all is decided or the budget is used up. Memory is quadratic in the visits, and so is what comes
    /// first: asking of every visit that is new, and each one before, whether they might be one place.
    pub(super) fn run(&mut self, budget: &Budget<'_>) {
        while !self.conclude() {
            let spent = budget.steps.is_some_and(|steps| self.effort.steps >= steps);
            if spent || (budget.interrupted)() || self.is_too_big(budget.memory) {
                return;
            }
            match self.experience.visits.get(self.ground.walk.len()) {
                Some(visit) => self.ground.push(visit, self.experience.axioms),
                None => self.step(budget.candidates),
            }
        }
    }

    /// What was found.
    pub(super) fn found(&self) -> &Minimal {
        &self.found
    }

    /// What was done.
    pub(super) fn effort(&self) -> Effort {
        let refuted = match self.ground.broken {
            Some(axiom) => Refutations::of(axiom),
            None => [self.ground.refuted, self.effort.refuted].into_iter().sum(),
        };
        Effort { refuted, ..self.effort }
    }

    /// Whether no simpler candidate is left to be found, nor another as simple.
    pub(super) fn is_done(&self) -> bool {
        self.state == State::Done
    }

    /// How simple the simplest map is at best: of all that is found or left open, the least bound. None as long as
    /// nothing is known, and where nothing is left.
    pub(super) fn bound(&self) -> Option<Simplicity> {
        let open = self.agenda.iter().filter(|decision| !decision.lists.ways.is_empty());
        let open = open.map(|decision| decision.bound).min();
        let ahead = match self.state {
            State::Ready => self.round.floor(),
            State::Running => self.round.least(open),
            State::Done => None,
        };
        ahead.into_iter().chain(self.found.simplicity()).min()
    }

    /// Whether it holds, or is about to hold, more bytes than it may: tables, decisions and what it takes to undo them, and
    /// the candidates found.
    pub(super) fn is_too_big(&self, memory: Option<usize>) -> bool {
        memory.is_some_and(|most| self.bytes() > most)
    }

    fn bytes(&self) -> usize {
        let decisions: usize = self.agenda.iter().map(|decision| decision.lists.bytes()).sum();
        let more = self.experience.visits.len() > self.ground.walk.len();
        let next = if more { self.ground.bytes_of_next() } else { 0 };
        self.ground.bytes() + next + decisions + self.found.bytes(self.ground.walk.dstates())
    }

    /// Comes to an end of what there is to do without a step; whether that is the end of the search.
    fn conclude(&mut self) -> bool {
        if self.ground.broken.is_some() {
            self.state = State::Done;
        }
        while let Some(last) = self.agenda.last()
            && (last.lists.ways.is_empty() || !self.found.allows(last.bound))
        {
            self.agenda.pop().into_iter().for_each(|decision| self.spare.give(decision.lists));
        }
        if self.state == State::Running && self.agenda.is_empty() {
            match self.round.next(&self.found, self.effort.steps) {
                Some(round) => self.begin(round),
                None => self.state = State::Done,
            }
        }
        self.state == State::Done
    }

    fn begin(&mut self, round: Round) {
        self.ground.reset();
        self.agenda.drain(..).for_each(|decision| self.spare.give(decision.lists));
        (self.round, self.state) = (round, State::Ready);
    }

    fn step(&mut self, candidates: Option<usize>) {
        self.effort.steps += 1;
        if let Some(decision) = self.agenda.last_mut() {
            self.ground.quotient.undo(decision.mark);
            self.ground.quotient.list(&decision.lists.classes);
            if let Some((_, way)) = decision.lists.ways.pop() {
                self.take(way);
            }
        }
        self.state = State::Running;
        self.look(candidates);
        self.end_dive();
    }

    /// The first round has no limit; it is to find some map that is not bad, and all if that is quick.
    fn end_dive(&mut self) {
        let most = DIVE * self.experience.visits.len() as u64;
        if self.round.is_unlimited()
            && self.effort.steps >= most
            && let Some(root) = self.agenda.first()
        {
            self.begin(Round::after_dive(root.bound, self.effort.steps));
        }
    }

    fn take(&mut self, way: Way) {
        let (Some(decision), Ground { walk, quotient, .. }) = (self.agenda.last(), &mut self.ground) else {
            return;
        };
        match way {
            Way::New => quotient.settle(decision.class, &decision.lists.settled),
            Way::Merged { onto, rotation } => {
                let axioms = self.experience.axioms;
                // It was probed in this very state, so that it merges again.
                let _ = quotient.merge(walk, decision.class, onto, rotation, axioms);
            }
        }
    }

    /// Judges the quotient, and puts the next decision on the agenda or, where there is none, keeps the candidate.
    fn look(&mut self, candidates: Option<usize>) {
        let mut lists = self.spare.take();
        lists.fill(&self.ground.walk, &self.ground.quotient);
        self.ground.quotient.list(&lists.classes);
        match self.judge(&lists) {
            None => self.spare.give(lists),
            Some(bound) => match self.next(&lists.settled, &lists.open) {
                Some(class) => self.decide(class, lists, bound),
                None => {
                    self.keep(candidates);
                    self.spare.give(lists);
                }
            },
        }
    }

    /// How simple the maps below the quotient can be at best; none if it is refuted or no map below it is looked for.
    fn judge(&mut self, lists: &Lists) -> Option<Simplicity> {
        let Ground { walk, quotient, .. } = &self.ground;
        let axioms = self.experience.axioms;
        let bounds = bounds(walk, quotient, lists, axioms.boundary() == Some(Boundary::Soft));
        if !self.round.admits(bounds.least(), &self.found) {
            return None;
        }
        let planar = axioms.contains(AxiomId::Planarity);
        if planar && !self.faces.planar(walk, quotient, &lists.settled) {
            self.effort.refuted.count(AxiomId::Planarity);
            return None;
        }
        if !self.narrow(lists, &bounds) || (self.in_order && !self.begins_well()) {
            return None;
        }
        self.effort.made += 1;
        Some(bounds.least())
    }

    /// Rules out what cannot be; whether every class can still be somewhere.
    fn narrow(&mut self, lists: &Lists, bounds: &Bounds) -> bool {
        let Ground { walk, quotient, .. } = &mut self.ground;
        let faces = self.experience.axioms.contains(AxiomId::Planarity).then_some(&self.faces);
        let (round, found) = (&mut self.round, &self.found);
        let mut may_be_new = |class: usize| round.admits(bounds.with_new(walk, class), found);
        match self.location.narrow(walk, quotient, faces, &mut may_be_new, [&lists.settled, &lists.open]) {
            Ok(()) => true,
            Err(axiom) => {
                axiom.into_iter().for_each(|axiom| self.effort.refuted.count(axiom));
                false
            }
        }
    }

    /// The class to decide: that with the fewest ways, of these the one of most visits; or the next on the walk.
    fn next(&self, settled: &[usize], open: &[usize]) -> Option<usize> {
        let Ground { walk, quotient, .. } = &self.ground;
        if self.in_order {
            let classes = (0..walk.len()).map(|visit| quotient.class(visit).0);
            return classes.into_iter().find(|&class| !quotient.is_settled(class));
        }
        let ways = |class: usize| -> u32 {
            let on = settled.iter().map(|&onto| quotient.alike(class, onto).count_ones());
            u32::from(self.location.can_be_new(class)) + on.sum::<u32>()
        };
        let visits = |class: usize| quotient.visits(class).count();
        let fewest = open.iter().map(|&class| (ways(class), class)).reduce(|best, next| {
            let better = next.0 < best.0 || next.0 == best.0 && visits(next.1) > visits(best.1);
            if better { next } else { best }
        });
        fewest.map(|(_, class)| class)
    }

    /// Puts the ways that are left for a class on the agenda: those that fold most are taken first, a new place last.
    fn decide(&mut self, class: usize, mut lists: Lists, bound: Simplicity) {
        for &onto in &lists.settled {
            for rotation in self.ground.rotations(class, onto) {
                let left = self.probe([class, onto, rotation], &lists.settled);
                lists.ways.extend(left.map(|left| (left, Way::Merged { onto, rotation })));
            }
        }
        lists.ways.sort_by_key(|&(left, _)| left);
        // A place of its own folds nothing.
        lists.ways.extend(self.location.can_be_new(class).then_some((usize::MAX, Way::New)));
        lists.ways.reverse();
        self.agenda.push(Decision { class, lists, mark: self.ground.quotient.mark(), bound });
    }

    fn probe(&mut self, merge: [usize; 3], settled: &[usize]) -> Option<usize> {
        let (axioms, faces) = (self.experience.axioms, &mut self.faces);
        self.ground.probe(merge, axioms, &mut self.effort.refuted, |walk, quotient| {
            match axioms.contains(AxiomId::Planarity) && !faces.planar(walk, quotient, settled) {
                true => Err(AxiomId::Planarity),
                false => Ok(()),
            }
        })
    }

    /// Whether all axioms and the operator's word allow the decided beginning of the walk.
    fn begins_well(&mut self) -> bool {
        let beginning = self.assignments();
        let Experience { visits, evidence, axioms, word } = &self.experience;
        match judge(visits, evidence.as_deref(), *axioms, &beginning) {
            Err(refutation) => self.effort.refuted.count(refutation.axiom),
            Ok(_) if !word.allows(&beginning) => self.effort.refuted.count_operator(1),
            Ok(_) => return true,
        }
        false
    }

    /// Keeps the candidate that the quotient is, all decided, if no simpler one is known.
    fn keep(&mut self, limit: Option<usize>) {
        let assignments = self.assignments();
        let Experience { visits, evidence, axioms, .. } = &self.experience;
        match judge(visits, evidence.as_deref(), *axioms, &assignments) {
            Err(refutation) => self.effort.refuted.count(refutation.axiom),
            Ok(None) => {}
            Ok(Some(candidate)) => self.found.keep(candidate.simplicity(*axioms), assignments, limit),
        }
    }

    /// What the visits are taken for, up to the first that is not decided. Places are numbered by first visit, and
    /// rotations are onto the star of the first visit.
    fn assignments(&self) -> Vec<Assignment> {
        let Ground { walk, quotient, .. } = &self.ground;
        let mut firsts: Vec<(usize, usize)> = Vec::new();
        let assign = |visit: usize| {
            let (class, turn) = quotient.class(visit);
            let number = firsts.iter().position(|&(first, _)| first == class).unwrap_or_else(|| {
                firsts.push((class, turn));
                firsts.len() - 1
            });
            let size = walk.size(visit);
            let rotation = ((turn + size - firsts[number].1) % size) as u8;
            // None: there are no more places than visits, and these have a limit.
            PlaceId::new(number).map(|place| Assignment { place, rotation })
        };
        let decided = |&visit: &usize| quotient.is_settled(quotient.class(visit).0);
        (0..walk.len()).take_while(decided).filter_map(assign).collect()
    }
}

impl Experience {
    /// Whether axioms are held, or was said what, folding does not know.
    fn in_order(&self) -> bool {
        let known = |axiom: &Axiom| FOLDED.contains(&axiom.id);
        !self.word.is_empty() || !self.axioms.iter().all(known)
    }
}
