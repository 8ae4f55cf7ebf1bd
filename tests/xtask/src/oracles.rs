//! Judges and rivals that are not ours: clingo and GTSAM, in a Python environment under `target/oracles`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A Python package to be asked, at the version that figures and tests are about.
#[derive(Debug)]
pub(crate) struct Oracle {
    package: &'static str,
    version: &'static str,
}

/// Answer-set solver: what the search is held to.
pub(crate) const CLINGO: Oracle = Oracle { package: "clingo", version: "5.8.3" };
/// Factor-graph solver: what relaxation is compared with. It needs numpy, which comes along.
pub(crate) const GTSAM: Oracle = Oracle { package: "gtsam", version: "4.3.0" };

/// The variable that names the Python to ask, see `axioms/clingo.rs`.
pub(crate) const PYTHON: &str = "TOPOSTAR_CLINGO_PYTHON";

/// Sets up what is missing; once it is there nothing is fetched again.
pub(crate) fn set_up(root: &Path, oracle: &Oracle) -> Result<PathBuf, String> {
    let Oracle { package, version } = *oracle;
    let python = python(root);
    if found_version(&python, package).as_deref() == Some(version) {
        return Ok(python);
    }
    let folder = folder(root);
    println!("setting up {package} {version} in {}", folder.display());
    let mend = "expected python3 with the module venv, and access to a Python package index";
    if !python.exists() {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder))
            .map_err(|why| format!("{why}; {mend}"))?;
    }
    let wanted = format!("{package}=={version}");
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet", &wanted]))
        .map_err(|why| format!("{why}; {mend}"))?;
    match found_version(&python, package) {
        Some(found) if found == version => Ok(python),
        found => Err(format!("{package} {version} was installed, but {found:?} answers")),
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

/// The version of a package that can be imported.
fn found_version(python: &Path, package: &str) -> Option<String> {
    let ask = format!("import {package}, importlib.metadata as m; print(m.version('{package}'))");
    let output = Command::new(python).args(["-c", &ask]).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}
