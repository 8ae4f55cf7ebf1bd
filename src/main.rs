//! The command line of Topostar; see `topostar --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    topostar::cli::run()
}
