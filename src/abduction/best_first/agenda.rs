//! Decisions, and the memory of their lists.

use super::quotient::{Mark, Quotient};
use super::walk::Walk;
use crate::abduction::Simplicity;

/// What one class is to be.
#[derive(Clone, Debug)]
pub(super) struct Decision {
    pub(super) class: usize,
    pub(super) lists: Lists,
    pub(super) mark: Mark,
    pub(super) bound: Simplicity,
}

/// The classes of a quotient, and of one of them each way that is left, with the classes it leaves, the last first.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    pub(super) classes: Vec<usize>,
    pub(super) settled: Vec<usize>,
    pub(super) open: Vec<usize>,
    pub(super) ways: Vec<(usize, Way)>,
}

/// Lists no longer used, whose memory is.
#[derive(Clone, Debug, Default)]
pub(super) struct Spare(Vec<Lists>);

#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    Merged { onto: usize, rotation: usize },
    New,
}

impl Lists {
    pub(super) fn fill(&mut self, walk: &Walk, quotient: &Quotient) {
        let Lists { classes, settled, open, ways } = self;
        [&mut *classes, &mut *settled, &mut *open].into_iter().for_each(Vec::clear);
        ways.clear();
        for class in quotient.classes(walk) {
            classes.push(class);
            if quotient.is_settled(class) { &mut *settled } else { &mut *open }.push(class);
        }
    }

    /// Bytes held, as many as there is something in them.
    pub(super) fn bytes(&self) -> usize {
        2 * size_of_val(self.classes.as_slice()) + size_of_val(self.ways.as_slice()) + size_of::<Decision>()
    }
}

impl Spare {
    pub(super) fn take(&mut self) -> Lists {
        self.0.pop().unwrap_or_default()
    }

    pub(super) fn give(&mut self, lists: Lists) {
        self.0.push(lists);
    }
}
