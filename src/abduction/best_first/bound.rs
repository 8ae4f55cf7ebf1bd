//! How simple the maps below a quotient can be at best.

use super::quotient::{Quotient, members, turned};
use super::walk::Walk;
use crate::abduction::Simplicity;

/// A lower bound of the simplicity of every map that a quotient can still become.
///
/// Classes that cannot lie on each other stay different places. So the places of a *clique* of such classes, the
/// settled ones among them, are all there at the end, and with them their slots at which a path ends for good: those
/// without a gateway, and those whose gateway no class can any more be travelled by. A path has two ends, so there are
/// at least half as many paths. The clique is found greedily, most ends first. Quadratic in the classes.
pub(super) fn bound(walk: &Walk, quotient: &Quotient, classes: &[usize], open: &[usize]) -> Simplicity {
    let mut clique: Vec<usize> = Vec::with_capacity(classes.len());
    clique.extend(classes.iter().filter(|&&class| quotient.is_settled(class)));
    let most = open.iter().map(|&class| walk.blocked(class)).max().unwrap_or(0);
    // Stars have few slots, so that it is quicker to go through the numbers of ends than to sort by them.
    for blocked in (0..=most).rev() {
        for &class in open.iter().filter(|&&class| walk.blocked(class) == blocked) {
            if clique.iter().all(|&other| quotient.alike(class, other) == 0) {
                clique.push(class);
            }
        }
    }
    let ends: usize = clique.iter().map(|&class| ends(walk, quotient, classes, class)).sum();
    Simplicity { abnormalities: None, paths: ends.div_ceil(2), places: clique.len() }
}

/// The slots of a class at which a path will end, whatever it merges with.
fn ends(walk: &Walk, quotient: &Quotient, classes: &[usize], class: usize) -> usize {
    let size = walk.size(class);
    if !walk.tracked(class) {
        return walk.blocked(class);
    }
    let mut unfilled = walk.navigable(class) & !quotient.filled(class);
    for &other in classes {
        if unfilled == 0 {
            break;
        }
        if other == class {
            continue;
        }
        // What lies on the other class by a rotation has it lie there by the rotation back.
        for rotation in members(quotient.alike(class, other)) {
            unfilled &= !turned(quotient.filled(other), size - rotation, size);
        }
    }
    walk.blocked(class) + unfilled.count_ones() as usize
}
