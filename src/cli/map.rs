//! `topostar map`: a trace in, the preferred map and the number of maps still possible out.

use crate::abduction::{Abduction, AxiomSet, Candidate, Report, StopReason, Strategy};
use crate::cli::asked::{Asked, Said};
use crate::cli::axiom_choice::AxiomChoice;
use crate::cli::classic::{self, is_of_views};
use crate::cli::failure::Failure;
use crate::cli::files::{files, json, written};
use crate::cli::input::{Events, read_arrivals, read_events};
use crate::cli::log::{LogArgs, is_log};
use crate::cli::mending::{Attempt, attempt};
use crate::cli::patchwork::{Patchwork, or_left_out, patchwork, rank, strain_in_words};
use crate::cli::poses::{pose_errors, poses_in_words};
use crate::cli::standstill::{Stopped, map_in_words, stopped};
use crate::cli::values::{bytes, resolution, seconds};
use crate::cli::words::{in_words, reasons_in_words, truth_in_words};
use crate::explanation::{Verdict, verdict as verdict_of};
use crate::export::{self, Explanation, Mark, PoseErrors, Truth, mending_text, standstill_text};
use crate::service::{Limits, MapConfig, Session, SessionError};
use crate::trace::recording::Arrival;
use crate::trace::{Event, EventKind};
use crate::visit::relations::Track;
use crate::visit::truth::Timetable;
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{Write, stdout};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Find all maps that explain a trace, and the simplest.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  topostar map trace.ndjson                         the preferred map in words
  topostar map trace.ndjson --profile paper --json  the report for machines
  topostar map run.clf.bz2 -o out/                  the places in a log and their map; writes the trace and pictures
  topostar map run.clf.bz2 --truth arrivals.csv     and what was found, missed, invented, merged or split
  topostar map run.clf.bz2 --visits arrivals.csv    the map of a log at known arrivals
  topostar map trace.ndjson --explain               and why: closures, refuted rivals, where to look next
  topostar map trace.ndjson --explain=0,8           why observations 0 and 8 are one place, or are not
  topostar map trace.ndjson --assert 0=8 --assert 3!=5
                                                    the map if these are, and these are not, one place")]
pub(super) struct Map {
    /// A trace (.ndjson), a log (CARMEN's .clf or .log, also .gz and .bz2; a ROS 2 bag, .mcap or its
    /// folder), or - for standard input.
    pub(super) input: PathBuf,
    /// The arrivals in a log, in place of those that are found: CSV with the columns place,raw_scan_index.
    #[arg(long, value_name = "CSV")]
    visits: Option<PathBuf>,
    /// Compare the map of a log with the true arrivals: CSV as for --visits.
    #[arg(long, value_name = "CSV")]
    truth: Option<PathBuf>,
    /// Compare the poses of a log with checked relative poses: lines of t1 t2 x y z roll pitch yaw.
    #[arg(long, value_name = "FILE")]
    relations: Option<PathBuf>,
    #[command(flatten)]
    held: AxiomChoice,
    #[command(flatten)]
    log: LogArgs,
    /// How candidates are searched.
    #[arg(long, value_enum, default_value_t = StrategyName::BreadthFirst)]
    pub(super) strategy: StrategyName,
    /// The most candidates kept after an observation, the simplest ones; best-first and simplest-first: the most maps
    /// made. Counts say when this cut the search.
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) max_candidates: u64,
    /// The most bytes that the search may hold, or KiB, MiB, GiB with a K, M or G behind the number: candidates, counted
    /// as if their maps shared no memory, and what searches for room and for the simplest ones remember.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    max_memory: Option<usize>,
    /// With --strategy best-first: the most partial explanations looked at.
    #[arg(long, value_name = "N")]
    max_steps: Option<u64>,
    /// With --strategy best-first: the longest search, in seconds; what was found by then is shown.
    #[arg(long, value_name = "S", value_parser = seconds)]
    max_seconds: Option<Duration>,
    /// Take every reading as it is: where no map explains them, do not look for doubtful ones to change.
    #[arg(long)]
    as_read: bool,
    /// Print the report as one JSON object.
    #[arg(long)]
    pub(super) json: bool,
    /// Say why: what the closures of the preferred map rest on and what rivals say, what refuted rivals, and where to
    /// look next. With =A,B, of these two observations, counted from 0.
    #[arg(long, value_name = "A,B", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    explain: Option<Asked>,
    /// An operator's word after the trace: two observations, counted from 0, are (=) or are not (!=) one place.
    #[arg(long = "assert", value_name = "A=B|A!=B")]
    asserts: Vec<Said>,
    /// Write trace.ndjson, report.json, map.txt and map.svg there; where travels were measured, also the patchwork: all
    /// that was seen as one grid for map_server (patchwork.png, patchwork.yaml), the same by odometry alone
    /// (odometry.png), the graph of the visits (patchwork.g2o), and of a log the way of the robot (trajectory.tum).
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Side of a cell of the patchwork's grids, metres; where they would be too large, larger cells are taken, and it is said
    /// so.
    #[arg(long, value_name = "METRES", requires = "output", default_value_t = 0.05, value_parser = resolution)]
    resolution: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum StrategyName {
    /// All candidates, one observation after the other: exhaustive.
    BreadthFirst,
    /// The simplest maps alone, and the proof that none is simpler.
    BestFirst,
    /// The map that is the simplest now, until one explains everything, as Beeson et al. 2003; for traces of views.
    #[value(name = "simplest-first")]
    Simplest,
}

