//! `topostar check`: the search, the slow reference and clingo on one trace, and whether they agree.

use crate::abduction::{Assertion, Visit};
use crate::cli::axiom_choice::AxiomChoice;
use crate::cli::classic::is_of_views;
use crate::cli::clingo::Clingo;
use crate::cli::comparison::{Comparison, Difference, Found, Race, Step};
use crate::cli::failure::Failure;
use crate::cli::input::{Events, read_events};
use crate::cli::log::LogArgs;
use crate::cli::map::progress;
use crate::cli::star_race::{Question, Senses, StarRace};
use crate::cli::view_race::ViewRace;
use crate::reference;
use crate::reference::views;
use crate::service::ViewSession;
use crate::star::PerceptionParameters;
use crate::trace::perceive::perceive;
use crate::trace::{Assert, Event, EventError, EventKind, Experience, Sighting};
use clap::Args;
use serde::Serialize;
use std::fs;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};

/// Check the search on a trace: every candidate against every axiom by the slow reference, and by clingo if there is
/// one.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  topostar check trace.ndjson                       search, reference and clingo, map by map
  topostar check trace.ndjson --clingo .venv/bin/python
                                                    with the module clingo of that Python
  topostar check trace.ndjson --lp -o theory/       the trace and the theory as answer-set programs
  topostar check trace.ndjson --lp | clingo - 0     all maps, by clingo alone")]
pub(super) struct Check {
    /// A trace (.ndjson), or - for standard input.
    input: PathBuf,
    #[command(flatten)]
    held: AxiomChoice,
    /// The most candidates compared after an observation; the comparison ends before the first with more.
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..))]
    max_candidates: u64,
    /// The clingo to ask: its executable, a Python that has its module, or `none`. Unless given, one is looked for on
    /// the search path.
    #[arg(long, value_name = "PATH", conflicts_with = "lp")]
    clingo: Option<PathBuf>,
    /// Print the comparison as one JSON object.
    #[arg(long, conflicts_with = "lp")]
    json: bool,
    /// Write trace, axioms and theory as an answer-set program, whose models are the candidates. What measurements refute
    /// and no rule says is found by comparing, as far as --max-candidates lets, and written as clashes.
    #[arg(long)]
    lp: bool,
    /// Write facts.lp and the files of the theory there, preference.lp among them, in place of one program to
    /// standard output without preference.
    #[arg(short, long, value_name = "DIR", requires = "lp")]
    output: Option<PathBuf>,
}

impl Check {
    pub(super) fn run(self) -> Result<(), Failure> {
        let input = read_events(&self.input, None, &LogArgs::default())?;
        match is_of_views(&input.events) {
            true => self.views(input),
            false => self.stars(input),
        }
    }

    fn stars(&self, input: Events) -> Result<(), Failure> {
        let axioms = self.held.for_stars().map_err(|why| self.misfit(why))?;
        let Read { seen, word, fault } = read(&self.input, input);
        let visits = seen.iter().map(Visit::from).collect();
        let question =
            Question { visits, axioms, word, most: self.most(), senses: Senses::of(&seen, axioms) };
        self.conclude(StarRace::new(&question), fault)
    }

    fn views(&self, input: Events) -> Result<(), Failure> {
        self.held.for_views().map_err(|why| self.misfit(why))?;
        let (mut session, mut fault) = (ViewSession::new(), input.fault);
        for (place, event) in &input.events {
            if let Err(error) = session.accept(event) {
                fault = Some(Failure::input(&self.input, format!("{place}: {error}")));
                break;
            }
        }
        self.conclude(ViewRace::new(session.seen().as_slice(), self.most()), fault)
    }

