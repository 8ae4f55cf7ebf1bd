//! Whether conditions can hold of each of which one of several ways has to be taken, by what is learned where they cannot.
//!
//! Depth first: ways are taken one after the other, until some of them are too much together, a *conflict*, or nothing is left
//! to take. A branch that contains a conflict known from elsewhere ends at once. Where each way on from a branch ends, what
//! they ended by, without these ways themselves, is a conflict too; and where one of them ends by ways taken before it, so do
//! all beside it (conflict-directed backjumping, Prosser 1993). Of several questions the one comes first of which the fewest
//! ways are left that no known conflict ends at once (fail first, Haralick and Elliott 1980).

use std::collections::BTreeSet;

/// What there is beyond ways taken.
pub(super) enum Look<W> {
    /// Of each of these one way has to be taken; what is to be asked first comes first. At least one.
    Next(Vec<Ways<W>>),
    /// Of the ways taken these are too much together.
    Conflict(BTreeSet<W>),
    /// Nothing is left to take.
    Open,
    /// Nothing is found out.
    Unknown,
}

/// Ways one of which has to be taken.
pub(super) struct Ways<W> {
    /// A way taken before of which they are the parts: without it there would be others.
    pub(super) whole: Option<W>,
    /// Those that are to be tried first come first.
    pub(super) parts: Vec<W>,
}

/// Whether there are ways that can all be taken together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// There are.
    Found,
    /// There are none.
    Lacking,
    /// It is not found out.
    Unknown,
}

/// Whether ways can be taken until nothing is left to take, by asking `look` until it does not know.
///
/// Law: they are lacking exactly if every choice contains a conflict, where `look` is never open but of a choice of all, and
/// never unknown.
pub(super) fn choice<W: Copy + Ord>(look: impl FnMut(&[W]) -> Look<W>) -> Choice {
    match (Search { look, conflicts: Vec::new() }).branch(&mut Vec::new()) {
        Ok(_) => Choice::Lacking,
        Err(Ended::Open) => Choice::Found,
        Err(Ended::Unknown) => Choice::Unknown,
    }
}

/// Why a search ends before all branches do.
enum Ended {
    Open,
    Unknown,
}

struct Search<W, L> {
    look: L,
    conflicts: Vec<BTreeSet<W>>,
}

impl<W: Copy + Ord, L: FnMut(&[W]) -> Look<W>> Search<W, L> {
    /// Ends all branches beyond ways taken; those of them that are in conflict, if every branch ends. As deep as ways can be
    /// taken.
    fn branch(&mut self, taken: &mut Vec<W>) -> Result<BTreeSet<W>, Ended> {
        let holds = |conflict: &&BTreeSet<W>| conflict.iter().all(|way| taken.contains(way));
        if let Some(known) = self.conflicts.iter().find(holds) {
            return Ok(known.clone());
        }
        let conflict = match (self.look)(taken) {
            Look::Open => return Err(Ended::Open),
            Look::Unknown => return Err(Ended::Unknown),
            Look::Conflict(conflict) => conflict,
            Look::Next(questions) => {
                let ways = self.narrowest(questions, taken).ok_or(Ended::Unknown)?;
                let mut all: BTreeSet<W> = ways.whole.into_iter().collect();
                for way in ways.parts {
                    taken.push(way);
                    let mut conflict = self.branch(taken)?;
                    taken.pop();
                    if !conflict.remove(&way) {
                        return Ok(conflict);
                    }
                    all.append(&mut conflict);
                }
                all
            }
        };
        self.conflicts.push(conflict.clone());
        Ok(conflict)
    }

