//! `topostar map` on a trace of views: profile `classic`.

use crate::classic::{Guide, Report, StopReason, best_first, breadth_first};
use crate::cli::failure::Failure;
use crate::cli::files::written;
use crate::cli::input::Events;
use crate::cli::map::{Map, StrategyName};
use crate::cli::words::numbers;
use crate::export::{Relation, ViewReport, ViewStrategy, view_text};
use crate::service::ViewSession;
use crate::trace::{Event, EventKind, Percept, write_trace};
use std::collections::BTreeSet;
use std::io::{Write, stdout};
use std::time::Instant;

/// Whether a trace is one of views; what it begins with decides.
pub(super) fn is_of_views(events: &[(String, Event)]) -> bool {
    let first = events.first().map(|(_, event)| &event.kind);
    matches!(first, Some(EventKind::Observation(seen)) if matches!(seen.percept, Percept::View(_)))
}

/// Explains a trace of views.
pub(super) fn run(map: &Map, input: Events) -> Result<(), Failure> {
    let started = Instant::now();
    let (mut session, mut taken, mut fault) = (ViewSession::new(), Vec::new(), input.fault);
    for (place, event) in input.events {
        if let Err(error) = session.accept(&event) {
            fault = Some(Failure::input(&map.input, format!("{place}: {error}")));
            break;
        }
        taken.push(event);
    }
    let (strategy, report) = search(map, &session);
    let mut wire = ViewReport::new(&report, strategy);
    wire.seconds = Some(started.elapsed().as_secs_f64());
    let json = serde_json::to_string_pretty(&wire).map_err(|error| Failure::Broken(error.to_string()))?;
    let words = in_words(&report, &wire, &session);
    writeln!(stdout(), "{}", if map.json { json.as_str() } else { words.trim_end() })?;
    if let Some(folder) = &map.output {
        let mut trace = Vec::new();
        write_trace(&mut trace, &taken)?;
        let found = report.minimal.first();
        let text = found.map(|candidate| view_text(&candidate.map, &session.view_names()));
        let files = [
            ("trace.ndjson", Some(trace)),
            ("report.json", Some(json.into_bytes())),
            ("map.txt", text.map(String::into_bytes)),
        ];
        written(folder, files.into_iter().filter_map(|(name, content)| Some((name, content?))))?;
    }
    fault.map_or_else(|| verdict(&report), Err)
}

fn search(map: &Map, session: &ViewSession) -> (ViewStrategy, Report) {
    let most = usize::try_from(map.max_candidates).unwrap_or(usize::MAX);
    let seen = session.seen();
    match map.strategy {
        StrategyName::BreadthFirst => (ViewStrategy::BreadthFirst, breadth_first(seen, most).report()),
        StrategyName::BestFirst => (ViewStrategy::BestFirst, best_first(seen, Guide::Bound, most)),
        StrategyName::Simplest => (ViewStrategy::SimplestFirst, best_first(seen, Guide::Simplest, most)),
    }
}

fn in_words(report: &Report, wire: &ViewReport, session: &ViewSession) -> String {
    let counts: Vec<String> = wire.candidates_per_observation.iter().map(u64::to_string).collect();
    let refuted: Vec<String> =
        wire.refuted.iter().map(|(axiom, count)| format!(" {axiom} {count}")).collect();
    let mut text = format!(
        "candidates after each observation  {}\nmaps created {}, refuted{}\n",
        counts.join(" "),
        wire.maps_created,
        refuted.join(",")
    );
    text += match report.stop_reason {
        StopReason::Exhausted | StopReason::Inconsistent { .. } => "\n",
        StopReason::Found | StopReason::MinimumProven => {
            "lower bounds, as other candidates were not followed\n\n"
        }
        StopReason::Limit { .. } => "lower bounds from where --max-candidates cut the search\n\n",
    };
    let (Some(candidate), Some(preferred)) = (report.minimal.first(), &wire.preferred) else {
        return text + "no map\n";
    };
    let at_least = if wire.candidates.relation == Relation::Gte { "at least " } else { "" };
    let simplest = match (preferred.unique, wire.minimal.len()) {
        (true, _) => "the simplest".into(),
        (false, 1) => "no other as simple found".into(),
        (false, ties) => format!("1 of {ties} equally simple"),
    };
    let proof = if preferred.proven { "proven" } else { "not proven" };
    text += &format!(
        "preferred map: 1 of {at_least}{} possible, {simplest}, {proof}\n",
        wire.candidates.value.max(1)
    );
    text += &format!(
        "{} places, {} paths, {} path segments, {} dstates\nvisits to places {}\n\n",
        preferred.places,
        preferred.paths,
        preferred.segments,
        preferred.dstates,
        numbers(&preferred.visits)
    );
    text += &view_text(&candidate.map, &session.view_names());
    // Most ties differ in dstates alone.
    let rivals: BTreeSet<&Vec<usize>> = wire.minimal.iter().collect();
    let rivals = rivals.into_iter().filter(|visits| **visits != preferred.visits).take(RIVALS);
    text.extend(rivals.map(|visits| format!("as simple: visits {}\n", numbers(visits))));
    text
}

/// Ties that are written out.
const RIVALS: usize = 20;

fn verdict(report: &Report) -> Result<(), Failure> {
    match report.stop_reason {
        StopReason::Exhausted | StopReason::Found | StopReason::MinimumProven => Ok(()),
        StopReason::Limit { observation } => Err(Failure::Limit(format!(
            "--max-candidates cut the search at observation {observation}: counts are lower bounds"
        ))),
        StopReason::Inconsistent { observation } => {
            let axioms = report.extinction.iter().flat_map(|end| &end.axioms).map(|axiom| axiom.name());
            Err(Failure::NoMap(format!(
                "no consistent map: nothing explains observation {observation}; refuted by {}",
                axioms.collect::<Vec<_>>().join(", ")
            )))
        }
    }
}
