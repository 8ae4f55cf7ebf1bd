//! The session of one trace of views: a state machine without I/O. The service does not keep such maps yet.

use crate::classic::{Action, Sight, Sights, TooMany, ViewId};
use crate::trace::views::ViewAction;
use crate::trace::{Event, ExperienceError, TurnDescription, ViewExperience};
use std::collections::BTreeMap;
use thiserror::Error;

/// What a trace of views has told so far.
#[derive(Clone, Debug, Default)]
pub struct ViewSession {
    experience: ViewExperience,
    views: BTreeMap<String, ViewId>,
    seen: Sights,
}

/// Why an event was not taken.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ViewSessionError {
    /// The trace may not go on with it.
    #[error("{}", .0.at())]
    Refused(#[from] ExperienceError),
    /// The logic cannot take the observation.
    #[error(transparent)]
    TooMany(#[from] TooMany),
}

impl ViewSession {
    /// A session before its first event.
    pub fn new() -> Self {
        ViewSession::default()
    }

    /// Takes an event; after an error all is as before.
    pub fn accept(&mut self, event: &Event) -> Result<(), ViewSessionError> {
        let mut experience = self.experience.clone();
        if let Some(sighting) = experience.accept(event)? {
            // A view has no higher number than there are observations, and these have the same limit.
            let next = ViewId(u16::try_from(self.views.len()).map_err(|_| TooMany)?);
            let view = self.views.get(&sighting.view).copied().unwrap_or(next);
            // The action before the first view does not count.
            let action = sighting.action.map_or(Action::Travel, Action::from);
            self.seen.push(Sight { action, view })?;
            self.views.insert(sighting.view, view);
        }
        self.experience = experience;
        Ok(())
    }

    /// What was seen: the input of a search.
    pub fn seen(&self) -> &Sights {
        &self.seen
    }

    /// The names of the views, by number.
    pub fn view_names(&self) -> Vec<&str> {
        let mut names: Vec<(ViewId, &str)> =
            self.views.iter().map(|(name, &id)| (id, name.as_str())).collect();
        names.sort_unstable();
        names.into_iter().map(|(_, name)| name).collect()
    }
}

impl From<ViewAction> for Action {
    fn from(action: ViewAction) -> Action {
        match action {
            ViewAction::Turn(TurnDescription::Left) => Action::Left,
            ViewAction::Turn(TurnDescription::Right) => Action::Right,
            ViewAction::Turn(TurnDescription::Around) => Action::Around,
            ViewAction::Travel => Action::Travel,
        }
    }
}
