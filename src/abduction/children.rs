//! The children of a candidate: every way to explain one more observation.

use crate::abduction::kept::Kept;
use crate::abduction::{
    Assignment, AxiomId, AxiomSet, Branch, Evidence, Lineage, Outcome, Proposal, Refutations, Visit,
};
use crate::map::{DstateId, Grown, InternedStar, PlaceId, TopologicalMap};
use crate::star::SlotIndex;

/// An observation after the first, with all that does not depend on the candidate.
pub(super) struct Seen {
    departure: SlotIndex,
    gateway: SlotIndex,
    star: InternedStar,
    /// For each star known by number, the rotations that lay the star observed onto it.
    alignments: Vec<Vec<u8>>,
}

/// A candidate that explains the observation.
pub(super) struct Child {
    pub(super) map: TopologicalMap,
    pub(super) assignment: Assignment,
    /// Whether the map is a new one, made by branching.
    pub(super) made: bool,
}

/// What the children of one observation share.
pub(super) struct Extension<'a> {
    pub(super) seen: &'a Seen,
    pub(super) axioms: AxiomSet,
    pub(super) evidence: Option<&'a dyn Evidence>,
    pub(super) refuted: Refutations,
    pub(super) kept: Kept,
    pub(super) grown: Grown,
}

impl Seen {
    /// The star is that of the visit, and the visit has a departure from `departure`.
    pub(super) fn new(visit: &Visit, departure: SlotIndex, star: InternedStar) -> Seen {
        let alignments = star.table.stars().map(|known| known.alignments(&visit.star)).collect();
        let gateway = visit.star.slots()[visit.arrival.0 as usize].opposite;
        Seen { departure, gateway, star, alignments }
    }

    /// The rotations that lay the star observed onto that of a place, ascending.
    fn alignments(&self, map: &TopologicalMap, place: PlaceId) -> &[u8] {
        &self.alignments[map.star_id(place).index()]
    }

    /// The slot at which a rotation lays the gateway passed on arrival.
    fn gateway(&self, rotation: u8) -> SlotIndex {
        turned(self.gateway, rotation, self.star.star().size())
    }

    /// The rotation that lays the gateway passed onto a slot, if the slot is one of a star of the same size.
    fn rotation(&self, to: SlotIndex) -> u8 {
        let size = self.star.star().size();
        turned(to, (size - self.gateway.0 as usize) as u8, size).0
    }
}

impl Extension<'_> {
    /// Adds the children of the candidate numbered `parent`, which had come to its map's place `at`.
    ///
    /// Children are in the order of assignments. A travel over a known path segment has one at most; another one
    /// branches over every alignment with every place, then a new place, which only measured axioms speak against.
    pub(super) fn extend(
        &mut self,
        parent: u32,
        map: &TopologicalMap,
        at: Assignment,
        lineage: &dyn Lineage,
    ) {
        let slot = turned(self.seen.departure, at.rotation, map.star(at.place).size());
        let from = DstateId { place: at.place, slot };
        let branch = Branch::new(map, from, self.seen.star.star(), lineage);
        match map.far_end(from) {
            Some(to) => self.follow(parent, map, &branch, to),
            None => {
                self.close(parent, &branch);
                self.grow(parent, &branch);
            }
        }
    }

    fn follow(&mut self, parent: u32, map: &TopologicalMap, branch: &Branch<'_>, to: DstateId) {
        let rotation = self.seen.rotation(to.slot);
        let matches = self.seen.alignments(map, to.place).contains(&rotation);
        let assignment = Assignment { place: to.place, rotation };
        if self.admits(&Proposal { branch, assignment, outcome: Outcome::Known { to, matches } }) {
            self.kept.push(parent, Child { map: map.clone(), assignment, made: false });
        }
    }

    fn close(&mut self, parent: u32, branch: &Branch<'_>) {
        let (seen, map) = (self.seen, branch.map());
        // A path segment has two ends; what says that the robot stayed is for `travel-moves` to refute.
        let refutable = self.axioms.contains(AxiomId::TravelMoves);
        for place in map.places() {
            for &rotation in seen.alignments(map, place) {
                let to = DstateId { place, slot: seen.gateway(rotation) };
                let assignment = Assignment { place, rotation };
                let closure = Proposal { branch, assignment, outcome: Outcome::Closure { to } };
                if (to != branch.from() || refutable) && self.admits(&closure) {
                    let map = map.joined(branch.from(), to);
                    self.kept.push(parent, Child { map, assignment, made: true });
                }
            }
        }
    }

    fn grow(&mut self, parent: u32, branch: &Branch<'_>) {
        let map = branch.map();
        // Some: a map has no more places than there were observations, and these have a limit.
        let Some(place) = map.next_place() else { return };
        let assignment = Assignment { place, rotation: 0 };
        if self.admits(&Proposal { branch, assignment, outcome: Outcome::NewPlace }) {
            let to = DstateId { place, slot: self.seen.gateway };
            let map = map.grown(branch.from(), &self.seen.star, to, &mut self.grown);
            self.kept.push(parent, Child { map, assignment, made: true });
        }
    }

    /// Whether all axioms hold; otherwise the first that does not is counted.
    fn admits(&mut self, proposal: &Proposal<'_>) -> bool {
        let broken = self.axioms.iter().find(|axiom| !axiom.holds(proposal, self.evidence));
        if let Some(axiom) = broken {
            self.refuted.count(axiom.id);
        }
        broken.is_none()
    }
}

/// The slot that many slots further clockwise on a star of `size` slots.
pub(super) fn turned(slot: SlotIndex, rotation: u8, size: usize) -> SlotIndex {
    SlotIndex(((slot.0 as usize + rotation as usize) % size) as u8)
}
