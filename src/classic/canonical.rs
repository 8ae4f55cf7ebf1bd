//! Maps without the order in which their dstates were met.

use crate::classic::{ClassicMap, Dstate, DstateId, ViewId};

/// For each dstate, in an order that the map alone decides, its view and where its actions lead.
pub(super) type CanonicalMap = Vec<(ViewId, [Option<usize>; 4])>;

/// The same for two maps if and only if dstates can be renumbered such that they are equal. Quadratic in the
/// dstates.
pub(super) fn canonical(map: &ClassicMap) -> CanonicalMap {
    // All dstates are reached from the first, so that some start gives an answer.
    map.ids().filter_map(|start| seen_from(map, start)).min().unwrap_or_default()
}

/// The map with its dstates in the order in which a search from one of them meets them, if it meets all.
fn seen_from(map: &ClassicMap, start: DstateId) -> Option<CanonicalMap> {
    let mut met = vec![start];
    let mut number = vec![None; map.dstates().len()];
    number[start.index()] = Some(0);
    let mut next = 0;
    while let Some(&here) = met.get(next) {
        next += 1;
        for to in map.dstate(here).after.into_iter().flatten() {
            if number[to.index()].is_none() {
                number[to.index()] = Some(met.len());
                met.push(to);
            }
        }
    }
    let row = |id: &DstateId| {
        let Dstate { view, after, .. } = map.dstate(*id);
        (*view, after.map(|to| to.and_then(|to| number[to.index()])))
    };
    (met.len() == number.len()).then(|| met.iter().map(row).collect())
}
