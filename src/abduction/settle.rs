//! The strategy that finds the simplest candidates alone.

use crate::abduction::best_first::{BestFirst, Budget, Experience};
use crate::abduction::{Abduction, Assignment, AxiomSet, Evidence, Limits, Simplicity, StopReason};
use std::collections::BTreeSet;
use std::sync::Arc;

/// How candidates are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// All candidates, one observation after the other: exhaustive.
    #[default]
    BreadthFirst,
    /// The simplest candidates alone, all that are equally simple, and the proof that none is simpler. Nothing is
    /// searched before [`Abduction::settle`].
    BestFirst,
}

/// How far a search for the simplest candidates has come. Nothing in it depends on the machine but, where it was
/// interrupted, when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settlement {
    /// Partial explanations looked at.
    pub steps: u64,
    /// Whether no candidate is simpler than those found, and none as simple is missing.
    pub proven: bool,
    /// No candidate is simpler than this, found or not; none as long as nothing is known.
    pub bound: Option<Simplicity>,
    /// Why it ended; that nothing explains the experience counts as a minimum proven.
    pub stop_reason: StopReason,
}

/// A search for the simplest candidates, and whether it is of all that is observed and said.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    search: Arc<BestFirst>,
    up_to_date: bool,
}

impl Abduction {
    /// The most observations of a search for the simplest candidates alone. It keeps eight bytes for each two of them,
    /// 32 MiB in all, and asks of each two whether they might be one place.
    pub const MOST_SETTLED: usize = 2_048;

    /// An abduction that has seen nothing, and will look for the simplest candidates alone. Of candidates that are
    /// equally simple it keeps as many as the limits allow; memory is that of these, and quadratic in the
    /// observations, which are therefore at most [`Abduction::MOST_SETTLED`].
    pub fn best_first(axioms: AxiomSet, limits: Limits) -> Abduction {
        let mut abduction = Abduction::new(axioms, limits);
        abduction.strategy = Strategy::BestFirst;
        abduction
    }

    /// How candidates are searched.
    pub fn strategy(&self) -> Strategy {
        self.strategy
    }

    /// Sets the most partial explanations that a search for the simplest candidates looks at, from now on.
    pub fn limit_steps(&mut self, most: u64) {
        self.limits.max_steps = Some(most);
    }

    /// Looks for the simplest candidates, until they are proven to be that, the limit on steps is reached, or
    /// `interrupted` says so; goes on from there when asked again. What was found by then is what the abduction
    /// holds. An abduction that is exhaustive holds all there is at any time.
    ///
    /// Exponential in the worst case; every partial explanation costs time linear in observations and dstates.
    pub fn settle(&mut self, interrupted: &dyn Fn() -> bool) {
        if self.strategy == Strategy::BreadthFirst || self.visits.is_empty() {
            return;
        }
        let mut search = self.search();
        let Limits { max_steps: steps, max_candidates: candidates, max_memory: memory } = self.limits;
        Arc::make_mut(&mut search).run(&Budget { steps, candidates, memory, interrupted });
        let (effort, found) = (search.effort(), search.found());
        (self.maps_created, self.refuted) = (effort.made, vec![effort.refuted]);
        let proven = search.is_done() && !found.is_cut();
        let stop_reason = self.end_of(&search);
        self.settlement =
            Some(Settlement { steps: effort.steps, proven, bound: search.bound(), stop_reason });
        self.hold(found.candidates());
        self.minimum = Some(Minimum { search, up_to_date: true });
    }

    /// How far [`Abduction::settle`] has come; none under the other strategy, or before.
    pub fn settlement(&self) -> Option<Settlement> {
        self.settlement
    }

    /// This abduction for readers: without what it takes to go on settling, which may be far more than the candidates.
    /// Settling it begins from nothing.
    #[must_use]
    pub fn for_readers(&self) -> Abduction {
        let mut shown = self.clone();
        shown.minimum = None;
        shown
    }

    /// Holds nothing until it is settled anew. What the search knows of the walk stays.
    pub(super) fn unsettle(&mut self) {
        (self.tree, self.maps, self.settlement) = Default::default();
        (self.maps_created, self.refuted) = (0, Vec::new());
        self.minimum.iter_mut().for_each(|minimum| minimum.up_to_date = false);
    }

    /// The search of all that is observed and said, as far as it has come.
    fn search(&mut self) -> Arc<BestFirst> {
        let evidence: Option<Arc<dyn Evidence>> = self.evidence.clone();
        let (visits, axioms, word) = (self.visits.clone(), self.axioms(), self.word.clone());
        let experience = Experience { visits, evidence, axioms, word };
        match self.minimum.take() {
            None => Arc::new(BestFirst::new(experience)),
            Some(Minimum { search, up_to_date: true }) => search,
            Some(Minimum { mut search, up_to_date: false }) => {
                Arc::make_mut(&mut search).go_on_to(experience);
                search
            }
        }
    }

    fn end_of(&self, search: &BestFirst) -> StopReason {
        let observation = self.visits.len() - 1;
        let spent = |most: u64| search.effort().steps >= most;
        match search.is_done() {
            true if search.found().is_cut() => StopReason::CandidateLimit { observation },
            true => StopReason::MinimumProven,
            false if search.is_too_big(self.limits.max_memory) => StopReason::MemoryLimit { observation },
            false if self.limits.max_steps.is_some_and(spent) => StopReason::StepLimit,
            false => StopReason::Interrupted,
        }
    }

    /// Holds exactly the candidates with these assignments of all observations, in their order: those that an exhaustive
    /// search finds if it is led to them.
    fn hold(&mut self, candidates: &BTreeSet<Vec<Assignment>>) {
        if self.holds(candidates) {
            return;
        }
        let mut led = Abduction::new(self.axioms, Limits::default());
        for (visit, length) in self.visits.iter().zip(1..) {
            // It was taken before, by the same rules.
            let _ = led.observe_measured(visit, self.evidence.clone());
            let beginnings: BTreeSet<&[Assignment]> =
                candidates.iter().map(|whole| &whole[..length]).collect();
            let keep: Vec<bool> = (0..led.len())
                .map(|leaf| beginnings.contains(led.tree.assignments(leaf).as_slice()))
                .collect();
            led.retain(&keep);
        }
        (self.tree, self.maps, self.stars) = (led.tree, led.maps, led.stars);
    }

    /// Whether it holds exactly these candidates.
    fn holds(&self, candidates: &BTreeSet<Vec<Assignment>>) -> bool {
        let known = |(leaf, candidate): (usize, &Vec<Assignment>)| self.tree.assignments(leaf) == *candidate;
        self.tree.depth() == self.visits.len()
            && self.len() == candidates.len()
            && candidates.iter().enumerate().all(known)
    }
}
