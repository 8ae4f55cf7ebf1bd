//! clingo as a judge: an executable of its own, or the module of a Python.

use crate::cli::failure::Failure;
use crate::export::answer_set::Theory;
use serde::Deserialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;

/// A clingo that answers.
#[derive(Debug)]
pub(super) struct Clingo {
    program: PathBuf,
    module: bool,
}

/// What clingo prints of a run, as far as it is read.
#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Run {
    call: Vec<Call>,
    result: String,
    models: Models,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Call {
    #[serde(default)]
    witnesses: Vec<Witness>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Witness {
    value: Vec<String>,
    #[serde(default)]
    costs: Vec<i64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Models {
    #[serde(default)]
    costs: Vec<i64>,
}

impl Clingo {
    /// The clingo named, an executable of clingo or of a Python that has its module; it must answer. If none is
    /// named, the one found on the search path, if any: `clingo`, or the module of `python3`.
    pub(super) fn find(named: Option<&Path>) -> Result<Option<Clingo>, Failure> {
        let Some(program) = named else {
            let known = [("clingo", false), ("python3", true)];
            let known = known.map(|(program, module)| Clingo { program: program.into(), module });
            return Ok(known.into_iter().find(|clingo| clingo.version().is_ok()));
        };
        let name = program.file_name().unwrap_or_default().to_string_lossy();
        let clingo = Clingo { program: program.to_owned(), module: name.starts_with("python") };
        clingo.version().map(|()| Some(clingo)).map_err(|why| {
            Failure::Usage(format!(
                "--clingo {}: {why}; expected clingo, or a python that has the module clingo",
                program.display()
            ))
        })
    }

    /// All candidates, in lexicographic order, but no more than `most`.
    pub(super) fn candidates<S: Ord>(
        &self,
        theory: &Theory<S>,
        facts: &str,
        observations: usize,
        most: usize,
    ) -> Result<Vec<S>, Failure> {
        let run = self.solve(theory.program(facts, false), &[&most.to_string()])?;
        stories(theory, &run, observations, |_| true)
    }

    /// The preferred candidates, in lexicographic order.
    pub(super) fn minimal<S: Ord>(
        &self,
        theory: &Theory<S>,
        facts: &str,
        observations: usize,
    ) -> Result<Vec<S>, Failure> {
        let options = ["--opt-mode=optN", "--project=show", "0"];
        let run = self.solve(theory.program(facts, true), &options)?;
        stories(theory, &run, observations, |witness| witness.costs == run.models.costs)
    }

    fn version(&self) -> Result<(), String> {
        let output = self.command().arg("--version").output().map_err(|error| error.to_string())?;
        match output.status.success() {
            true => Ok(()),
            false => Err(format!("ended with {}", output.status)),
        }
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        if self.module {
            command.args(["-m", "clingo"]);
        }
        command
    }

    fn solve(&self, program: String, options: &[&str]) -> Result<Run, Failure> {
        let output =
            self.feed(program, options).map_err(|error| Failure::Broken(format!("clingo: {error}")))?;
        let broken = |why: String| {
            let said = String::from_utf8_lossy(&output.stderr);
            Failure::Broken(format!("clingo: {why}: {}", said.lines().next().unwrap_or("it says nothing")))
        };
        let run: Run = serde_json::from_slice(&output.stdout).map_err(|error| broken(error.to_string()))?;
        match run.result.as_str() {
            "SATISFIABLE" | "UNSATISFIABLE" | "OPTIMUM FOUND" => Ok(run),
            other => Err(broken(format!("the result is {other}"))),
        }
    }

    fn feed(&self, program: String, options: &[&str]) -> std::io::Result<Output> {
        let mut command = self.command();
        command.args(["--outf=2", "-"]).args(options);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn()?;
        // What is written must not wait for what is read.
        let stdin = process.stdin.take();
        let feeding =
            thread::spawn(move || stdin.map_or(Ok(()), |mut stdin| stdin.write_all(program.as_bytes())));
        let output = process.wait_with_output()?;
        // A clingo that does not read to the end has said why.
        let _ = feeding.join();
        Ok(output)
    }
}

fn stories<S: Ord>(
    theory: &Theory<S>,
    run: &Run,
    observations: usize,
    wanted: impl Fn(&Witness) -> bool,
) -> Result<Vec<S>, Failure> {
    let witnesses = run.call.iter().flat_map(|call| &call.witnesses).filter(|witness| wanted(witness));
    let told = witnesses.map(|witness| (theory.story)(&witness.value, observations));
    let mut stories: Vec<S> = told
        .collect::<Option<_>>()
        .ok_or_else(|| Failure::Broken("clingo: a model says not of every visit what it is".into()))?;
    stories.sort_unstable();
    // An optimum may be shown when found and again when proven.
    stories.dedup();
    Ok(stories)
}
