//! The tags of answers that cost much to make: a client that has such an answer need not have it made again to learn so.

use crate::export::TieOrder;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// What was asked of what a map has found.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Question {
    /// The candidate, as paths name it; the preferred one depends on the order of those that tie.
    pub(super) candidate: String,
    /// What orders these.
    pub(super) ordered_by: Option<TieOrder>,
    /// What of it, and in which form.
    pub(super) form: String,
}

/// The tags of answers given.
#[derive(Debug, Default)]
pub(super) struct Tags(Mutex<BTreeMap<Question, String>>);

impl Tags {
    /// How many are remembered at most: what follows from a map can be asked in endless ways.
    const MOST: usize = 256;

    /// The tag of an answer that was given before.
    pub(super) fn get(&self, question: &Question) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(question).cloned()
    }

    /// Remembers the tag of an answer. Where there is no room, all others are forgotten.
    pub(super) fn insert(&self, question: Question, tag: String) {
        let mut tags = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if tags.len() >= Tags::MOST && !tags.contains_key(&question) {
            tags.clear();
        }
        tags.insert(question, tag);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn question(candidate: usize) -> Question {
        Question { candidate: candidate.to_string(), ordered_by: None, form: "graph".into() }
    }

    #[test]
    fn tags_are_remembered_up_to_a_bound() {
        let tags = Tags::default();
        (0..Tags::MOST).for_each(|at| tags.insert(question(at), at.to_string()));
        tags.insert(question(7), "seven".into());
        assert_eq!(
            (tags.get(&question(7)).as_deref(), tags.get(&question(8)).as_deref()),
            (Some("seven"), Some("8"))
        );
        let other = Question { ordered_by: Some(TieOrder::Strain), ..question(7) };
        assert_eq!(tags.get(&other), None);
        tags.insert(other.clone(), "other".into());
        assert_eq!((tags.get(&other).as_deref(), tags.get(&question(7))), (Some("other"), None));
    }
}
