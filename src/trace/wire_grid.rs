//! The JSON form of a grid: ROS `info` and cells as a list, as base64 bytes or as a base64 PNG.

use crate::geometry::{Point, Pose};
use crate::grid::{Cell, GridError, GridInfo, OccupancyGrid};
use crate::lpm::Lpm;
use crate::trace::event_error::EventError;
use crate::trace::object;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The most cells a side of a posted grid may have.
pub const MAX_POSTED_SIDE: u64 = 2048;
/// The most points a posted trail or the shape of a travel may have: six kilometres in steps of 10 cm.
pub const MAX_POSTED_POINTS: usize = 65_536;

/// A local perceptual model. Row 0 is the bottom row, x is fastest; -1 unknown, 0 free, 100 occupied.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Lpm)]
#[serde(deny_unknown_fields)]
pub struct WireLpm {
    /// Size, scale and place of the grid.
    #[serde(deserialize_with = "object::one")]
    pub info: WireGridInfo,
    /// Cells as a list of numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<Vec<i16>>,
    /// Cells as base64 of signed bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data_b64: Option<String>,
    /// Cells as base64 of a greyscale PNG in the greys of `map_server`: 0 occupied, 205 unknown, 254 free.
    /// An image's first row is the top row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub png_b64: Option<String>,
    /// Where the robot has driven around the place, before and after the arrival, points in the frame of the grid,
    /// metres: there is a way, however narrow.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trail: Vec<[f64; 2]>,
    /// The middle of the place in the frame of the grid, metres, where the robot found it before; else the place is
    /// looked for around the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub middle: Option<[f64; 2]>,
}

/// `nav_msgs/MapMetaData` without its load time.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = GridInfo)]
#[serde(deny_unknown_fields)]
pub struct WireGridInfo {
    /// Metres per cell.
    pub resolution: f64,
    /// Columns.
    pub width: u64,
    /// Rows.
    pub height: u64,
    /// Pose of the bottom-left corner of cell (0, 0).
    #[serde(default, deserialize_with = "object::one")]
    pub origin: WireOrigin,
    /// Accepted from ROS and ignored.
    #[serde(default, skip_serializing)]
    #[schema(ignore)]
    pub map_load_time: Option<serde::de::IgnoredAny>,
}

/// A planar pose, as ROS spells it or in short.
#[derive(Clone, Debug, Default, Serialize, Deserialize, ToSchema)]
#[schema(as = Origin)]
#[serde(deny_unknown_fields)]
pub struct WireOrigin {
    /// ROS: where.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub position: Option<WirePosition>,
    /// ROS: which way; a unit quaternion about z.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub orientation: Option<WireQuaternion>,
    /// Short: metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// Short: metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// Short: radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta: Option<f64>,
}

/// `geometry_msgs/Point`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Position)]
#[serde(deny_unknown_fields)]
pub struct WirePosition {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Metres; ignored.
    #[serde(default)]
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Quaternion)]
#[serde(deny_unknown_fields)]
pub struct WireQuaternion {
    /// 0 for a planar pose.
    #[serde(default)]
    pub x: f64,
    /// 0 for a planar pose.
    #[serde(default)]
    pub y: f64,
    /// sin of half the heading.
    pub z: f64,
    /// cos of half the heading.
    pub w: f64,
}

impl WireLpm {
    /// The grid with the robot's pose in it.
    pub fn lpm(self, robot_pose: Pose, at: &str) -> Result<Lpm, EventError> {
        check_points(self.trail.len(), &format!("{at}/trail"))?;
        let trail = self.trail.iter().map(|&[x, y]| Point::new(x, y)).collect();
        let middle = self.middle.map(|[x, y]| Point::new(x, y));
        Ok(Lpm { grid: self.grid(at)?, robot_pose, trail, middle })
    }

    /// The grid; errors point below `at`.
    pub fn grid(self, at: &str) -> Result<OccupancyGrid, EventError> {
        let info = self.info.grid_info(at)?;
        let grid = |values: &[i8], field: &str| {
            OccupancyGrid::from_occupancy(info, values)
                .map_err(|e| EventError::new(format!("{at}/{field}"), e.to_string()))
        };
        match (self.data, self.data_b64, self.png_b64) {
            (Some(data), None, None) => grid(&values_of(&data), "data"),
            (None, Some(text), None) => {
                let bytes = decode(&text, &format!("{at}/data_b64"))?;
                grid(&bytes.iter().map(|&b| b as i8).collect::<Vec<_>>(), "data_b64")
            }
            (None, None, Some(text)) => {
                let pointer = format!("{at}/png_b64");
                let cells =
                    png_cells(&decode(&text, &pointer)?, &info).map_err(|m| EventError::new(&pointer, m))?;
                OccupancyGrid::new(info, cells).map_err(|e| EventError::new(pointer, e.to_string()))
            }
            (None, None, None) => {
                Err(EventError::new(at, "has no cells, expected data, data_b64 or png_b64"))
            }
            _ => Err(EventError::new(
                at,
                "has cells in more than one form, expected one of data, data_b64, png_b64",
            )),
        }
    }

