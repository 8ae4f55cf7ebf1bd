//! The walk with some visits taken for one place: a quotient, closed under all that follows.

use super::rotations::{Rotations, reversed, turned, wrapped};
use super::trailed::Trailed;
use super::walk::Walk;
use crate::abduction::{AxiomId, AxiomSet};

/// Classes of visits, each to be one place of the map.
///
/// At first every visit is a class of its own, and the map is the walk itself. [`Quotient::merge`] takes two
/// classes for one place, under a rotation; *folding* follows: a gateway has one far end, so that the classes beyond equal
/// gateways merge too, and so on, in both directions of travel and over the whole walk. What cannot be shows at once,
/// long before the walk comes to where a chronological search would find it.
///
/// Laws: what is merged stays so in every quotient further down, so that any axiom broken here is broken there.
/// A *settled* class is a place of its own, never merged with another settled one.
#[derive(Clone, Debug, Default)]
pub(super) struct Quotient {
    /// For each visit the visit that names its class.
    name: Trailed<u16>,
    /// For each visit how many slots further on the star of the naming visit its slots are.
    turn: Trailed<u8>,
    /// The visits of a class in a ring.
    next: Trailed<u16>,
    /// For each dstate of a naming visit the dstate at its far end, of any visit of the class there; [`NONE`] without.
    far: Trailed<u32>,
    /// For each naming visit the slots with a far end, where sets are kept.
    filled: Trailed<Rotations>,
    settled: Trailed<bool>,
    /// One cell: the number of classes.
    count: Trailed<usize>,
    /// For each two naming visits the rotations under which they might still be one place; see [`pair`].
    alike: Trailed<Rotations>,
    /// The classes when they were last listed: all that there are now are among them.
    roots: Vec<u16>,
    /// For each visit and each dstate the last pass along a path that came to it.
    passed: Vec<u64>,
    walked: Vec<u64>,
    pass: u64,
    merges: Vec<Merge>,
    touched: Vec<usize>,
    /// Pairs of classes compared so far.
    compared: u64,
}

/// A state to come back to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark([usize; 8]);

/// Slot `s` of visit `visit` is slot `s + rotation` of visit `onto`.
#[derive(Clone, Copy, Debug)]
struct Merge {
    visit: usize,
    onto: usize,
    rotation: usize,
}

/// No far end.
const NONE: u32 = u32::MAX;

impl Quotient {
    /// Goes on to the last visit of the walk, for good; an error is the axiom that the walk breaks. To be called in a
    /// state that nothing is to be undone from. Linear in the visits, but for what folds.
    pub(super) fn push(&mut self, walk: &Walk, axioms: AxiomSet) -> Result<(), AxiomId> {
        let visit = walk.len() - 1;
        self.name.push(visit as u16);
        self.turn.push(0);
        self.next.push(visit as u16);
        (0..walk.size(visit)).for_each(|_| self.far.push(NONE));
        self.filled.push(0);
        self.settled.push(false);
        match visit {
            0 => self.count.push(1),
            _ => self.count.set(0, self.count() + 1),
        }
        (0..visit).for_each(|other| self.alike.push(matching(walk, visit, other)));
        self.alike.push(1);
        (0..visit).for_each(|other| self.alike.push(matching(walk, other, visit)));
        self.roots.push(visit as u16);
        self.passed.push(0);
        self.walked.resize(walk.dstates(), 0);
        let travelled = if visit == 0 { Ok(()) } else { self.travel(walk, visit, axioms) };
        self.commit();
        travelled
    }

    /// What is, is for good: no mark from before is valid any more.
    pub(super) fn commit(&mut self) {
        let Quotient { name, turn, next, far, filled, settled, count, alike, .. } = self;
        [name, next].into_iter().for_each(Trailed::commit);
        [filled, alike].into_iter().for_each(Trailed::commit);
        turn.commit();
        far.commit();
        settled.commit();
        count.commit();
    }

    /// Back to what is for good.
    pub(super) fn reset(&mut self) {
        self.undo(Mark([0; 8]));
    }

