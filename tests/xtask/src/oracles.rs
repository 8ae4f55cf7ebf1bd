//! Judges that are not ours: clingo, in a Python environment under `target/oracles`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The version of clingo that tests ask.
const CLINGO: &str = "5.8.3";

/// The variable that names the Python to ask, see `axioms/clingo.rs`.
pub(crate) const PYTHON: &str = "TOPOSTAR_CLINGO_PYTHON";

/// Sets up what is missing; once it is there nothing is fetched again.
pub(crate) fn set_up(root: &Path) -> Result<PathBuf, String> {
    let python = python(root);
    if version(&python).as_deref() == Some(CLINGO) {
        return Ok(python);
    }
    let folder = folder(root);
    println!("setting up clingo {CLINGO} in {}", folder.display());
    let mend = "expected python3 with the module venv, and access to a Python package index";
    run(Command::new("python3").args(["-m", "venv"]).arg(&folder)).map_err(|why| format!("{why}; {mend}"))?;
    let package = format!("clingo=={CLINGO}");
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet", &package]))
        .map_err(|why| format!("{why}; {mend}"))?;
    match version(&python) {
        Some(found) if found == CLINGO => Ok(python),
        found => Err(format!("clingo {CLINGO} was installed, but {found:?} answers")),
    }
}

/// The Python of the environment, where it has been set up.
pub(crate) fn found(root: &Path) -> Option<PathBuf> {
    Some(python(root)).filter(|python| python.exists())
}

fn folder(root: &Path) -> PathBuf {
    root.join("target/oracles")
}

fn python(root: &Path) -> PathBuf {
    folder(root).join("bin/python")
}

fn version(python: &Path) -> Option<String> {
    let output =
        Command::new(python).args(["-c", "import clingo; print(clingo.__version__)"]).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}
