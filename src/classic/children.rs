//! The children of a candidate: every way to explain one more observation.

use crate::classic::{AxiomId, ClassicMap, DstateId, Refutations, Sight};

/// A map that explains the observation.
pub(super) struct Child {
    pub(super) map: ClassicMap,
    /// The dstate that the observation is assigned to.
    pub(super) at: DstateId,
    /// Whether the map is a new one, made by branching.
    pub(super) made: bool,
}

/// The children of a map in which the robot is at `from`, in the order of assignments, and what was refuted (seed,
/// section 3.3).
pub(super) fn children(
    map: &ClassicMap,
    from: DstateId,
    seen: Sight,
    refuted: &mut Refutations,
) -> Vec<Child> {
    let Sight { action, view } = seen;
    let mut judge = |at: DstateId, judged: Result<ClassicMap, AxiomId>| match judged {
        Ok(map) => Some(Child { map, at, made: true }),
        Err(axiom) => {
            refuted.count(axiom);
            None
        }
    };
    match map.after(from, action) {
        Some(at) if map.dstate(at).view == view => vec![Child { map: map.clone(), at, made: false }],
        Some(_) => {
            refuted.count(AxiomId::View);
            Vec::new()
        }
        None => {
            let alike = map.ids().filter(|&at| map.dstate(at).view == view);
            let mut children: Vec<Child> =
                alike.filter_map(|at| judge(at, map.joined(from, action, at))).collect();
            // Some: a map has no more dstates than there are observations, and these have a limit.
            children.extend(map.grown(from, action, view).and_then(|(at, grown)| judge(at, grown)));
            children
        }
    }
}
