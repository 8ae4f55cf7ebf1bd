//! What `topostar map -o` writes: the trace, the report, the map in words and as a picture.

use crate::abduction::{Candidate, Report};
use crate::cli::failure::Failure;
use crate::cli::mending::Attempt;
use crate::cli::standstill::{Stopped, pictures};
use crate::cli::words::certainty;
use crate::export::{self, MapGraph, Mending, map_svg, map_text, mending_text, standstill_text};
use crate::trace::{Event, write_event};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// A file to be written: its name and what is in it.
pub(super) type Named = (String, Vec<u8>);

/// What there is to be written of a map.
pub(super) fn files(
    events: &[Arc<Event>],
    report: &Report,
    wire: &export::Report,
    stopped: Option<&Stopped>,
    attempt: Option<&Attempt>,
) -> Result<Vec<Named>, Failure> {
    let mut trace = Vec::new();
    events.iter().try_for_each(|event| write_event(&mut trace, event))?;
    let mut files: Vec<Named> =
        vec![("trace.ndjson".into(), trace), ("report.json".into(), json(wire)?.into_bytes())];
    let mending = wire.mending.as_deref();
    if let Some(stopped) = stopped
        && let found = attempt.map_or(&stopped.before, |attempt| &attempt.found)
        && let Some(candidate) = found.minimal.first()
    {
        files.extend(longest(candidate, stopped, mending));
    }
    if let (Some(candidate), Some(preferred)) = (report.minimal.first(), &wire.preferred) {
        let certainty = certainty(&wire.candidates, preferred, wire.minimal.len());
        let map = MapGraph::of(candidate);
        files.extend(map_files(map_text(&map), map_svg(&map, "Preferred map", &certainty)));
    }
    let concerned = stopped.map(|stopped| stopped.why.concerned()).into_iter().flatten();
    let concerned = concerned.chain(mending.iter().flat_map(|mending| mending.observations_changed()));
    files.extend(pictures(concerned.collect(), events, &|observation| {
        mending.map(|mending| mending.remarks(observation)).unwrap_or_default()
    }));
    Ok(files)
}

/// A report as JSON.
pub(super) fn json(report: &export::Report) -> Result<String, Failure> {
    serde_json::to_string_pretty(report).map_err(|error| Failure::Broken(error.to_string()))
}

/// Writes files into a folder and says so.
pub(super) fn written(
    folder: &Path,
    files: impl IntoIterator<Item = (impl AsRef<Path>, Vec<u8>)>,
) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
    for (name, content) in files {
        let file = folder.join(name);
        fs::write(&file, content).map_err(|error| Failure::writing(&file, error))?;
    }
    eprintln!("written to {}", folder.display());
    Ok(())
}

/// The map of the longest stretch that is explained, where no map explains all, as it was read.
fn longest(candidate: &Candidate, stopped: &Stopped, mending: Option<&Mending>) -> [Named; 2] {
    let map = MapGraph::of(candidate);
    let (title, said) = match mending {
        None => {
            let title = format!("Map before observation {}", stopped.why.observation);
            (title, "nothing explains what came then".to_owned())
        }
        Some(mending) => {
            let last = (mending.first + mending.explained).saturating_sub(1);
            let all = mending.explained == mending.observations;
            let what = if all { "all of them" } else { "the longest stretch that a map explains" };
            let changed = match mending.changes.len() {
                1 => "1 reading changed".to_owned(),
                count => format!("{count} readings changed"),
            };
            (format!("Map of observations {} to {last}", mending.first), format!("{what}; {changed}"))
        }
    };
    let mended = mending.map(mending_text).unwrap_or_default();
    let words = format!("{}\n{mended}{}", standstill_text(&stopped.why), map_text(&map));
    map_files(words, map_svg(&map, &title, &said))
}

fn map_files(words: String, picture: String) -> [Named; 2] {
    [("map.txt".into(), words.into_bytes()), ("map.svg".into(), picture.into_bytes())]
}
