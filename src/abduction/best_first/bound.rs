//! How simple the maps below a quotient can be at best.

use super::quotient::{Quotient, turned};
use super::walk::Walk;
use crate::abduction::Simplicity;
use std::cmp::Reverse;

/// A lower bound of the simplicity of every map that a quotient can still become.
///
/// Classes that cannot lie on each other stay different places. So the places of a *clique* of such classes, the
/// settled ones among them, are all there at the end, and with them their slots at which a path ends for good: those
/// without a gateway, and those whose gateway no class can any more be travelled by. A path has two ends, so there are
/// at least half as many paths. The clique is found greedily, most ends first. Quadratic in the classes.
pub(super) fn bound(walk: &Walk, quotient: &Quotient, classes: &[usize]) -> Simplicity {
    let (mut clique, mut open): (Vec<usize>, Vec<usize>) =
        classes.iter().partition(|&&class| quotient.is_settled(class));
    open.sort_by_key(|&class| Reverse(walk.blocked(class)));
    for class in open {
        if clique.iter().all(|&other| quotient.alike(class, other) == 0) {
            clique.push(class);
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
        let mut rotations = if other == class { 0 } else { quotient.alike(other, class) };
        while rotations != 0 {
            unfilled &= !turned(quotient.filled(other), rotations.trailing_zeros() as usize, size);
            rotations &= rotations - 1;
        }
    }
    walk.blocked(class) + unfilled.count_ones() as usize
}
