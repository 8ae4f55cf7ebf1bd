//! `topostar check`: the search, the slow reference and clingo on one trace, and whether they agree.

use crate::abduction::{Assertion, AxiomSet, Boundary, Visit};
use crate::cli::clingo::Clingo;
use crate::cli::comparison::{Comparison, Difference, Effect, Found, Question, Race, Step};
use crate::cli::failure::Failure;
use crate::cli::input::read_events;
use crate::cli::log::LogArgs;
use crate::cli::map::{BoundaryName, ProfileName, progress};
use crate::export::answer_set::{PREFERENCE, THEORY, facts};
use crate::reference::Story;
use crate::star::PerceptionParameters;
use crate::trace::perceive::perceive;
use crate::trace::{Assert, Event, EventError, EventKind, Experience};
use clap::Args;
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
    /// A choice of axioms.
    #[arg(long, value_enum, default_value_t = ProfileName::Default)]
    profile: ProfileName,
    /// Hold boundaries too: a path divides what is right of it from what is left.
    #[arg(long, value_enum)]
    boundary: Option<BoundaryName>,
    /// Exactly these axioms in place of a profile, names with commas between.
    #[arg(long, conflicts_with_all = ["profile", "boundary"])]
    axioms: Option<AxiomSet>,
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
    /// Compare nothing; write trace, axioms and theory as an answer-set program, whose models are the candidates.
    #[arg(long)]
    lp: bool,
    /// Write facts.lp and the files of the theory there, preference.lp among them, in place of one program to
    /// standard output without preference.
    #[arg(short, long, value_name = "DIR", requires = "lp")]
    output: Option<PathBuf>,
}

impl Check {
    pub(super) fn run(self) -> Result<(), Failure> {
        let Read { visits, word, fault } = read(&self.input)?;
        let boundary = self.boundary.map(Boundary::from);
        let profile = || AxiomSet::of(self.profile.into()).with_boundary(boundary);
        let axioms = self.axioms.unwrap_or_else(profile);
        if self.lp {
            write_program(self.output.as_deref(), &facts(&visits, axioms, &word))?;
            return fault.map_or(Ok(()), Err);
        }
        let clingo = match &self.clingo {
            Some(path) if path == Path::new("none") => None,
            path => Clingo::find(path.as_deref())?,
        };
        let most = usize::try_from(self.max_candidates).unwrap_or(usize::MAX);
        let axioms = axioms.without_measured();
        let question = Question { visits: &visits, axioms, word: &word, most };
        let comparison = self.compare(question, clingo.as_ref())?;
        match self.json {
            true => writeln!(stdout(), "{}", json(&comparison)?)?,
            false => write!(stdout(), "{}", in_words(&comparison))?,
        }
        fault.map_or_else(|| self.verdict(&comparison), Err)
    }

    fn compare(&self, question: Question<'_>, clingo: Option<&Clingo>) -> Result<Comparison, Failure> {
        let (race, difference) = self.race(question)?;
        let mut comparison = Comparison::new(&race, difference);
        let compared = Question { visits: race.seen(), ..question };
        if let Some(clingo) = clingo {
            eprintln!("asking clingo");
            ask(clingo, &race, &compared, &mut comparison)?;
        }
        for axiom in question.axioms.iter() {
            eprintln!("without {}", axiom.name);
            comparison.axioms.push(Effect::of(axiom, &compared).map_err(|error| self.refused(error))?);
        }
        Ok(comparison)
    }

