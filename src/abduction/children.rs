//! The children of a candidate: every way to explain one more observation.

use crate::abduction::kept::Kept;
use crate::abduction::tree::Node;
use crate::abduction::{
    Assignment, Axiom, AxiomId, AxiomSet, Boundary, Branch, Evidence, Learned, Lineage, Outcome, Proposal,
    Refutations, Simplicity, Visit,
};
use crate::map::{DstateId, InternedStar, TopologicalMap};
use crate::star::SlotIndex;

/// An observation after the first, with all that does not depend on the candidate.
#[derive(Debug)]
pub(super) struct Seen {
    departure: SlotIndex,
    gateway: SlotIndex,
    star: InternedStar,
    /// For each star known by number, the ways to lay the star observed onto it, ascending.
    alignments: Vec<Vec<Alignment>>,
}

/// A rotation that lays the star observed onto another, and the slot at which it lays the gateway passed on arrival.
#[derive(Clone, Copy, Debug)]
struct Alignment {
    rotation: u8,
    gateway: SlotIndex,
}

/// What the children of one observation share.
pub(super) struct Extension<'a> {
    seen: &'a Seen,
    axioms: AxiomSet,
    /// Those of the axioms that refute, in the order of the registry.
    laws: Vec<&'static Axiom>,
    evidence: Option<&'a dyn Evidence>,
    pub(super) refuted: Refutations,
    pub(super) kept: Kept,
}

impl Seen {
    /// The star is that of the visit, and the visit has a departure from `departure`.
    pub(super) fn new(visit: &Visit, departure: SlotIndex, star: InternedStar) -> Seen {
        let gateway = visit.star.slots()[visit.arrival.0 as usize].opposite;
        let aligned =
            |rotation| Alignment { rotation, gateway: turned(gateway, rotation, visit.star.size()) };
        let alignments = star.table.stars().map(|known| known.alignments(&visit.star));
        let alignments = alignments.map(|rotations| rotations.into_iter().map(aligned).collect()).collect();
        Seen { departure, gateway, star, alignments }
    }

    /// Turns the map of a candidate that had come to `at` into that which it has when it takes the observation for
    /// `now`.
    pub(super) fn extend(&self, map: &mut TopologicalMap, [at, now]: [Assignment; 2]) {
        let (from, to) = (self.left_by(map, at), self.far_end(now));
        if map.far_end(from).is_some() {
            // It stays as it is.
        } else if Some(now.place) == map.next_place() {
            map.grow(from, &self.star, to);
        } else {
            map.join(from, to);
        }
    }

    /// How simple the map then is, which is made only where that cannot be said without.
    pub(super) fn simplicity(
        &self,
        map: &TopologicalMap,
        [at, now]: [Assignment; 2],
        axioms: AxiomSet,
    ) -> Simplicity {
        let (from, to) = (self.left_by(map, at), self.far_end(now));
        if axioms.boundary() == Some(Boundary::Soft) {
            let mut map = map.clone();
            self.extend(&mut map, [at, now]);
            return Simplicity::of(&map, axioms);
        }
        let (paths, places) = (map.path_count(), map.place_count());
        let (paths, places) = if map.far_end(from).is_some() {
            (paths, places)
        } else if Some(now.place) == map.next_place() {
            (paths + self.star.star().fragments() - 1, places + 1)
        } else {
            (paths - usize::from(!map.closes(from, to)), places)
        };
        Simplicity { abnormalities: None, paths, places }
    }

    /// The gateway by which a candidate left that had come to `at`.
    fn left_by(&self, map: &TopologicalMap, at: Assignment) -> DstateId {
        DstateId { place: at.place, slot: turned(self.departure, at.rotation, map.star(at.place).size()) }
    }

    /// The gateway passed on arrival, as an assignment lays it.
    fn far_end(&self, Assignment { place, rotation }: Assignment) -> DstateId {
        DstateId { place, slot: turned(self.gateway, rotation, self.star.star().size()) }
    }

