//! Helper tasks: `cargo xtask test` is everything that has to pass before a change lands.

mod oracles;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

struct Step {
    what: &'static str,
    arguments: &'static [&'static str],
    /// Environment of the step.
    environment: &'static [(&'static str, &'static str)],
    /// The component of the toolchain it needs beyond cargo itself.
    component: Option<&'static str>,
}

const TEST: &[Step] = &[
    Step {
        what: "format",
        arguments: &["fmt", "--all", "--check"],
        environment: &[],
        component: Some("rustfmt"),
    },
    Step {
        what: "lints, warnings denied",
        arguments: &["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"],
        environment: &[],
        component: Some("clippy"),
    },
    Step {
        what: "lints of the tests on recorded data, which are no default target",
        arguments: &["clippy", "--locked", "--test", "real_data", "--", "-D", "warnings"],
        environment: &[],
        component: Some("clippy"),
    },
    Step {
        what: "tests, golden files included",
        arguments: &["test", "--workspace", "--locked"],
        environment: &[],
        component: None,
    },
    Step {
        what: "documentation, warnings denied",
        arguments: &["doc", "--workspace", "--no-deps", "--locked", "--document-private-items"],
        environment: &[("RUSTDOCFLAGS", "-D warnings")],
        component: None,
    },
];

const HELP: &str = "\
usage: cargo xtask <task>

  test     format check, lints, all tests, documentation, golden files up to date
  compare [SECONDS]
           the search beside clingo on the recorded grids: whether the answers are the same, then how long each takes;
           clingo is cut off after so many seconds a question, 60 unless told otherwise
  compare-perception
           distance field, skeleton and graph beside OpenCV, scikit-image and sknw: whether the answers are the same, then
           how long each takes
  compare-relax [graphs] [truth] [growing] [candidates] [growth]
           relaxation beside GTSAM: objectives and times on the recorded graphs of ../shared/data, the distance to the
           ground truth, the cost of each pose as a graph or a candidate map grows, and of graphs of 100 to 100,000
           poses
  evaluate [WALKS [SEED]]
           random walks with odometry that drifts: how often an axiom refutes the true map, how many candidates are
           left, and how often the true map is preferred
  gateways [visits] [again] [doors] [borders] [stability] [defaults] [chain]
           how well gateways and stars are read off recorded maps; needs ../shared/data
  golden   write the golden files anew (api/openapi.json, api/examples, worlds/pictures); look at the difference
           before committing";

fn main() -> ExitCode {
    let tasks: Vec<String> = std::env::args().skip(1).collect();
    match tasks.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => test(),
        ["golden"] => run_all(&[&Step {
            what: "golden files",
            arguments: &["test", "--locked", "--test", "suite"],
            environment: &[("UPDATE_GOLDEN", "1")],
            component: None,
        }]),
        ["compare", ref rest @ ..] => compare("rival", oracles::CLINGO, rest),
        ["compare-perception"] => compare("perception_rival", oracles::IMAGES, &[]),
        ["compare-relax", ref rest @ ..] => compare("relax", oracles::GTSAM, rest),
        ["evaluate", ref rest @ ..] => evaluate(rest),
        ["gateways", ref rest @ ..] => bench("gateways", rest, &[]),
        ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("{HELP}");
            ExitCode::from(2)
        }
    }
}

fn compare(target: &str, rivals: &[oracles::Package], rest: &[&str]) -> ExitCode {
    match oracles::set_up(&root(), rivals) {
        Ok(python) => bench(target, rest, &[(oracles::PYTHON, python)]),
        Err(why) => {
            eprintln!("failed: no rival to compare with: {why}");
            ExitCode::FAILURE
        }
    }
}

fn evaluate(rest: &[&str]) -> ExitCode {
    bench("evaluation", rest, &[])
}

fn bench(target: &str, rest: &[&str], environment: &[(&str, PathBuf)]) -> ExitCode {
    let mut command = cargo();
    command.args(["bench", "--locked", "--bench", target, "--"]).args(rest);
    match command.envs(environment.iter().map(|(name, value)| (name, value))).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo cannot be started: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Tests on recorded data that is not part of the repository; its folder lies beside the checkout, or does not.
const REAL_DATA: Step = Step {
    what: "tests on recorded data",
    arguments: &["test", "--locked", "--test", "real_data"],
    environment: &[],
    component: None,
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn test() -> ExitCode {
    let root = root();
    if let Err(why) = oracles::set_up(&root, oracles::CLINGO) {
        eprintln!("failed: no oracle to hold the search to: {why}");
        return ExitCode::FAILURE;
    }
    if root.join("../shared/data").is_dir() {
        return run_all(&TEST.iter().chain([&REAL_DATA]).collect::<Vec<_>>());
    }
    let outcome = run_all(&TEST.iter().collect::<Vec<_>>());
    println!("skipped, as ../shared/data is not there:");
    let source = |file: &str| fs::read_to_string(root.join("tests/real_data").join(file)).unwrap_or_default();
    let sources = ["main.rs", "logs.rs", "patchwork.rs", "posegraphs.rs"].map(source).concat();
    let tests = sources.split("#[test]\nfn ").skip(1).filter_map(|rest| rest.split('(').next());
    tests.for_each(|name| println!("  real_data {name}"));
    outcome
}

fn run_all(steps: &[&Step]) -> ExitCode {
    for (k, step) in steps.iter().enumerate() {
        println!("\n[{}/{}] {}", k + 1, steps.len(), step.what);
        if let Err(why) = step.run() {
            eprintln!("\nfailed: {}: {why}", step.what);
            return ExitCode::FAILURE;
        }
    }
    println!("\nall {} steps passed", steps.len());
    ExitCode::SUCCESS
}

impl Step {
    fn run(&self) -> Result<(), String> {
        self.install_component()?;
        let mut command = cargo();
        command.args(self.arguments).envs(self.environment.iter().copied());
        command.envs(oracles::found(&root()).map(|python| (oracles::PYTHON, python)));
        println!("$ cargo {}", self.arguments.join(" "));
        let status = command.status().map_err(|e| format!("cargo cannot be started: {e}"))?;
        if status.success() {
            Ok(())
        } else {
            Err(format!("cargo {} ended with {status}", self.arguments[0]))
        }
    }

    fn install_component(&self) -> Result<(), String> {
        let Some(component) = self.component else { return Ok(()) };
        let present = cargo().args([self.arguments[0], "--version"]).output();
        if present.is_ok_and(|output| output.status.success()) {
            return Ok(());
        }
        println!("{component} is missing, installing it");
        let added = Command::new("rustup").args(["component", "add", component]).status();
        if added.is_ok_and(|status| status.success()) {
            return Ok(());
        }
        Err(format!(
            "{component} is missing and rustup could not add it; install it by `rustup component add {component}`"
        ))
    }
}

fn cargo() -> Command {
    Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
}
