//! The search. Breadth-first it is exhaustive unless a limit cuts it; for the other strategy see [`Abduction::settle`].

use crate::abduction::candidate::{Assignment, Candidate};
use crate::abduction::children::{Extension, Seen, turned};
use crate::abduction::kept::{Kept, retain};
use crate::abduction::leaves::{BATCH, LeafMaps};
use crate::abduction::settle::Minimum;
use crate::abduction::tree::{Node, Tree};
use crate::abduction::{
    Assertion, AxiomSet, Count, Evidence, Extinction, Learned, Refutations, Report, Settlement, Simplicity,
    StopReason, Strategy, Visit, VisitError, Word, WordError,
};
use crate::map::{Atlas, DstateId, PlaceId, StarTable, TopologicalMap};
use crate::star::SlotIndex;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use std::ops::Range;
use std::sync::Arc;

/// All candidates that explain the observations so far (seed, section 3.3, exhaustive breadth-first search).
///
/// An observation extends the candidates; it recomputes none. Candidates are in the order of their assignments,
/// which is also that of breadth-first generation. A clone shares everything and is a snapshot: its cost is that
/// of one pointer per observation. Time and memory are exponential in the travels in the worst case (seed,
/// section 4.4).
#[derive(Clone, Debug)]
pub struct Abduction {
    pub(super) axioms: AxiomSet,
    pub(super) strategy: Strategy,
    pub(super) limits: Limits,
    pub(super) stars: Arc<StarTable>,
    pub(super) evidence: Option<Arc<dyn Evidence>>,
    pub(super) visits: Vec<Arc<Visit>>,
    pub(super) word: Word,
    pub(super) tree: Tree,
    pub(super) maps: LeafMaps,
    /// What evidence learned of each leaf; nothing where it has judged none.
    learned: Arc<Vec<Learned>>,
    pub(super) maps_created: u64,
    /// By observation; of all together under the strategy that does not go by observations.
    pub(super) refuted: Vec<Refutations>,
    /// The search for the simplest candidates, once it was asked for.
    pub(super) minimum: Option<Minimum>,
    pub(super) settlement: Option<Settlement>,
    first_cut: Option<StopReason>,
    /// The most places of a candidate; zero unless the number of candidates is limited.
    most_places: usize,
    /// The bytes that what evidence learned takes of each candidate, on the mean; zero unless memory is limited.
    bytes_learned: usize,
}

/// Batches whose children are in memory before they come together and are cut to the limit.
const WAVE: usize = 64;

/// While candidates are extended there are as many children as candidates, or twice as many before they are cut.
const GATHERED: usize = 3;
/// Of a map: a dstate's far end, its opposite, and its share of what describes its place.
pub(super) const BYTES_OF_DSTATE: usize = 8;

/// What a search may use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// The most candidates kept after an observation: the simplest, and of equally simple ones the first by visits.
    pub max_candidates: Option<usize>,
    /// The most partial explanations that a search for the simplest candidates looks at.
    pub max_steps: Option<u64>,
    /// The most bytes that the search may hold, beside the observations; counted as if candidates shared no memory but
    /// what evidence has learned of them ([`Learned`]), which is that of the observation before.
    /// Breadth-first it keeps the simplest candidates that fit, the next ones beside them; best-first it stops.
    pub max_memory: Option<usize>,
}

impl Abduction {
    /// An abduction that has seen nothing.
    pub fn new(axioms: AxiomSet, limits: Limits) -> Self {
        Abduction {
            axioms,
            strategy: Strategy::BreadthFirst,
            limits,
            stars: Arc::default(),
            evidence: None,
            visits: Vec::new(),
            word: Word::default(),
            tree: Tree::default(),
            maps: LeafMaps::default(),
            learned: Arc::default(),
            maps_created: 0,
            refuted: Vec::new(),
            minimum: None,
            settlement: None,
            first_cut: None,
            most_places: 0,
            bytes_learned: 0,
        }
    }