    /// Bytes held, as many as there is something in them.
    pub(super) fn bytes(&self) -> usize {
        let Quotient { name, turn, next, far, filled, settled, count, alike, .. } = self;
        let narrow =
            name.bytes() + turn.bytes() + next.bytes() + far.bytes() + settled.bytes() + count.bytes();
        let passes = size_of_val(self.passed.as_slice()) + size_of_val(self.walked.as_slice());
        narrow + filled.bytes() + alike.bytes() + passes
    }

    /// Takes two different classes for one place: slot `s` of `class` is slot `s + rotation` of `onto`. After an
    /// error the quotient is good for nothing but [`Quotient::undo`].
    pub(super) fn merge(
        &mut self,
        walk: &Walk,
        class: usize,
        onto: usize,
        rotation: usize,
        axioms: AxiomSet,
    ) -> Result<(), AxiomId> {
        self.merges.clear();
        self.touched.clear();
        self.merges.push(Merge { visit: class, onto, rotation });
        while let Some(merge) = self.merges.pop() {
            self.fold(walk, merge)?;
        }
        self.check_paths(walk, axioms)
    }

    /// Settles that a class is a place unlike all settled ones.
    pub(super) fn settle(&mut self, class: usize, others: &[usize]) {
        self.settled.set(class, true);
        for &other in others {
            self.set_alike(class, other, 0);
            self.set_alike(other, class, 0);
        }
    }

    /// Notes that a class cannot lie on another under a rotation.
    pub(super) fn refute(&mut self, walk: &Walk, class: usize, onto: usize, rotation: usize) {
        if walk.tracked(class) {
            let back = wrapped(walk.size(class) - rotation, walk.size(class));
            self.set_alike(class, onto, self.alike(class, onto) & !(1 << rotation));
            self.set_alike(onto, class, self.alike(onto, class) & !(1 << back));
        }
    }

    /// The visit that names the class of a visit, and the rotation onto it.
    pub(super) fn class(&self, visit: usize) -> (usize, usize) {
        (self.name.get(visit) as usize, self.turn.get(visit) as usize)
    }

    /// The classes, by naming visit.
    pub(super) fn classes(&self, walk: &Walk) -> impl Iterator<Item = usize> {
        (0..walk.len()).filter(|&visit| self.name.get(visit) as usize == visit)
    }

    /// Lists the classes, so that merging need not look for them. To be called again after [`Quotient::undo`].
    pub(super) fn list(&mut self, classes: &[usize]) {
        self.roots.clear();
        self.roots.extend(classes.iter().map(|&class| class as u16));
    }

    /// What merging has cost so far, in pairs of classes compared. Undoing does not take it back.
    pub(super) fn compared(&self) -> u64 {
        self.compared
    }

    /// The number of classes.
    pub(super) fn count(&self) -> usize {
        self.count.get(0)
    }

