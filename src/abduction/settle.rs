//! The strategy that finds the simplest candidates alone.

use crate::abduction::best_first::{BestFirst, Budget, Experience};
use crate::abduction::{Abduction, Assignment, AxiomSet, Evidence, Limits, Refutations, Simplicity};
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

    /// Looks for the simplest candidates, until they are proven to be that, the limit on steps is reached, or
    /// `interrupted` says so; goes on from there when asked again. What was found by then is what the abduction
    /// holds. An abduction that is exhaustive holds all there is at any time.
    ///
    /// Exponential in the worst case; every partial explanation costs time linear in observations and dstates.
    pub fn settle(&mut self, interrupted: &dyn Fn() -> bool) {
        if self.strategy == Strategy::BreadthFirst || self.visits.is_empty() {
            return;
        }
        if self.minimum.is_none() {
            self.minimum = Some(Arc::new(self.search()));
        }
        let Some(Ok(search)) = self.minimum.as_mut().map(Arc::make_mut) else { return };
        let limits = self.limits;
        search.run(&Budget { steps: limits.max_steps, candidates: limits.max_candidates, interrupted });
        let effort = search.effort();
        let found = search.found().candidates.clone();
        self.hold(&found);
        (self.maps_created, self.refuted) = (effort.made, vec![effort.refuted]);
    }

    /// How far [`Abduction::settle`] has come; none under the other strategy, or before.
    pub fn settlement(&self) -> Option<Settlement> {
        let search = self.minimum.as_deref()?;
        Some(match search {
            Err(_) => Settlement { steps: 0, proven: true, bound: None },
            Ok(search) => Settlement {
                steps: search.effort().steps,
                proven: search.is_done() && !search.found().cut,
                bound: search.bound(),
            },
        })
    }

    fn search(&mut self) -> Result<BestFirst, Refutations> {
        let evidence: Option<Arc<dyn Evidence>> = self.evidence.clone();
        let (visits, axioms, word) = (self.visits.clone(), self.axioms(), self.word.clone());
        let search = BestFirst::new(Experience { visits, evidence, axioms, word });
        search.map_err(|axiom| {
            let mut refuted = Refutations::default();
            refuted.count(axiom);
            self.refuted = vec![refuted];
            refuted
        })
    }

    /// Holds exactly the candidates with these assignments of all observations, in their order: those that an exhaustive
    /// search finds if it is led to them.
    fn hold(&mut self, candidates: &[Vec<Assignment>]) {
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
}
