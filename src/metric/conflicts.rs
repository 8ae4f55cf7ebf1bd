//! Whether conditions can hold of each of which one of several ways has to be taken, by what is learned where they cannot.
//!
//! Depth first: ways are taken one after the other, until some of them are too much together, a *conflict*, or nothing is left
//! to take. A branch that contains a conflict known from elsewhere ends at once. Where each way on from a branch ends, what
//! they ended by, without these ways themselves, is a conflict too; and where one of them ends by ways taken before it, so do
//! all beside it (conflict-directed backjumping, Prosser 1993). Of several questions the one comes first of which the fewest
//! ways are left that no known conflict ends at once (fail first, Haralick and Elliott 1980).
//!
//! What a search has learned another one may know from the beginning, as far as it holds there.

use rustc_hash::FxHashSet;
use std::collections::BTreeSet;
use std::hash::Hash;
use std::sync::Arc;

/// Ways that are too much together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Conflict<W, R> {
    /// Ascending.
    pub(super) ways: Box<[W]>,
    /// How far it holds: as far as all do that it follows from.
    pub(super) holds: f64,
    /// The least of the reasons of these.
    pub(super) reason: R,
}

/// Conflicts that are known.
pub(super) type Known<W, R> = Vec<Arc<Conflict<W, R>>>;

/// What there is beyond ways taken.
pub(super) enum Look<W, R> {
    /// Of each of these one way has to be taken; what is to be asked first comes first. At least one.
    Next(Vec<Ways<W>>),
    /// Of the ways taken these are too much together.
    Conflict(Conflict<W, R>),
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
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Choice<W, R> {
    /// There are.
    Found,
    /// There are none: a conflict of no ways.
    Lacking(Arc<Conflict<W, R>>),
    /// It is not found out.
    Unknown,
}

/// Whether ways can be taken until nothing is left to take, by asking `look` until it does not know; and all conflicts that are
/// known then, those known before first.
///
/// Law: they are lacking exactly if every choice contains a conflict, where `look` is never open but of a choice of all, and
/// never unknown; whichever of its conflicts, or what follows from them, were known before.
pub(super) fn choice<W: Copy + Ord + Hash, R: Clone + PartialOrd>(
    known: Known<W, R>,
    look: impl FnMut(&[W]) -> Look<W, R>,
) -> (Choice<W, R>, Known<W, R>) {
    let mut search = Search { look, conflicts: known };
    let choice = match search.branch(&mut Vec::new()) {
        Ok(conflict) => Choice::Lacking(conflict),
        Err(Ended::Open) => Choice::Found,
        Err(Ended::Unknown) => Choice::Unknown,
    };
    (choice, search.conflicts)
}

/// Why a search ends before all branches do.
enum Ended {
    Open,
    Unknown,
}

struct Search<W, R, L> {
    look: L,
    conflicts: Known<W, R>,
}

impl<W: Copy + Ord + Hash, R: Clone + PartialOrd, L: FnMut(&[W]) -> Look<W, R>> Search<W, R, L> {
    /// Ends all branches beyond ways taken; those of them that are in conflict, if every branch ends. As deep as ways can be
    /// taken.
    fn branch(&mut self, taken: &mut Vec<W>) -> Result<Arc<Conflict<W, R>>, Ended> {
        let all: FxHashSet<W> = taken.iter().copied().collect();
        if let Some(known) =
            self.conflicts.iter().find(|known| known.ways.iter().all(|way| all.contains(way)))
        {
            return Ok(Arc::clone(known));
        }
        let conflict = match (self.look)(taken) {
            Look::Open => return Err(Ended::Open),
            Look::Unknown => return Err(Ended::Unknown),
            Look::Conflict(conflict) => Arc::new(conflict),
            Look::Next(questions) => {
                let ways = self.narrowest(questions, &all).ok_or(Ended::Unknown)?;
                match self.beyond(taken, ways)? {
                    Beyond::Before(known) => return Ok(known),
                    Beyond::All(conflict) => Arc::new(conflict),
                }
            }
        };
        self.conflicts.push(Arc::clone(&conflict));
        Ok(conflict)
    }

    /// Ends all branches by each of some ways.
    fn beyond(&mut self, taken: &mut Vec<W>, ways: Ways<W>) -> Result<Beyond<W, R>, Ended> {
        let mut all: BTreeSet<W> = ways.whole.into_iter().collect();
        let mut ended: Known<W, R> = Vec::new();
        for way in ways.parts {
            taken.push(way);
            let conflict = self.branch(taken)?;
            taken.pop();
            if !conflict.ways.contains(&way) {
                return Ok(Beyond::Before(conflict));
            }
            all.extend(conflict.ways.iter().filter(|&&other| other != way));
            ended.push(conflict);
        }
        let holds = ended.iter().map(|conflict| conflict.holds).fold(f64::INFINITY, f64::min);
        let reasons = ended.iter().map(|conflict| &conflict.reason);
        let least = reasons.reduce(|least, reason| if reason < least { reason } else { least });
        let reason = least.ok_or(Ended::Unknown)?.clone();
        Ok(Beyond::All(Conflict { ways: all.into_iter().collect(), holds, reason }))
    }

