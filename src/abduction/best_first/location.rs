//! What the settled places say of the classes that are open: where in the map each of them can lie.

use super::faces::Faces;
use super::quotient::{Quotient, members, turned, wrapped};
use super::walk::{Rotations, Walk};
use crate::abduction::AxiomId;

/// A set of faces, one bit each. Beyond the last bit faces share it, which only says less.
type Region = u64;

/// Where classes can lie: arc consistency (Mackworth 1977) over the path segments of the walk.
///
/// A class lies on a settled place under a rotation, or apart from all of them. Each path segment of the walk joins two
/// classes, and what is joined must go together:
/// * the far ends of one gateway are one place, so that a class that lies on a place must have its neighbours lie on the place's;
/// * under `planarity`, a path segment that is not one between settled places crosses none of these. It lies in one of their
///   faces; so do both its ends, which are places on that face's border or within it.
///
/// Faces are those of the largest connected part of what is settled; settled classes elsewhere lie within one of them.
/// What is ruled out here is ruled out in every map further down.
#[derive(Clone, Debug, Default)]
pub(super) struct Location {
    /// For each settled place's dstate the region of its corner, if it has one: empty where a path segment is.
    corner: Vec<Region>,
    /// For each settled place's dstate the dstate at the far end, settled or not, or [`NONE`].
    far: Vec<u32>,
    main: Vec<bool>,
    /// For each class the region in which it lies if it is no place of the largest part.
    within: Vec<Region>,
    fresh: Vec<bool>,
    others: Vec<usize>,
    /// The path segments of each class of `others`, one after the other.
    segments: Vec<Segment>,
    first: Vec<u32>,
    waiting: Vec<bool>,
    agenda: Vec<usize>,
    sizes: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    slot: usize,
    next: usize,
    gateway: usize,
    /// For the filter in progress: the region in which it lies.
    region: Region,
}

const NONE: u32 = u32::MAX;

