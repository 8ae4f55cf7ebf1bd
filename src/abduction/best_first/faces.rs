//! The faces of the part of a quotient that is settled.

use super::quotient::Quotient;
use super::walk::Walk;

/// The rotation system of the settled classes and the path segments between them. It is worked out anew for each quotient; what
/// stays is its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    /// For each dstate of a settled class the one at its far end, if that is settled too; else [`NONE`].
    across: Vec<u32>,
    /// For each dstate of a settled class its face.
    face: Vec<u32>,
    /// For each settled class the connected part it belongs to.
    part: Vec<u32>,
    faces: usize,
    parts: usize,
    agenda: Vec<usize>,
}

/// Nothing there, or not known yet.
const NONE: u32 = u32::MAX;

impl Faces {
    /// Walks around all faces; whether the genus is 0. Linear in the dstates of the settled classes.
    ///
    /// They are part of every map further down, and a part of a planar map is planar. Euler: each connected part has
    /// two more places and faces than path segments.
    pub(super) fn planar(&mut self, walk: &Walk, quotient: &Quotient, settled: &[usize]) -> bool {
        let ends = self.cross(walk, quotient, settled);
        self.walk_around(walk, settled);
        self.connect(walk, settled);
        settled.len() + self.faces == ends / 2 + 2 * self.parts
    }

    /// The face in which a dstate of a settled class lies that has no settled far end; none if it has one.
    pub(super) fn corner(&self, dstate: usize) -> Option<usize> {
        (self.across[dstate] == NONE).then_some(self.face[dstate] as usize)
    }

    /// The number of connected parts.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// The connected part of a settled class.
    pub(super) fn part(&self, class: usize) -> usize {
        self.part[class] as usize
    }

    /// The number of dstates with a settled far end.
    fn cross(&mut self, walk: &Walk, quotient: &Quotient, settled: &[usize]) -> usize {
        self.across.resize(walk.dstates(), NONE);
        let mut ends = 0;
        for &class in settled {
            for slot in 0..walk.size(class) {
                let far = quotient.far_end(walk, class, slot).filter(|&(next, _)| quotient.is_settled(next));
                self.across[walk.dstate(class, slot)] =
                    far.map_or(NONE, |(next, gateway)| walk.dstate(next, gateway) as u32);
                ends += usize::from(far.is_some());
            }
        }
        ends
    }

    /// Faces are the orbits of "go clockwise to the next slot, and if it has a far end, cross".
    fn walk_around(&mut self, walk: &Walk, settled: &[usize]) {
        self.face.resize(walk.dstates(), NONE);
        let dstates = |class| (0..walk.size(class)).map(move |slot| walk.dstate(class, slot));
        settled.iter().copied().flat_map(dstates).for_each(|dstate| self.face[dstate] = NONE);
        let mut faces = 0;
        for start in settled.iter().copied().flat_map(dstates) {
            if self.face[start] != NONE {
                continue;
            }
            let mut at = start;
            while self.face[at] == NONE {
                self.face[at] = faces;
                let next = walk.clockwise(at);
                at = if self.across[next] == NONE { next } else { self.across[next] as usize };
            }
            faces += 1;
        }
        self.faces = faces as usize;
    }

    fn connect(&mut self, walk: &Walk, settled: &[usize]) {
        self.part.resize(walk.len(), NONE);
        settled.iter().for_each(|&class| self.part[class] = NONE);
        self.parts = 0;
        for &start in settled {
            if self.part[start] != NONE {
                continue;
            }
            let part = self.parts as u32;
            self.parts += 1;
            self.part[start] = part;
            self.agenda.push(start);
            while let Some(class) = self.agenda.pop() {
                for slot in 0..walk.size(class) {
                    let far = self.across[walk.dstate(class, slot)];
                    if far != NONE {
                        let next = walk.place_of(far as usize).0;
                        if std::mem::replace(&mut self.part[next], part) == NONE {
                            self.agenda.push(next);
                        }
                    }
                }
            }
        }
    }
}