    /// Search and reference side by side, as far as they agree and are few.
    fn race<'a>(&self, question: Question<'a>) -> Result<(Race<'a>, Option<Difference>), Failure> {
        let mut race = Race::new(question);
        let bar = progress(question.visits.len());
        let mut difference = None;
        for _ in question.visits {
            match race.step().map_err(|error| self.refused(error))? {
                Step::Agreed => {}
                Step::TooMany => break,
                Step::Differ(found) => {
                    difference = Some(found);
                    break;
                }
            }
            bar.inc(1);
            bar.set_message(format!("{} candidates", race.len()));
        }
        bar.finish_and_clear();
        Ok((race, difference))
    }

    fn refused(&self, error: impl std::fmt::Display) -> Failure {
        Failure::input(&self.input, error)
    }

    fn verdict(&self, found: &Comparison) -> Result<(), Failure> {
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

/// A trace up to its first fault.
struct Read {
    visits: Vec<Visit>,
    /// What an operator said, in the end.
    word: Vec<Assertion>,
    fault: Option<Failure>,
}

fn read(input: &Path) -> Result<Read, Failure> {
    let events = read_events(input, None, &LogArgs::default())?;
    let mut experience = Experience::new();
    let mut read = Read { visits: Vec::new(), word: Vec::new(), fault: events.fault };
    for (place, event) in &events.events {
        if let Err(error) = read.take(&mut experience, event) {
            read.fault = Some(Failure::input(input, format!("{place}: {error}")));
            break;
        }
    }
    Ok(read)
}

impl Read {
    fn take(&mut self, experience: &mut Experience, event: &Event) -> Result<(), EventError> {
        let parameters = PerceptionParameters::default();
        let sighting = experience.accept(event, &|lpm, first| perceive(lpm, first, &parameters));
        self.visits.extend(sighting.map_err(|error| error.at())?.iter().map(Visit::from));
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

/// Adds what clingo found, and the first difference to that.
fn ask(
    clingo: &Clingo,
    race: &Race<'_>,
    question: &Question<'_>,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let facts = facts(question.visits, question.axioms, question.word);
    let observations = question.visits.len();
    let candidates = clingo.candidates(&facts, observations, question.most.saturating_add(1))?;
    let minimal = clingo.minimal(&facts, observations)?;
    let differs = |among, theirs, ours| {
        Difference::first(observations.saturating_sub(1), among, ("reference", theirs), ("clingo", ours))
    };
    let found = || {
        differs("candidates", race.stories(), &candidates)
            .or_else(|| differs("minimal", &comparison.reference.minimal, &minimal))
    };
    comparison.difference = comparison.difference.take().or_else(found);
    comparison.equal = comparison.difference.is_none();
    comparison.clingo = Some(race.found(&candidates, minimal));
    Ok(())
}

fn json(comparison: &Comparison) -> Result<String, Failure> {
    serde_json::to_string_pretty(comparison).map_err(|error| Failure::Broken(error.to_string()))
}

fn in_words(found: &Comparison) -> String {
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
    text += "\npreferred, as place.rotation of each visit\n";
    let lines = found.reference.minimal.iter().map(|story| format!("  {}\n", visits(story)));
    text + &lines.collect::<String>()
}

fn numbers(found: &Found) -> String {
    let simplest = found.size.map_or(String::new(), |size| {
        let ranked = size.abnormalities.map_or(String::new(), |count| format!(" {count} abnormalities,"));
        format!(", {} preferred:{ranked} {} paths, {} places", found.minimal.len(), size.paths, size.places)
    });
    format!("{} candidates{simplest}", found.candidates)
}

fn in_short(difference: &Difference) -> String {
    let Difference { observation, only, not, among, visits: story } = difference;
    format!("{only} has among the {among} at observation {observation} what {not} has not: {}", visits(story))
}

fn visits(story: &Story) -> String {
    let told = story.iter().map(|(place, rotation)| format!("{place}.{rotation}"));
    told.collect::<Vec<String>>().join(" ")
}

fn write_program(folder: Option<&Path>, facts: &str) -> Result<(), Failure> {
    let Some(folder) = folder else {
        let theory = THEORY.iter().filter(|file| **file != PREFERENCE).map(|(_, text)| *text);
        let program: Vec<&str> = theory.chain([facts]).collect();
        return Ok(write!(stdout(), "{}", program.join("\n"))?);
    };
    fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
    for (name, text) in THEORY.iter().chain([&("facts.lp", facts)]) {
        let file = folder.join(name);
        fs::write(&file, text).map_err(|error| Failure::writing(&file, error))?;
    }
    eprintln!("written to {}", folder.display());
    Ok(())
}