impl Location {
    /// Rules out what cannot be, and notes it in the quotient; whether every class can still be somewhere. Faces, if
    /// planarity is held, are those of the quotient.
    pub(super) fn narrow(
        &mut self,
        walk: &Walk,
        quotient: &mut Quotient,
        faces: Option<&Faces>,
        may_be_new: &mut dyn FnMut(usize) -> bool,
        settled: &[usize],
        open: &[usize],
    ) -> Result<(), Option<AxiomId>> {
        self.prepare(walk, quotient, faces, may_be_new, settled, open);
        while let Some(index) = self.agenda.pop() {
            self.waiting[index] = false;
            match self.filter(walk, quotient, faces.is_some(), settled, index) {
                None => {
                    // A class that may be new can always be, but for planarity.
                    return Err(self.fresh[self.others[index]].then_some(AxiomId::Planarity));
                }
                Some(false) => {}
                Some(true) => {
                    for segment in self.first[index] as usize..self.first[index + 1] as usize {
                        let next = self.segments[segment].next;
                        if let Ok(next) = self.others.binary_search(&next)
                            && !self.waiting[next]
                        {
                            self.waiting[next] = true;
                            self.agenda.push(next);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether an open class can be a place unlike all settled ones.
    pub(super) fn can_be_new(&self, class: usize) -> bool {
        self.within[class] != 0 && self.fresh[class]
    }

    fn prepare(
        &mut self,
        walk: &Walk,
        quotient: &Quotient,
        faces: Option<&Faces>,
        may_be_new: &mut dyn FnMut(usize) -> bool,
        settled: &[usize],
        open: &[usize],
    ) {
        self.corner.resize(walk.dstates(), 0);
        self.far.resize(walk.dstates(), NONE);
        self.main.resize(walk.len(), false);
        self.within.resize(walk.len(), 0);
        for &class in settled {
            for slot in 0..walk.size(class) {
                let dstate = walk.dstate(class, slot);
                let far = quotient.far_end(walk, class, slot);
                self.far[dstate] = far.map_or(NONE, |(next, gateway)| walk.dstate(next, gateway) as u32);
            }
        }
        self.others.clear();
        let all = match faces {
            Some(faces) if !settled.is_empty() => self.survey(walk, faces, settled),
            _ => Region::MAX,
        };
        self.others.extend(open);
        self.others.sort_unstable();
        self.fresh.resize(walk.len(), true);
        for &class in &self.others {
            self.within[class] = all;
            self.fresh[class] = quotient.is_settled(class) || !walk.tracked(class) || may_be_new(class);
        }
        self.segments.clear();
        self.first.clear();
        for &class in &self.others {
            self.first.push(self.segments.len() as u32);
            for slot in members(quotient.filled(class)) {
                if let Some((next, gateway)) = quotient.far_end(walk, class, slot) {
                    self.segments.push(Segment { slot, next, gateway, region: 0 });
                }
            }
        }
        self.first.push(self.segments.len() as u32);
        self.waiting.clear();
        self.waiting.resize(self.others.len(), true);
        self.agenda.clear();
        self.agenda.extend((0..self.others.len()).rev());
    }

    /// Takes the faces of the largest part; the region of all of them.
    fn survey(&mut self, walk: &Walk, faces: &Faces, settled: &[usize]) -> Region {
        self.sizes.clear();
        self.sizes.resize(faces.parts(), 0);
        settled.iter().for_each(|&class| self.sizes[faces.part(class)] += 1);
        let largest = self.sizes.iter().copied().max();
        let largest = self.sizes.iter().position(|&size| Some(size) == largest);
        let mut all = 0;
        for &class in settled {
            self.main[class] = Some(faces.part(class)) == largest;
            if !self.main[class] {
                self.others.push(class);
                continue;
            }
            for slot in 0..walk.size(class) {
                let dstate = walk.dstate(class, slot);
                let region = faces.corner(dstate).map_or(0, |face| 1 << face.min(Region::BITS as usize - 1));
                self.corner[dstate] = region;
                all |= region;
            }
        }
        all
    }

    fn filter(
        &mut self,
        walk: &Walk,
        quotient: &mut Quotient,
        planar: bool,
        settled: &[usize],
        index: usize,
    ) -> Option<bool> {
        let class = self.others[index];
        if !walk.tracked(class) {
            return Some(false);
        }
        let own = self.first[index] as usize..self.first[index + 1] as usize;
        let before = self.within[class];
        if planar {
            for segment in own.clone() {
                let region = self.region(walk, quotient, settled, self.segments[segment]);
                self.segments[segment].region = region;
                self.within[class] &= region;
            }
        }
        let mut changed = self.within[class] != before;
        if quotient.is_settled(class) {
            return (self.within[class] != 0).then_some(changed);
        }
        let (mut on, mut inside) = (false, false);
        for &place in settled {
            let all = quotient.alike(class, place);
            if all == 0 {
                continue;
            }
            let mut left = all;
            let inner = planar && !self.main[place];
            if inner && self.within[class] & self.within[place] == 0 {
                left = 0;
            }
            for segment in own.clone() {
                left = self.fitting(walk, quotient, planar, &self.segments[segment], class, place, left);
            }
            if left != all {
                changed = true;
                members(all & !left).for_each(|rotation| quotient.refute(walk, class, place, rotation));
            }
            on |= left != 0;
            inside |= left != 0 && inner;
        }
        if !self.fresh[class] && !inside && planar {
            changed |= self.within[class] != 0;
            self.within[class] = 0;
        }
        (on || self.within[class] != 0 && self.fresh[class]).then_some(changed)
    }

    /// Where the path segment lies, as far as its other end tells.
    fn region(&self, walk: &Walk, quotient: &Quotient, settled: &[usize], segment: Segment) -> Region {
        let Segment { next, gateway, .. } = segment;
        if quotient.is_settled(next) && self.main[next] {
            return self.corner[walk.dstate(next, gateway)];
        }
        if !walk.tracked(next) {
            return Region::MAX;
        }
        let mut region = self.within[next];
        if quotient.is_settled(next) {
            return region;
        }
        let size = walk.size(next);
        for &place in settled.iter().filter(|&&place| self.main[place]) {
            let first = walk.dstate(place, 0);
            for rotation in members(quotient.alike(next, place)) {
                region |= self.corner[first + wrapped(gateway + rotation, size)];
            }
        }
        region
    }

    /// Of the rotations that might lay a class on a place, those under which a path segment of the class goes with it.
    fn fitting(
        &self,
        walk: &Walk,
        quotient: &Quotient,
        planar: bool,
        segment: &Segment,
        class: usize,
        place: usize,
        mut left: Rotations,
    ) -> Rotations {
        let size = walk.size(class);
        let taken = left & turned(quotient.filled(place), size - segment.slot, size);
        let first = walk.dstate(place, 0);
        for rotation in members(taken) {
            let far = self.far[first + wrapped(segment.slot + rotation, size)];
            let (other, slot) = walk.place_of(far as usize);
            let beyond = walk.size(other);
            let turn = wrapped(slot + beyond - segment.gateway, beyond);
            let fits = walk.size(segment.next) == beyond
                && (!walk.tracked(other) || quotient.alike(segment.next, other) >> turn & 1 == 1);
            left &= !(Rotations::from(!fits) << rotation);
        }
        if planar && self.main[place] {
            for rotation in members(left) {
                let corner = self.corner[first + wrapped(segment.slot + rotation, size)];
                // A path segment between settled places is there, and judged above.
                let fits = corner == 0 || corner & segment.region != 0;
                left &= !(Rotations::from(!fits) << rotation);
            }
        }
        left
    }
}