    /// The axioms it holds. Those that speak of measurements count among them only where there are some.
    pub fn axioms(&self) -> AxiomSet {
        if self.evidence.is_some() { self.axioms } else { self.axioms.without_measured() }
    }

    /// Extends the candidates by one observation. After an error all is as before.
    pub fn observe(&mut self, visit: &Visit) -> Result<(), VisitError> {
        self.observe_measured(visit, None)
    }

    /// Extends the candidates by one observation, of which, as of all before it, this was measured. Once
    /// measurements have been given, each later observation gives some. After an error all is as before.
    pub fn observe_measured(
        &mut self,
        visit: &Visit,
        evidence: Option<Arc<dyn Evidence>>,
    ) -> Result<(), VisitError> {
        visit.check(self.visits.last().map(|visit| &visit.star))?;
        if self.visits.len() == PlaceId::LIMIT {
            return Err(VisitError::TooMany);
        }
        if self.strategy == Strategy::BestFirst && self.visits.len() == Abduction::MOST_SETTLED {
            return Err(VisitError::TooManyToSettle);
        }
        let star = self.stars.intern(&visit.star).ok_or(VisitError::TooMany)?;
        self.stars = Arc::clone(&star.table);
        self.evidence = evidence;
        match visit.departure {
            _ if self.strategy == Strategy::BestFirst => self.unsettle(),
            None => {
                let assignment = Assignment { place: PlaceId::FIRST, rotation: 0 };
                let (map, mut kept) = (TopologicalMap::first(&star), self.no_children());
                let simplicity = || Simplicity::of(&map, self.axioms);
                kept.push(Node { parent: 0, assignment }, true, simplicity, Learned::default);
                self.keep(kept, Refutations::default(), LeafMaps::first(&map));
            }
            Some(departure) => self.extend(Seen::new(visit, departure, star)),
        }
        self.visits.push(Arc::new(visit.clone()));
        Ok(())
    }

    /// Takes the operator's word: refutes, of the candidates of the latest observation, those that it does not
    /// allow, and so all that would come of them. After an error all is as before. Linear in candidates and
    /// observations.
    pub fn assert(&mut self, assertion: Assertion) -> Result<(), WordError> {
        self.word.check(&assertion, self.observations())?;
        self.word.add(assertion);
        if self.strategy == Strategy::BestFirst {
            self.unsettle();
            return Ok(());
        }
        let allowed = |leaf: usize| assertion.allows(&self.tree.assignments(leaf));
        let keep: Vec<bool> = (0..self.len()).map(allowed).collect();
        let refuted = keep.iter().filter(|&&keep| !keep).count();
        if refuted > 0 {
            self.retain(&keep);
            if let Some(latest) = self.refuted.last_mut() {
                latest.count_operator(refuted as u64);
            }
        }
        Ok(())
    }

    /// What the operator said.
    pub fn word(&self) -> &Word {
        &self.word
    }

    /// What was observed.
    pub fn visits(&self) -> &[Arc<Visit>] {
        &self.visits
    }

    /// What was measured, if anything was.
    pub fn evidence(&self) -> Option<&dyn Evidence> {
        self.evidence.as_deref()
    }

    /// The number of observations.
    pub fn observations(&self) -> usize {
        self.visits.len()
    }

    /// The number of candidates kept.
    pub fn len(&self) -> usize {
        self.tree.leaves().len()
    }

    /// Whether no candidate is kept.
    pub fn is_empty(&self) -> bool {
        self.tree.leaves().is_empty()
    }

    /// Whether every candidate there is was kept.
    pub fn is_complete(&self) -> bool {
        match self.settlement() {
            Some(settlement) => settlement.proven && self.is_empty(),
            None => self.strategy == Strategy::BreadthFirst && self.first_cut.is_none(),
        }
    }

    /// The candidate at a position in the order of assignments. Linear in the observations and the dstates.
    pub fn candidate(&self, index: usize) -> Option<Candidate> {
        (index < self.len()).then(|| self.candidate_in(index, &mut self.blank()))
    }

