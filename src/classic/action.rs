//! What the robot does and sees.

use crate::classic::DstateId;
use thiserror::Error;

/// What the robot does at a dstate. Every action is deterministic (seed, section 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Action {
    /// A turn to the left, onto another path of the place.
    Left,
    /// A turn to the right, onto another path of the place.
    Right,
    /// A turn around, to the other direction of the same path.
    Around,
    /// A travel along the path that the robot faces, to another place.
    Travel,
}

/// A view, by number. What it looks like does not matter, only which views are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ViewId(pub u16);

/// An observation: an action and the view it leads to (seed, section 3.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sight {
    /// The action before it. That of the first observation does not count.
    pub action: Action,
    /// The view.
    pub view: ViewId,
}

impl Action {
    /// All actions.
    pub const ALL: [Action; 4] = [Action::Left, Action::Right, Action::Around, Action::Travel];

    /// Whether it keeps the robot at its place.
    pub fn is_turn(self) -> bool {
        self != Action::Travel
    }

    /// Whether it turns the robot onto another path of the place.
    pub fn changes_path(self) -> bool {
        matches!(self, Action::Left | Action::Right)
    }
}

/// What a robot has seen, first to last: the input of a search.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sights {
    seen: Vec<Sight>,
}

/// More observations than dstates can be numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("more than {limit} observations", limit = DstateId::LIMIT)]
pub struct TooMany;

impl Sights {
    /// Adds an observation, the last so far.
    pub fn push(&mut self, sight: Sight) -> Result<(), TooMany> {
        if self.seen.len() == DstateId::LIMIT {
            return Err(TooMany);
        }
        self.seen.push(sight);
        Ok(())
    }

    /// The observations.
    pub fn as_slice(&self) -> &[Sight] {
        &self.seen
    }
}
