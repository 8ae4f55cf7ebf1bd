//! `topostar relax`: a pose graph in, the poses of least strain out.

use crate::cli::failure::Failure;
use crate::cli::growing::Grown;
use crate::cli::input::{open, plain_extension};
use crate::cli::values::{seconds, sigmas};
use crate::export::{GrowthReport, RelaxationOutcome, RelaxationReport, RelaxationSeconds, poses_svg};
use crate::patchwork::format::{InformationOrder, ReadGraph, read_graph, write_g2o, write_toro, write_tum};
use crate::patchwork::{
    Loss, Outcome, PoseGraph, PoseId, RelaxError, RelaxOptions, Relaxation, Relaxer, Start,
};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write as _;
use std::fs;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Relax a pose graph: move its poses until what was measured between them is strained least.
#[derive(Debug, Args)]
#[command(after_help = "\
The objective is the sum over edges of e' W e: the error of each edge, squared and weighted by its information. Where \
covariances are honest it is about the degrees of freedom; much more means that an edge lies, or that errors were larger \
than was said.

Examples:
  topostar relax city10000.g2o                        objective, iterations, the most strained edges
  topostar relax run.g2o.gz -o relaxed.g2o            the graph with relaxed poses
  topostar relax run.graph -o run.tum --svg run.svg   a trajectory, and a picture before and after
  topostar relax run.g2o --loss cauchy                when loops may have been closed wrongly
  topostar relax run.g2o --max-seconds 60             the best that a minute gives
  topostar relax run.g2o --growing                    pose by pose, and what that takes while the robot drives
  topostar relax run.g2o --covariance 17              how sure the place of pose 17 is")]
