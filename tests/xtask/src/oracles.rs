//! Judges and rivals that are not ours, in a Python environment under `target/oracles`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A package of the Python package index.
pub(crate) struct Package {
    name: &'static str,
    version: &'static str,
}

impl Package {
    fn pinned(&self) -> String {
        format!("{}=={}", self.name, self.version)
    }
}

/// What tests ask.
pub(crate) const CLINGO: &[Package] = &[Package { name: "clingo", version: "5.8.3" }];

/// What perception is compared with.
pub(crate) const IMAGES: &[Package] = &[
    Package { name: "opencv-python-headless", version: "5.0.0.93" },
    Package { name: "scikit-image", version: "0.26.0" },
    Package { name: "sknw", version: "0.15" },
];

/// What relaxation is compared with; numpy comes along.
pub(crate) const GTSAM: &[Package] = &[Package { name: "gtsam", version: "4.3.0" }];

/// The variable that names the Python to ask, see `axioms/clingo.rs`.
pub(crate) const PYTHON: &str = "TOPOSTAR_CLINGO_PYTHON";

/// Sets up what is missing of some packages; once it is there nothing is fetched again.
pub(crate) fn set_up(root: &Path, packages: &[Package]) -> Result<PathBuf, String> {
    let python = python(root);
    let is_there = |package: &&Package| version(&python, package.name).as_deref() == Some(package.version);
    let missing: Vec<String> =
        packages.iter().filter(|package| !is_there(package)).map(Package::pinned).collect();
    if missing.is_empty() {
        return Ok(python);
    }
    let folder = folder(root);
    println!("setting up {} in {}", missing.join(", "), folder.display());
    let mend = "expected python3 with the module venv, and access to a Python package index";
    if !python.exists() {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder))
            .map_err(|why| format!("{why}; {mend}"))?;
    }
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(&missing))
        .map_err(|why| format!("{why}; {mend}"))?;
    match packages.iter().find(|package| !is_there(package)) {
        None => Ok(python),
        Some(package) => {
            let found = version(&python, package.name);
            Err(format!("{} was installed, but version {found:?} is there", package.pinned()))
        }
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

/// The version of a package that is there.
fn version(python: &Path, package: &str) -> Option<String> {
    let ask = format!("from importlib.metadata import version; print(version('{package}'))");
    let output = Command::new(python).args(["-c", &ask]).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}