    /// The first of the questions of which the fewest ways are left, beyond those taken. As many steps as conflicts have ways.
    fn narrowest(&self, questions: Vec<Ways<W>>, taken: &FxHashSet<W>) -> Option<Ways<W>> {
        let last = |conflict: &Arc<Conflict<W, R>>| {
            let mut others = conflict.ways.iter().filter(|way| !taken.contains(way));
            others.next().copied().filter(|_| others.next().is_none())
        };
        let ended: FxHashSet<W> = self.conflicts.iter().filter_map(last).collect();
        let left = |ways: &Ways<W>| ways.parts.iter().filter(|way| !ended.contains(way)).count();
        questions.into_iter().min_by_key(left)
    }
}

/// What ends all branches by each of some ways.
enum Beyond<W, R> {
    /// A conflict of ways taken before.
    Before(Arc<Conflict<W, R>>),
    /// What they end by together.
    All(Conflict<W, R>),
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

    /// One of some conflicts, which holds as far as its number says.
    fn numbered(conflicts: &[BTreeSet<Way>], number: usize) -> Conflict<Way, usize> {
        let ways = conflicts[number].iter().copied().collect();
        Conflict { ways, holds: number as f64, reason: number }
    }

    /// What is beyond ways taken if these are the conflicts, and questions come in this order.
    fn look(conflicts: &[BTreeSet<Way>], order: &[usize], taken: &[Way]) -> Look<Way, usize> {
        let holds = |conflict: &BTreeSet<Way>| conflict.iter().all(|way| taken.contains(way));
        if let Some(number) = conflicts.iter().position(holds) {
            return Look::Conflict(numbered(conflicts, number));
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
            let (found, learned) = choice(Vec::new(), |taken: &[Way]| look(&conflicts, &order, taken));
            let ended = |choice: &BTreeSet<Way>| conflicts.iter().any(|conflict| conflict.is_subset(choice));
            let all_end = choices().iter().all(ended);
            prop_assert_eq!(matches!(found, Choice::Lacking(_)), all_end);
            prop_assert_eq!(found == Choice::Found, !all_end);
            // What was learned is so: where it is chosen, something as far or farther that it follows from is too.
            for conflict in &learned {
                let least = conflict.reason;
                prop_assert_eq!(conflict.holds, least as f64);
                let follows = |choice: &BTreeSet<Way>| conflicts[least..].iter().any(|known| known.is_subset(choice));
                let chosen = |choice: &&BTreeSet<Way>| conflict.ways.iter().all(|way| choice.contains(way));
                prop_assert!(choices().iter().filter(chosen).all(follows));
            }
        }

        /// Also where each conflict was learned with some of them gone since.
        #[test]
        fn what_was_learned_changes_nothing(
            conflicts in prop::collection::vec(prop::collection::btree_set(ways(), 1..4), 0..24),
            order in Just((0..QUESTIONS).collect::<Vec<_>>()).prop_shuffle(),
            then in Just((0..QUESTIONS).collect::<Vec<_>>()).prop_shuffle(),
            (gone, most) in (0usize..12, 0usize..40),
        ) {
            let mut left = most;
            let (_, learned) = choice(Vec::new(), |taken: &[Way]| {
                let known = left.checked_sub(1).map(|rest| left = rest);
                known.map_or(Look::Unknown, |()| look(&conflicts, &order, taken))
            });
            let still = learned.into_iter().filter(|known| known.holds >= gone as f64).collect();
            let rest = conflicts.get(gone..).unwrap_or_default();
            let (found, _) = choice(still, |taken: &[Way]| look(rest, &then, taken));
            let ended = |choice: &BTreeSet<Way>| rest.iter().any(|conflict| conflict.is_subset(choice));
            prop_assert_eq!(matches!(found, Choice::Lacking(_)), choices().iter().all(ended));
        }
    }

    #[test]
    fn what_is_not_known_is_not_closed() {
        let conflicts: Vec<BTreeSet<Way>> = [0, 1].map(|side| BTreeSet::from([(0, side, None)])).into();
        let asked = |most: usize| {
            let mut left = most;
            let asked = choice(Vec::new(), |taken: &[Way]| {
                let known = left.checked_sub(1).map(|rest| left = rest);
                known.map_or(Look::Unknown, |()| look(&conflicts, &[0, 1, 2, 3], taken))
            });
            asked.0
        };
        for most in 0..3 {
            assert_eq!(asked(most), Choice::Unknown);
        }
        let lacking = Conflict { ways: Box::default(), holds: 0.0, reason: 0 };
        assert_eq!(asked(3), Choice::Lacking(Arc::new(lacking)));
    }

    #[test]
    fn the_question_with_the_fewest_ways_left_comes_first() {
        let [zero, one, three] = [(0, 0, None), (1, 0, None), (3, 0, None)];
        let conflicts = [[zero, three], [one, three], [one, (2, 1, None)]].map(BTreeSet::from);
        let conflicts = (0..3).map(|number| Arc::new(numbered(&conflicts, number))).collect();
        let search = Search { look: |_: &[Way]| Look::Unknown, conflicts };
        let first = |order: &[usize], taken: &[Way]| {
            let Look::Next(questions) = look(&[], order, taken) else { return None };
            search.narrowest(questions, &taken.iter().copied().collect()).map(|ways| ways.parts)
        };
        let both = |question| Some(vec![(question, 0, None), (question, 1, None)]);
        assert_eq!(first(&[1, 2, 3], &[]), both(1), "where all have as many left the first one");
        assert_eq!(first(&[1, 2, 3], &[zero]), both(3));
        assert_eq!(first(&[2, 1], &[three]), both(1), "one of its two ways is ended");
        assert_eq!(first(&[3, 2, 1], &[one, (3, 1, None), (3, 1, Some(0))]), both(2));
    }
}
