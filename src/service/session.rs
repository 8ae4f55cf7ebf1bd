//! The session of one map: a state machine without I/O.
//!
//! It takes events one by one. What it cannot take leaves it unchanged, what it has taken before it takes
//! again without effect, and the same events always give the same state, however they arrived.

use crate::abduction::{self, Abduction, Assertion, Revisable, Strategy, Visit, VisitError, WordError};
use crate::lpm::Lpm;
use crate::patchwork::survey::Survey;
use crate::service::{Limits, MapConfig};
use crate::star::PerceptionParameters;
use crate::trace::perceive::perceive;
use crate::trace::{Assert, Event, EventKind, Experience, ExperienceError, Percept, Sighting};
use std::sync::Arc;
use thiserror::Error;

/// The state of one map.
#[derive(Clone, Debug)]
pub struct Session {
    config: MapConfig,
    limits: Limits,
    experience: Experience,
    abduction: Revisable,
    survey: Arc<Survey>,
    events: Vec<Arc<Event>>,
    cells: usize,
}

/// How an event was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accepted {
    /// For the first time.
    New,
    /// Once more; nothing has changed.
    Replay,
}

/// Why an event was not taken.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SessionError {
    /// Events before it are missing.
    #[error("the event has seq {found}, expected {expected}; send again from {expected}")]
    Gap {
        /// The number that comes next.
        expected: u64,
        /// The number given.
        found: u64,
    },
    /// Another event was taken under its number.
    #[error("seq {seq} was taken before with another content; events are never changed once taken")]
    Conflict {
        /// The number.
        seq: u64,
    },
    /// The trace may not go on with it.
    #[error(transparent)]
    Refused(#[from] ExperienceError),
    /// The logic cannot take the observation.
    #[error(transparent)]
    Visit(#[from] VisitError),
    /// The logic cannot take the operator's word.
    #[error(transparent)]
    Word(#[from] WordError),
    /// The map is full.
    #[error("the map holds the most {what} it may hold, {limit}; go on in a new map")]
    Full {
        /// What there is too much of.
        what: &'static str,
        /// How much is allowed.
        limit: usize,
    },
}

impl Session {
    /// A session before its first event.
    pub fn new(config: MapConfig, limits: Limits) -> Self {
        let MapConfig { max_candidates, max_memory, max_steps, .. } = config;
        let search = abduction::Limits { max_candidates: Some(max_candidates), max_memory, max_steps };
        let abduction = match config.strategy {
            Strategy::BreadthFirst => Abduction::new(config.axioms, search),
            Strategy::BestFirst => Abduction::best_first(config.axioms, search),
        };
        Session {
            config,
            limits,
            experience: Experience::new(),
            abduction: Revisable::new(abduction),
            survey: Arc::default(),
            events: Vec::new(),
            cells: 0,
        }
    }

    /// The session that took these events.
    pub fn replay(config: MapConfig, limits: Limits, events: &[Arc<Event>]) -> Result<Self, SessionError> {
        let mut session = Session::new(config, limits);
        events.iter().try_for_each(|event| session.accept(event).map(|_| ()))?;
        Ok(session)
    }

    /// Takes an event; after an error all is as before.
    pub fn accept(&mut self, event: &Arc<Event>) -> Result<Accepted, SessionError> {
        if event.seq < self.next_seq() {
            return self.known(event);
        }
        if event.seq > self.next_seq() {
            return Err(SessionError::Gap { expected: self.next_seq(), found: event.seq });
        }
        let cells = self.room_for(event)?;
        let mut experience = self.experience.clone();
        let describe = |lpm: &Lpm, first| perceive(lpm, first, &PerceptionParameters::default());
        let sighting = experience.accept(event, &describe)?;
        match (&event.kind, sighting) {
            (&EventKind::Assert(Assert { visits, same }), _) => {
                self.abduction.assert(Assertion { id: event.seq, visits, same })?;
            }
            (&EventKind::Retract { assert }, _) => self.abduction.retract(assert)?,
            (_, Some(sighting)) => {
                let survey = self.survey.with(event, &sighting);
                self.abduction.observe(&Visit::from(&sighting), survey.measurements().evidence())?;
                self.survey = Arc::new(survey);
            }
            (_, None) => {}
        }
        self.experience = experience;
        self.cells = cells;
        self.events.push(Arc::clone(event));
        Ok(Accepted::New)
    }

    /// Finds the simplest candidates, where the strategy leaves that to the end; see [`Abduction::settle`].
    pub fn settle(&mut self, interrupted: &dyn Fn() -> bool) {
        let most = self.limits.steps(self.abduction.observations());
        self.abduction.limit_steps(self.config.max_steps.map_or(most, |asked| asked.min(most)));
        self.abduction.settle(interrupted);
    }

    /// How the map is built.
    pub fn config(&self) -> MapConfig {
        self.config
    }

    /// The number that the next event must carry.
    pub fn next_seq(&self) -> u64 {
        self.experience.next_seq()
    }

    /// What explains the events so far.
    pub fn abduction(&self) -> &Abduction {
        &self.abduction
    }

    /// What the events tell the patchwork.
    pub fn survey(&self) -> &Arc<Survey> {
        &self.survey
    }

    fn known(&self, event: &Event) -> Result<Accepted, SessionError> {
        let taken = usize::try_from(event.seq).ok().and_then(|seq| self.events.get(seq));
        match taken.is_some_and(|taken| **taken == *event) {
            true => Ok(Accepted::Replay),
            false => Err(SessionError::Conflict { seq: event.seq }),
        }
    }

    /// The cells held once the event is taken.
    fn room_for(&self, event: &Event) -> Result<usize, SessionError> {
        if self.events.len() >= self.limits.events_per_map {
            return Err(SessionError::Full { what: "events", limit: self.limits.events_per_map });
        }
        let cells = self.cells + cells(event);
        if cells > self.limits.cells_per_map {
            return Err(SessionError::Full { what: "grid cells", limit: self.limits.cells_per_map });
        }
        Ok(cells)
    }
}

fn cells(event: &Event) -> usize {
    match &event.kind {
        EventKind::Observation(seen) => match &seen.percept {
            Percept::Lpm(lpm) => lpm.grid.info().width * lpm.grid.info().height,
            Percept::Star { .. } | Percept::View(_) => 0,
        },
        EventKind::Turn(_) | EventKind::Travel(_) | EventKind::Assert(_) | EventKind::Retract { .. } => 0,
    }
}

impl From<&Sighting> for Visit {
    /// What the logic takes of a sighting: metres stop here.
    fn from(sighting: &Sighting) -> Visit {
        Visit { departure: sighting.departure, star: sighting.star.large_scale(), arrival: sighting.arrival }
    }
}
