//! The operator's word: which visits are, or are not, to one place.

use crate::abduction::Assignment;
use std::collections::BTreeMap;
use thiserror::Error;

/// What an operator said in force. It prunes: a candidate stays exactly if [`Word::allows`] its assignments. The
/// order in which it was said does not matter to what it allows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Word {
    assertions: Vec<Assertion>,
}

/// That two visits are, or are not, to one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Assertion {
    /// The name under which it can be taken back.
    pub id: u64,
    /// Two observations, counted from 0.
    pub visits: [usize; 2],
    /// Whether their places are one.
    pub same: bool,
}

/// Why an assertion, or a retraction, was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum WordError {
    /// A visit that was not made yet.
    #[error("observation {visit} has not been made, expected one below {observations}")]
    Unseen {
        /// The visit.
        visit: usize,
        /// The number of observations.
        observations: usize,
    },
    /// One visit given twice.
    #[error("observation {0} is given as both visits, expected two different ones")]
    OneVisit(usize),
    /// The name is in use.
    #[error("an assertion named {0} is in force")]
    Taken(u64),
    /// No such assertion is in force.
    #[error("no assertion named {0} is in force")]
    NotInForce(u64),
}

impl Assertion {
    /// Whether it allows the assignments of a candidate, or of the beginning of one: what is said of visits beyond
    /// them is not judged.
    pub fn allows(&self, assignments: &[Assignment]) -> bool {
        let [a, b] = self.visits.map(|visit| assignments.get(visit));
        match (a, b) {
            (Some(a), Some(b)) => (a.place == b.place) == self.same,
            _ => true,
        }
    }
}

impl Word {
    /// What was said, in the order in which it was.
    pub fn assertions(&self) -> &[Assertion] {
        &self.assertions
    }

    /// Whether nothing is in force.
    pub fn is_empty(&self) -> bool {
        self.assertions.is_empty()
    }

    /// Whether all assertions allow the assignments of a candidate, or of the beginning of one. A pure function:
    /// any order of search may ask it of any beginning, and prune what it forbids. Linear in the assertions.
    pub fn allows(&self, assignments: &[Assignment]) -> bool {
        self.assertions.iter().all(|assertion| assertion.allows(assignments))
    }

    /// The assertions that do not allow the assignments of a candidate, or of the beginning of one.
    pub fn broken_by(&self, assignments: &[Assignment]) -> Vec<Assertion> {
        self.assertions.iter().filter(|assertion| !assertion.allows(assignments)).copied().collect()
    }

    /// Assertions that no assignment at all can obey together: one that two visits differ, and those that make
    /// them one. Empty if there are none. The first in the order in which they were said, by the shortest chain.
    pub fn contradiction(&self) -> Vec<Assertion> {
        let differ = self.assertions.iter().filter(|assertion| !assertion.same);
        let mut found = differ.filter_map(|&assertion| {
            let mut chain = self.chain(assertion.visits)?;
            chain.push(assertion);
            chain.sort_unstable();
            Some(chain)
        });
        found.next().unwrap_or_default()
    }

    /// The assertion can follow after so many observations.
    pub(super) fn check(&self, assertion: &Assertion, observations: usize) -> Result<(), WordError> {
        if let Some(&visit) = assertion.visits.iter().find(|&&visit| visit >= observations) {
            return Err(WordError::Unseen { visit, observations });
        }
        if assertion.visits[0] == assertion.visits[1] {
            return Err(WordError::OneVisit(assertion.visits[0]));
        }
        match self.assertions.iter().any(|own| own.id == assertion.id) {
            true => Err(WordError::Taken(assertion.id)),
            false => Ok(()),
        }
    }

    pub(super) fn add(&mut self, assertion: Assertion) {
        self.assertions.push(assertion);
    }

    /// The shortest chain of assertions that makes two visits one place, found breadth-first.
    fn chain(&self, [from, to]: [usize; 2]) -> Option<Vec<Assertion>> {
        let mut came_by: BTreeMap<usize, Option<(usize, Assertion)>> = BTreeMap::from([(from, None)]);
        let mut reached = vec![from];
        let mut next = 0;
        while let Some(&at) = reached.get(next) {
            next += 1;
            for &assertion in self.assertions.iter().filter(|assertion| assertion.same) {
                let [a, b] = assertion.visits;
                let other = if a == at { b } else { a };
                if (a == at || b == at) && !came_by.contains_key(&other) {
                    came_by.insert(other, Some((at, assertion)));
                    reached.push(other);
                }
            }
        }
        let mut at = to;
        let mut chain = Vec::new();
        while let Some((before, assertion)) = *came_by.get(&at)? {
            chain.push(assertion);
            at = before;
        }
        Some(chain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(said: &[(usize, usize, bool)]) -> Word {
        let assertion =
            |(id, &(a, b, same)): (u64, &(usize, usize, bool))| Assertion { id, visits: [a, b], same };
        Word { assertions: (0..).zip(said).map(assertion).collect() }
    }

    #[test]
    fn contradictions_name_what_contradicts_and_nothing_else() {
        let named = |said: &[(usize, usize, bool)]| -> Vec<u64> {
            word(said).contradiction().iter().map(|assertion| assertion.id).collect()
        };
        assert!(word(&[(0, 8, true), (3, 8, true), (0, 4, false)]).contradiction().is_empty());
        assert_eq!(named(&[(0, 8, true), (3, 7, true), (8, 0, false)]), [0, 2]);
        assert_eq!(named(&[(0, 3, false), (1, 2, true), (8, 0, true), (3, 8, true)]), [0, 2, 3]);
    }
}