impl Map {
    pub(super) fn run(self) -> Result<(), Failure> {
        let started = Instant::now();
        let mut input = read_events(&self.input, self.visits.as_deref(), &self.log)?;
        // Where there is nothing to tell by, the options do.
        let asked = input.events.is_empty() && self.held.is_classic();
        let (axioms, strategy) = match self.theory(asked || is_of_views(&input.events))? {
            Theory::Views => return classic::run(&self, input),
            Theory::Stars(axioms, strategy) => (axioms, strategy),
        };
        let (timetable, track) = (std::mem::take(&mut input.timetable), std::mem::take(&mut input.track));
        let way = std::mem::take(&mut input.way);
        let Explained { events, session, fault } = self.search(input, axioms, strategy)?;
        let attempt = if self.as_read { None } else { attempt(&session, &events)? };
        let attempt = attempt.as_ref();
        let (abduction, survey) =
            (session.abduction(), attempt.map_or(&**session.survey(), |attempt| &attempt.survey));
        let (mut report, mut agreements) = (abduction.report(), survey.agreements());
        let ties = rank(&mut report, survey, &mut agreements);
        let mut wire = export::Report::new(&report);
        wire.ties = ties;
        wire.explain = self.reasons(abduction, &report)?.map(Box::new);
        wire.truth = self.compared(&timetable, abduction, wire.preferred.as_ref())?.map(Box::new);
        let shown = report.minimal.first().or(attempt.and_then(|attempt| attempt.found.minimal.first()));
        let told = |map: &Candidate| match attempt {
            Some(attempt) => attempt.mending.told.clone(),
            None => (0..map.visits.len()).map(Some).collect(),
        };
        let patchwork = shown.and_then(|map| {
            or_left_out("the patchwork", patchwork(survey, &mut agreements, &map.visits, &way, &told(map)))
        });
        let strain = patchwork.as_ref().filter(|_| wire.preferred.is_some());
        wire.strain = strain.map(|patchwork| Box::new(patchwork.strain.clone()));
        wire.poses = self.pose_errors(&track, patchwork.as_ref())?.map(Box::new);
        let stopped = stopped(&session, &events, limits())?;
        wire.standstill = stopped.as_ref().map(|stopped| Box::new(stopped.why.clone()));
        wire.mending = attempt.map(|attempt| Box::new(attempt.mending.clone()));
        wire.seconds = Some(started.elapsed().as_secs_f64());
        self.print(&report, &wire, stopped.as_ref(), attempt)?;
        if let Some(folder) = &self.output {
            let mut files = files(&events, &report, &wire, stopped.as_ref(), attempt)?;
            if let Some(patchwork) = &patchwork {
                files.extend(patchwork.files(self.resolution)?);
            }
            written(folder, files)?;
        }
        fault.map_or_else(|| verdict(&report), Err)
    }