    /// The visits of a class.
    pub(super) fn visits(&self, class: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(class), move |&visit| {
            Some(self.next.get(visit) as usize).filter(|&next| next != class)
        })
    }

    /// Whether a class is a place of its own.
    pub(super) fn is_settled(&self, class: usize) -> bool {
        self.settled.get(class)
    }

    /// The rotations under which a class might still lie on another.
    pub(super) fn alike(&self, class: usize, onto: usize) -> Rotations {
        self.alike.get(pair(class, onto))
    }

    /// The slots of a class with a far end, one bit each; none for stars without sets.
    pub(super) fn filled(&self, class: usize) -> Rotations {
        self.filled.get(class)
    }

    /// The class and slot at the far end of a class's slot.
    pub(super) fn far_end(&self, walk: &Walk, class: usize, slot: usize) -> Option<(usize, usize)> {
        let far = self.far.get(walk.dstate(class, slot));
        (far != NONE).then(|| self.resolve(walk, far))
    }

    /// The present state.
    pub(super) fn mark(&self) -> Mark {
        let Quotient { name, turn, next, far, filled, settled, count, alike, .. } = self;
        let marks = [name.mark(), turn.mark(), next.mark(), far.mark()];
        Mark([
            marks[0],
            marks[1],
            marks[2],
            marks[3],
            filled.mark(),
            settled.mark(),
            count.mark(),
            alike.mark(),
        ])
    }

    /// Back to a state before.
    pub(super) fn undo(&mut self, Mark([name, turn, next, far, filled, settled, count, alike]): Mark) {
        self.name.undo(name);
        self.turn.undo(turn);
        self.next.undo(next);
        self.far.undo(far);
        self.filled.undo(filled);
        self.settled.undo(settled);
        self.count.undo(count);
        self.alike.undo(alike);
    }

    /// Adds the travel to a visit. One that goes back where the visit before came from folds at once.
    fn travel(&mut self, walk: &Walk, visit: usize, axioms: AxiomSet) -> Result<(), AxiomId> {
        let (departure, gateway) = walk.travel(visit);
        let (from, turn) = self.class(visit - 1);
        let from = walk.dstate(from, wrapped(departure + turn, walk.size(from)));
        let to = walk.dstate(visit, gateway);
        self.set_far(walk, to, from as u32);
        match self.far.get(from) {
            NONE => {
                self.set_far(walk, from, to as u32);
                Ok(())
            }
            known => {
                let (onto, slot) = self.resolve(walk, known);
                let size = walk.size(visit);
                if walk.size(onto) != size {
                    return Err(AxiomId::StarMatch);
                }
                self.merge(walk, visit, onto, wrapped(slot + size - gateway, size), axioms)
            }
        }
    }

    /// Merges two classes, and notes which others have to follow.
    fn fold(&mut self, walk: &Walk, Merge { visit, onto, rotation }: Merge) -> Result<(), AxiomId> {
        let ((a, turn_a), (b, turn_b)) = (self.class(visit), self.class(onto));
        let size = walk.size(a);
        if walk.size(b) != size {
            return Err(AxiomId::StarMatch);
        }
        let rotation = wrapped(wrapped(rotation + turn_b, size) + size - turn_a, size);
        if a == b {
            return if rotation == 0 { Ok(()) } else { Err(AxiomId::Determinism) };
        }
        if self.settled.get(a) && self.settled.get(b) {
            return Err(AxiomId::Determinism);
        }
        let absorbed = !self.settled.get(a) && (self.settled.get(b) || b < a);
        let (from, to, rotation) =
            if absorbed { (a, b, rotation) } else { (b, a, wrapped(size - rotation, size)) };
        self.compared += self.roots.len() as u64;
        if !walk.matches(from, to).contains(&(rotation as u8)) {
            return Err(AxiomId::StarMatch);
        }
        self.narrow(walk, from, to, rotation)?;
        self.rename(walk, from, to, rotation);
        self.touched.push(to);
        self.count.set(0, self.count.get(0) - 1);
        for slot in 0..size {
            let far = self.far.get(walk.dstate(from, slot));
            if far == NONE {
                continue;
            }
            let own = walk.dstate(to, wrapped(slot + rotation, size));
            match self.far.get(own) {
                NONE => self.set_far(walk, own, far),
                known => self.follow(walk, far, known)?,
            }
        }
        Ok(())
    }

    /// The far ends of one gateway are one gateway.
    fn follow(&mut self, walk: &Walk, far: u32, known: u32) -> Result<(), AxiomId> {
        let ((visit, slot), (onto, known)) = (self.resolve(walk, far), self.resolve(walk, known));
        let size = walk.size(visit);
        if walk.size(onto) != size {
            return Err(AxiomId::StarMatch);
        }
        if visit != onto || slot != known {
            self.merges.push(Merge { visit, onto, rotation: wrapped(known + size - slot, size) });
        }
        Ok(())
    }

    /// What the merged class might still lie on is what both might.
    fn narrow(&mut self, walk: &Walk, from: usize, to: usize, rotation: usize) -> Result<(), AxiomId> {
        if !walk.tracked(from) {
            return Ok(());
        }
        if self.alike(from, to) & (1 << rotation) == 0 {
            return Err(AxiomId::Determinism);
        }
        let size = walk.size(from);
        for index in 0..self.roots.len() {
            let other = self.roots[index] as usize;
            let is_class = self.name.get(other) as usize == other;
            if !is_class || other == from || other == to || walk.size(other) != size {
                continue;
            }
            // A rotation from `from` onto `other` is that from `to`, further on by `rotation`.
            let own = self.alike(to, other);
            let both = own & turned(self.alike(from, other), size - rotation, size);
            if both != own {
                self.set_alike(to, other, both);
                self.set_alike(other, to, reversed(both, size));
            }
        }
        Ok(())
    }

    fn rename(&mut self, walk: &Walk, from: usize, to: usize, rotation: usize) {
        let size = walk.size(from);
        let mut visit = from;
        loop {
            self.name.set(visit, to as u16);
            self.turn.set(visit, wrapped(self.turn.get(visit) as usize + rotation, size) as u8);
            visit = self.next.get(visit) as usize;
            if visit == from {
                break;
            }
        }
        // Two rings become one by crossing over.
        let (a, b) = (self.next.get(from), self.next.get(to));
        self.next.set(from, b);
        self.next.set(to, a);
    }

    /// Whether the paths through all classes just merged are still in order, and no travel stays where it was.
    fn check_paths(&mut self, walk: &Walk, axioms: AxiomSet) -> Result<(), AxiomId> {
        let before = self.pass;
        for index in 0..self.touched.len() {
            let class = self.touched[index];
            if self.name.get(class) as usize != class {
                continue;
            }
            for slot in 0..walk.size(class) {
                match self.far_end(walk, class, slot) {
                    Some(far) if far == (class, slot) => return Err(AxiomId::Determinism),
                    Some((far, _)) if far == class && axioms.contains(AxiomId::TravelMoves) => {
                        return Err(AxiomId::TravelMoves);
                    }
                    _ => {}
                }
                let is_new = self.walked[walk.dstate(class, slot)] <= before;
                if is_new && axioms.contains(AxiomId::PathOrder) && !self.in_order(walk, class, slot) {
                    return Err(AxiomId::PathOrder);
                }
            }
        }
        Ok(())
    }

    /// Whether the path through a slot comes to every place once.
    fn in_order(&mut self, walk: &Walk, class: usize, slot: usize) -> bool {
        self.pass += 1;
        self.passed[class] = self.pass;
        [slot, walk.opposite(class, slot)].into_iter().all(|start| {
            let (mut at, mut ahead) = (class, start);
            loop {
                self.walked[walk.dstate(at, ahead)] = self.pass;
                let Some((next, gateway)) = self.far_end(walk, at, ahead) else { return true };
                if self.passed[next] == self.pass {
                    return false;
                }
                self.passed[next] = self.pass;
                self.walked[walk.dstate(next, gateway)] = self.pass;
                (at, ahead) = (next, walk.opposite(next, gateway));
            }
        })
    }

    fn resolve(&self, walk: &Walk, dstate: u32) -> (usize, usize) {
        let (visit, slot) = walk.place_of(dstate as usize);
        let (class, turn) = self.class(visit);
        (class, wrapped(slot + turn, walk.size(class)))
    }

    fn set_far(&mut self, walk: &Walk, dstate: usize, far: u32) {
        self.far.set(dstate, far);
        let (visit, slot) = walk.place_of(dstate);
        if walk.tracked(visit) {
            self.filled.set(visit, self.filled.get(visit) | 1 << slot);
        }
    }

    fn set_alike(&mut self, class: usize, onto: usize, rotations: Rotations) {
        self.alike.set(pair(class, onto), rotations);
    }
}

/// The position of an ordered pair of visits among all, such that those of the first visits come first.
fn pair(a: usize, b: usize) -> usize {
    if a >= b { a * a + b } else { b * b + b + 1 + a }
}

/// The rotations by which the star of a visit lies on that of another; all, where sets are not kept.
fn matching(walk: &Walk, visit: usize, onto: usize) -> Rotations {
    let matches = walk.matches(visit, onto);
    match walk.tracked(visit) {
        true => matches.iter().fold(0, |set, &rotation| set | 1 << rotation),
        false if matches.is_empty() => 0,
        false => Rotations::MAX,
    }
}
