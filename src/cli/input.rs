//! Input files: traces and recorded logs, plain or compressed, or standard input.

use crate::cli::failure::Failure;
use crate::cli::log::{LogArgs, is_log, read_log};
use crate::trace::recording::{Arrival, RecordingParameters, cut};
use crate::trace::{Event, read_lines};
use bzip2::read::MultiBzDecoder;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// The events of an input up to its first fault.
pub(super) struct Events {
    /// Each with the words that say where it came from.
    pub(super) events: Vec<(String, Event)>,
    /// What ended the reading before the end of the input.
    pub(super) fault: Option<Failure>,
}

/// The events of a trace, or of a log with the arrivals in it.
pub(super) fn read_events(input: &Path, visits: Option<&Path>, log: &LogArgs) -> Result<Events, Failure> {
    match (is_log(input), visits) {
        (true, Some(visits)) => read_arrivals(input, visits, log),
        (true, None) => Err(Failure::Input(format!(
            "{}: is a log, and places are not yet found in it by themselves; name the arrivals by --visits FILE.csv \
             with the columns place,raw_scan_index",
            input.display()
        ))),
        (false, Some(_)) => {
            Err(Failure::Input(format!("{}: --visits goes with a log, not with a trace", input.display())))
        }
        (false, None) if *log != LogArgs::default() => {
            Err(Failure::Usage(format!("{}: the options for logs do not go with a trace", input.display())))
        }
        (false, None) => {
            let (events, error) = read_lines(open(input)?);
            let events = events.into_iter().map(|(line, event)| (format!("line {line}"), event)).collect();
            Ok(Events { events, fault: error.map(|error| Failure::input(input, error)) })
        }
    }
}

/// The extension of a file name once that of a compression is taken off; empty if there is none.
pub(super) fn plain_extension(path: &Path) -> String {
    let compressed = path.extension().is_some_and(|ending| ending == "bz2" || ending == "gz");
    let plain = if compressed { path.with_extension("") } else { path.to_owned() };
    plain.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The events of a log up to its first fault; arrivals after that are left out.
fn read_arrivals(input: &Path, visits: &Path, log: &LogArgs) -> Result<Events, Failure> {
    let mut log = read_log(input, log)?;
    let (scans, fault) = log.read_all();
    let fault = fault.map(|fault| Failure::input(input, fault));
    if scans.is_empty() {
        return fault.map_or_else(|| Ok(Events { events: Vec::new(), fault: None }), Err);
    }
    eprintln!("{}: {}", input.display(), log.report());
    let bad = |error: &dyn std::fmt::Display| Failure::input(visits, error);
    let text = io::read_to_string(open(visits)?).map_err(|error| bad(&error))?;
    let mut arrivals = Arrival::read_csv(&text).map_err(|error| bad(&error))?;
    if fault.is_some() {
        arrivals.retain(|arrival| arrival.scan < scans.len());
    }
    let events =
        cut(&scans, &arrivals, &RecordingParameters::default()).map_err(|error| bad(&error))?.into_iter();
    let events = events.map(|event| (format!("event {} of the arrivals", event.seq), event)).collect();
    Ok(Events { events, fault })
}

/// A file, decompressed by its ending; `-` is standard input.
pub(super) fn open(path: &Path) -> Result<Box<dyn BufRead>, Failure> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin().lock()));
    }
    let file =
        File::open(path).map_err(|error| Failure::input(path, format!("cannot be opened: {error}")))?;
    Ok(decompressed(path, file))
}

/// The content of a file, decompressed by the ending of its name.
pub(super) fn decompressed(path: &Path, file: impl Read + 'static) -> Box<dyn BufRead> {
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default() {
        "bz2" => Box::new(BufReader::new(MultiBzDecoder::new(file))),
        "gz" => Box::new(BufReader::new(MultiGzDecoder::new(file))),
        _ => Box::new(BufReader::new(file)),
    }
}
