//! An occupancy grid as ROS's `map_server` reads it: a grey picture, row 0 at the top, and a YAML file beside it.

use crate::grid::{Cell, OccupancyGrid};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

/// The greys of `map_saver`, which mode `trinary` reads back as they were.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// The picture as PNG.
pub fn map_png(grid: &OccupancyGrid) -> Result<Vec<u8>, ImageError> {
    let mut png = Vec::new();
    let [width, height] = size(grid);
    PngEncoder::new(&mut png).write_image(&greys(grid), width, height, ExtendedColorType::L8)?;
    Ok(png)
}

/// The picture as PGM, which needs no decoder.
pub fn map_pgm(grid: &OccupancyGrid) -> Vec<u8> {
    let [width, height] = size(grid);
    let mut pgm = format!("P5\n{width} {height}\n255\n").into_bytes();
    pgm.extend(greys(grid));
    pgm
}

/// The YAML file that names the picture and says how large a cell is and where the picture lies.
pub fn map_yaml(grid: &OccupancyGrid, picture: &str) -> String {
    let info = grid.info();
    let origin = info.origin;
    format!(
        "image: {picture}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: \
         0.65\nfree_thresh: 0.196\n",
        info.resolution, origin.x, origin.y, origin.theta
    )
}

/// Columns and rows; sides are bounded (`grid::MAX_SIDE`).
fn size(grid: &OccupancyGrid) -> [u32; 2] {
    [grid.info().width, grid.info().height].map(|side| side as u32)
}

fn greys(grid: &OccupancyGrid) -> Vec<u8> {
    let grey = |cell: &Cell| match cell {
        Cell::Occupied => OCCUPIED,
        Cell::Unknown => UNKNOWN,
        Cell::Free => FREE,
    };
    grid.cells().chunks(grid.info().width).rev().flatten().map(grey).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::grid::GridInfo;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_picture_is_read_back_as_it_was(
            cells in (1..8_usize, 1..8_usize).prop_flat_map(|(w, h)| (Just(w), prop::collection::vec(0..3_usize, w * h))),
        ) {
            let (width, cells) = cells;
            let info = GridInfo { resolution: 0.05, width, height: cells.len() / width, origin: Pose::IDENTITY };
            let kinds = [Cell::Unknown, Cell::Free, Cell::Occupied];
            let grid = OccupancyGrid::new(info, cells.iter().map(|cell| kinds[*cell]).collect()).unwrap();
            let read = image::load_from_memory(&map_png(&grid).unwrap()).unwrap().into_luma8();
            prop_assert_eq!([read.width(), read.height()], size(&grid));
            let rows: Vec<&[u8]> = read.as_raw().chunks(width).collect();
            let back: Vec<Cell> = rows.iter().rev().flat_map(|row| row.iter().map(|grey| Cell::from_grey(*grey))).collect();
            prop_assert_eq!(back.as_slice(), grid.cells());
            let pgm = map_pgm(&grid);
            prop_assert_eq!(&pgm[pgm.len() - read.as_raw().len()..], read.as_raw().as_slice());
        }
    }

    #[test]
    fn the_file_beside_the_picture_says_where_it_lies() {
        let info = GridInfo { resolution: 0.05, width: 2, height: 1, origin: Pose::new(-1.5, 2.0, 0.0) };
        let grid = OccupancyGrid::new(info, vec![Cell::Free, Cell::Occupied]).unwrap();
        let yaml = map_yaml(&grid, "map.png");
        assert!(yaml.contains("image: map.png\n") && yaml.contains("resolution: 0.05\n"), "{yaml}");
        assert!(yaml.contains("origin: [-1.5, 2, 0]\n"), "{yaml}");
    }
}