    /// Compares, or writes the program, and says what came of it.
    fn conclude<R: Race<Story: Told>>(&self, mut race: R, fault: Option<Failure>) -> Result<(), Failure> {
        if self.lp {
            if race.clashes() {
                self.race(&mut race)?;
            }
            self.write_program(&race)?;
            return fault.map_or(Ok(()), Err);
        }
        let clingo = match &self.clingo {
            Some(path) if path == Path::new("none") => None,
            path => Clingo::find(path.as_deref())?,
        };
        let comparison = self.compare(&mut race, clingo.as_ref())?;
        match self.json {
            true => writeln!(stdout(), "{}", json(&comparison)?)?,
            false => write!(stdout(), "{}", in_words(&comparison))?,
        }
        fault.map_or_else(|| self.verdict(&comparison), Err)
    }

    fn compare<R: Race>(
        &self,
        race: &mut R,
        clingo: Option<&Clingo>,
    ) -> Result<Comparison<R::Story>, Failure> {
        let difference = self.race(race)?;
        let mut comparison = Comparison::new(race, difference);
        if let Some(clingo) = clingo {
            eprintln!("asking clingo");
            comparison.ask(clingo, race, self.most())?;
        }
        for axiom in race.axioms() {
            eprintln!("without {axiom}");
            comparison.axioms.push(race.effect(axiom)?);
        }
        Ok(comparison)
    }

    /// Search and reference side by side, as far as they agree and are few.
    fn race<R: Race>(&self, race: &mut R) -> Result<Option<Difference<R::Story>>, Failure> {
        let bar = progress(race.observations());
        let mut difference = None;
        while race.compared() < race.observations() {
            match race.step()? {
                Step::Agreed => {}
                Step::TooMany => break,
                Step::Differ(found) => {
                    difference = Some(found);
                    break;
                }
            }
            bar.inc(1);
            bar.set_message(format!("{} candidates", race.stories().len()));
        }
        bar.finish_and_clear();
        Ok(difference)
    }

    fn write_program<R: Race>(&self, race: &R) -> Result<(), Failure> {
        let (theory, facts) = (race.theory(), race.facts(race.observations()));
        if race.clashes() && race.compared() < race.observations() {
            let last = race.compared().saturating_sub(1);
            eprintln!(
                "what measurements refute is written up to observation {last}; models may be more than candidates"
            );
        }
        let Some(folder) = &self.output else {
            return Ok(write!(stdout(), "{}", theory.program(&facts, false))?);
        };
        fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
        let files: Vec<(&str, &str)> = theory.files().collect();
        for (name, text) in files.into_iter().chain([("facts.lp", facts.as_str())]) {
            let file = folder.join(name);
            fs::write(&file, text).map_err(|error| Failure::writing(&file, error))?;
        }
        eprintln!("written to {}", folder.display());
        Ok(())
    }

    fn most(&self) -> usize {
        usize::try_from(self.max_candidates).unwrap_or(usize::MAX)
    }

    fn misfit(&self, what: &str) -> Failure {
        Failure::Usage(format!("{}: {what}", self.input.display()))
    }

    fn verdict<S: Told>(&self, found: &Comparison<S>) -> Result<(), Failure> {
        if let Some(difference) = &found.difference {
            return Err(Failure::Broken(in_short(difference)));
        }
        if found.compared < found.observations {
            return Err(Failure::Limit(format!(
                "compared up to observation {} of {}: after the next there are more candidates than --max-candidates \
                 {}",
                found.compared.saturating_sub(1),
                found.observations.saturating_sub(1),
                self.max_candidates
            )));
        }
        if found.observations > 0 && found.search.candidates == 0 {
            let axioms: Vec<&str> = found.axioms.iter().map(|effect| effect.axiom).collect();
            return Err(Failure::NoMap(format!("no consistent map under {}", axioms.join(", "))));
        }
        Ok(())
    }
}

/// A trace of stars up to its first fault.
struct Read {
    seen: Vec<Sighting>,
    /// What an operator said, in the end.
    word: Vec<Assertion>,
    fault: Option<Failure>,
}

