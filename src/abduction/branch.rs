//! What axioms judge: a child proposed for a candidate.

use crate::abduction::{Assignment, Learned};
use crate::map::{Boundaries, DstateId, Face, PlaceId, PlaceSet, TopologicalMap, path_from_end};
use crate::star::LargeScaleStar;
use std::any::Any;
use std::cell::OnceCell;
use std::fmt::Debug;

/// A map and the gateway the robot left it by. What several proposals ask for is found once, when first asked for.
#[derive(Debug)]
pub struct Branch<'a> {
    map: &'a TopologicalMap,
    from: DstateId,
    seen: &'a LargeScaleStar,
    lineage: &'a dyn Lineage,
    learned: &'a Learned,
    visits: OnceCell<Vec<Assignment>>,
    path: OnceCell<PlaceSet>,
    face: OnceCell<Face>,
    boundaries: OnceCell<Boundaries>,
    measured: OnceCell<Box<dyn Any>>,
}

/// What a child says of one travel. All that was before obeys the axioms.
#[derive(Clone, Copy, Debug)]
pub struct Proposal<'a> {
    /// The candidate, and the gateway left by.
    pub branch: &'a Branch<'a>,
    /// What the observation after the travel is taken for.
    pub assignment: Assignment,
    /// What that makes of the travel.
    pub outcome: Outcome,
}

/// What a travel comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It went along a known path segment.
    Known {
        /// The gateway at the far end.
        to: DstateId,
        /// Whether the star observed lies on that of the place, under the rotation the gateway fixes.
        matches: bool,
    },
    /// It made a new path segment to a known place, whose star has this alignment with the one observed.
    Closure {
        /// The gateway at the far end, navigable and another one than that left by.
        to: DstateId,
    },
    /// It made a new path segment to a new place.
    NewPlace,
}

/// Where a candidate comes from.
pub trait Lineage: Debug {
    /// What each observation so far was taken for. Linear in the observations.
    fn assignments(&self) -> Vec<Assignment>;
}

impl<'a> Branch<'a> {
    pub(super) fn new(
        map: &'a TopologicalMap,
        from: DstateId,
        seen: &'a LargeScaleStar,
        lineage: &'a dyn Lineage,
        learned: &'a Learned,
    ) -> Self {
        Branch {
            map,
            from,
            seen,
            lineage,
            learned,
            visits: OnceCell::new(),
            path: OnceCell::new(),
            face: OnceCell::new(),
            boundaries: OnceCell::new(),
            measured: OnceCell::new(),
        }
    }

    /// The map before the travel.
    pub fn map(&self) -> &'a TopologicalMap {
        self.map
    }

    /// The gateway the robot left by.
    pub fn from(&self) -> DstateId {
        self.from
    }

    /// The star observed after the travel, as listed then.
    pub fn seen(&self) -> &'a LargeScaleStar {
        self.seen
    }

    /// What each observation before the travel was taken for. Linear in the observations the first time.
    pub fn visits(&self) -> &[Assignment] {
        self.visits.get_or_init(|| self.lineage.assignments())
    }

    /// What evidence learned of the candidate when that was judged.
    pub fn learned(&self) -> &'a Learned {
        self.learned
    }

    /// What evidence makes of the branch, whatever is proposed for it: made once, when first asked for. A branch is
    /// judged by one evidence, which asks for one type; `None` for another.
    pub fn measured<T: 'static>(&self, make: impl FnOnce() -> T) -> Option<&T> {
        self.measured.get_or_init(|| Box::new(make())).downcast_ref()
    }

    /// The observation after the travel, and those before it that are of some places, ascending.
    pub fn observations_of(&self, places: &[PlaceId]) -> Vec<usize> {
        let visits = self.visits();
        let of = (0..visits.len()).filter(|&visit| places.contains(&visits[visit].place));
        of.chain([visits.len()]).collect()
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

    /// Whether no place is on two sides of a path, or on it and beside it, once `from` and `to`, neither with a far
    /// end, are joined; nothing is so before. Linear in the dstates times the length of paths the first time, in the
    /// dstates on both paths from then on.
    pub fn boundaries_kept(&self, to: DstateId) -> bool {
        self.boundaries.get_or_init(|| Boundaries::of(self.map)).agree_joined(self.map, self.from, to)
    }
}
