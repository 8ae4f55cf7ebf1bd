//! Input files: traces and recorded logs, plain or compressed, or standard input.

use crate::cli::failure::Failure;
use crate::cli::log::{LogArgs, LogScans, is_log, read_log};
use crate::cli::members::{BzipMembers, GzipMembers};
use crate::geometry::Pose;
use crate::patchwork::assembly::Stop;
use crate::patchwork::drive::{Drive, DriveRecorder};
use crate::sensor::log::LogError;
use crate::sensor::{LaserScan, LocalPose, ScanMatcher};
use crate::trace::recording::{Arrival, Recorder};
use crate::trace::{Event, read_lines};
use crate::visit::relations::{Relation, Track};
use crate::visit::truth::Timetable;
use crate::visit::{AnnotatedVisits, Stage, Visit, VisitDetector, VisitParameters};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::sync::mpsc;
use std::thread;

/// The events of an input up to its first fault.
#[derive(Default)]
pub(super) struct Events {
    /// Each with the words that say where it came from.
    pub(super) events: Vec<(String, Event)>,
    /// What ended the reading before the end of the input.
    pub(super) fault: Option<Failure>,
    /// When the visits of a log were; empty for a trace.
    pub(super) timetable: Timetable,
    /// Where the robot was at the scans of a log.
    pub(super) track: Track,
    /// The way of a log; empty for a trace.
    pub(super) way: Way,
}

/// The way of a log, and its visits.
#[derive(Default)]
pub(super) struct Way {
    pub(super) drive: Drive,
    pub(super) stops: Vec<Stop>,
}

/// The events of a trace, or of the visits in a log: those that are found, or those at the arrivals given.
pub(super) fn read_events(input: &Path, visits: Option<&Path>, log: &LogArgs) -> Result<Events, Failure> {
    match (is_log(input), visits) {
        (true, None) => found_visits(input, read_log(input, log)?),
        (true, Some(visits)) => visits_at(input, read_log(input, log)?, visits),
        (false, Some(_)) => {
            Err(Failure::Input(format!("{}: --visits goes with a log, not with a trace", input.display())))
        }
        (false, None) if *log != LogArgs::default() => {
            Err(Failure::Usage(format!("{}: the options for logs do not go with a trace", input.display())))
        }
        (false, None) => {
            let (events, error) = read_lines(open(input)?);
            let hint = if events.is_empty() { hint_at_logs(input) } else { "" };
            let events = events.into_iter().map(|(line, event)| (format!("line {line}"), event)).collect();
            let fault = error.map(|error| Failure::input(input, format!("{error}{hint}")));
            Ok(Events { events, fault, ..Events::default() })
        }
    }
}

/// What may help where a file does not even begin as a trace does.
fn hint_at_logs(input: &Path) -> &'static str {
    match plain_extension(input).as_str() {
        "ndjson" | "jsonl" => "",
        _ => {
            "\n  it was read as a trace; a log is known by the end of its name: .clf or .log, also with .gz or .bz2 behind \
             it, or .mcap"
        }
    }
}

/// The extension of a file name, in small letters.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The extension of a file name once that of a compression is taken off, in small letters; empty if there is none.
pub(super) fn plain_extension(path: &Path) -> String {
    match extension(path).as_str() {
        "bz2" | "gz" => extension(&path.with_extension("")),
        plain => plain.to_owned(),
    }
}

/// The events of a log up to its first fault.
fn found_visits(input: &Path, mut log: LogScans) -> Result<Events, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::input(input, error);
    let parameters = VisitParameters::default();
    let mut detector = VisitDetector::new(parameters).map_err(|error| bad(&error))?;
    let (mut stages, mut track) = (Vec::new(), Track::default());
    let mut drive = DriveRecorder::new(parameters.matching.max_range);
    let fault = feed(&mut log, ScanMatcher::new(parameters.matching), |scan, pose| {
        stages.extend(detector.add_placed(scan, pose));
        detector.now().into_iter().for_each(|now| track.add(scan, now));
        drive.add(scan, pose);
    });
    let driven = detector.now().map_or(0.0, |now| now.driven);
    stages.extend(detector.finish());
    Events::of(input, &log, stages, driven, fault).map(|events| events.along(track, drive))
}

