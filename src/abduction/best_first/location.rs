//! What the settled places say of the classes that are open: where in the map each of them can lie.

use super::faces::Faces;
use super::quotient::Quotient;
use super::rotations::{Rotations, members, turned, wrapped};
use super::walk::Walk;
use crate::abduction::AxiomId;
use std::ops::Range;

/// A set of faces, one bit each. Beyond the last bit faces share it, which only says less.
type Region = u64;

/// Where classes can lie: arc consistency (Mackworth 1977) over the path segments of the walk.
///
/// A class lies on a settled place under a rotation, or apart from all of them. Each path segment of the walk joins two
/// classes, and what is joined must go together:
/// * the far ends of one gateway are one place, so that a class on a place has its neighbours on those of the place;
/// * under `planarity`, a path segment that is not one between settled places crosses none of these. It lies in one of
///   their faces; so do both its ends, which are places on that face's border or within it.
///
/// Faces are those of the largest connected part of what is settled, the *main* part; settled classes elsewhere lie within
/// one of them. What is ruled out here is ruled out in every map further down. Stars without sets of rotations are left
/// out. One pass takes open classes times settled ones times slots; all is worked out anew for each quotient, and what
/// stays is the memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Location {
    /// For each dstate of a main place the face of its corner; empty where a path segment between settled places is.
    corner: Vec<Region>,
    /// For each dstate of a settled place the one at its far end, settled or not, or [`NONE`].
    far: Vec<u32>,
    /// For each settled class whether it is of the main part.
    main: Vec<bool>,
    /// For each other class the faces in which it can lie if it is no main place.
    within: Vec<Region>,
    /// For each other class whether it can be a place unlike all settled ones.
    fresh: Vec<bool>,
    /// The classes that are no main places, ascending.
    others: Vec<usize>,
    /// The path segments of each of them, one after the other, and where they begin.
    segments: Vec<Segment>,
    first: Vec<u32>,
    /// Those of them that are to be looked at, by position.
    agenda: Vec<usize>,
    waiting: Vec<bool>,
    sizes: Vec<usize>,
}

/// A path segment of the walk, from a slot of one class to the gateway of another.
#[derive(Clone, Copy, Debug)]
struct Segment {
    slot: usize,
    next: usize,
    gateway: usize,
    /// Where it can lie, as far as its other end tells.
    region: Region,
}

/// What does not change while classes are looked at.
#[derive(Clone, Copy)]
struct Scene<'a> {
    walk: &'a Walk,
    settled: &'a [usize],
    planar: bool,
}

/// No far end.
const NONE: u32 = u32::MAX;

impl Location {
    /// Rules out what cannot be, and notes it in the quotient. An error says that some class can be nowhere: the axiom
    /// that says so, or none if it could be a new place but for `may_be_new`, which is asked of each open class. The faces
    /// are those of the quotient, given if planarity is held.
    pub(super) fn narrow(
        &mut self,
        walk: &Walk,
        quotient: &mut Quotient,
        faces: Option<&Faces>,
        may_be_new: &mut dyn FnMut(usize) -> bool,
        [settled, open]: [&[usize]; 2],
    ) -> Result<(), Option<AxiomId>> {
        self.survey(walk, quotient, faces, [settled, open]);
        self.fresh.resize(walk.len(), true);
        for &class in &self.others {
            self.fresh[class] = quotient.is_settled(class) || !walk.tracked(class) || may_be_new(class);
        }
        self.list_segments(walk, quotient);
        let scene = Scene { walk, settled, planar: faces.is_some() };
        while let Some(index) = self.agenda.pop() {
            self.waiting[index] = false;
            match self.look(scene, quotient, index) {
                // A class that may be new can always be, but for planarity.
                None => return Err(self.fresh[self.others[index]].then_some(AxiomId::Planarity)),
                Some(true) => self.wake_neighbours(index),
                Some(false) => {}
            }
        }
        Ok(())
    }

    /// Whether an open class can be a place unlike all settled ones.
    pub(super) fn can_be_new(&self, class: usize) -> bool {
        self.within[class] != 0 && self.fresh[class]
    }

    /// Takes the far ends of the settled places and the faces of the main ones.
    fn survey(
        &mut self,
        walk: &Walk,
        quotient: &Quotient,
        faces: Option<&Faces>,
        [settled, open]: [&[usize]; 2],
    ) {
        self.corner.resize(walk.dstates(), 0);
        self.far.resize(walk.dstates(), NONE);
        self.main.resize(walk.len(), false);
        self.within.resize(walk.len(), 0);
        for &class in settled {
            for slot in 0..walk.size(class) {
                let far = quotient.far_end(walk, class, slot);
                self.far[walk.dstate(class, slot)] =
                    far.map_or(NONE, |(next, gateway)| walk.dstate(next, gateway) as u32);
            }
        }
        self.others.clear();
        let all = match faces {
            Some(faces) if !settled.is_empty() => self.take_faces(walk, faces, settled),
            _ => Region::MAX,
        };
        self.others.extend(open);
        self.others.sort_unstable();
        self.others.iter().for_each(|&class| self.within[class] = all);
    }

    /// Takes the faces of the main part; all of them.
    fn take_faces(&mut self, walk: &Walk, faces: &Faces, settled: &[usize]) -> Region {
        self.sizes.clear();
        self.sizes.resize(faces.parts(), 0);
        settled.iter().for_each(|&class| self.sizes[faces.part(class)] += 1);
        let largest = self.sizes.iter().copied().max();
        let main = self.sizes.iter().position(|&size| Some(size) == largest);
        let mut all = 0;
        for &class in settled {
            self.main[class] = Some(faces.part(class)) == main;
            if !self.main[class] {
                self.others.push(class);
                continue;
            }
            for slot in 0..walk.size(class) {
                let dstate = walk.dstate(class, slot);
                let bit = |face: usize| 1 << face.min(Region::BITS as usize - 1);
                self.corner[dstate] = faces.corner(dstate).map_or(0, bit);
                all |= self.corner[dstate];
            }
        }
        all
    }

