//! `topostar extract`: gateways and star of one grid, or of every grid of a trace.

use crate::cli::failure::Failure;
use crate::cli::input::{Events, open, plain_extension, read_events};
use crate::cli::log::LogArgs;
use crate::cli::{metres, pose};
use crate::export::{Extraction, Visited, extraction_svg, visits_svg};
use crate::geometry::Pose;
use crate::grid::{Cell, GridInfo, OccupancyGrid, SkeletonParameters};
use crate::lpm::Lpm;
use crate::star::{DescribeError, PerceptionParameters, PlaceDescription, Rejected, describe, rejected};
use crate::trace::wire_grid::WireLpm;
use crate::trace::{EventKind, Percept};
use clap::Args;
use std::fs;
use std::io::{Read, Write, stdout};
use std::path::{Path, PathBuf};

/// Read gateways and star off one occupancy grid, or off every grid of a trace or visit in a log.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  topostar extract lpm.json --svg lpm.svg            one grid as in a trace's lpm field
  topostar extract map.pgm --at 12.5,3.0,1.57        a window of a map_server image around a pose
  topostar extract trace.ndjson -o pictures/         a picture of every place of a trace
  topostar extract run.clf.bz2 --svg visits.svg      a sheet with every place that is found in a log
  topostar extract run.clf.bz2 --visits arrivals.csv -o pictures/")]
pub(super) struct Extract {
    /// A grid (.json, .png, .pgm, row 0 of an image at the top), a trace (.ndjson), or a log.
    input: PathBuf,
    /// The robot's pose in the grid's frame: x,y,heading in metres and radians; default: the middle, heading 0.
    #[arg(long, value_name = "X,Y,THETA", value_parser = pose, allow_hyphen_values = true)]
    at: Option<Pose>,
    /// Side of a pixel of an image, metres; the image's bottom-left corner is the origin.
    #[arg(long, default_value_t = 0.05, value_parser = metres)]
    resolution: f64,
    /// The narrowest way that counts as one, metres: 0.65 for a robot that goes through office
    /// doors. Below a metre rooms count as places to go to.
    #[arg(long, value_name = "METRES", value_parser = metres)]
    passage_width: Option<f64>,
    /// The arrivals in a log: CSV with the columns place,raw_scan_index.
    #[arg(long, value_name = "CSV")]
    visits: Option<PathBuf>,
    #[command(flatten)]
    log: LogArgs,
    /// Write a picture of a single grid there, or one sheet with all of them in order.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write a picture of each grid there, observation-NN.svg, and a sheet with all of them, visits.svg.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// A robot with a passage width below this goes through doors, metres.
const WIDEST_DOOR: f64 = 1.0;

/// A place with the openings that are no gateways.
type Described = Result<(PlaceDescription, Vec<Rejected>), DescribeError>;

/// The grids of an input up to its first fault.
struct Grids {
    lpms: Vec<Lpm>,
    fault: Option<Failure>,
}

impl Extract {
    /// Prints one JSON object a grid; a grid that cannot be described gives an error only after the others.
    pub(super) fn run(self) -> Result<(), Failure> {
        let Grids { lpms, fault } = self.grids()?;
        if let Some(folder) = &self.output {
            fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
        }
        let parameters = self.parameters();
        let places: Vec<_> = lpms.iter().map(|lpm| read(lpm, &parameters)).collect();
        let mut refused = Vec::new();
        for (number, place) in places.iter().enumerate() {
            match place {
                Ok((place, rejected)) => {
                    let json = serde_json::to_string(&Extraction::of(number, place, rejected));
                    writeln!(stdout(), "{}", json.map_err(|error| Failure::Broken(error.to_string()))?)?;
                }
                Err(error) => refused.push(format!("observation {number}: {error}")),
            }
        }
        self.draw(&lpms, &places)?;
        if !refused.is_empty() {
            return Err(Failure::input(&self.input, refused.join("; ")));
        }
        fault.map_or(Ok(()), Err)
    }

    fn parameters(&self) -> PerceptionParameters {
        let mut parameters = PerceptionParameters::default();
        if let Some(width) = self.passage_width {
            let doors = SkeletonParameters::for_doors();
            let room_ratio = doors.room_ratio.filter(|_| width < WIDEST_DOOR);
            parameters.skeleton =
                SkeletonParameters { passage_width: width, room_ratio, ..SkeletonParameters::default() };
        }
        parameters
    }

    /// A picture of each place in the folder; of all of them one sheet, or just the picture where there is one.
    fn draw(&self, lpms: &[Lpm], places: &[Described]) -> Result<(), Failure> {
        let write = |file: &Path, picture: &str| {
            fs::write(file, picture).map_err(|error| Failure::writing(file, error))
        };
        let both = || lpms.iter().zip(places).enumerate();
        let whole = match (lpms, places) {
            ([lpm], [seen]) => seen.as_ref().ok().map(|seen| picture(lpm, seen)),
            _ => Some(visits_svg(&both().map(visited).collect::<Vec<_>>())),
        };
        if let (Some(file), Some(whole)) = (&self.svg, &whole) {
            write(file, whole)?;
        }
        let Some(folder) = &self.output else { return Ok(()) };
        for (number, (lpm, seen)) in both() {
            if let Ok(seen) = seen {
                write(&folder.join(format!("observation-{number:02}.svg")), &picture(lpm, seen))?;
            }
        }
        whole.map_or(Ok(()), |whole| write(&folder.join("visits.svg"), &whole))
    }

