//! The walk of a world file and what is expected of it.

use crate::star::SlotIndex;
use crate::worlds::fault::{Fault, fault};
use crate::worlds::format::{WireExpectation, WireTruth, WireWalk};
use crate::worlds::world::{Exit, Expectation, Minimal, Place, SlotRef, Truth, Walk};

/// The walk, which must be possible.
pub(super) fn read_walk(places: &[Place], wire: &WireWalk) -> Result<Walk, Fault> {
    let start = wire.start.split_once('.').and_then(|(place, slot)| {
        let at = places.iter().position(|p| p.name == place)?;
        Some(SlotRef { place: at, slot: slot_named(&places[at], slot)? })
    });
    let Some(start) = start else {
        return fault("walk.start", format!("is \"{}\", expected the PLACE.slot faced first", wire.start));
    };
    let mut here = start.place;
    let mut leave = Vec::with_capacity(wire.leave.len());
    for (step, name) in wire.leave.iter().enumerate() {
        let field = format!("walk.leave[{step}]");
        let place = &places[here];
        let Some(slot) = slot_named(place, name) else {
            return fault(field, format!("is \"{name}\", expected a slot of {}", place.name));
        };
        let Exit::To(far) = place.slots[slot.0 as usize].exit else {
            return fault(field, format!("is \"{name}\", which leads from {} to no place", place.name));
        };
        leave.push(slot);
        here = far.place;
    }
    Ok(Walk { start, leave })
}

fn slot_named(place: &Place, name: &str) -> Option<SlotIndex> {
    let slot = place.slots.iter().position(|s| s.name == name)?;
    u8::try_from(slot).ok().map(SlotIndex)
}

/// What must come out in the profile of a field.
pub(super) fn read_expectation(
    field: &str,
    visits: usize,
    wire: WireExpectation,
) -> Result<Expectation, Fault> {
    if wire.candidates.len() != visits {
        let message =
            format!("has {} counts, expected one for each of {visits} visits", wire.candidates.len());
        return fault(format!("{field}.candidates"), message);
    }
    let truth = match wire.truth {
        WireTruth::Minimal => Truth::Minimal,
        WireTruth::Candidate => Truth::Candidate,
        WireTruth::Refuted { observation, .. } if observation >= visits => {
            let message = format!("is {observation}, expected an observation before {visits}");
            return fault(format!("{field}.truth.refuted.observation"), message);
        }
        WireTruth::Refuted { axiom, observation } => Truth::Refuted { axiom, observation },
    };
    let minimal = Minimal { paths: wire.minimal.paths, places: wire.minimal.places, ties: wire.minimal.ties };
    Ok(Expectation { candidates: wire.candidates, created: wire.created, minimal, truth })
}
