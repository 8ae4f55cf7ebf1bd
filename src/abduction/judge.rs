//! A given assignment, judged observation by observation.

use crate::abduction::children::turned;
use crate::abduction::{
    Assignment, Axiom, AxiomId, AxiomSet, Branch, Candidate, Clash, Evidence, Learned, Lineage, Outcome,
    Proposal, Visit,
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
    let laws = Laws::of(evidence, axioms);
    let judged = laws.beginning(visits, assignments)?.map(|(judged, _)| judged);
    Ok(judged.map(|Judged { map, visits, robot, .. }| Candidate { map, visits, robot }))
}

/// The children that a search proposes for the candidate that a beginning of assignments makes, when it comes to the
/// next of the visits; each with what refutes it, in the order in which the search makes them.
///
/// Law: as many are refuted by each axiom as the search counts for the candidate. None without a next visit, nor
/// after an empty beginning. An error says what refutes the beginning itself.
pub fn proposed(
    visits: &[impl Borrow<Visit>],
    evidence: Option<&dyn Evidence>,
    axioms: AxiomSet,
    beginning: &[Assignment],
) -> Result<Vec<Proposed>, Refutation> {
    let laws = Laws::of(evidence, axioms);
    let (Some((judged, stars)), Some(visit)) =
        (laws.beginning(visits, beginning)?, visits.get(beginning.len()).map(Borrow::borrow))
    else {
        return Ok(Vec::new());
    };
    let (Some(departure), Some(star)) = (visit.departure, stars.intern(&visit.star)) else {
        return Ok(Vec::new());
    };
    let assignment = Assignment { place: PlaceId::FIRST, rotation: 0 };
    let step = Step { visit, departure, star, assignment, laws };
    let judge = |assignment| {
        let refutation = judged.check(&Step { assignment, star: step.star.clone(), ..step }).err();
        Proposed { assignment, refutation }
    };
    Ok(judged.assignments(&step).into_iter().map(judge).collect())
}

/// A child that a search proposes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proposed {
    /// What it takes the observation for.
    pub assignment: Assignment,
    /// What refutes it, if an axiom does.
    pub refutation: Option<Refutation>,
}

/// What is judged by.
#[derive(Clone, Copy)]
struct Laws<'a> {
    axioms: AxiomSet,
    evidence: Option<&'a dyn Evidence>,
}

impl<'a> Laws<'a> {
    fn of(evidence: Option<&'a dyn Evidence>, axioms: AxiomSet) -> Laws<'a> {
        let axioms = if evidence.is_some() { axioms } else { axioms.without_measured() };
        Laws { axioms, evidence }
    }

    /// The candidate that assignments make of the first visits, and the stars of these.
    fn beginning(
        self,
        visits: &[impl Borrow<Visit>],
        assignments: &[Assignment],
    ) -> Result<Option<(Judged, Arc<StarTable>)>, Refutation> {
        let mut judged: Option<(Judged, Arc<StarTable>)> = None;
        for (visit, &assignment) in visits.iter().map(Borrow::borrow).zip(assignments) {
            let (before, stars) =
                judged.map_or_else(Default::default, |(judged, stars)| (Some(judged), stars));
            // None: a trace has no more different stars than a search takes.
            let Some(star) = stars.intern(&visit.star) else { return Ok(None) };
            let stars = Arc::clone(&star.table);
            let now = match (before, visit.departure) {
                (Some(before), Some(departure)) => {
                    before.with(&Step { visit, departure, star, assignment, laws: self })?
                }
                _ => Judged::first(visit, &star, assignment)?,
            };
            judged = Some((now, stars));
        }
        Ok(judged)
    }
}

/// A candidate so far.
struct Judged {
    map: Arc<TopologicalMap>,
    visits: Vec<Assignment>,
    robot: DstateId,
    learned: Learned,
}

/// One observation and what it is taken for.
struct Step<'a> {
    visit: &'a Visit,
    departure: SlotIndex,
    star: InternedStar,
    assignment: Assignment,
    laws: Laws<'a>,
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
        Ok(Judged {
            map: Arc::new(TopologicalMap::first(star)),
            visits: vec![assignment],
            robot,
            learned: Learned::default(),
        })
    }

    fn with(mut self, step: &Step<'_>) -> Result<Judged, Refutation> {
        let (map, learned) = self.check(step)?;
        self.map = map.map_or(self.map, Arc::new);
        self.learned = learned;
        let Assignment { place, rotation } = step.assignment;
        self.robot = DstateId { place, slot: turned(step.visit.arrival, rotation, step.size()) };
        self.visits.push(step.assignment);
        Ok(self)
    }

    /// The new map, if one is made, and what evidence learned; or what refutes the step.
    fn check(&self, step: &Step<'_>) -> Result<(Option<TopologicalMap>, Learned), Refutation> {
        let lineage = Known(&self.visits);
        let branch = Branch::new(&self.map, self.left_by(step), step.star.star(), &lineage, &self.learned);
        let proposal = step.proposal(&branch, self.visits.len())?;
        step.check(&proposal)?;
        let learned = step.laws.evidence.map(|evidence| evidence.learned(&proposal)).unwrap_or_default();
        Ok((step.map(&proposal), learned))
    }

    /// What a search proposes to take the observation for.
    fn assignments(&self, step: &Step<'_>) -> Vec<Assignment> {
        let (map, from) = (&self.map, self.left_by(step));
        if let Some(to) = map.far_end(from) {
            return vec![Assignment { place: to.place, rotation: step.rotation(to.slot) }];
        }
        // A path segment has two ends; what says that the robot stayed is for `travel-moves` to refute.
        let refutable = step.laws.axioms.contains(AxiomId::TravelMoves);
        let of_place = |place| {
            let alignments = map.star(place).alignments(step.star.star()).into_iter();
            alignments.map(move |rotation| Assignment { place, rotation })
        };
        let known = map
            .places()
            .flat_map(of_place)
            .filter(|&assignment| refutable || step.far_end(assignment) != from);
        let new = map.next_place().map(|place| Assignment { place, rotation: 0 });
        known.chain(new).collect()
    }

    /// The gateway left by.
    fn left_by(&self, step: &Step<'_>) -> DstateId {
        // The first observation has been judged, so that there is a last one.
        let at = self.visits.last().copied().unwrap_or(step.assignment);
        let slot = turned(step.departure, at.rotation, self.map.star(at.place).size());
        DstateId { place: at.place, slot }
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

    /// The gateway passed on arrival, as an assignment lays it.
    fn far_end(&self, Assignment { place, rotation }: Assignment) -> DstateId {
        DstateId { place, slot: turned(self.gateway(), rotation, self.size()) }
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
            true => proposal(Outcome::Closure { to: self.far_end(assignment) }),
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
        match self.laws.axioms.iter().find(|axiom| !axiom.holds(proposal, self.laws.evidence)) {
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
        let clash = axiom.clash(proposal, self.laws.evidence);
        Refutation { observation, axiom: axiom.id, clash }
    }

    /// The map with the travel, unless that is in the map.
    fn map(&self, proposal: &Proposal<'_>) -> Option<TopologicalMap> {
        let (map, from) = (proposal.branch.map(), proposal.branch.from());
        match proposal.outcome {
            Outcome::Known { .. } => None,
            Outcome::Closure { to } => Some(map.joined(from, to)),
            Outcome::NewPlace => {
                let to = self.far_end(self.assignment);
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
