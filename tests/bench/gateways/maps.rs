//! Recorded maps and the windows that are cut out of them.

use flate2::read::GzDecoder;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use topostar::export::extraction_svg;
use topostar::geometry::{Point, Pose};
use topostar::grid::{Cell, GridInfo, OccupancyGrid};
use topostar::lpm::Lpm;
use topostar::star::PlaceDescription;

/// Side of the windows, metres, and of their cells.
const SIDE: f64 = 20.0;
const RESOLUTION: f64 = 0.05;

pub(super) fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(file)
}

/// An image in the greys of `map_server`, packed or not, as a grid with its origin at the bottom left.
pub(super) fn grid(file: &str, resolution: f64) -> OccupancyGrid {
    let image = image(file);
    let info = GridInfo {
        resolution,
        width: image.width() as usize,
        height: image.height() as usize,
        origin: Pose::IDENTITY,
    };
    let cells = image.rows().rev().flat_map(|row| row.map(|pixel| Cell::from_grey(pixel.0[0])));
    OccupancyGrid::new(info, cells.collect()).unwrap()
}

fn image(file: &str) -> image::GrayImage {
    let path = data(&format!("maps/{file}"));
    let mut bytes = Vec::new();
    if file.ends_with(".gz") {
        GzDecoder::new(File::open(path).unwrap()).read_to_end(&mut bytes).unwrap();
    } else {
        bytes = fs::read(path).unwrap();
    }
    image::load_from_memory(&bytes).unwrap().into_luma8()
}

/// The window of a map whose middle lies at a point of the map and whose axes are turned, every cell looked up where
/// `moved` takes its centre. The frame of the window is the map's.
pub(super) fn window(
    map: &OccupancyGrid,
    middle: &Point,
    turned: f64,
    mut moved: impl FnMut(Point) -> Point,
) -> OccupancyGrid {
    let half = Pose::new(-SIDE / 2.0, -SIDE / 2.0, 0.0);
    let side = (SIDE / RESOLUTION).round() as usize;
    let origin = Pose::new(middle.x, middle.y, turned).compose(&half);
    let info = GridInfo { resolution: RESOLUTION, width: side, height: side, origin };
    let cell = |i: usize| {
        let at = map.info().cell_at(&moved(info.center(info.index(i))));
        at.map_or(Cell::Unknown, |at| map.cell(at))
    };
    OccupancyGrid::new(info, (0..side * side).map(cell).collect()).unwrap()
}

/// Draws what was read off a window into the folder that `GATEWAY_PICTURES` names, if it is set.
pub(super) fn draw(place: &PlaceDescription, robot: &Pose, name: &str) {
    let Some(folder) = std::env::var_os("GATEWAY_PICTURES") else { return };
    fs::create_dir_all(&folder).unwrap();
    fs::write(Path::new(&folder).join(format!("{name}.svg")), extraction_svg(place, robot, &[])).unwrap();
}

/// The window around a robot, along the axes of the map.
pub(super) fn lpm(map: &OccupancyGrid, robot: &Pose) -> Lpm {
    // Cells of the window fall on cells of the map where both are of one size.
    let snap = |v: f64| (v / RESOLUTION).round() * RESOLUTION;
    let middle = Point::new(snap(robot.x), snap(robot.y));
    Lpm::new(window(map, &middle, 0.0, |point| point), *robot)
}
