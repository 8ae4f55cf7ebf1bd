//! What axioms judge: a child proposed for a candidate.

use crate::map::{DstateId, Face, PlaceSet, TopologicalMap, path_from_end};
use std::cell::OnceCell;

/// A map and the gateway the robot left it by. What several proposals ask for is found once, when first asked for.
#[derive(Debug)]
pub struct Branch<'a> {
    map: &'a TopologicalMap,
    from: DstateId,
    path: OnceCell<PlaceSet>,
    face: OnceCell<Face>,
}

/// What a child says of one travel. All that was before obeys the axioms.
#[derive(Clone, Copy, Debug)]
pub enum Proposal<'a> {
    /// It went along a known path segment.
    Known {
        /// The map and the gateway left by.
        branch: &'a Branch<'a>,
        /// The gateway at the far end.
        to: DstateId,
        /// Whether the star observed lies on that of the place, under the rotation the gateway fixes.
        matches: bool,
    },
    /// It made a new path segment to a known place, whose star has this alignment with the one observed.
    Closure {
        /// The map and the gateway left by, which has no far end.
        branch: &'a Branch<'a>,
        /// The gateway at the far end, navigable and another one than that left by.
        to: DstateId,
    },
    /// It made a new path segment to a new place.
    NewPlace {
        /// The map and the gateway left by, which has no far end.
        branch: &'a Branch<'a>,
    },
}

impl<'a> Branch<'a> {
    pub(super) fn new(map: &'a TopologicalMap, from: DstateId) -> Self {
        Branch { map, from, path: OnceCell::new(), face: OnceCell::new() }
    }

    /// The map before the travel.
    pub fn map(&self) -> &'a TopologicalMap {
        self.map
    }

    /// The gateway the robot left by.
    pub fn from(&self) -> DstateId {
        self.from
    }

    /// Whether the paths that end at `from` and at `to`, neither with a far end, have no place in common. Linear
    /// in the places on both paths.
    pub fn paths_apart(&self, to: DstateId) -> bool {
        let path = self.path.get_or_init(|| path_from_end(self.map, self.from).collect());
        path_from_end(self.map, to).all(|place| !path.contains(place))
    }

    /// Whether `from` and `to`, neither with a far end, lie in one face of the travelled path segments. Linear in
    /// the length of the face the first time, constant from then on.
    pub fn one_face(&self, to: DstateId) -> bool {
        self.face.get_or_init(|| Face::around(self.map, self.from)).holds(self.map, to)
    }
}
