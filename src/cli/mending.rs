//! Where no map explains a trace as it was read: the map of the trace with doubtful readings changed.

use crate::abduction::{self, Abduction, Report, StopReason, Strategy, Visit};
use crate::cli::failure::Failure;
use crate::cli::patchwork::rank;
use crate::export::Mending;
use crate::mending::{Bounds, Mended, Told, mend_longest, readings};
use crate::patchwork::survey::Survey;
use crate::service::{MapConfig, Session};
use crate::star::PerceptionParameters;
use crate::trace::{Event, EventKind, Observation, Percept};
use std::sync::Arc;

/// What changing doubtful readings leads to. It stands beside the answer for the trace as it was read, never for it.
pub(super) struct Attempt {
    /// What was changed.
    pub(super) mending: Mending,
    /// What these visits tell the patchwork.
    pub(super) survey: Survey,
    /// What explains the visits with the changes, all of them or the longest stretch found, ties in order.
    pub(super) found: Report,
}

/// Walks of more visits are not mended: each is likened to every other, from each observation on.
const MOST_MENDED: usize = 256;

/// So many candidates of the walk with changes are kept after each observation at least.
const KEPT: usize = 2_000;

/// Looks for readings to change; nothing where there is a map, where something other than the axioms ended the search, where
/// the operator has spoken, and where no change leads further.
pub(super) fn attempt(session: &Session, events: &[Arc<Event>]) -> Result<Option<Attempt>, Failure> {
    let as_read = session.abduction().report();
    let Some(stuck) = stuck(&as_read) else { return Ok(None) };
    let broken = |error: &dyn std::fmt::Display| Failure::Broken(error.to_string());
    let readings = readings(events, &PerceptionParameters::default()).map_err(|e| broken(&e))?;
    if readings.len() > MOST_MENDED {
        eprintln!(
            "readings are not mended: there are {} observations, more than {MOST_MENDED}",
            readings.len()
        );
        return Ok(None);
    }
    let mended = mend_longest(&readings, session.config().axioms, Bounds::default());
    if mended.explained <= stuck {
        return Ok(None);
    }
    // On the mean as many as of the walk as it was read, so that all of it costs about as much again.
    let kept = (as_read.maps_created.value as usize / mended.told.len().max(1)).max(KEPT);
    let config = MapConfig { max_candidates: kept.min(session.config().max_candidates), ..session.config() };
    let (abduction, survey) = explained(&mended, events, config).map_err(|e| broken(&e))?;
    let mut found = abduction.report();
    rank(&mut found, &survey, &mut survey.agreements());
    let mending = Mending::of(&mended, readings.len(), &found);
    Ok(Some(Attempt { mending, survey, found }))
}

/// The observation that nothing explains, if that is to be mended.
fn stuck(report: &Report) -> Option<usize> {
    let by_observation = report.strategy == Strategy::BreadthFirst && report.word.assertions().is_empty();
    match report.stop_reason {
        StopReason::Inconsistent { observation } if by_observation => Some(observation),
        _ => None,
    }
}

/// The visits as they are taken, explained in the ordinary way.
fn explained(
    mended: &Mended,
    events: &[Arc<Event>],
    config: MapConfig,
) -> Result<(Abduction, Survey), abduction::VisitError> {
    let MapConfig { axioms, max_candidates, max_memory, max_steps, .. } = config;
    let limits = abduction::Limits { max_candidates: Some(max_candidates), max_memory, max_steps };
    let seen: Vec<&Arc<Event>> =
        events.iter().filter(|event| matches!(event.kind, EventKind::Observation(_))).collect();
    let (mut abduction, mut survey) = (Abduction::new(axioms, limits), Survey::default());
    for told in &mended.told {
        let event = told
            .observation
            .and_then(|k| seen.get(k))
            .map_or_else(|| unseen(told), |event| Arc::clone(event));
        survey = survey.with(&event, &told.sighting);
        abduction.observe_measured(&Visit::from(&told.sighting), survey.measurements().evidence())?;
    }
    Ok((abduction, survey))
}

/// An observation that was not made, of a place that the robot passed.
fn unseen(told: &Told) -> Arc<Event> {
    let sighting = &told.sighting;
    let (star, dstate) = (sighting.star.clone(), sighting.arrival);
    let percept = Percept::Star { star, dstate, robot_pose: Some(sighting.robot_pose) };
    let kind = EventKind::Observation(Box::new(Observation { percept }));
    Arc::new(Event { seq: 0, stamp: None, kind })
}