pub(super) struct Relax {
    /// A pose graph in g2o or TORO format, plain, .gz or .bz2; '-' is standard input.
    graph: PathBuf,
    /// Write the relaxed graph there: .g2o, .graph for TORO, .tum for a trajectory with the pose's number as its stamp.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Where to start. best takes the cheaper of the poses in the file and of headings first, and tries the other if
    /// what comes out is unlikely.
    #[arg(long, value_enum, default_value = "best")]
    start: StartName,
    /// Take the poses in one after the other, in the order of the file and by the edges alone, as a robot that drives tells
    /// of them, and relax after each what it touches: the loops through it. Tells what that took; the whole is relaxed from
    /// there.
    #[arg(long, conflicts_with = "start")]
    growing: bool,
    /// What an edge that does not fit may cost: squared is the most likely layout if errors are normal, the others
    /// let an edge that lies pull less.
    #[arg(long, value_enum, default_value = "squared")]
    loss: LossName,
    /// Standard deviations at which a robust loss sets in.
    #[arg(long, value_name = "SIGMAS", default_value_t = 3.0, value_parser = sigmas)]
    loss_width: f64,
    /// How many steps to take at most.
    #[arg(long, value_name = "STEPS", default_value_t = RelaxOptions::default().max_iterations)]
    max_iterations: usize,
    /// The longest relaxation, in seconds; the best poses found by then are told and written. A factorisation under way
    /// is finished, and so is the one that shows what is not determined.
    #[arg(long, value_name = "S", value_parser = seconds)]
    max_seconds: Option<Duration>,
    /// The order of the six numbers of information on a line, where the file is not as its words say.
    #[arg(long, value_enum, value_name = "ORDER")]
    information_order: Option<OrderName>,
    /// Print the covariance of a pose in the frame of the gauge, null where nothing determines it; may be given more than
    /// once.
    #[arg(long, value_name = "POSE")]
    covariance: Vec<u64>,
    /// Write a picture of the poses before and after there.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StartName {
    /// The cheaper of guesses and rotations.
    Best,
    /// The poses in the file; those that are wanting from the edges, odometry first.
    Guesses,
    /// The odometry alone, whatever poses are in the file.
    Odometry,
    /// Headings from all measurements, then positions, whatever poses are in the file.
    Rotations,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LossName {
    /// Chi-square as it is.
    Squared,
    /// Grows linearly beyond the width; keeps one minimum where there was one.
    Huber,
    /// Grows logarithmically.
    Cauchy,
    /// Stops growing: an edge that is far off does not pull.
    GemanMcclure,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum OrderName {
    /// 11 12 13 22 23 33.
    G2o,
    /// 11 12 22 33 13 23.
    Toro,
}

impl Relax {
    /// Reads, relaxes, prints and writes; the exit code tells whether it converged.
    pub(super) fn run(self) -> Result<(), Failure> {
        let write = self.output.as_deref().map(Writer::of).transpose()?;
        let clock = Instant::now();
        let ReadGraph { graph, order, mut notes } = read_graph(open(&self.graph)?, self.order())
            .map_err(|error| Failure::input(&self.graph, error))?;
        self.check_covariances(&graph)?;
        notes.extend(write.and_then(|write| write.leaves_out(&graph)));
        let reading = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let grown = self.growing.then(|| self.grown(&graph, clock)).transpose()?;
        let begin = grown.as_ref().map_or_else(|| graph.clone(), |grown| grown.placed(&graph));
        let (mut relaxer, answer, seconds) = self.relaxed(&begin, clock)?;
        let mut report = RelaxationReport::of(&graph, &answer);
        report.growing = grown.map(|grown| grown.report);
        report.seconds = RelaxationSeconds { reading, ..seconds };
        (report.information_order, report.notes) = (order.name(), notes);
        self.print(&report, &covariances(&mut relaxer, &self.covariance))?;
        if let (Some(file), Some(write)) = (&self.output, write) {
            save(file, &write.text(&graph.with_guesses(&answer.poses)))?;
        }
        if let Some(file) = &self.svg {
            let before = Relaxer::new(&graph, &self.options()).map_err(broken)?.guesses();
            save(file, &poses_svg(&graph, &before, &answer.poses))?;
        }
        ended(&answer)
    }

    /// The graph relaxed, as far as the time since `clock` allows.
    fn relaxed(
        &self,
        graph: &PoseGraph,
        clock: Instant,
    ) -> Result<(Relaxer, Relaxation, RelaxationSeconds), Failure> {
        let (begun, bar) = (Instant::now(), progress("factorisation"));
        let mut relaxer = Relaxer::new(graph, &self.options()).map_err(broken)?;
        let setup = begun.elapsed().as_secs_f64();
        let answer = relaxer.relax_until(&|| self.is_over(clock, &bar)).map_err(broken)?;
        bar.finish_and_clear();
        let relaxing = begun.elapsed().as_secs_f64() - setup;
        Ok((relaxer, answer, RelaxationSeconds { reading: 0.0, setup, relaxing }))
    }

    /// The graph taken in pose by pose, as far as the time since `clock` allows.
    fn grown(&self, graph: &PoseGraph, clock: Instant) -> Result<Grown, Failure> {
        let bar = progress("pose");
        let grown = Grown::of(graph, &self.options(), &|| self.is_over(clock, &bar)).map_err(broken)?;
        bar.finish_and_clear();
        Ok(grown)
    }

    /// Whether time is over; asked once for each piece of work.
    fn is_over(&self, clock: Instant, bar: &ProgressBar) -> bool {
        bar.inc(1);
        self.max_seconds.is_some_and(|most| clock.elapsed() >= most)
    }

    fn order(&self) -> Option<InformationOrder> {
        self.information_order.map(|order| match order {
            OrderName::G2o => InformationOrder::G2o,
            OrderName::Toro => InformationOrder::Toro,
        })
    }

    fn options(&self) -> RelaxOptions {
        let width = self.loss_width;
        RelaxOptions {
            start: match self.start {
                _ if self.growing => Start::Guesses,
                StartName::Best => Start::Best,
                StartName::Guesses => Start::Guesses,
                StartName::Odometry => Start::Odometry,
                StartName::Rotations => Start::Rotations,
            },
            loss: match self.loss {
                LossName::Squared => Loss::Squared,
                LossName::Huber => Loss::Huber { width },
                LossName::Cauchy => Loss::Cauchy { width },
                LossName::GemanMcclure => Loss::GemanMcClure { width },
            },
            max_iterations: self.max_iterations,
            ..RelaxOptions::default()
        }
    }

    /// A pose that is not there is told of before anything is computed.
    fn check_covariances(&self, graph: &PoseGraph) -> Result<(), Failure> {
        match self.covariance.iter().find(|pose| graph.number(PoseId(**pose)).is_none()) {
            None => Ok(()),
            Some(pose) => Err(Failure::Usage(format!("--covariance {pose}: expected a pose of the graph"))),
        }
    }

    fn print(&self, report: &RelaxationReport, covariances: &[PoseCovariance]) -> Result<(), Failure> {
        if !self.json {
            write!(stdout(), "{}", words(report, covariances))?;
            return Ok(());
        }
        let broken = |error: serde_json::Error| Failure::Broken(error.to_string());
        let mut json = serde_json::to_value(report).map_err(broken)?;
        if !covariances.is_empty() {
            let named =
                covariances.iter().map(|(pose, matrix)| (pose.to_string(), serde_json::json!(matrix)));
            json["covariances"] = serde_json::Value::Object(named.collect());
        }
        writeln!(stdout(), "{json}")?;
        Ok(())
    }
}

fn save(file: &Path, text: &str) -> Result<(), Failure> {
    fs::write(file, text).map_err(|error| Failure::writing(file, error))
}

fn broken(error: RelaxError) -> Failure {
    Failure::Broken(error.to_string())
}

/// What a relaxation has done so far, on a terminal only.
fn progress(of: &str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    let told = format!("{{spinner}} relaxing for {{elapsed}}, {of} {{pos}}");
    if let Ok(style) = ProgressStyle::with_template(&told) {
        bar.set_style(style);
    }
    if !bar.is_hidden() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// How a graph is written into a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Writer {
    G2o,
    Toro,
    Tum,
}

impl Writer {
    /// By the name of the file.
    fn of(file: &Path) -> Result<Writer, Failure> {
        match plain_extension(file).as_str() {
            _ if file.extension().is_some_and(|e| e == "gz" || e == "bz2") => Err(Failure::Usage(format!(
                "{}: graphs are written uncompressed, expected a name that ends in .g2o, .graph or .tum",
                file.display()
            ))),
            "g2o" => Ok(Writer::G2o),
            "graph" | "toro" => Ok(Writer::Toro),
            "tum" | "txt" => Ok(Writer::Tum),
            _ => Err(Failure::Usage(format!(
                "{}: the ending tells the format, expected .g2o, .graph (TORO) or .tum",
                file.display()
            ))),
        }
    }

    fn text(self, graph: &PoseGraph) -> String {
        match self {
            Writer::G2o => write_g2o(graph),
            Writer::Toro => write_toro(graph),
            Writer::Tum => write_tum(graph),
        }
    }

    /// What a graph says that a file of this format does not.
    fn leaves_out(self, graph: &PoseGraph) -> Option<String> {
        let held = graph.held().iter().filter(|held| **held).count();
        (self == Writer::Toro && held > 0).then(|| {
            format!(
                "TORO has no word for a pose that is held: FIX of {held} is not written, .g2o would have it"
            )
        })
    }
}

/// A pose and its covariance by rows: x, y, heading; none where the measurements do not determine it.
type PoseCovariance = (u64, Option<[[f64; 3]; 3]>);

fn covariances(relaxer: &mut Relaxer, asked: &[u64]) -> Vec<PoseCovariance> {
    let of = |pose: &u64| {
        let rows = relaxer
            .covariance(PoseId(*pose))
            .map(|matrix| std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)])));
        (*pose, rows)
    };
    asked.iter().map(of).collect()
}

