//! The law `planarity`.

use crate::reference::told::{End, Told};
use std::collections::BTreeSet;

/// Euler: places, path segments and faces of the connected map.
pub(super) fn planarity(told: &Told<'_>) -> bool {
    let segments = told.segments();
    let used: BTreeSet<End> = segments.iter().flat_map(|&(a, b)| [a, b]).collect();
    let mut unseen = used.clone();
    let mut faces = usize::from(used.is_empty());
    while let Some(&start) = unseen.first() {
        faces += 1;
        let mut at = start;
        while unseen.remove(&at) {
            at = next_on_face(told, &used, at);
        }
    }
    told.stars.len() + faces == segments.len() + 2
}

/// Travel away, then turn clockwise to the next gateway that has a far end; that is the one come in by if no other.
fn next_on_face(told: &Told<'_>, used: &BTreeSet<End>, at: End) -> End {
    let Some((place, slot)) = told.far_end(at) else { return at };
    let size = told.stars[place].size();
    let clockwise = (1..=size).map(|step| (place, (slot + step) % size));
    clockwise.into_iter().find(|end| used.contains(end)).unwrap_or(at)
}
