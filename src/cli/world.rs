//! `topostar world`: the bundled worlds and the traces of walks through them.

use crate::cli::failure::Failure;
use crate::cli::metres;
use crate::trace::write_trace;
use crate::worlds::{self, Naming, lpm_trace, star_trace, view_trace};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use std::io::{BufWriter, Write, stdout};

/// Write the trace of a bundled world, or list the worlds.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  topostar world                                  the names of the bundled worlds
  topostar world office | topostar map -          a walk as grids, mapped
  topostar world office --stars > office.ndjson   the same walk as bare stars
  topostar world office --views | topostar map - --strategy best-first
                                                  the same walk as views, turns and travels
  topostar world office --picture > office.svg    the building as a drawing")]
pub(super) struct World {
    /// Name of the world; left out, the names are listed.
    #[arg(value_parser = PossibleValuesParser::new(worlds::names()))]
    name: Option<String>,
    /// Bare stars in place of grids.
    #[arg(long)]
    stars: bool,
    /// Views at every dstate in place of grids, named by what a range sensor sees there.
    #[arg(long, value_name = "NAMING", num_args = 0..=1, default_missing_value = "sides", conflicts_with = "stars")]
    views: Option<NamingName>,
    /// A drawing of the world in place of a trace, SVG.
    #[arg(long, conflicts_with_all = ["stars", "views"])]
    picture: bool,
    /// Draws where each grid lies in its frame, and the noise of the odometry.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Side of a grid cell, metres.
    #[arg(long, default_value_t = 0.05, value_parser = cell_side)]
    resolution: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum NamingName {
    /// What lies ahead, left and right: a corridor, a wall, or open space.
    Sides,
    /// Whether there is a wall ahead, left and right.
    Walls,
    /// What lies ahead.
    Ahead,
}

impl From<NamingName> for Naming {
    fn from(name: NamingName) -> Naming {
        match name {
            NamingName::Sides => Naming::Sides,
            NamingName::Walls => Naming::Walls,
            NamingName::Ahead => Naming::Ahead,
        }
    }
}

impl World {
    pub(super) fn run(self) -> Result<(), Failure> {
        let mut out = BufWriter::new(stdout().lock());
        let Some(name) = self.name else {
            for name in worlds::names() {
                let world = load(name)?;
                writeln!(out, "{name:14} {}", world.title)?;
            }
            return Ok(out.flush()?);
        };
        let world = load(&name)?;
        if self.picture {
            out.write_all(worlds::picture(&world).as_bytes())?;
            return Ok(out.flush()?);
        }
        let events = if let Some(naming) = self.views {
            view_trace(&world, naming.into()).events
        } else if self.stars {
            star_trace(&world, None).map_err(|error| Failure::Broken(error.to_string()))?.events
        } else {
            let trace = lpm_trace(&world, self.seed, self.resolution);
            trace.map_err(|error| Failure::Broken(format!("--resolution: {error}")))?.events
        };
        write_trace(&mut out, &events)?;
        Ok(out.flush()?)
    }
}

/// Grids of 20 m on a side must stay within what a trace may hold.
fn cell_side(text: &str) -> Result<f64, String> {
    let side = metres(text)?;
    if (0.01..=1.0).contains(&side) { Ok(side) } else { Err("expected 0.01 to 1 metres".into()) }
}

/// A bundled world by name.
pub(super) fn load(name: &str) -> Result<worlds::World, Failure> {
    worlds::bundled(name).map_err(|error| Failure::Broken(error.to_string()))
}