    fn print(
        &self,
        report: &Report,
        wire: &export::Report,
        stopped: Option<&Stopped>,
        attempt: Option<&Attempt>,
    ) -> Result<(), Failure> {
        if self.json {
            return Ok(writeln!(stdout(), "{}", json(wire)?)?);
        }
        let mending = wire.mending.as_deref().map(mending_text).unwrap_or_default();
        write!(stdout(), "{}", in_words(report, wire))?;
        write!(stdout(), "{}{}", reasons_in_words(wire), truth_in_words(wire))?;
        write!(stdout(), "{}", wire.strain.as_deref().map(strain_in_words).unwrap_or_default())?;
        write!(stdout(), "{}", wire.poses.as_deref().map(poses_in_words).unwrap_or_default())?;
        if let Some(Stopped { why, before }) = stopped {
            let longest = attempt.map_or(before, |attempt| &attempt.found);
            write!(stdout(), "{}\n{mending}{}", standstill_text(why), map_in_words(longest))?;
        }
        Ok(())
    }

    /// What the options ask for, which must go with the trace.
    fn theory(&self, views: bool) -> Result<Theory, Failure> {
        if views {
            let reasons = self.explain.is_some() || !self.asserts.is_empty();
            let steps = self.max_steps.is_some() || self.max_seconds.is_some() || self.max_memory.is_some();
            self.held.for_views().map_err(|why| self.misfit(why))?;
            if steps {
                return Err(self.misfit("is a trace of views, for which --max-candidates is the only limit"));
            }
            if reasons {
                return Err(
                    self.misfit("is a trace of views, with which --explain and --assert do not go yet")
                );
            }
            if !self.held.is_classic() {
                eprintln!("{}: a trace of views, explained in profile classic", self.input.display());
            }
            return Ok(Theory::Views);
        }
        let axioms = self.held.for_stars().map_err(|why| self.misfit(why))?;
        let strategy = match self.strategy {
            StrategyName::BreadthFirst => Strategy::BreadthFirst,
            StrategyName::BestFirst => Strategy::BestFirst,
            StrategyName::Simplest => {
                return Err(self.misfit("is no trace of views, which alone --strategy simplest-first is for"));
            }
        };
        Ok(Theory::Stars(axioms, strategy))
    }

    /// What was found beside the true arrivals, if they are given.
    fn compared(
        &self,
        timetable: &Timetable,
        abduction: &Abduction,
        preferred: Option<&export::Preferred>,
    ) -> Result<Option<Truth>, Failure> {
        let Some(file) = &self.truth else { return Ok(None) };
        if !is_log(&self.input) {
            return Err(self.misfit("is no log, and --truth is the arrivals in a log"));
        }
        let marks: Vec<Mark> =
            read_arrivals(file)?.into_iter().map(|Arrival { place, scan }| Mark { place, scan }).collect();
        let at = timetable.visits_at(&marks.iter().map(|mark| mark.scan).collect::<Vec<_>>());
        let places = preferred.map(|preferred| preferred.visits.as_slice());
        Ok(Some(Truth::of(marks, &at, abduction.visits(), places)))
    }

    /// How far the poses are off, if relations are given.
    fn pose_errors(
        &self,
        track: &Track,
        patchwork: Option<&Patchwork<'_>>,
    ) -> Result<Option<PoseErrors>, Failure> {
        let Some(file) = &self.relations else { return Ok(None) };
        if !is_log(&self.input) {
            return Err(self.misfit("is no log, and --relations is about the poses in a log"));
        }
        pose_errors(track, patchwork, file).map(Some)
    }

    fn misfit(&self, what: &str) -> Failure {
        Failure::Usage(format!("{}: {what}", self.input.display()))
    }

