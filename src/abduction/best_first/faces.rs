//! Planarity of the part of a quotient that is settled.

use super::quotient::Quotient;
use super::walk::Walk;

/// Whether the rotation system of the settled classes and the path segments between them has genus 0.
///
/// It is part of every map further down, and a part of a planar map is planar. Euler: each connected part has two
/// more places and faces than path segments. Linear in the dstates of the walk.
pub(super) fn planar(walk: &Walk, quotient: &Quotient, settled: &[usize]) -> bool {
    let far = Far { walk, quotient };
    let (mut faces, mut ends) = (0, 0);
    let mut passed = vec![false; walk.dstates()];
    for &class in settled {
        let mut alone = true;
        for slot in 0..walk.size(class) {
            let mut at = (class, slot);
            let mut length = 0;
            while !passed[walk.dstate(at.0, at.1)] {
                let Some(next) = far.around(at) else { break };
                passed[walk.dstate(at.0, at.1)] = true;
                length += 1;
                at = next;
            }
            faces += usize::from(length > 0);
            ends += length;
            alone &= far.end((class, slot)).is_none();
        }
        faces += usize::from(alone);
    }
    settled.len() + faces == ends / 2 + 2 * parts(walk, &far, settled)
}

/// Path segments between settled classes.
struct Far<'a> {
    walk: &'a Walk,
    quotient: &'a Quotient,
}

impl Far<'_> {
    fn end(&self, (class, slot): (usize, usize)) -> Option<(usize, usize)> {
        self.quotient.far_end(self.walk, class, slot).filter(|&(next, _)| self.quotient.is_settled(next))
    }

    /// The next travelled slot of the same face: across, then clockwise.
    fn around(&self, at: (usize, usize)) -> Option<(usize, usize)> {
        let (class, gateway) = self.end(at)?;
        let size = self.walk.size(class);
        (1..=size).map(|step| (class, (gateway + step) % size)).find(|&next| self.end(next).is_some())
    }
}

/// The number of connected parts.
fn parts(walk: &Walk, far: &Far<'_>, settled: &[usize]) -> usize {
    let mut left = vec![false; walk.len()];
    settled.iter().for_each(|&class| left[class] = true);
    let (mut parts, mut agenda) = (0, Vec::new());
    for &start in settled {
        if !std::mem::take(&mut left[start]) {
            continue;
        }
        parts += 1;
        agenda.push(start);
        while let Some(class) = agenda.pop() {
            let next = (0..walk.size(class)).filter_map(|slot| far.end((class, slot))).map(|(next, _)| next);
            agenda.extend(next.filter(|&next| std::mem::take(&mut left[next])));
        }
    }
    parts
}