fn words(report: &RelaxationReport, covariances: &[PoseCovariance]) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = describe(&mut text, report);
    for (pose, rows) in covariances {
        let Some(rows) = rows else {
            let _ =
                writeln!(text, "covariance of pose {pose}: none, what was measured does not determine it");
            continue;
        };
        let _ = writeln!(text, "covariance of pose {pose} (x, y, heading; metres, radians)");
        for [x, y, theta] in rows {
            let _ = writeln!(text, "  {x:>13.6e} {y:>13.6e} {theta:>13.6e}");
        }
    }
    text
}

fn describe(text: &mut String, report: &RelaxationReport) -> std::fmt::Result {
    writeln!(text, "{} poses, {} edges", report.poses, report.edges)?;
    for note in &report.notes {
        writeln!(text, "  {note}")?;
    }
    if let Some(growing) = &report.growing {
        let GrowthReport { poses, updates, relaxed, most_relaxed, not_converged, seconds, slowest, .. } =
            growing;
        writeln!(
            text,
            "{poses} poses taken in one after the other in {seconds:.3} s, {slowest:.4} s for the slowest"
        )?;
        writeln!(text, "  {updates} of them moved others: {relaxed} in all, {most_relaxed} at most")?;
        if *not_converged > 0 {
            writeln!(text, "  {not_converged} of these did not converge")?;
        }
    }
    let each = report.objective / report.degrees_of_freedom.max(1) as f64;
    writeln!(text, "objective {:.6}", report.objective)?;
    writeln!(text, "  {} degrees of freedom, {each:.3} for each", report.degrees_of_freedom)?;
    if report.cost != report.objective {
        writeln!(text, "  {:.6} with the loss asked for", report.cost)?;
    }
    let ended = match report.outcome {
        RelaxationOutcome::Converged => "converged",
        RelaxationOutcome::Stalled => {
            "did not converge: rounding keeps the cost from falling, numbers are too large or too far apart"
        }
        RelaxationOutcome::OutOfIterations => "did not converge: --max-iterations is reached",
        RelaxationOutcome::Interrupted => "did not converge: --max-seconds are over",
        RelaxationOutcome::Overflow => "did not converge: the cost is beyond what a number holds",
    };
    writeln!(text, "{ended} after {} iterations from {}", report.iterations, report.start)?;
    writeln!(text, "gauge: {} held where it was", listed(&report.gauge, "pose", "poses"))?;
    if report.parts.len() > 1 {
        writeln!(text, "{} parts, of which nothing tells how they lie to each other", report.parts.len())?;
        for part in report.parts.iter().take(LISTED) {
            writeln!(text, "  {} poses from {} on", part.poses, part.first)?;
        }
    }
    if !report.undetermined.is_empty() {
        let poses = listed(&report.undetermined, "pose", "poses");
        writeln!(text, "not determined by what was measured: {poses}")?;
    }
    if report.objective > 0.0 {
        writeln!(text, "most strained edges")?;
        for edge in report.strained.iter().take(STRAINED) {
            let of = edge.degrees_of_freedom;
            writeln!(text, "  {} - {}  chi-square {:.3} of {of}", edge.from, edge.to, edge.chi_square)?;
        }
    }
    let seconds = &report.seconds;
    let RelaxationSeconds { reading, setup, relaxing } = seconds;
    writeln!(text, "seconds: {reading:.4} reading, {setup:.4} setting up, {relaxing:.4} relaxing")
}