    fn search(&self, input: Events, axioms: AxiomSet, strategy: Strategy) -> Result<Explained, Failure> {
        let max_candidates = usize::try_from(self.max_candidates).unwrap_or(usize::MAX);
        let (max_memory, max_steps) = (self.max_memory, self.max_steps);
        let config = MapConfig { axioms, strategy, max_candidates, max_memory, max_steps };
        let mut session = Session::new(config, limits());
        let bar = progress(input.events.len());
        let (mut events, mut fault) = (Vec::new(), input.fault);
        for (place, event) in input.events {
            let event = Arc::new(event);
            if let Err(error) = session.accept(&event) {
                fault = Some(Failure::input(&self.input, format!("{place}: {}", pointed(&error))));
                break;
            }
            events.push(event);
            bar.inc(1);
            bar.set_message(format!("{} candidates", session.abduction().len()));
        }
        for &Said(said) in &self.asserts {
            let event =
                Arc::new(Event { seq: session.next_seq(), stamp: None, kind: EventKind::Assert(said) });
            let usage = |error: SessionError| Failure::Usage(format!("--assert: {}", pointed(&error)));
            session.accept(&event).map_err(usage)?;
            events.push(event);
        }
        let begun = Instant::now();
        session.settle(&|| self.max_seconds.is_some_and(|longest| begun.elapsed() >= longest));
        bar.finish_and_clear();
        Ok(Explained { events, session, fault })
    }

    /// The reasons of the preferred map, if they are asked for and there is one.
    fn reasons(&self, abduction: &Abduction, report: &Report) -> Result<Option<Explanation>, Failure> {
        let preferred = report.minimal.first().and_then(|map| verdict_of(abduction, &map.visits));
        let (Some(asked), Some(Verdict::Kept(preferred))) = (self.explain, preferred) else {
            return Ok(None);
        };
        let visits = match asked {
            Asked::All => None,
            Asked::Visits(visits) => Some(visits),
        };
        let explanation = Explanation::of(abduction, preferred, visits);
        let last = abduction.observations().saturating_sub(1);
        let unknown = format!("--explain: expected two different observations of 0 to {last}");
        explanation.map(Some).ok_or(Failure::Usage(unknown))
    }
}

/// What one process reads for one user is bounded by the input itself.
fn limits() -> Limits {
    Limits {
        events_per_map: usize::MAX,
        cells_per_map: usize::MAX,
        steps_per_map: u64::MAX,
        ..Limits::default()
    }
}

/// What is wrong, with the JSON pointer where there is one.
fn pointed(error: &SessionError) -> String {
    match error {
        SessionError::Refused(refused) => refused.at().to_string(),
        other => other.to_string(),
    }
}

/// What was found in an input, up to its first fault.
struct Explained {
    events: Vec<Arc<Event>>,
    session: Session,
    fault: Option<Failure>,
}

/// What is to explain a trace.
enum Theory {
    Stars(AxiomSet, Strategy),
    Views,
}

/// A bar on standard error, which draws itself on a terminal only.
pub(super) fn progress(events: usize) -> ProgressBar {
    let bar = ProgressBar::new(events as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} event {pos}/{len}  {msg}") {
        bar.set_style(style);
    }
    bar
}

/// A search that a limit cut.
fn cut(limit: &str, report: &Report, observation: usize) -> Failure {
    Failure::Limit(match report.strategy {
        Strategy::BreadthFirst => format!(
            "{limit} cut the search at observation {observation}: counts from there on are lower bounds"
        ),
        Strategy::BestFirst => {
            format!("{limit} cut the search: what is shown is the simplest of what was found")
        }
    })
}

fn verdict(report: &Report) -> Result<(), Failure> {
    match report.stop_reason {
        StopReason::Exhausted | StopReason::MinimumProven => Ok(()),
        StopReason::StepLimit | StopReason::Interrupted => {
            let limit =
                if report.stop_reason == StopReason::StepLimit { "--max-steps" } else { "--max-seconds" };
            Err(Failure::Limit(format!(
                "{limit} ended the search: the preferred map is the simplest found, not proven to be the simplest"
            )))
        }
        StopReason::CandidateLimit { observation } => Err(cut("--max-candidates", report, observation)),
        StopReason::MemoryLimit { observation } => Err(cut("--max-memory", report, observation)),
        StopReason::Inconsistent { observation } => {
            let end = report
                .extinction
                .as_ref()
                .map_or_else(|| format!("observation {observation}"), |end| end.to_string());
            Err(Failure::NoMap(format!("no consistent map: nothing explains {end}")))
        }
    }
}
