//! The tags of answers that cost much to make: a client that has such an answer need not have it made again to learn so.
//! An answer that someone else keeps is found here, too.

use crate::export::TieOrder;
use crate::service::representation::Representation;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// What was asked of what a map has found.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Question {
    /// The address of the answer; that of the preferred candidate depends on the order of those that tie.
    pub(super) of: String,
    /// What orders these.
    pub(super) ordered_by: Option<TieOrder>,
}

/// An answer that was given.
#[derive(Clone, Debug)]
pub(super) struct Given {
    /// Its tag.
    pub(super) tag: String,
    answer: Weak<Representation>,
}

/// The answers given.
#[derive(Debug, Default)]
pub(super) struct Tags(Mutex<BTreeMap<Question, Given>>);

impl Given {
    /// The answer itself, if it is still kept.
    pub(super) fn kept(&self) -> Option<Arc<Representation>> {
        self.answer.upgrade()
    }
}

impl Tags {
    /// How many are remembered at most: what follows from a map can be asked in endless ways.
    const MOST: usize = 256;

    /// An answer that was given before.
    pub(super) fn get(&self, question: &Question) -> Option<Given> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(question).cloned()
    }

    /// Remembers the tag of an answer, and the answer as long as it is kept. Where there is no room, all others are forgotten.
    pub(super) fn insert(&self, question: Question, answer: &Arc<Representation>) {
        let mut tags = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = tags.get(&question);
        if known.is_some_and(|given| given.kept().is_some()) {
            return;
        }
        if tags.len() >= Tags::MOST && known.is_none() {
            tags.clear();
        }
        tags.insert(question, Given { tag: answer.tag.clone(), answer: Arc::downgrade(answer) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn question(candidate: usize) -> Question {
        Question { of: candidate.to_string(), ordered_by: None }
    }

    fn answer(text: &str) -> Arc<Representation> {
        Arc::new(Representation::of_bytes("text/plain", text.into()))
    }

    #[test]
    fn tags_are_remembered_up_to_a_bound() {
        let tags = Tags::default();
        let tag = |question: &Question| tags.get(question).map(|given| given.tag);
        (0..Tags::MOST).for_each(|at| tags.insert(question(at), &answer(&at.to_string())));
        tags.insert(question(7), &answer("seven"));
        assert_eq!(
            (tag(&question(7)), tag(&question(8))),
            (Some(answer("seven").tag.clone()), Some(answer("8").tag.clone()))
        );
        let other = Question { ordered_by: Some(TieOrder::Strain), ..question(7) };
        assert_eq!(tag(&other), None);
        tags.insert(other.clone(), &answer("other"));
        assert_eq!((tag(&other), tag(&question(7))), (Some(answer("other").tag.clone()), None));
    }

    #[test]
    fn an_answer_is_there_as_long_as_it_is_kept() {
        let (tags, kept) = (Tags::default(), answer("kept"));
        tags.insert(question(0), &kept);
        // Who made the same answer once more, and does not keep it, does not take it away.
        tags.insert(question(0), &answer("kept"));
        let found = tags.get(&question(0)).and_then(|given| given.kept());
        assert_eq!(found.map(|found| found.bytes.clone()), Some(kept.bytes.clone()));
        let tag = kept.tag.clone();
        drop(kept);
        let given = tags.get(&question(0)).unwrap();
        assert!(given.kept().is_none() && given.tag == tag);
    }
}