    fn grids(&self) -> Result<Grids, Failure> {
        let lpm = match plain_extension(&self.input).as_str() {
            "json" => self.json_lpm()?,
            "png" | "pgm" => {
                let grid = self.image_grid()?;
                let pose = self.at.unwrap_or_else(|| middle(grid.info()));
                Lpm::new(grid, pose)
            }
            _ if self.at.is_some() => {
                return Err(Failure::Usage(
                    "--at goes with one grid; a trace says where the robot is".into(),
                ));
            }
            _ => return self.trace_grids(),
        };
        if self.visits.is_some() {
            return Err(Failure::Usage("--visits goes with a log, not with a grid".into()));
        }
        Ok(Grids { lpms: vec![lpm], fault: None })
    }

    fn trace_grids(&self) -> Result<Grids, Failure> {
        let Events { events, fault, .. } = read_events(&self.input, self.visits.as_deref(), &self.log)?;
        let mut lpms = Vec::new();
        let mut way = None;
        for (_, event) in events {
            match event.kind {
                EventKind::Travel(travel) => way = Some(travel),
                EventKind::Observation(seen) => {
                    if let Percept::Lpm(lpm) = seen.percept {
                        let way = way.take().map(|way| way.trail(&lpm.robot_pose));
                        lpms.push(lpm.reached_by(way));
                    }
                }
                EventKind::Turn(_) | EventKind::Assert(_) | EventKind::Retract { .. } => {}
            }
        }
        if let (true, None) = (lpms.is_empty(), &fault) {
            let none = "no observation with an lpm, expected grids: bare stars have nothing to extract";
            return Err(Failure::input(&self.input, none));
        }
        Ok(Grids { lpms, fault })
    }

    fn json_lpm(&self) -> Result<Lpm, Failure> {
        let bad = |error: String| Failure::input(&self.input, error);
        let mut json = serde_json::Deserializer::from_reader(open(&self.input)?);
        let wire: WireLpm =
            serde_path_to_error::deserialize(&mut json).map_err(|error| bad(error.to_string()))?;
        json.end().map_err(|error| bad(format!("more text after the grid: {error}; expected one object")))?;
        let lpm = wire.lpm(Pose::IDENTITY, "").map_err(|error| bad(error.to_string()))?;
        let robot_pose = self.at.unwrap_or_else(|| middle(lpm.grid.info()));
        Ok(Lpm { robot_pose, ..lpm })
    }

    fn image_grid(&self) -> Result<OccupancyGrid, Failure> {
        let mut bytes = Vec::new();
        open(&self.input)?.read_to_end(&mut bytes).map_err(|error| Failure::input(&self.input, error))?;
        image_grid(&bytes, self.resolution).map_err(|error| Failure::input(&self.input, error))
    }
}

fn read(lpm: &Lpm, parameters: &PerceptionParameters) -> Described {
    let place = describe(lpm, parameters)?;
    let openings = rejected(lpm, &place, parameters);
    Ok((place, openings))
}

fn picture(lpm: &Lpm, (place, rejected): &(PlaceDescription, Vec<Rejected>)) -> String {
    extraction_svg(place, &lpm.robot_pose, rejected)
}

fn visited<'a>((observation, (lpm, seen)): (usize, (&'a Lpm, &'a Described))) -> Visited<'a> {
    let rejected = seen.as_ref().map_or(&[][..], |(_, rejected)| rejected);
    let place = seen.as_ref().map(|(place, _)| place).map_err(ToString::to_string);
    Visited { observation, robot: lpm.robot_pose, rejected, place }
}

/// An image in the greys of `map_server`, its first row at the top.
fn image_grid(bytes: &[u8], resolution: f64) -> Result<OccupancyGrid, String> {
    let image = image::load_from_memory(bytes).map_err(|error| error.to_string())?.into_luma8();
    let info = GridInfo {
        resolution,
        width: image.width() as usize,
        height: image.height() as usize,
        origin: Pose::IDENTITY,
    };
    let rows = image.rows().rev();
    let cells = rows.flat_map(|row| row.map(|pixel| Cell::from_grey(pixel.0[0]))).collect();
    OccupancyGrid::new(info, cells).map_err(|error| error.to_string())
}

fn middle(info: &GridInfo) -> Pose {
    let half =
        Pose::new(info.width as f64 * info.resolution / 2.0, info.height as f64 * info.resolution / 2.0, 0.0);
    info.origin.compose(&half)
}