    /// Lists the path segments of the other classes, and puts all of these on the agenda.
    fn list_segments(&mut self, walk: &Walk, quotient: &Quotient) {
        self.segments.clear();
        self.first.clear();
        for &class in &self.others {
            self.first.push(self.segments.len() as u32);
            for slot in members(quotient.filled(class)) {
                if let Some((next, gateway)) = quotient.far_end(walk, class, slot) {
                    self.segments.push(Segment { slot, next, gateway, region: Region::MAX });
                }
            }
        }
        self.first.push(self.segments.len() as u32);
        self.waiting.clear();
        self.waiting.resize(self.others.len(), true);
        self.agenda.clear();
        self.agenda.extend((0..self.others.len()).rev());
    }

    fn wake_neighbours(&mut self, index: usize) {
        for segment in self.segments_of(index) {
            if let Ok(next) = self.others.binary_search(&self.segments[segment].next)
                && !std::mem::replace(&mut self.waiting[next], true)
            {
                self.agenda.push(next);
            }
        }
    }

    fn segments_of(&self, index: usize) -> Range<usize> {
        self.first[index] as usize..self.first[index + 1] as usize
    }

    /// Rules out where a class cannot lie; whether anything was, or none if nothing is left.
    fn look(&mut self, scene: Scene<'_>, quotient: &mut Quotient, index: usize) -> Option<bool> {
        let class = self.others[index];
        if !scene.walk.tracked(class) {
            return Some(false);
        }
        let before = self.within[class];
        if scene.planar {
            for segment in self.segments_of(index) {
                let region = self.region(scene, quotient, self.segments[segment]);
                self.segments[segment].region = region;
                self.within[class] &= region;
            }
        }
        if quotient.is_settled(class) {
            return (self.within[class] != 0).then_some(self.within[class] != before);
        }
        let (mut somewhere, mut inside, mut ruled_out) = (false, false, false);
        for &place in scene.settled {
            let all = quotient.alike(class, place);
            let left = self.fitting(scene, quotient, index, place, all);
            members(all & !left).for_each(|rotation| quotient.refute(scene.walk, class, place, rotation));
            ruled_out |= left != all;
            somewhere |= left != 0;
            inside |= left != 0 && scene.planar && !self.main[place];
        }
        // Within a face it is a new place, or one of those settled that lie there.
        if scene.planar && !self.fresh[class] && !inside {
            self.within[class] = 0;
        }
        (somewhere || self.can_be_new(class)).then_some(ruled_out || self.within[class] != before)
    }

    /// The faces in which a path segment can lie, as far as its other end tells.
    fn region(&self, scene: Scene<'_>, quotient: &Quotient, segment: Segment) -> Region {
        let (walk, Segment { next, gateway, .. }) = (scene.walk, segment);
        if !walk.tracked(next) {
            return Region::MAX;
        }
        if quotient.is_settled(next) {
            return if self.main[next] { self.corner[walk.dstate(next, gateway)] } else { self.within[next] };
        }
        let mut region = self.within[next];
        for &place in scene.settled.iter().filter(|&&place| self.main[place]) {
            for rotation in members(quotient.alike(next, place)) {
                region |= self.corner[walk.dstate(place, wrapped(gateway + rotation, walk.size(next)))];
            }
        }
        region
    }

    /// Of the rotations that might lay a class on a settled place, those under which all its path segments go with it.
    fn fitting(
        &self,
        scene: Scene<'_>,
        quotient: &Quotient,
        index: usize,
        place: usize,
        mut left: Rotations,
    ) -> Rotations {
        let inside = scene.planar && !self.main[place];
        if left == 0 || inside && self.within[self.others[index]] & self.within[place] == 0 {
            return 0;
        }
        for segment in &self.segments[self.segments_of(index)] {
            left = self.following(scene.walk, quotient, segment, place, left);
            if scene.planar && !inside {
                left = self.uncrossed(scene.walk, segment, place, left);
            }
        }
        left
    }

    /// Those under which the far end of a path segment can be that of the place's gateway, if this has one.
    fn following(
        &self,
        walk: &Walk,
        quotient: &Quotient,
        segment: &Segment,
        place: usize,
        mut left: Rotations,
    ) -> Rotations {
        let size = walk.size(place);
        let taken = left & turned(quotient.filled(place), size - segment.slot, size);
        for rotation in members(taken) {
            let far = self.far[walk.dstate(place, wrapped(segment.slot + rotation, size))];
            let (other, slot) = walk.place_of(far as usize);
            let beyond = walk.size(other);
            let turn = || wrapped(slot + beyond - segment.gateway, beyond);
            let fits = walk.size(segment.next) == beyond
                && (!walk.tracked(other) || quotient.alike(segment.next, other) >> turn() & 1 == 1);
            left &= !(Rotations::from(!fits) << rotation);
        }
        left
    }

    /// Those under which a path segment leaves a main place into a face in which it can lie.
    fn uncrossed(&self, walk: &Walk, segment: &Segment, place: usize, mut left: Rotations) -> Rotations {
        for rotation in members(left) {
            let corner = self.corner[walk.dstate(place, wrapped(segment.slot + rotation, walk.size(place)))];
            // Where a path segment between settled places is, it is that one or none: see `following`.
            let fits = corner == 0 || corner & segment.region != 0;
            left &= !(Rotations::from(!fits) << rotation);
        }
        left
    }
}