/// How many poses or parts, and how many strained edges, are named in words.
const LISTED: usize = 10;
const STRAINED: usize = 5;

fn listed(poses: &[u64], one: &str, many: &str) -> String {
    let named: Vec<String> = poses.iter().take(LISTED).map(u64::to_string).collect();
    let more =
        if poses.len() > LISTED { format!(" and {} more", poses.len() - LISTED) } else { String::new() };
    match poses.len() {
        0 => format!("no {one}"),
        1 => format!("{one} {}", named.concat()),
        _ => format!("{many} {}{more}", named.join(", ")),
    }
}

fn ended(answer: &Relaxation) -> Result<(), Failure> {
    match answer.outcome {
        Outcome::Converged => Ok(()),
        Outcome::OutOfIterations => {
            Err(Failure::Limit("--max-iterations is reached before the strain is least".into()))
        }
        Outcome::Interrupted => Err(Failure::Limit("--max-seconds are over before the strain is least".into())),
        Outcome::Stalled => Err(Failure::Broken(
            "rounding keeps the strain from falling, though it is not least: numbers are too large or too far apart; \
             move the graph nearer to the origin, or leave out the edges that lie"
                .into(),
        )),
        Outcome::Overflow => Err(Failure::Broken(
            "the strain is beyond what a number holds: measurements or information are absurdly large".into(),
        )),
    }
}
