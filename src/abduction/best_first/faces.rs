//! Planarity of the part of a quotient that is settled.

use super::quotient::Quotient;
use super::walk::Walk;
use std::collections::BTreeSet;

/// Whether the rotation system of the settled classes and the path segments between them has genus 0.
///
/// It is part of every map further down, and a part of a planar map is planar. Euler: each connected part has two
/// more places and faces than path segments. Linear in the dstates of the settled classes, but for the sets.
pub(super) fn planar(walk: &Walk, quotient: &Quotient, settled: &[usize]) -> bool {
    let far = |class: usize, slot: usize| {
        quotient.far_end(walk, class, slot).filter(|&(next, _)| quotient.is_settled(next))
    };
    let slots = |&class: &usize| (0..walk.size(class)).map(move |slot| (class, slot));
    let mut ends: BTreeSet<(usize, usize)> =
        settled.iter().flat_map(slots).filter(|&(class, slot)| far(class, slot).is_some()).collect();
    let segments = ends.len() / 2;
    let mut faces =
        settled.iter().filter(|&&class| (0..walk.size(class)).all(|s| far(class, s).is_none())).count();
    while let Some(&start) = ends.first() {
        faces += 1;
        let mut at = start;
        while ends.remove(&at) {
            let Some((class, gateway)) = far(at.0, at.1) else { break };
            let size = walk.size(class);
            let after = (1..=size).map(|step| (gateway + step) % size);
            // The gateway itself is one, so that there is a next.
            at = (class, after.into_iter().find(|&slot| far(class, slot).is_some()).unwrap_or(gateway));
        }
    }
    settled.len() + faces == segments + 2 * parts(settled, walk, &far)
}

/// The number of connected parts.
fn parts(settled: &[usize], walk: &Walk, far: &dyn Fn(usize, usize) -> Option<(usize, usize)>) -> usize {
    let mut left: BTreeSet<usize> = settled.iter().copied().collect();
    let mut parts = 0;
    while let Some(start) = left.pop_first() {
        parts += 1;
        let mut agenda = vec![start];
        while let Some(class) = agenda.pop() {
            let next = (0..walk.size(class)).filter_map(|slot| far(class, slot)).map(|(next, _)| next);
            agenda.extend(next.filter(|next| left.remove(next)));
        }
    }
    parts
}
