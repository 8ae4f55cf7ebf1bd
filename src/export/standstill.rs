//! Why no map explains a whole trace, and the map of what was before.

use crate::explanation::Dissent;
use crate::export::{Preferred, Refutation};
use crate::star::{SlotIndex, SmallScaleStar};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use utoipa::ToSchema;

/// The end of all candidates at an observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Standstill {
    /// The observation that nothing explains, counted from 0.
    pub observation: usize,
    /// The preferred map of all observations before it.
    pub before: Preferred,
    /// What the observation could have been on that map, and what refutes each.
    pub reasons: Vec<Dissenting>,
}

/// What an observation could have been, and what refutes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Dissenting {
    /// The place; the next number for a new one.
    pub place: usize,
    /// How many slots further on the star of the place each slot seen is.
    pub rotation: u8,
    /// What refutes it.
    pub refuted: Refutation,
    /// The readings of which one is wrong if it is the place all the same, the least certain first.
    pub doubts: Vec<Doubt>,
}

/// A slot as it was read at an observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Doubt {
    /// The observation, counted from 0.
    pub observation: usize,
    /// The slot, clockwise in the star as it was seen then.
    pub slot: u8,
    /// Whether there is a gateway.
    pub gateway: bool,
    /// Its direction in the frame of the observation, radians.
    pub bearing: Option<f64>,
    /// How far it was from being read otherwise, 0 being not at all; null where the star was given.
    pub margin: Option<f64>,
}

impl Standstill {
    /// `stars` are those of the observations, as far as `observation`.
    pub fn of(
        observation: usize,
        before: Preferred,
        found: &[Dissent],
        stars: &[SmallScaleStar],
    ) -> Standstill {
        let reason = |dissent: &Dissent| {
            let doubt = |&(observation, slot)| Doubt::of(observation, slot, stars);
            let mut doubts: Vec<Doubt> = dissent.slots.iter().filter_map(doubt).collect();
            let unsure = |doubt: &Doubt| doubt.margin.unwrap_or(f64::INFINITY);
            doubts.sort_by(|a, b| unsure(a).total_cmp(&unsure(b)));
            Dissenting {
                place: dissent.assignment.place.index(),
                rotation: dissent.assignment.rotation,
                refuted: Refutation::of(&dissent.refutation),
                doubts,
            }
        };
        Standstill { observation, before, reasons: found.iter().map(reason).collect() }
    }

    /// The observations whose readings clash, ascending.
    pub fn concerned(&self) -> Vec<usize> {
        let doubts = self.reasons.iter().flat_map(|reason| &reason.doubts);
        let mut all: Vec<usize> = doubts.map(|doubt| doubt.observation).chain([self.observation]).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

impl Doubt {
    fn of(observation: usize, slot: SlotIndex, stars: &[SmallScaleStar]) -> Option<Doubt> {
        let seen = stars.get(observation)?.slot(slot)?;
        let (gateway, bearing, margin) = (seen.outward.is_some(), seen.bearing, seen.margin);
        Some(Doubt { observation, slot: slot.0, gateway, bearing, margin })
    }
}

/// So many of the least certain readings are told of.
const TOLD: usize = 4;

/// What stands in the way, and what would mend it, as lines of text.
pub fn standstill_text(standstill: &Standstill) -> String {
    let Standstill { observation, before, reasons } = standstill;
    let mut text = format!(
        "no map explains observation {observation}. The simplest map of observations 0 to {} has {} places and {} \
         paths; on it\n",
        observation - 1,
        before.places,
        before.paths
    );
    for Dissenting { place, refuted, doubts, .. } in reasons {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "  it is not place {place} by {}: {}", refuted.axiom, refuted.words);
        if doubts.is_empty() {
            continue;
        }
        let _ = writeln!(text, "  unless one of these was read wrongly, the least certain first:");
        for doubt in doubts.iter().take(TOLD) {
            let _ = writeln!(text, "    {}", doubt_text(doubt));
        }
    }
    text + "what would mend it: another reading of one of these, or a place between that was passed unseen. Look at \
            the\npictures (-o DIR, or `topostar extract`), and say where the places are (--visits) or what is wrong \
            with the trace.\n"
}

fn doubt_text(doubt: &Doubt) -> String {
    let kind = if doubt.gateway { "a gateway" } else { "no gateway" };
    let bearing =
        doubt.bearing.map_or_else(String::new, |bearing| format!(" at {:.0} degrees", bearing.to_degrees()));
    let margin = match doubt.margin {
        Some(margin) => format!("margin {:.0} %", 100.0 * margin),
        None => "as given".into(),
    };
    format!("observation {}, slot {}, {kind}{bearing}: {margin}", doubt.observation, doubt.slot)
}
