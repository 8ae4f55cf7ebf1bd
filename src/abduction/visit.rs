//! What one observation tells.

use crate::abduction::Abduction;
use crate::map::PlaceId;
use crate::star::{LargeScaleStar, SlotIndex};
use thiserror::Error;

/// An observation and the travel that led to it. Slots are those of the stars as observed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The slot of the previous observation the robot left by; none for the first observation only.
    pub departure: Option<SlotIndex>,
    /// The star observed.
    pub star: LargeScaleStar,
    /// The directed path the robot came in on, so that it passed this slot's inward gateway; at the first
    /// observation any slot, the one it faces.
    pub arrival: SlotIndex,
}

/// Why a visit cannot follow on those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum VisitError {
    /// A first observation with a travel before it.
    #[error("the first observation has a departure, expected none")]
    DepartureTooEarly,
    /// A later observation without one.
    #[error("the observation has no departure, expected a slot of the star before it")]
    NoDeparture,
    /// The slot left by is not in the star before.
    #[error("departure by slot {slot}, expected one below {size}")]
    UnknownDeparture {
        /// The slot.
        slot: u8,
        /// The number of slots.
        size: usize,
    },
    /// The slot left by has no outward gateway.
    #[error("departure by slot {0}, expected one with an outward gateway")]
    DepartureBlocked(u8),
    /// The slot of arrival is not in the star.
    #[error("arrival on slot {slot}, expected one below {size}")]
    UnknownArrival {
        /// The slot.
        slot: u8,
        /// The number of slots.
        size: usize,
    },
    /// The slot of arrival has no inward gateway.
    #[error("arrival on slot {0}, expected one with an inward gateway")]
    ArrivalBlocked(u8),
    /// More observations than places can be numbered.
    #[error("more than {limit} observations", limit = PlaceId::LIMIT)]
    TooMany,
    /// More observations than a search for the simplest candidates alone takes.
    #[error(
        "more than {limit} observations, the most of the strategy best-first; the strategy breadth-first takes more",
        limit = Abduction::MOST_SETTLED
    )]
    TooManyToSettle,
}

impl Visit {
    /// Whether the visit can follow on an observation of `before`, or be the first.
    pub(super) fn check(&self, before: Option<&LargeScaleStar>) -> Result<(), VisitError> {
        let size = self.star.size();
        let arrival = self.star.slots().get(self.arrival.0 as usize);
        let arrival = arrival.ok_or(VisitError::UnknownArrival { slot: self.arrival.0, size })?;
        match (self.departure, before) {
            (None, None) => Ok(()),
            (Some(_), None) => Err(VisitError::DepartureTooEarly),
            (None, Some(_)) => Err(VisitError::NoDeparture),
            (Some(departure), Some(before)) => {
                let slot = before.slots().get(departure.0 as usize);
                let unknown = VisitError::UnknownDeparture { slot: departure.0, size: before.size() };
                if !slot.ok_or(unknown)?.navigable {
                    return Err(VisitError::DepartureBlocked(departure.0));
                }
                match self.star.slots()[arrival.opposite.0 as usize].navigable {
                    true => Ok(()),
                    false => Err(VisitError::ArrivalBlocked(self.arrival.0)),
                }
            }
        }
    }
}
