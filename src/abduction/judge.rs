//! A given assignment, judged observation by observation.

use crate::abduction::children::turned;
use crate::abduction::{
    Assignment, Axiom, AxiomId, AxiomSet, Branch, Candidate, Clash, Evidence, Lineage, Outcome, Proposal,
    Visit,
};
use crate::map::{DstateId, InternedStar, PlaceId, StarTable, TopologicalMap};
use crate::star::SlotIndex;
use std::borrow::Borrow;
use std::sync::Arc;

/// Where an assignment breaks an axiom first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refutation {
    /// The observation whose assignment is refuted.
    pub observation: usize,
    /// The first axiom, in the order of the registry, that does not hold of it.
    pub axiom: AxiomId,
    /// What clashes.
    pub clash: Clash,
}

/// The candidate that an assignment of all visits makes, or what refutes it first.
///
/// Law: it is a candidate exactly if a search without limits under the same axioms and the same evidence finds it;
/// it is refuted by the axiom and at the observation at which that search refutes it. An assignment that a search
/// does not even propose breaks `determinism`, where a known path segment leads elsewhere, or else `star-match`.
///
/// The visits are those of one trace: each but the first departs by a gateway of the one before. Visits and
/// assignments beyond the shorter of the two lists are not looked at. Without visits there is nothing to judge, and
/// the answer is `Ok(None)`. Linear in visits times map, and what the evidence takes.
pub fn judge(
    visits: &[impl Borrow<Visit>],
    evidence: Option<&dyn Evidence>,
    axioms: AxiomSet,
    assignments: &[Assignment],
) -> Result<Option<Candidate>, Refutation> {
    let axioms = if evidence.is_some() { axioms } else { axioms.without_measured() };
    let mut stars = Arc::new(StarTable::default());
    let mut judged: Option<Judged> = None;
    for (visit, &assignment) in visits.iter().map(Borrow::borrow).zip(assignments) {
        // None: a trace has no more different stars than a search takes.
        let Some(star) = stars.intern(&visit.star) else { break };
        stars = Arc::clone(&star.table);
        judged = Some(match (judged, visit.departure) {
            (Some(before), Some(departure)) => {
                before.with(&Step { visit, departure, star, assignment, axioms, evidence })?
            }
            _ => Judged::first(visit, &star, assignment)?,
        });
    }
    Ok(judged.map(|Judged { map, visits, robot }| Candidate { map, visits, robot }))
}

/// A candidate so far.
struct Judged {
    map: Arc<TopologicalMap>,
    visits: Vec<Assignment>,
    robot: DstateId,
}

/// One observation and what it is taken for.
struct Step<'a> {
    visit: &'a Visit,
    departure: SlotIndex,
    star: InternedStar,
    assignment: Assignment,
    axioms: AxiomSet,
    evidence: Option<&'a dyn Evidence>,
}

/// The assignments of one candidate, at hand.
#[derive(Debug)]
struct Known<'a>(&'a [Assignment]);

impl Lineage for Known<'_> {
    fn assignments(&self) -> Vec<Assignment> {
        self.0.to_vec()
    }
}

impl Judged {
    fn first(visit: &Visit, star: &InternedStar, assignment: Assignment) -> Result<Judged, Refutation> {
        if assignment != (Assignment { place: PlaceId::FIRST, rotation: 0 }) {
            return Err(not_proposed(0, assignment, "the first observation is of place 0, unturned"));
        }
        let robot = DstateId { place: assignment.place, slot: visit.arrival };
        Ok(Judged { map: Arc::new(TopologicalMap::first(star)), visits: vec![assignment], robot })
    }

    fn with(mut self, step: &Step<'_>) -> Result<Judged, Refutation> {
        let lineage = Known(&self.visits);
        // The first observation has been judged, so that there is a last one.
        let at = self.visits.last().copied().unwrap_or(step.assignment);
        let slot = turned(step.departure, at.rotation, self.map.star(at.place).size());
        let branch = Branch::new(&self.map, DstateId { place: at.place, slot }, &lineage);
        let proposal = step.proposal(&branch, self.visits.len())?;
        step.check(&proposal)?;
        if let Some(map) = step.map(&proposal) {
            self.map = Arc::new(map);
        }
        let Assignment { place, rotation } = step.assignment;
        self.robot = DstateId { place, slot: turned(step.visit.arrival, rotation, step.size()) };
        self.visits.push(step.assignment);
        Ok(self)
    }
}

