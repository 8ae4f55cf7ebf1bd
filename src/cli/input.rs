//! Input files: traces and recorded logs, plain or compressed, or standard input.

use crate::cli::failure::Failure;
use crate::grid::GridError;
use crate::sensor::CarmenLog;
use crate::trace::recording::{Arrival, Recorder};
use crate::trace::{Event, read_lines};
use crate::visit::{AnnotatedVisits, ArrivalsError, Stage, VisitDetector, VisitParameters};
use bzip2::read::MultiBzDecoder;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// The events of an input up to its first fault.
pub(super) struct Events {
    /// Each with the words that say where it came from.
    pub(super) events: Vec<(String, Event)>,
    /// What ended the reading before the end of the input.
    pub(super) fault: Option<Failure>,
}

/// The events of a trace, or of the visits in a CARMEN log: those that are found, or those whose arrivals are given.
pub(super) fn read_events(input: &Path, visits: Option<&Path>) -> Result<Events, Failure> {
    match (is_log(input), visits) {
        (true, visits) => {
            let numbered = read_log(input, visits)?.into_iter();
            let events = numbered.map(|event| (format!("event {} of the log", event.seq), event)).collect();
            Ok(Events { events, fault: None })
        }
        (false, Some(_)) => {
            Err(Failure::Input(format!("{}: --visits goes with a log, not with a trace", input.display())))
        }
        (false, None) => {
            let (events, error) = read_lines(open(input)?);
            let events = events.into_iter().map(|(line, event)| (format!("line {line}"), event)).collect();
            Ok(Events { events, fault: error.map(|error| Failure::input(input, error)) })
        }
    }
}

/// Whether a file name is that of a CARMEN log.
fn is_log(input: &Path) -> bool {
    matches!(plain_extension(input).as_str(), "clf" | "log")
}

/// The extension of a file name once that of a compression is taken off; empty if there is none.
pub(super) fn plain_extension(path: &Path) -> String {
    let compressed = path.extension().is_some_and(|ending| ending == "bz2" || ending == "gz");
    let plain = if compressed { path.with_extension("") } else { path.to_owned() };
    plain.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default()
}

fn read_log(input: &Path, visits: Option<&Path>) -> Result<Vec<Event>, Failure> {
    let log = CarmenLog::read(open(input)?).map_err(|error| Failure::input(input, error))?;
    eprintln!("{}: {} scans, {} other lines passed over", input.display(), log.scans.len(), log.skipped);
    let stages = match visits {
        Some(visits) => marked_visits(&log, visits)?,
        None => found_visits(&log).map_err(|error| Failure::input(input, error))?,
    };
    let mut recorder = Recorder::default();
    Ok(stages.into_iter().flat_map(|stage| recorder.add(stage)).collect())
}

fn found_visits(log: &CarmenLog) -> Result<Vec<Stage>, GridError> {
    let mut detector = VisitDetector::new(VisitParameters::default())?;
    let mut stages: Vec<Stage> = log.scans.iter().flat_map(|scan| detector.add(scan)).collect();
    stages.extend(detector.finish());
    Ok(stages)
}

fn marked_visits(log: &CarmenLog, visits: &Path) -> Result<Vec<Stage>, Failure> {
    let text = io::read_to_string(open(visits)?).map_err(|error| Failure::input(visits, error))?;
    let arrivals = Arrival::read_csv(&text).map_err(|error| Failure::input(visits, error))?;
    let arrivals = arrivals.into_iter().map(|arrival| arrival.scan).collect();
    let refused = |error: ArrivalsError| Failure::input(visits, error);
    let mut marked = AnnotatedVisits::new(arrivals, &VisitParameters::default()).map_err(refused)?;
    let mut stages: Vec<Stage> = log.scans.iter().filter_map(|scan| marked.add(scan)).collect();
    stages.extend(marked.finish().map_err(refused)?);
    Ok(stages)
}

/// A file, decompressed by its ending; `-` is standard input.
pub(super) fn open(path: &Path) -> Result<Box<dyn BufRead>, Failure> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin().lock()));
    }
    let file =
        File::open(path).map_err(|error| Failure::input(path, format!("cannot be opened: {error}")))?;
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    Ok(match ending {
        "bz2" => Box::new(BufReader::new(MultiBzDecoder::new(file))),
        "gz" => Box::new(BufReader::new(MultiGzDecoder::new(file))),
        _ => Box::new(BufReader::new(file)),
    })
}