    /// The JSON form of an LPM without its robot pose, cells as base64 bytes.
    pub fn from_lpm(Lpm { grid, trail, middle, .. }: &Lpm) -> WireLpm {
        let bytes: Vec<u8> = grid.to_occupancy().iter().map(|&v| v as u8).collect();
        WireLpm {
            info: WireGridInfo::of(grid.info()),
            data: None,
            data_b64: Some(STANDARD.encode(bytes)),
            png_b64: None,
            trail: trail.iter().map(|point| [point.x, point.y]).collect(),
            middle: middle.map(|point| [point.x, point.y]),
        }
    }
}

/// Refuses more points of a way than are taken.
pub(super) fn check_points(points: usize, at: &str) -> Result<(), EventError> {
    let many = || {
        format!(
            "has {points} points, expected up to {MAX_POSTED_POINTS}; leave out those that are near others"
        )
    };
    if points > MAX_POSTED_POINTS { Err(EventError::new(at, many())) } else { Ok(()) }
}

impl WireGridInfo {
    /// The JSON form.
    pub fn of(info: &GridInfo) -> WireGridInfo {
        WireGridInfo {
            resolution: info.resolution,
            width: info.width as u64,
            height: info.height as u64,
            origin: WireOrigin::from_pose(&info.origin),
            map_load_time: None,
        }
    }

    fn grid_info(&self, at: &str) -> Result<GridInfo, EventError> {
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_POSTED_SIDE).contains(&side) {
                return Err(EventError::new(
                    format!("{at}/info/{name}"),
                    format!("is {side}, expected 1 to {MAX_POSTED_SIDE} cells"),
                ));
            }
        }
        let origin = self.origin.pose().map_err(|m| EventError::new(format!("{at}/info/origin"), m))?;
        let info = GridInfo {
            resolution: self.resolution,
            width: self.width as usize,
            height: self.height as usize,
            origin,
        };
        OccupancyGrid::check(&info).map_err(|error| {
            let field = if error == GridError::Origin { "origin" } else { "resolution" };
            EventError::new(format!("{at}/info/{field}"), error.to_string())
        })?;
        Ok(info)
    }
}

impl WireOrigin {
    fn pose(&self) -> Result<Pose, String> {
        let ros = self.position.is_some() || self.orientation.is_some();
        let short = self.x.is_some() || self.y.is_some() || self.theta.is_some();
        if ros && short {
            return Err("mixes position/orientation with x/y/theta, expected one of the two spellings".into());
        }
        if short {
            return Ok(Pose::new(self.x.unwrap_or(0.0), self.y.unwrap_or(0.0), self.theta.unwrap_or(0.0)));
        }
        let (x, y) = self.position.map_or((0.0, 0.0), |p| (p.x, p.y));
        Ok(Pose::new(x, y, self.orientation.map_or(Ok(0.0), yaw)?))
    }

    fn from_pose(pose: &Pose) -> WireOrigin {
        let half = pose.theta / 2.0;
        WireOrigin {
            position: Some(WirePosition { x: pose.x, y: pose.y, z: 0.0 }),
            orientation: Some(WireQuaternion { x: 0.0, y: 0.0, z: half.sin(), w: half.cos() }),
            ..WireOrigin::default()
        }
    }
}

fn yaw(q: WireQuaternion) -> Result<f64, String> {
    let norm = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if norm == 0.0 {
        return Err("has an all-zero quaternion; did you mean w = 1?".into());
    }
    if (norm - 1.0).abs() > 1e-3 {
        return Err(format!("has a quaternion of norm {norm}, expected 1"));
    }
    if q.x.abs() > 5e-3 || q.y.abs() > 5e-3 {
        return Err("rolls or pitches, expected a rotation about z only".into());
    }
    Ok((2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
}

/// Values outside -1..=100 are unknown to ROS readers; a byte holds no others that mean anything.
fn values_of(data: &[i16]) -> Vec<i8> {
    data.iter().map(|&v| i8::try_from(v).unwrap_or(-1)).collect()
}

fn decode(text: &str, pointer: &str) -> Result<Vec<u8>, EventError> {
    STANDARD.decode(text).map_err(|e| EventError::new(pointer, format!("is not base64: {e}")))
}

fn png_cells(bytes: &[u8], info: &GridInfo) -> Result<Vec<Cell>, String> {
    let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), image::ImageFormat::Png);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(info.width as u32);
    limits.max_image_height = Some(info.height as u32);
    reader.limits(limits);
    let image = reader
        .decode()
        .map_err(|e| format!("is not a PNG of {} x {} pixels: {e}", info.width, info.height))?;
    let grey = image.into_luma8();
    if (grey.width() as usize, grey.height() as usize) != (info.width, info.height) {
        return Err(format!(
            "is {} x {} pixels, expected {} x {} as in info",
            grey.width(),
            grey.height(),
            info.width,
            info.height
        ));
    }
    let rows = grey.rows().rev().flat_map(|row| row.map(|pixel| Cell::from_grey(pixel.0[0])));
    Ok(rows.collect())
}
