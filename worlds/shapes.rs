//! The drawing of a world file as shapes.

use crate::geometry::Point;
use crate::worlds::drawing::{Drawing, Shape};
use crate::worlds::fault::Fault;
use crate::worlds::format::{WireDrawing, WireShape};

/// The drawing of a file.
pub(super) fn read_drawing(wire: &WireDrawing) -> Result<Drawing, Fault> {
    let all = |shapes: &[WireShape], name: &str| -> Result<Vec<Shape>, Fault> {
        let mut read = Vec::new();
        for (index, shape) in shapes.iter().enumerate() {
            let field =
                |message: &str| Fault { field: format!("drawing.{name}[{index}]"), message: message.into() };
            read.extend(read_shape(shape).map_err(field)?);
        }
        Ok(read)
    };
    Ok(Drawing { open: all(&wire.open, "open")?, solid: all(&wire.solid, "solid")? })
}

fn read_shape(wire: &WireShape) -> Result<Vec<Shape>, &'static str> {
    match wire {
        WireShape { corridor: Some(axis), width: Some(width), disc: None, radius: None, polygon: None } => {
            if axis.len() < 2 || !finite(axis) || !positive(*width) {
                return Err("expected a corridor of two or more finite points and a width above 0");
            }
            if axis.windows(2).any(|pair| pair[0] == pair[1]) {
                return Err("expected a corridor whose points differ");
            }
            Ok(axis.windows(2).map(|pair| stretch(point(&pair[0]), point(&pair[1]), *width)).collect())
        }
        WireShape {
            corridor: None,
            width: None,
            disc: Some(center),
            radius: Some(radius),
            polygon: None,
        } => {
            if !finite(&[*center]) || !positive(*radius) {
                return Err("expected a disc with a finite centre and a radius above 0");
            }
            Ok(vec![Shape::Disc { center: point(center), radius: *radius }])
        }
        WireShape { corridor: None, width: None, disc: None, radius: None, polygon: Some(corners) } => {
            if corners.len() < 3 || !finite(corners) {
                return Err("expected a polygon of three or more finite corners");
            }
            Ok(vec![Shape::Polygon(corners.iter().map(point).collect())])
        }
        _ => Err("expected one of `corridor` and `width`, `disc` and `radius`, or `polygon`"),
    }
}

/// A straight piece of corridor. It reaches half its width beyond both points, so that pieces meeting at a right
/// angle make a full corner.
fn stretch(from: Point, to: Point, width: f64) -> Shape {
    let beyond = (to - from).normalize() * (width / 2.0);
    Shape::Corridor { from: from - beyond, to: to + beyond, width }
}

fn point(at: &[f64; 2]) -> Point {
    Point::new(at[0], at[1])
}

fn finite(points: &[[f64; 2]]) -> bool {
    points.iter().flatten().all(|v| v.is_finite())
}

fn positive(length: f64) -> bool {
    length.is_finite() && length > 0.0
}