    /// All candidates, in the order of their assignments.
    pub fn candidates(&self) -> impl Iterator<Item = Candidate> {
        let mut map = self.blank();
        (0..self.len()).map(move |index| self.candidate_in(index, &mut map))
    }

    /// The positions of the simplest candidates, all that are equally simple.
    pub fn minimal(&self) -> Vec<usize> {
        let mut map = self.blank();
        let simplicity = |leaf| self.maps.simplicity(&self.tree, leaf, self.axioms, &mut map);
        let all: Vec<Simplicity> = (0..self.len()).map(simplicity).collect();
        let least = all.iter().min();
        (0..self.len()).filter(|&index| Some(&all[index]) == least).collect()
    }

    /// What is found so far. Linear in candidates and observations.
    pub fn report(&self) -> Report {
        let exact_at = |observation: usize| {
            self.first_cut.and_then(StopReason::observation).is_none_or(|cut| observation < cut)
        };
        let complete = self.is_complete();
        let settlement = self.settlement();
        let proven = settlement.map_or(complete, |settlement| settlement.proven);
        let exact_at = |observation: usize| exact_at(observation) && self.strategy == Strategy::BreadthFirst;
        let minimal: Vec<Candidate> =
            self.minimal().into_iter().filter_map(|index| self.candidate(index)).collect();
        let widths = self.tree.widths().enumerate();
        Report {
            candidates: Count::new(self.len() as u64, complete),
            candidates_per_observation: widths
                .map(|(observation, width)| Count::new(width as u64, exact_at(observation)))
                .collect(),
            maps_created: Count::new(self.maps_created, complete),
            refuted: self.refuted.iter().copied().sum(),
            refuted_per_observation: self.refuted.clone(),
            simplicity: minimal.first().map(|candidate| candidate.simplicity(self.axioms)),
            unique: proven && minimal.len() == 1,
            minimal,
            proven,
            strategy: self.strategy,
            settlement,
            asked: self.axioms,
            in_force: self.axioms(),
            complete,
            stop_reason: self.stop_reason(),
            word: self.word.clone(),
            extinction: self.extinction(),
        }
    }