    /// The rotation that lays the gateway passed onto a slot, if the slot is one of a star of the same size.
    fn rotation(&self, to: SlotIndex) -> u8 {
        let size = self.star.star().size();
        turned(to, (size - self.gateway.0 as usize) as u8, size).0
    }
}

impl<'a> Extension<'a> {
    pub(super) fn new(
        seen: &'a Seen,
        axioms: AxiomSet,
        evidence: Option<&'a dyn Evidence>,
        kept: Kept,
    ) -> Extension<'a> {
        Extension {
            seen,
            axioms,
            laws: axioms.iter().collect(),
            evidence,
            refuted: Refutations::default(),
            kept,
        }
    }

    /// Adds the children of the candidate numbered `parent`, which had come to its map's place `at` and of which evidence has
    /// `learned` something; whether there are any.
    ///
    /// Children are in the order of assignments. A travel over a known path segment has one at most; another one
    /// branches over every alignment with every place, then a new place, which only measured axioms speak against.
    pub(super) fn extend(
        &mut self,
        parent: u32,
        map: &TopologicalMap,
        at: Assignment,
        lineage: &dyn Lineage,
        learned: &Learned,
    ) -> bool {
        let before = self.kept.added;
        let branch = Branch::new(map, self.seen.left_by(map, at), self.seen.star.star(), lineage, learned);
        let parent = Parent { number: parent, at, branch: &branch };
        match map.far_end(branch.from()) {
            Some(to) => self.follow(&parent, to),
            None => {
                self.close(&parent);
                self.grow(&parent);
            }
        }
        self.kept.added > before
    }

    fn follow(&mut self, parent: &Parent<'_>, to: DstateId) {
        let rotation = self.seen.rotation(to.slot);
        let alignments = &self.seen.alignments[parent.branch.map().star_id(to.place).index()];
        let matches = alignments.iter().any(|alignment| alignment.rotation == rotation);
        let assignment = Assignment { place: to.place, rotation };
        self.propose(parent, assignment, Outcome::Known { to, matches });
    }

    fn close(&mut self, parent: &Parent<'_>) {
        let from = parent.branch.from();
        // A path segment has two ends; what says that the robot stayed is for `travel-moves` to refute.
        let refutable = self.axioms.contains(AxiomId::TravelMoves);
        for (place, star) in parent.branch.map().places_with_stars() {
            for &Alignment { rotation, gateway } in &self.seen.alignments[star.index()] {
                let to = DstateId { place, slot: gateway };
                if to != from || refutable {
                    self.propose(parent, Assignment { place, rotation }, Outcome::Closure { to });
                }
            }
        }
    }

    fn grow(&mut self, parent: &Parent<'_>) {
        // Some: a map has no more places than there were observations, and these have a limit.
        let Some(place) = parent.branch.map().next_place() else { return };
        self.propose(parent, Assignment { place, rotation: 0 }, Outcome::NewPlace);
    }

    /// Adds the child if all axioms hold; otherwise the first that does not is counted.
    fn propose(&mut self, parent: &Parent<'_>, assignment: Assignment, outcome: Outcome) {
        let &Parent { number, at, branch } = parent;
        let proposal = Proposal { branch, assignment, outcome };
        if let Some(axiom) = self.laws.iter().find(|axiom| !axiom.holds(&proposal, self.evidence)) {
            self.refuted.count(axiom.id);
            return;
        }
        let simplicity = || self.seen.simplicity(branch.map(), [at, assignment], self.axioms);
        let made = !matches!(outcome, Outcome::Known { .. });
        let learned = || self.evidence.map(|evidence| evidence.learned(&proposal)).unwrap_or_default();
        self.kept.push(Node { parent: number, assignment }, made, simplicity, learned);
    }
}

/// The candidate that is extended.
struct Parent<'a> {
    number: u32,
    /// What it takes the observation before for.
    at: Assignment,
    branch: &'a Branch<'a>,
}

/// The slot that many slots further clockwise on a star of `size` slots.
pub(super) fn turned(slot: SlotIndex, rotation: u8, size: usize) -> SlotIndex {
    SlotIndex(((slot.0 as usize + rotation as usize) % size) as u8)
}