/// The events of a log up to its first fault; arrivals after that are left out.
fn visits_at(input: &Path, mut log: LogScans, visits: &Path) -> Result<Events, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::input(visits, error);
    let arrivals: Vec<usize> = read_arrivals(visits)?.into_iter().map(|arrival| arrival.scan).collect();
    if arrivals.is_empty() {
        return Err(bad(
            &"has no arrival, expected a line for each, the scan at which the robot comes to a place",
        ));
    }
    let parameters = VisitParameters::default();
    let mut marked = AnnotatedVisits::new(arrivals, &parameters).map_err(|error| bad(&error))?;
    let (mut stages, mut track) = (Vec::new(), Track::default());
    let mut drive = DriveRecorder::new(parameters.matching.max_range);
    let fault = feed(&mut log, ScanMatcher::new(parameters.matching), |scan, pose| {
        stages.extend(marked.add_placed(scan, pose));
        marked.now().into_iter().for_each(|now| track.add(scan, now));
        drive.add(scan, pose);
    });
    let driven = marked.now().map_or(0.0, |now| now.driven);
    let (last, beyond) = marked.finish();
    stages.extend(last);
    // A log that ended too early does not hold them all.
    if let Some(error) = beyond.filter(|_| fault.is_none()) {
        return Err(bad(&error));
    }
    Events::of(input, &log, stages, driven, fault).map(|events| events.along(track, drive))
}

/// Marked arrivals, from CSV.
pub(super) fn read_arrivals(file: &Path) -> Result<Vec<Arrival>, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::input(file, error);
    let text = io::read_to_string(open(file)?).map_err(|error| bad(&error))?;
    Arrival::read_csv(&text).map_err(|error| bad(&error))
}

/// Checked relative poses.
pub(super) fn read_relations(file: &Path) -> Result<Vec<Relation>, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::input(file, error);
    let text = io::read_to_string(open(file)?).map_err(|error| bad(&error))?;
    Relation::read(&text).map_err(|error| bad(&error))
}

/// So many scans are read ahead at most.
const AHEAD: usize = 256;

/// Gives away the scans of a log one by one with their poses, up to its first fault. They are read and matched ahead, in
/// a thread of their own.
fn feed(
    log: &mut LogScans,
    mut matcher: ScanMatcher,
    mut take: impl FnMut(&LaserScan, &LocalPose),
) -> Option<LogError> {
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel(AHEAD);
        let reader = scope.spawn(move || {
            log.find_map(|scan| {
                let placed = scan.map(|scan| (matcher.add(&scan), scan));
                // Nobody stops to listen before the end.
                placed.map(|placed| drop(sender.send(placed))).err()
            })
        });
        receiver.iter().for_each(|(pose, scan)| take(&scan, &pose));
        reader.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

impl Events {
    fn of(
        input: &Path,
        log: &LogScans,
        stages: Vec<Stage>,
        driven: f64,
        fault: Option<LogError>,
    ) -> Result<Events, Failure> {
        let fault = fault.map(|fault| Failure::input(input, fault));
        let report = log.report();
        if report.scans() == 0 {
            return fault.map_or_else(|| Ok(Events::default()), Err);
        }
        eprintln!("{}: {report}", input.display());
        if stages.is_empty() && fault.is_none() {
            return Err(Failure::input(input, no_visit(log, driven)));
        }
        let mut events = Events { fault, ..Events::default() };
        let mut recorder = Recorder::default();
        for stage in stages {
            events.timetable.add(&stage);
            events.way.stops.push(stop(&stage));
            let recorded = recorder.add(stage).into_iter();
            events.events.extend(recorded.map(|event| (format!("event {} of the log", event.seq), event)));
        }
        Ok(events)
    }
}

impl Events {
    /// The same with the way they were on.
    fn along(mut self, track: Track, drive: DriveRecorder) -> Events {
        self.track = track;
        self.way.drive = drive.finish();
        self
    }
}

/// Why a log has no visit, as far as can be told.
fn no_visit(log: &LogScans, driven: f64) -> String {
    let report = log.report();
    format!(
        "no visit was found in {} scans over {driven:.1} m, expected a place with more than one way on that the robot came \
         into and left: is the log longer than a corridor, and do most of its readings return?",
        report.scans()
    )
}

/// Where a visit is on the way. Its LPM has the axes of the local frame.
fn stop(stage: &Stage) -> Stop {
    let Visit { center, arrival, departure, .. } = &stage.visit;
    let scan = arrival.scan + (departure.scan.max(arrival.scan) - arrival.scan) / 2;
    Stop { scan, local_from_visit: Pose { x: center.x, y: center.y, theta: 0.0 } }
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
pub(super) fn decompressed(path: &Path, file: impl Read + Send + 'static) -> Box<dyn BufRead + Send> {
    match extension(path).as_str() {
        "bz2" => Box::new(BufReader::new(BzipMembers::new(BufReader::new(file)))),
        "gz" => Box::new(BufReader::new(GzipMembers::new(BufReader::new(file)))),
        _ => Box::new(BufReader::new(file)),
    }
}