    /// The first of the questions of which the fewest ways are left, beyond those taken. As many steps as conflicts have ways, for each
    /// way taken.
    fn narrowest(&self, questions: Vec<Ways<W>>, taken: &[W]) -> Option<Ways<W>> {
        let last = |conflict: &BTreeSet<W>| {
            let mut others = conflict.iter().filter(|way| !taken.contains(way));
            others.next().copied().filter(|_| others.next().is_none())
        };
        let ended: BTreeSet<W> = self.conflicts.iter().filter_map(last).collect();
        let left = |ways: &Ways<W>| ways.parts.iter().filter(|way| !ended.contains(way)).count();
        questions.into_iter().min_by_key(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of a question, one of two sides and, of that, one of two parts.
    type Way = (usize, usize, Option<usize>);

    const QUESTIONS: usize = 4;

    fn ways() -> impl Strategy<Value = Way> {
        (0..QUESTIONS, 0usize..2, prop::option::of(0usize..2))
    }

    /// Every choice of parts, with the sides they are parts of.
    fn choices() -> Vec<BTreeSet<Way>> {
        let choice = |bits: usize| {
            let question = |question: usize| {
                let (side, part) = (bits >> (2 * question) & 1, bits >> (2 * question + 1) & 1);
                [(question, side, None), (question, side, Some(part))]
            };
            (0..QUESTIONS).flat_map(question).collect()
        };
        (0..1usize << (2 * QUESTIONS)).map(choice).collect()
    }

    /// What is beyond ways taken if these are the conflicts, and questions come in this order.
    fn look(conflicts: &[BTreeSet<Way>], order: &[usize], taken: &[Way]) -> Look<Way> {
        let holds = |conflict: &&BTreeSet<Way>| conflict.iter().all(|way| taken.contains(way));
        if let Some(conflict) = conflicts.iter().find(holds) {
            return Look::Conflict(conflict.clone());
        }
        let of = |question: usize| taken.iter().rfind(move |way| way.0 == question);
        let next = order.iter().filter(|&&question| of(question).is_none_or(|way| way.2.is_none()));
        let ways = next.map(|&question| match of(question) {
            None => Ways { whole: None, parts: vec![(question, 0, None), (question, 1, None)] },
            Some(&whole) => {
                let part = |part| (question, whole.1, Some(part));
                Ways { whole: Some(whole), parts: vec![part(0), part(1)] }
            }
        });
        let ways: Vec<Ways<Way>> = ways.collect();
        if ways.is_empty() { Look::Open } else { Look::Next(ways) }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2048, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn all_are_closed_exactly_if_every_choice_has_a_conflict(
            conflicts in prop::collection::vec(prop::collection::btree_set(ways(), 1..4), 0..24),
            order in Just((0..QUESTIONS).collect::<Vec<_>>()).prop_shuffle(),
        ) {
            let found = choice(|taken: &[Way]| look(&conflicts, &order, taken));
            let ended = |choice: &BTreeSet<Way>| conflicts.iter().any(|conflict| conflict.is_subset(choice));
            let all_end = choices().iter().all(ended);
            prop_assert_eq!(found, if all_end { Choice::Lacking } else { Choice::Found });
        }
    }

    #[test]
    fn what_is_not_known_is_not_closed() {
        let conflicts: Vec<BTreeSet<Way>> = [0, 1].map(|side| BTreeSet::from([(0, side, None)])).into();
        let asked = |most: usize| {
            let mut left = most;
            choice(|taken: &[Way]| {
                let known = left.checked_sub(1).map(|rest| left = rest);
                known.map_or(Look::Unknown, |()| look(&conflicts, &[0, 1, 2, 3], taken))
            })
        };
        assert_eq!([0, 1, 2].map(asked), [Choice::Unknown; 3]);
        assert_eq!(asked(3), Choice::Lacking);
    }

    #[test]
    fn the_question_with_the_fewest_ways_left_comes_first() {
        let [zero, one, three] = [(0, 0, None), (1, 0, None), (3, 0, None)];
        let conflicts = [[zero, three], [one, three], [one, (2, 1, None)]].map(BTreeSet::from);
        let search = Search { look: |_: &[Way]| Look::Unknown, conflicts: conflicts.into() };
        let first = |order: &[usize], taken: &[Way]| {
            let Look::Next(questions) = look(&[], order, taken) else { return None };
            search.narrowest(questions, taken).map(|ways| ways.parts)
        };
        let both = |question| Some(vec![(question, 0, None), (question, 1, None)]);
        assert_eq!(first(&[1, 2, 3], &[]), both(1), "where all have as many left the first one");
        assert_eq!(first(&[1, 2, 3], &[zero]), both(3));
        assert_eq!(first(&[2, 1], &[three]), both(1), "one of its two ways is ended");
        assert_eq!(first(&[3, 2, 1], &[one, (3, 1, None), (3, 1, Some(0))]), both(2));
    }
}
