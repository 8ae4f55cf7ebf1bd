//! The search beside clingo, on the same traces and in the same run: first whether both give the same answers, then how
//! long each takes. `cargo xtask compare [SECONDS]` sets clingo up and runs it.
//!
//! Clingo's seconds are grounding and solving in a process that is warm, its models counted and not told; reading the
//! programs is left out. Ours are everything from the first observation to the last candidate. One thread is compared
//! with one by seconds on the processor, which a machine in use lengthens alike for both: clingo's the least of some
//! repetitions, ours the mean. Two threads are compared by the clock. Clingo is cut off after so many seconds (60 unless
//! told otherwise).

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "a benchmark may fail")]

#[path = "clock.rs"]
mod clock;
#[path = "../../axioms/solver.rs"]
mod solver;
#[path = "../../axioms/traces.rs"]
mod traces;

use clock::{mean, processor, wall};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Deserialize;
use serde_json::json;
use solver::{PYTHON, Solver};
use std::hint::black_box;
use std::process::ExitCode;
use topostar::abduction::{Abduction, Assignment, AxiomSet, Limits, Profile, Visit};
use topostar::export::answer_set::facts;
use topostar::map::PlaceId;

const ALL_MAPS: [&str; 4] = ["grid3x3-16", "grid4x3-20", "grid4x4-24", "grid4x4-28"];
const MINIMA: [&str; 5] = ["grid3x3-16", "grid4x3-20", "grid4x4-24", "grid4x4-28", "grid6x6-64"];
/// Repetitions go on until there are so many or they took so long.
const REPETITIONS: usize = 7;
const SECONDS: f64 = 3.0;
/// How many times as long clingo may take where it tells all its models.
const TELLING: f64 = 20.0;

type Story = Vec<Assignment>;

/// What is asked about a trace.
struct Question {
    trace: &'static str,
    profile: Profile,
    preferred: bool,
    visits: Vec<Visit>,
}