fn read(input: &Path, events: Events) -> Read {
    let mut experience = Experience::new();
    let mut read = Read { seen: Vec::new(), word: Vec::new(), fault: events.fault };
    for (place, event) in &events.events {
        if let Err(error) = read.take(&mut experience, event) {
            read.fault = Some(Failure::input(input, format!("{place}: {error}")));
            break;
        }
    }
    read
}

impl Read {
    fn take(&mut self, experience: &mut Experience, event: &Event) -> Result<(), EventError> {
        let parameters = PerceptionParameters::default();
        let sighting = experience.accept(event, &|lpm, first| perceive(lpm, first, &parameters));
        self.seen.extend(sighting.map_err(|error| error.at())?);
        match event.kind {
            EventKind::Assert(Assert { visits, same }) => {
                self.word.push(Assertion { id: event.seq, visits, same });
            }
            EventKind::Retract { assert } => self.word.retain(|assertion| assertion.id != assert),
            EventKind::Observation(_) | EventKind::Turn(_) | EventKind::Travel(_) => {}
        }
        Ok(())
    }
}

/// A candidate in words.
trait Told: Ord + Clone + Serialize {
    /// What is told of each observation.
    const OF: &'static str;

    fn told(&self) -> String;
}

impl Told for reference::Story {
    const OF: &'static str = "place.rotation of each visit";

    fn told(&self) -> String {
        let told = self.iter().map(|(place, rotation)| format!("{place}.{rotation}"));
        told.collect::<Vec<String>>().join(" ")
    }
}

impl Told for views::Story {
    const OF: &'static str = "dstate of each view";

    fn told(&self) -> String {
        self.iter().map(usize::to_string).collect::<Vec<String>>().join(" ")
    }
}

fn json<S: Serialize>(comparison: &Comparison<S>) -> Result<String, Failure> {
    serde_json::to_string_pretty(comparison).map_err(|error| Failure::Broken(error.to_string()))
}

fn in_words<S: Told>(found: &Comparison<S>) -> String {
    let mut text = format!(
        "profile {}, observations compared {} of {}\n",
        found.profile, found.compared, found.observations
    );
    let judges = [
        ("search", Some(&found.search)),
        ("reference", Some(&found.reference)),
        ("clingo", found.clingo.as_ref()),
    ];
    for (judge, found) in judges {
        text += &format!("  {judge:<10} {}\n", found.map_or("not asked".into(), numbers));
    }
    text += &match &found.difference {
        None => "the same candidates and the same preferred ones\n".into(),
        Some(difference) => format!("{}\n", in_short(difference)),
    };
    text += "\naxiom          refutes, of the candidates there are without it\n";
    for effect in &found.axioms {
        let what = match (effect.refutes, effect.without) {
            (Some(refutes), Some(without)) => format!("{refutes} of {without}"),
            _ => effect.untried.unwrap_or_default().into(),
        };
        text += &format!("{:<14} {what}\n", effect.axiom);
    }
    if !found.stated_once.is_empty() {
        let once = found.stated_once.join(", ");
        text += &format!(
            "not compared: what {once} say; all take it from the search's own measure, map by map\n"
        );
    }
    text += &format!("\npreferred, as {}\n", S::OF);
    let lines = found.reference.minimal.iter().map(|story| format!("  {}\n", story.told()));
    text + &lines.collect::<String>()
}

fn numbers<S>(found: &Found<S>) -> String {
    let simplest = found.size.map_or(String::new(), |size| {
        let ranked = size.abnormalities.map_or(String::new(), |count| format!(" {count} abnormalities,"));
        format!(", {} preferred:{ranked} {} paths, {} places", found.minimal.len(), size.paths, size.places)
    });
    format!("{} candidates{simplest}", found.candidates)
}

fn in_short<S: Told>(difference: &Difference<S>) -> String {
    let Difference { observation, only, not, among, visits } = difference;
    format!("{only} has among the {among} at observation {observation} what {not} has not: {}", visits.told())
}
