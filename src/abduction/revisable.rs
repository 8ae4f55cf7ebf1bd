//! An abduction whose operator may take a word back.

use crate::abduction::{Abduction, Assertion, Evidence, Visit, VisitError, WordError};
use std::ops::Deref;
use std::sync::Arc;

/// An abduction with what it takes to undo each assertion in force.
///
/// Law: after a retraction all is, exactly, as if the assertion had never been made. Its cost is that of what came
/// after the assertion; what came before is kept as a snapshot, which shares its maps. Without assertions in force
/// nothing is kept.
#[derive(Clone, Debug)]
pub struct Revisable {
    now: Abduction,
    /// The assertions in force, oldest first.
    undo: Vec<Undo>,
    /// All steps since the oldest assertion in force, that one first.
    since: Vec<Step>,
}

/// How to undo an assertion.
#[derive(Clone, Debug)]
struct Undo {
    id: u64,
    before: Abduction,
    /// Which of the steps since the oldest assertion it is.
    step: usize,
}

#[derive(Clone, Debug)]
enum Step {
    Observed(Visit, Option<Arc<dyn Evidence>>),
    Asserted(Assertion),
}

impl Revisable {
    /// An abduction from which nothing can be taken back yet.
    pub fn new(abduction: Abduction) -> Revisable {
        Revisable { now: abduction, undo: Vec::new(), since: Vec::new() }
    }

    /// As [`Abduction::observe_measured`].
    pub fn observe(&mut self, visit: &Visit, evidence: Option<Arc<dyn Evidence>>) -> Result<(), VisitError> {
        self.now.observe_measured(visit, evidence.clone())?;
        if !self.undo.is_empty() {
            self.since.push(Step::Observed(visit.clone(), evidence));
        }
        Ok(())
    }

    /// As [`Abduction::assert`].
    pub fn assert(&mut self, assertion: Assertion) -> Result<(), WordError> {
        let before = self.now.for_readers();
        self.now.assert(assertion)?;
        self.undo.push(Undo { id: assertion.id, before, step: self.since.len() });
        self.since.push(Step::Asserted(assertion));
        Ok(())
    }

    /// As [`Abduction::limit_steps`].
    pub fn limit_steps(&mut self, most: u64) {
        self.now.limit_steps(most);
    }

    /// As [`Abduction::settle`].
    pub fn settle(&mut self, interrupted: &dyn Fn() -> bool) {
        self.now.settle(interrupted);
    }

    /// Takes an assertion in force back. After an error all is as before.
    pub fn retract(&mut self, id: u64) -> Result<(), WordError> {
        let taken = self.undo.iter().position(|undo| undo.id == id).ok_or(WordError::NotInForce(id))?;
        let Undo { before, step, .. } = &self.undo[taken];
        let mut revised = Revisable {
            now: before.clone(),
            undo: self.undo[..taken].to_vec(),
            since: self.since[..*step].to_vec(),
        };
        for step in &self.since[step + 1..] {
            match step {
                // It followed on the same visits before, so that it does again.
                Step::Observed(visit, evidence) => drop(revised.observe(visit, evidence.clone())),
                Step::Asserted(assertion) => revised.assert(*assertion)?,
            }
        }
        *self = revised;
        Ok(())
    }
}

impl Deref for Revisable {
    type Target = Abduction;

    fn deref(&self) -> &Abduction {
        &self.now
    }
}
