//! The annotated doors of gdc3.

use crate::maps;
use crate::openings::{Opening, Tally, open_ones};
use std::fs;
use topostar::geometry::{Point, Pose, Vector};
use topostar::grid::{OccupancyGrid, SkeletonParameters};
use topostar::star::PerceptionParameters;

/// Where the origin of the map lies in the frame of its annotations.
const ORIGIN: Vector = Vector::new(-60.45, -23.4);

pub(super) fn print() {
    let (map, doors) = load();
    println!("\ndoors of gdc3");
    let mut tally = Tally::default();
    tally.look(&map, &doors, &with_doors(PerceptionParameters::default()));
    println!("  {}", tally.line());
    let (open, closed) = open_ones(&map, doors);
    let mut passable = Tally::default();
    passable.look(&map, &open, &with_doors(PerceptionParameters::default()));
    println!("  without the {closed} that the map shows shut: {}", passable.line());
    passable.missed.iter().for_each(|missed| println!("    {missed}"));
}

/// The same parameters for a robot that goes through doors.
pub(super) fn with_doors(mut parameters: PerceptionParameters) -> PerceptionParameters {
    let default = PerceptionParameters::default().skeleton.passage_width;
    let doors = SkeletonParameters::for_doors();
    parameters.skeleton.passage_width *= doors.passage_width / default;
    parameters.skeleton.room_ratio = doors.room_ratio;
    parameters
}

pub(super) fn load() -> (OccupancyGrid, Vec<Opening>) {
    let text = fs::read_to_string(maps::data("maps/gdc3/doors.yaml")).unwrap();
    (maps::grid("gdc3/3.pgm.gz", 0.05), read(&text))
}

/// Reads the annotations: an item a door, with two points and the poses of approach.
fn read(text: &str) -> Vec<Opening> {
    let mut doors: Vec<Opening> = Vec::new();
    let (mut poses, mut jambs) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let Some((key, value)) = line.trim_start_matches(['-', ' ']).split_once(':') else { continue };
        let numbers = value.trim().trim_matches(['[', ']']).split(',').map(|word| word.trim().parse::<f64>());
        match key {
            "point" => {
                let n: Vec<f64> = numbers.map(Result::unwrap).collect();
                poses.push(Pose::new(n[0] - ORIGIN.x, n[1] - ORIGIN.y, n[2]));
            }
            "door_corner_pt_1" | "door_corner_pt_2" => {
                let n: Vec<f64> = numbers.map(Result::unwrap).collect();
                jambs.push(Point::new(n[0], n[1]) - ORIGIN);
            }
            "name" => {
                let poses = std::mem::take(&mut poses);
                doors.push(Opening { jambs: [jambs[0], jambs[1]], poses });
                jambs.clear();
            }
            _ => {}
        }
    }
    doors
}