fn main() -> ExitCode {
    let told = std::env::args().skip(1).find_map(|argument| argument.parse().ok());
    let Some(mut clingo) = Clingo::start(told.unwrap_or(60.0)) else {
        println!("clingo is not compared: {PYTHON} is not set; `cargo xtask compare` sets it");
        return ExitCode::SUCCESS;
    };
    let pools = [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    println!(
        "ours, clingo, ratio: one thread, seconds on the processor; the other three: two threads, by the clock"
    );
    println!("clingo cut off after {} s by the clock\n", clingo.seconds);
    println!(
        "{}",
        row(["trace", "profile", "what", "ours", "clingo", "ratio", "ours x2", "-t2", "ratio", ""])
    );
    let mut agree = true;
    for question in questions() {
        agree &= question.compare(&mut clingo, &pools);
    }
    println!("\n{}", if agree { "all answers agree" } else { "SOME ANSWERS DIFFER" });
    if agree { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn questions() -> impl Iterator<Item = Question> {
    let asked = [(&ALL_MAPS[..], false), (&MINIMA[..], true)];
    let each = asked.into_iter().flat_map(|(traces, preferred)| {
        Profile::ALL
            .into_iter()
            .flat_map(move |profile| traces.iter().map(move |&trace| (trace, profile, preferred)))
    });
    each.map(|(trace, profile, preferred)| Question {
        trace,
        profile,
        preferred,
        visits: traces::visits(trace),
    })
}

fn row(cells: [&str; 10]) -> String {
    let [trace, profile, what, a, b, c, d, e, f, rest] = cells;
    format!("{trace:<11} {profile:<8} {what:<8} {a:>8} {b:>8} {c:>8} {d:>8} {e:>8} {f:>8}  {rest}")
}

impl Question {
    /// Whether the answers are the same, as far as clingo gives one.
    fn compare(&self, clingo: &mut Clingo, pools: &[ThreadPool; 2]) -> bool {
        let found = self.answer();
        let told = clingo.ask(self, 1, true);
        let agree = !told.whole || told.stories(self.visits.len()) == stories(&found, self.preferred);
        let ours = [0, 1].map(|index| {
            let clock = if index == 0 { processor } else { wall };
            pools[index].install(|| mean(clock, 1.0, || drop(black_box(self.answer()))))
        });
        // What did not come to an end while it told its models may do so where it only counts them.
        let ends = told.whole || clingo.ask(self, 1, false).whole;
        let theirs = [1, 2].map(|threads| {
            let seconds = |counted: Told| if threads == 1 { counted.processor } else { counted.wall };
            ends.then(|| least(|| seconds(clingo.ask(self, threads, false))))
        });
        self.print(&found, ours, theirs, clingo.seconds, &told, agree);
        agree
    }

    fn answer(&self) -> Abduction {
        let axioms = AxiomSet::of(self.profile);
        let make = if self.preferred { Abduction::best_first } else { Abduction::new };
        let mut abduction = make(axioms, Limits::default());
        for visit in &self.visits {
            abduction.observe(visit).unwrap();
        }
        abduction.settle(&|| false);
        abduction
    }

    fn print(
        &self,
        found: &Abduction,
        ours: [f64; 2],
        theirs: [Option<f64>; 2],
        cut: f64,
        told: &Told,
        agree: bool,
    ) {
        let report = found.report();
        let seconds = |seconds: f64| format!("{seconds:.4}");
        let their_seconds = |it: Option<f64>| it.map_or(format!(">{cut}"), |it| format!("{it:.2}"));
        let ratio = |theirs: Option<f64>, ours: f64| match theirs {
            Some(theirs) => format!("{:.1}", theirs / ours),
            None => format!(">{:.0}", cut / ours),
        };
        let effort = match report.settlement {
            Some(settlement) => {
                format!("{} minima, {} steps, proven: {}", found.len(), settlement.steps, settlement.proven)
            }
            None => format!("{} maps, {} created", found.len(), report.maps_created.value),
        };
        let answers = match (told.whole, agree) {
            (true, true) => "same answers",
            (true, false) => "ANSWERS DIFFER",
            (false, _) => "not compared",
        };
        println!(
            "{}",
            row([
                self.trace,
                self.profile.name(),
                if self.preferred { "minimum" } else { "all maps" },
                &seconds(ours[0]),
                &their_seconds(theirs[0]),
                &ratio(theirs[0], ours[0]),
                &seconds(ours[1]),
                &their_seconds(theirs[1]),
                &ratio(theirs[1], ours[1]),
                &format!("{effort}; {answers}"),
            ])
        );
    }
}

/// The assignments of the candidates, or of the simplest, ascending.
fn stories(found: &Abduction, preferred: bool) -> Vec<Story> {
    match preferred {
        true => found.report().minimal.into_iter().map(|candidate| candidate.visits).collect(),
        false => found.candidates().map(|candidate| candidate.visits).collect(),
    }
}

fn least(mut seconds: impl FnMut() -> f64) -> f64 {
    let (mut all, mut least) = (0.0, f64::INFINITY);
    for _ in 0..REPETITIONS {
        let now = seconds();
        (all, least) = (all + now, least.min(now));
        if all > SECONDS {
            break;
        }
    }
    least
}

/// clingo, and when to stop it.
struct Clingo {
    solver: Solver,
    seconds: f64,
}

#[derive(Deserialize)]
struct Told {
    /// Seconds of grounding and solving by the clock, and on the processor.
    wall: f64,
    processor: f64,
    models: usize,
    whole: bool,
    visits: Vec<Vec<[u16; 3]>>,
}

impl Clingo {
    fn start(seconds: f64) -> Option<Clingo> {
        let root = env!("CARGO_MANIFEST_DIR");
        let solver = Solver::start([format!("{root}/tests/bench/rival.py"), format!("{root}/axioms")])?;
        Some(Clingo { solver, seconds })
    }

    fn ask(&mut self, question: &Question, threads: usize, tell: bool) -> Told {
        let facts = facts(&question.visits, AxiomSet::of(question.profile), &[]);
        let request = json!({
            "facts": facts,
            "preferred": question.preferred,
            "threads": threads,
            "tell": tell,
            // To tell a model takes longer than to find it, and all are to be told.
            "seconds": if tell && !question.preferred { TELLING * self.seconds } else { self.seconds },
        });
        serde_json::from_value(self.solver.ask(&request)).unwrap()
    }
}

impl Told {
    /// The models in lexicographic order, places numbered by first visit as ours are.
    fn stories(&self, observations: usize) -> Vec<Story> {
        let story = |model: &Vec<[u16; 3]>| {
            let mut visits = model.clone();
            visits.sort_unstable();
            assert!(visits.iter().map(|visit| visit[0] as usize).eq(0..observations));
            let mut known: Vec<u16> = Vec::new();
            let assign = |[_, name, rotation]: [u16; 3]| {
                let number = known.iter().position(|&known| known == name).unwrap_or_else(|| {
                    known.push(name);
                    known.len() - 1
                });
                Assignment { place: PlaceId::new(number).unwrap(), rotation: rotation as u8 }
            };
            visits.into_iter().map(assign).collect()
        };
        let mut stories: Vec<Story> = self.visits.iter().map(story).collect();
        assert_eq!(stories.len(), self.models);
        stories.sort_unstable();
        stories
    }
}