impl Step<'_> {
    fn size(&self) -> usize {
        self.star.star().size()
    }

    /// The outward gateway passed on arrival, on the star as observed.
    fn gateway(&self) -> SlotIndex {
        self.star.star().slots()[self.visit.arrival.0 as usize].opposite
    }

    /// The rotation that lays the gateway passed onto a slot, if the slot is one of a star of the same size.
    fn rotation(&self, to: SlotIndex) -> u8 {
        let size = self.size();
        turned(to, (size - self.gateway().0 as usize) as u8, size).0
    }

    /// What the assignment makes of the travel, if a search would propose it.
    fn proposal<'a>(&self, branch: &'a Branch<'a>, observation: usize) -> Result<Proposal<'a>, Refutation> {
        let (map, assignment) = (branch.map(), self.assignment);
        let proposal = |outcome| Ok(Proposal { branch, assignment, outcome });
        if let Some(to) = map.far_end(branch.from()) {
            return match assignment == (Assignment { place: to.place, rotation: self.rotation(to.slot) }) {
                true => proposal(Outcome::Known { to, matches: self.lies_on(map) }),
                false => Err(elsewhere(branch, observation, assignment, to)),
            };
        }
        let refused = |words: &str| Err(not_proposed(observation, assignment, words));
        if Some(assignment.place) == map.next_place() {
            return match assignment.rotation {
                0 => proposal(Outcome::NewPlace),
                _ => refused("the star of a new place is that observed"),
            };
        }
        if assignment.place.index() >= map.place_count() {
            return refused("places are numbered by first visit");
        }
        match self.lies_on(map) {
            true => proposal(Outcome::Closure {
                to: DstateId {
                    place: assignment.place,
                    slot: turned(self.gateway(), assignment.rotation, self.size()),
                },
            }),
            false => refused("the star observed does not lie on that of the place under this rotation"),
        }
    }

    /// Whether the star observed lies on that of the place, under the rotation, as assigned.
    fn lies_on(&self, map: &TopologicalMap) -> bool {
        let Assignment { place, rotation } = self.assignment;
        (rotation as usize) < self.size() && map.star(place).matches(self.star.star(), rotation)
    }

    /// The first axiom that does not hold.
    fn check(&self, proposal: &Proposal<'_>) -> Result<(), Refutation> {
        match self.axioms.iter().find(|axiom| !axiom.holds(proposal, self.evidence)) {
            Some(axiom) => Err(self.refutation(axiom, proposal)),
            None if proposal.outcome == (Outcome::Closure { to: proposal.branch.from() }) => {
                let words = "a path segment has two ends";
                Err(not_proposed(proposal.branch.visits().len(), self.assignment, words))
            }
            None => Ok(()),
        }
    }

    fn refutation(&self, axiom: &Axiom, proposal: &Proposal<'_>) -> Refutation {
        let observation = proposal.branch.visits().len();
        let clash = match self.evidence {
            Some(evidence) if axiom.is_measured() => evidence.clash(axiom.id, proposal),
            _ => Clash {
                observations: vec![observation],
                places: vec![proposal.branch.from().place, proposal.assignment.place],
                segments: Vec::new(),
                words: axiom.statement.into(),
            },
        };
        Refutation { observation, axiom: axiom.id, clash }
    }

    /// The map with the travel, unless that is in the map.
    fn map(&self, proposal: &Proposal<'_>) -> Option<TopologicalMap> {
        let (map, from) = (proposal.branch.map(), proposal.branch.from());
        match proposal.outcome {
            Outcome::Known { .. } => None,
            Outcome::Closure { to } => Some(map.joined(from, to)),
            Outcome::NewPlace => {
                let to = DstateId { place: self.assignment.place, slot: self.gateway() };
                Some(map.grown(from, &self.star, to))
            }
        }
    }
}

fn not_proposed(observation: usize, assignment: Assignment, words: &str) -> Refutation {
    let clash = Clash {
        observations: vec![observation],
        places: vec![assignment.place],
        segments: Vec::new(),
        words: words.into(),
    };
    Refutation { observation, axiom: AxiomId::StarMatch, clash }
}

/// The path segment travelled is known and leads to `far`, which the assignment is not.
fn elsewhere(branch: &Branch<'_>, observation: usize, assignment: Assignment, far: DstateId) -> Refutation {
    let clash = Clash {
        observations: vec![observation],
        places: vec![far.place, assignment.place],
        segments: vec![[branch.from(), far]],
        words: format!("the gateway {} leads to {far}, as travelled before", branch.from()),
    };
    Refutation { observation, axiom: AxiomId::Determinism, clash }
}
