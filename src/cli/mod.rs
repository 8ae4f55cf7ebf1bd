//! The command line: verbs over the library and the service.
//!
//! Data goes to standard output, progress and diagnostics to standard error; progress bars only to a terminal.

mod asked;
mod axiom_choice;
mod check;
mod classic;
mod clingo;
mod comparison;
mod demo;
mod extract;
mod failure;
mod files;
mod growing;
mod input;
mod log;
mod map;
mod members;
mod mending;
mod patchwork;
mod poses;
mod relax;
mod serve;
mod standstill;
mod star_race;
mod values;
mod view_race;
mod words;
mod world;

use crate::geometry::Pose;
use clap::{Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

/// Topological maps from what a robot saw at places and did between them: the map that explains it best, the
/// exact number of maps still possible, and why the others were refuted.
#[derive(Debug, Parser)]
#[command(name = "topostar", version, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

const EXIT_CODES: &str = "\
Exit codes: 0 ok, 1 failure, 2 usage, 3 bad input (with file and line), 4 no consistent map (with the axioms), \
5 limit hit, partial result";

#[derive(Debug, Subcommand)]
enum Verb {
    /// Map a bundled world end to end over HTTP on loopback; prints what happens at each place.
    Demo(demo::Demo),
    /// Find all maps that explain a trace, and the simplest.
    Map(map::Map),
    /// Check the search on a trace against the slow reference and clingo.
    Check(check::Check),
    /// Read gateways and star off one occupancy grid, or off every grid of a trace.
    Extract(extract::Extract),
    /// Relax a pose graph: move its poses until what was measured between them is strained least.
    Relax(relax::Relax),
    /// Run the HTTP service.
    Serve(serve::Serve),
    /// Write the trace of a bundled world, or list the worlds.
    World(world::World),
}

/// A length given as an option.
fn metres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length.is_finite() && length > 0.0 => Ok(length),
        _ => Err("expected metres, a number above 0".into()),
    }
}

/// A pose given as an option: x,y,heading.
fn pose(text: &str) -> Result<Pose, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, theta]) if [x, y, theta].iter().all(|n| n.is_finite()) => Ok(Pose::new(x, y, theta)),
        _ => Err("expected three numbers, x,y,heading".into()),
    }
}

/// Runs the verb that the process was called with.
pub fn run() -> ExitCode {
    let outcome = match Cli::parse().verb {
        Verb::Demo(verb) => verb.run(),
        Verb::Map(verb) => verb.run(),
        Verb::Check(verb) => verb.run(),
        Verb::Extract(verb) => verb.run(),
        Verb::Relax(verb) => verb.run(),
        Verb::Serve(verb) => verb.run(),
        Verb::World(verb) => verb.run(),
    };
    outcome.map_or_else(|failure: Failure| failure.report(), |()| ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_three_numbers_and_nothing_else() {
        assert_eq!(pose("1, -2,0.5"), Ok(Pose::new(1.0, -2.0, 0.5)));
        for bad in ["1,2", "1,2,3,4", "1,x,2,3", "1,2,nan", "1,2,1e999", "", ",,"] {
            assert!(pose(bad).is_err(), "{bad}");
        }
    }
}
