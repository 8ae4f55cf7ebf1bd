//! What holds of a walk before anything is decided. It grows with the walk, by a visit at a time.

use super::quotient::Quotient;
use super::rotations::members;
use super::walk::Walk;
use crate::abduction::{AxiomId, AxiomSet, Refutations, Visit};

/// A walk, its quotient, and of every two classes whether they might be one place at all.
///
/// A visit is asked for, with each class before it, when the walk has come to it and no further: what cannot be then
/// cannot be later. So what is known depends on the walk alone, and a visit costs its own row of questions. They save work
/// later, and no answer rests on them; so a row that takes too long is broken off.
#[derive(Clone, Debug, Default)]
pub(super) struct Ground {
    pub(super) walk: Walk,
    pub(super) quotient: Quotient,
    /// What the axioms refuted.
    pub(super) refuted: Refutations,
    /// The axiom that the walk breaks however it is explained.
    pub(super) broken: Option<AxiomId>,
}

/// The most pairs of classes compared for a row: a millisecond or two.
const MOST_COMPARED: u64 = 1 << 18;

impl Ground {
    /// Goes on to a visit. Linear in the visits, times folding. To be called when nothing is decided.
    pub(super) fn push(&mut self, visit: &Visit, axioms: AxiomSet) {
        self.walk.push(visit);
        if self.broken.is_some() {
            return;
        }
        self.broken = self.quotient.push(&self.walk, axioms).err();
        let class = self.walk.len() - 1;
        if self.broken.is_none() && self.quotient.class(class).0 == class && self.walk.tracked(class) {
            self.tell_apart(class, axioms);
        }
        self.quotient.commit();
    }

    /// Bytes held, as many as there is something in them.
    pub(super) fn bytes(&self) -> usize {
        self.walk.bytes() + self.quotient.bytes()
    }

    /// Bytes that one visit more will take.
    pub(super) fn bytes_of_next(&self) -> usize {
        2 * size_of::<u64>() * self.walk.len()
    }

    /// Back to where nothing is decided.
    pub(super) fn reset(&mut self) {
        self.quotient.reset();
        let classes: Vec<usize> = self.quotient.classes(&self.walk).collect();
        self.quotient.list(&classes);
    }

    /// The number of classes that are left if one lies on another; none if it cannot, which is noted and counted.
    /// `holds` is asked of the quotient then.
    pub(super) fn probe(
        &mut self,
        [class, onto, rotation]: [usize; 3],
        axioms: AxiomSet,
        refuted: &mut Refutations,
        holds: impl FnOnce(&Walk, &Quotient) -> Result<(), AxiomId>,
    ) -> Option<usize> {
        let Ground { walk, quotient, .. } = self;
        let mark = quotient.mark();
        let merged = quotient.merge(walk, class, onto, rotation, axioms);
        let left = quotient.count();
        let merged = merged.and_then(|()| holds(walk, quotient));
        quotient.undo(mark);
        match merged {
            Ok(()) => Some(left),
            Err(axiom) => {
                refuted.count(axiom);
                quotient.refute(walk, class, onto, rotation);
                None
            }
        }
    }

    /// The rotations by which a class might lie on another, ascending.
    pub(super) fn rotations(&self, class: usize, onto: usize) -> impl Iterator<Item = usize> + use<> {
        let (kept, listed) = match self.walk.tracked(class) {
            true => (self.quotient.alike(class, onto), Vec::new()),
            false => (0, self.walk.matches(class, onto).to_vec()),
        };
        members(kept).chain(listed.into_iter().map(usize::from))
    }

    /// Asks of a class and every one before, under each rotation, whether they can be one place.
    fn tell_apart(&mut self, class: usize, axioms: AxiomSet) {
        let mut refuted = self.refuted;
        let before: Vec<usize> = self.quotient.classes(&self.walk).filter(|&onto| onto < class).collect();
        let compared = self.quotient.compared();
        for onto in before {
            if self.quotient.compared() - compared > MOST_COMPARED {
                break;
            }
            for rotation in self.rotations(class, onto) {
                let _ = self.probe([class, onto, rotation], axioms, &mut refuted, |_, _| Ok(()));
            }
        }
        self.refuted = refuted;
    }
}
