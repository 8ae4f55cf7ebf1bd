//! How simple the maps below a quotient can be at best.

use super::agenda::Lists;
use super::quotient::Quotient;
use super::rotations::{members, turned};
use super::walk::Walk;
use crate::abduction::Simplicity;

/// A lower bound of the simplicity of every map that a quotient can still become.
///
/// Classes that cannot lie on each other stay different places. So the places of a *clique* of such classes, the
/// settled ones among them, are all there at the end, and with them their slots at which a path ends for good: those
/// without a gateway, and those whose gateway no class can any more be travelled by. A path has two ends, so there are
/// at least half as many paths. The clique is found greedily, most ends first. Quadratic in the classes.
pub(super) fn bounds(walk: &Walk, quotient: &Quotient, lists: &Lists, soft: bool) -> Bounds {
    let Lists { classes, settled, open, .. } = lists;
    let ends = |class: usize| ends(walk, quotient, classes, class);
    let mut all: usize = settled.iter().map(|&class| ends(class)).sum();
    let with_new = Ends { ends: all, places: settled.len() + 1 };
    let mut clique: Vec<usize> = Vec::new();
    let most = open.iter().map(|&class| walk.blocked(class)).max().unwrap_or(0);
    // Stars have few slots, so that it is quicker to go through the numbers of ends than to sort by them.
    for blocked in (0..=most).rev() {
        for &class in open.iter().filter(|&&class| walk.blocked(class) == blocked) {
            if settled.iter().chain(&clique).all(|&other| quotient.alike(class, other) == 0) {
                clique.push(class);
                all += ends(class);
            }
        }
    }
    let least = Ends { ends: all, places: settled.len() + clique.len() };
    Bounds { least, with_new, abnormalities: soft.then_some(0) }
}

/// What is known of the maps below a quotient.
pub(super) struct Bounds {
    least: Ends,
    with_new: Ends,
    abnormalities: Option<usize>,
}

impl Bounds {
    /// How simple they are at best.
    pub(super) fn least(&self) -> Simplicity {
        self.least.simplicity(0, self.abnormalities)
    }

    /// How simple they are at best if an open class is a place unlike all settled ones.
    pub(super) fn with_new(&self, walk: &Walk, class: usize) -> Simplicity {
        self.with_new.simplicity(walk.blocked(class), self.abnormalities)
    }
}

/// Different places, and the ends of paths at them.
struct Ends {
    ends: usize,
    places: usize,
}

impl Ends {
    fn simplicity(&self, more: usize, abnormalities: Option<usize>) -> Simplicity {
        Simplicity { abnormalities, paths: (self.ends + more).div_ceil(2), places: self.places }
    }
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