    /// Drops the leaves that are not to be kept.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        self.tree.prune(keep);
        retain(Arc::make_mut(&mut self.learned), keep);
    }

    /// Extends all candidates, on all cores. Each batch of them is extended by one thread, and the batches' children
    /// come together in the order of the batches, so that nothing depends on the number of threads.
    fn extend(&mut self, seen: Seen) {
        let mut kept = self.no_children();
        let mut refuted = Refutations::default();
        let mut maps = Vec::new();
        let batches: Vec<Range<usize>> =
            (0..self.len()).step_by(BATCH).map(|start| start..self.len().min(start + BATCH)).collect();
        for wave in batches.chunks(WAVE) {
            let extended: Vec<(Atlas, Kept, Refutations)> =
                wave.par_iter().map(|parents| self.extend_batch(&seen, parents.clone())).collect();
            for (parents, children, counts) in extended {
                maps.push(parents);
                kept.append(children);
                refuted = [refuted, counts].into_iter().sum();
            }
        }
        self.keep(kept, refuted, LeafMaps::new(maps, seen));
    }

    fn keep(&mut self, kept: Kept, refuted: Refutations, maps: LeafMaps) {
        let observation = self.tree.depth();
        self.maps_created += kept.made;
        self.most_places = kept.most_places();
        let (nodes, learned, cut) = kept.finish();
        if cut {
            let reason = match self.most_candidates() == self.limits.max_candidates {
                true => StopReason::CandidateLimit { observation },
                false => StopReason::MemoryLimit { observation },
            };
            self.first_cut = self.first_cut.or(Some(reason));
        }
        self.tree.push(nodes);
        self.maps = maps;
        let limited = self.limits.max_memory.is_some();
        self.bytes_learned =
            if limited { Learned::bytes(&learned).div_ceil(learned.len().max(1)) } else { 0 };
        self.learned = Arc::new(learned);
        self.refuted.push(refuted);
    }

    /// The children of some candidates, and the maps of those that have any.
    fn extend_batch(&self, seen: &Seen, parents: Range<usize>) -> (Atlas, Kept, Refutations) {
        let mut extension = Extension::new(seen, self.axioms(), self.evidence.as_deref(), self.no_children());
        let (mut maps, mut map) = (Atlas::with_capacity(parents.len()), self.blank());
        for parent in parents {
            self.maps.make(&self.tree, parent, &mut map);
            let at = self.tree.leaves()[parent].assignment;
            let learned = self.learned.get(parent).cloned().unwrap_or_default();
            match extension.extend(parent as u32, &map, at, &self.tree.leaf(parent), &learned) {
                true => maps.push(&map),
                false => maps.skip(),
            }
        }
        maps.shrink();
        (maps, extension.kept, extension.refuted)
    }

    fn no_children(&self) -> Kept {
        Kept::new(self.most_candidates(), self.evidence.is_some())
    }

    /// The candidate at a position, its map made in some memory.
    fn candidate_in(&self, index: usize, map: &mut TopologicalMap) -> Candidate {
        self.maps.make(&self.tree, index, map);
        let Assignment { place, rotation } = self.tree.leaves()[index].assignment;
        // There is a candidate, so that there was an observation.
        let arrival = self.visits.last().map_or(SlotIndex(0), |last| last.arrival);
        let robot = DstateId { place, slot: turned(arrival, rotation, map.star(place).size()) };
        Candidate { map: Arc::new(map.clone()), visits: self.tree.assignments(index), robot }
    }

    fn blank(&self) -> TopologicalMap {
        TopologicalMap::blank(Arc::clone(&self.stars))
    }

    /// The most candidates kept after the observation that is being made.
    fn most_candidates(&self) -> Option<usize> {
        let fitting = self.limits.max_memory.map(|most| {
            let left = most.saturating_sub(self.tree.bytes());
            (left / (GATHERED * self.bytes_of_candidate())).max(1)
        });
        self.limits.max_candidates.into_iter().chain(fitting).min()
    }

    /// The most bytes of a candidate that shares nothing but what was learned of it, after one observation more.
    fn bytes_of_candidate(&self) -> usize {
        let star = self.stars.stars().map(|star| star.size()).max().unwrap_or(0);
        let dstates = (self.most_places + 1) * star;
        let map = size_of::<TopologicalMap>() + dstates * BYTES_OF_DSTATE;
        size_of::<Node>() + size_of::<Simplicity>() + size_of::<Learned>() + map + self.bytes_learned
    }

    fn stop_reason(&self) -> StopReason {
        match (self.first_cut, self.settlement(), self.extinction()) {
            (Some(cut), ..) => cut,
            (None, _, Some(Extinction { observation, .. })) => StopReason::Inconsistent { observation },
            (None, Some(settlement), None) => settlement.stop_reason,
            (None, None, None) if self.strategy == Strategy::BestFirst => StopReason::Interrupted,
            (None, None, None) => StopReason::Exhausted,
        }
    }

    /// The observation that nothing explains; by the strategy that does not go by observations, the latest.
    fn extinct_at(&self) -> Option<usize> {
        match self.settlement() {
            Some(settlement) => (settlement.proven && self.is_empty()).then(|| self.visits.len() - 1),
            None => self.tree.widths().position(|width| width == 0),
        }
    }

    fn extinction(&self) -> Option<Extinction> {
        let observation = self.extinct_at()?;
        let refuted = self.refuted.get(observation).or(self.refuted.last())?;
        if refuted.by_operator() == 0 {
            let axioms = refuted.iter().map(|(id, _)| id).collect();
            return Some(Extinction { observation, axioms, assertions: Vec::new() });
        }
        // What the axioms left, the operator's word refuted.
        let contradiction = self.word.contradiction();
        let assertions =
            if contradiction.is_empty() { self.word.assertions().to_vec() } else { contradiction };
        Some(Extinction { observation, axioms: Vec::new(), assertions })
    }
}
