//! Why a search came to no map, and the map of what was before.

use crate::abduction::{Report, Strategy};
use crate::cli::failure::Failure;
use crate::cli::patchwork::rank;
use crate::explanation::standstill;
use crate::export::{self, Preferred, Standstill, extraction_svg_with, map_text};
use crate::lpm::Lpm;
use crate::service::{Limits, Session};
use crate::star::{PerceptionParameters, SmallScaleStar, describe, rejected};
use crate::trace::perceive::perceive;
use crate::trace::{Event, EventKind, Experience, Percept};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What is known where all candidates were refuted.
pub(super) struct Stopped {
    pub(super) why: Standstill,
    /// What had been found before.
    pub(super) before: Report,
}

/// Searches once more up to the observation that nothing explains; nothing where there is a map, or where the search
/// did not go by observations, or the operator's word ended it.
pub(super) fn stopped(
    session: &Session,
    events: &[Arc<Event>],
    limits: Limits,
) -> Result<Option<Stopped>, Failure> {
    let report = session.abduction().report();
    let ended = report.extinction.filter(|end| end.assertions.is_empty());
    let (Some(end), Strategy::BreadthFirst) = (ended, report.strategy) else { return Ok(None) };
    let seen = events.iter().enumerate().filter(|(_, event)| matches!(event.kind, EventKind::Observation(_)));
    let Some((fatal, _)) = seen.clone().nth(end.observation) else { return Ok(None) };
    let broken = |error: &dyn std::fmt::Display| Failure::Broken(error.to_string());
    let before = Session::replay(session.config(), limits, &events[..fatal]).map_err(|e| broken(&e))?;
    let (survey, mut before) = (Arc::clone(before.survey()), before.abduction().report());
    rank(&mut before, &survey, &mut survey.agreements());
    let (Some(simplest), Some(preferred)) = (before.minimal.first(), Preferred::of(&before)) else {
        return Ok(None);
    };
    let dissents = standstill(session.abduction(), &simplest.visits);
    let stars = stars(&events[..=fatal]);
    let why = Standstill::of(end.observation, preferred, &dissents, &stars);
    Ok(Some(Stopped { why, before }))
}

/// The stars that were seen, with all that was measured of them.
fn stars(events: &[Arc<Event>]) -> Vec<SmallScaleStar> {
    let mut experience = Experience::new();
    let describe = |lpm: &Lpm, first| perceive(lpm, first, &PerceptionParameters::default());
    let sightings = events.iter().filter_map(|event| experience.accept(event, &describe).ok().flatten());
    sightings.map(|sighting| sighting.star).collect()
}

/// The simplest map that was found, in words.
pub(super) fn map_in_words(found: &Report) -> String {
    let map = found.minimal.first().map(|candidate| map_text(&export::MapGraph::of(candidate)));
    map.unwrap_or_default()
}

/// Pictures of some observations, by name, with the remarks on each.
pub(super) fn pictures(
    observations: BTreeSet<usize>,
    events: &[Arc<Event>],
    remarks: &dyn Fn(usize) -> Vec<String>,
) -> Vec<(String, Vec<u8>)> {
    let mut way = None;
    let mut lpms = Vec::new();
    for event in events {
        match &event.kind {
            EventKind::Travel(travel) => way = Some(travel),
            EventKind::Observation(seen) => lpms.push(match &seen.percept {
                Percept::Lpm(lpm) => {
                    let way = way.take().map(|way| way.trail(&lpm.robot_pose));
                    Some(lpm.clone().reached_by(way))
                }
                Percept::Star { .. } | Percept::View(_) => None,
            }),
            EventKind::Turn(_) | EventKind::Assert(_) | EventKind::Retract { .. } => {}
        }
    }
    let picture = |observation: usize| {
        let lpm = lpms.get(observation)?.as_ref()?;
        let parameters = PerceptionParameters::default();
        let place = describe(lpm, &parameters).ok()?;
        let openings = rejected(lpm, &place, &parameters);
        let svg = extraction_svg_with(&place, &lpm.robot_pose, &openings, &remarks(observation));
        Some((format!("observation-{observation:02}.svg"), svg.into_bytes()))
    };
    observations.into_iter().filter_map(picture).collect()
}
