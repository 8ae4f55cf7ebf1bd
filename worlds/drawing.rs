//! Floor plans drawn from simple shapes, and the occupancy grids they give.

use crate::geometry::{Point, Pose, Vector, direction};
use crate::grid::{Cell, CellIndex, GridError, GridInfo, OccupancyGrid};
use std::f64::consts::TAU;

/// A region of the plane, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points within half the width of a straight axis, with square ends.
    Corridor {
        /// One end of the axis.
        from: Point,
        /// The other end of the axis.
        to: Point,
        /// Width across the axis.
        width: f64,
    },
    /// All points within a radius.
    Disc {
        /// The middle.
        center: Point,
        /// The radius.
        radius: f64,
    },
    /// The inside of a closed polygon (even-odd rule).
    Polygon(Vec<Point>),
}

/// A floor plan: the union of its open shapes without its solid shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Where the robot can be.
    pub open: Vec<Shape>,
    /// What stands in the way.
    pub solid: Vec<Shape>,
}

impl Drawing {
    /// A plan without any open space.
    pub fn new() -> Self {
        Drawing::default()
    }

    /// With a corridor from one point to another.
    pub fn corridor(self, from: (f64, f64), to: (f64, f64), width: f64) -> Self {
        let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
        self.with(Shape::Corridor { from, to, width })
    }

    /// With corridors of one width and length that leave a point in the given directions (radians).
    pub fn arms(self, center: (f64, f64), directions: &[f64], length: f64, width: f64) -> Self {
        let from = Point::new(center.0, center.1);
        let arm = |&angle: &f64| Shape::Corridor { from, to: from + direction(angle) * length, width };
        directions.iter().map(arm).fold(self, Drawing::with)
    }

    /// With a round room.
    pub fn disc(self, center: (f64, f64), radius: f64) -> Self {
        self.with(Shape::Disc { center: Point::new(center.0, center.1), radius })
    }

    /// With a rectangular room between two opposite corners.
    pub fn room(self, low: (f64, f64), high: (f64, f64)) -> Self {
        self.with(rectangle(low, high))
    }

    /// With a rectangular block between two opposite corners.
    pub fn block(mut self, low: (f64, f64), high: (f64, f64)) -> Self {
        self.solid.push(rectangle(low, high));
        self
    }

    /// With one more open shape.
    pub fn with(mut self, shape: Shape) -> Self {
        self.open.push(shape);
        self
    }

    /// The same plan moved: `a_from_b` takes the old coordinates to the new.
    pub fn moved(&self, a_from_b: &Pose) -> Drawing {
        self.map(|point| a_from_b.transform_point(&point))
    }

    /// The mirror image on the x-axis.
    pub fn mirrored(&self) -> Drawing {
        self.map(|point| Point::new(point.x, -point.y))
    }

    /// Whether a point is open.
    pub fn contains(&self, point: &Point) -> bool {
        self.open.iter().any(|shape| shape.contains(point))
            && !self.solid.iter().any(|shape| shape.contains(point))
    }

    /// The grid of what can be known from inside: open cells connected to `inside` by their sides are free, cells
    /// touching those are occupied, all else is unknown. A cell is open if its centre is.
    /// Refuses what [`OccupancyGrid::new`] refuses.
    pub fn render(&self, info: &GridInfo, inside: &Point) -> Result<OccupancyGrid, GridError> {
        // Refuses bad sizes before memory is taken for them.
        OccupancyGrid::check(info)?;
        let mut cells = vec![Cell::Unknown; info.width * info.height];
        let mut stack: Vec<CellIndex> = info.cell_at(inside).into_iter().collect();
        while let Some(at) = stack.pop() {
            if cells[info.offset(at)] == Cell::Unknown && self.contains(&info.center(at)) {
                cells[info.offset(at)] = Cell::Free;
                stack.extend(info.neighbors(at, false));
            }
        }
        for i in 0..cells.len() {
            let free = |next: CellIndex| cells[info.offset(next)] == Cell::Free;
            if cells[i] == Cell::Unknown && info.neighbors(info.index(i), true).any(free) {
                cells[i] = Cell::Occupied;
            }
        }
        OccupancyGrid::new(*info, cells)
    }

    fn map(&self, place: impl Fn(Point) -> Point) -> Drawing {
        let all = |shapes: &[Shape]| shapes.iter().map(|shape| shape.map(&place)).collect();
        Drawing { open: all(&self.open), solid: all(&self.solid) }
    }
}

impl Shape {
    /// Whether a point is inside.
    pub fn contains(&self, point: &Point) -> bool {
        match self {
            Shape::Corridor { from, to, width } => {
                let axis: Vector = to - from;
                let along = axis.dot(&(point - from)) / axis.norm();
                let across = axis.perp(&(point - from)) / axis.norm();
                (0.0..=axis.norm()).contains(&along) && across.abs() <= width / 2.0
            }
            Shape::Disc { center, radius } => (point - center).norm() <= *radius,
            Shape::Polygon(corners) => inside_polygon(corners, point),
        }
    }

    fn map(&self, place: &impl Fn(Point) -> Point) -> Shape {
        match self {
            Shape::Corridor { from, to, width } => {
                Shape::Corridor { from: place(*from), to: place(*to), width: *width }
            }
            Shape::Disc { center, radius } => Shape::Disc { center: place(*center), radius: *radius },
            Shape::Polygon(corners) => Shape::Polygon(corners.iter().map(|&corner| place(corner)).collect()),
        }
    }
}

/// A square window of a grid around the origin: `side` metres, its axes turned and its middle shifted.
pub fn window(side: f64, resolution: f64, middle: Point, turned: f64) -> GridInfo {
    let cells = (side / resolution).round() as usize;
    let half = cells as f64 * resolution / 2.0;
    let corner = middle - Pose::new(0.0, 0.0, turned).rotate(&Vector::new(half, half));
    GridInfo { resolution, width: cells, height: cells, origin: Pose::new(corner.x, corner.y, turned) }
}

/// Directions (radians) spread evenly over a full turn.
pub fn evenly(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 * TAU / count as f64).collect()
}

fn rectangle(low: (f64, f64), high: (f64, f64)) -> Shape {
    let corners = [(low.0, low.1), (high.0, low.1), (high.0, high.1), (low.0, high.1)];
    Shape::Polygon(corners.iter().map(|&(x, y)| Point::new(x, y)).collect())
}

fn inside_polygon(corners: &[Point], point: &Point) -> bool {
    let crossed = |(a, b): (&Point, &Point)| {
        (a.y > point.y) != (b.y > point.y) && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
    };
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).filter(|&pair| crossed(pair)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corridor_has_its_width_at_any_rotation() {
        for turned in evenly(7) {
            let plan = Drawing::new().corridor((-9.0, 0.0), (9.0, 0.0), 2.0);
            let plan = plan.moved(&Pose::new(0.0, 0.0, turned));
            let grid = plan.render(&window(8.0, 0.1, Point::origin(), 0.3), &Point::origin()).unwrap();
            let free = grid.cells().iter().filter(|&&cell| cell == Cell::Free).count() as f64 * 0.01;
            assert!((16.0..23.0).contains(&free), "{free} square metres");
        }
    }

    #[test]
    fn only_what_connects_to_the_inside_is_known() {
        let plan = Drawing::new().room((-1.0, -1.0), (1.0, 1.0)).room((2.0, -1.0), (3.0, 1.0));
        let info = window(8.0, 0.1, Point::origin(), 0.0);
        let grid = plan.render(&info, &Point::origin()).unwrap();
        let cell = |x, y| grid.cell(info.cell_at(&Point::new(x, y)).unwrap());
        assert_eq!(cell(0.5, 0.5), Cell::Free);
        assert_eq!(cell(1.05, 0.0), Cell::Occupied);
        assert_eq!(cell(1.55, 0.0), Cell::Unknown);
        assert_eq!(cell(2.5, 0.0), Cell::Unknown);
    }

    #[test]
    fn a_window_of_no_size_or_beyond_all_bounds_is_refused() {
        let plan = Drawing::new().room((-1.0, -1.0), (1.0, 1.0));
        let render =
            |side, resolution| plan.render(&window(side, resolution, Point::origin(), 0.0), &Point::origin());
        for resolution in [0.0, 1e-9, 1e9] {
            assert_eq!(render(8.0, resolution), Err(GridError::Resolution(resolution)));
        }
        for side in [0.0, 8e4] {
            assert!(matches!(render(side, 0.1), Err(GridError::Size { .. })));
        }
    }

    #[test]
    fn blocks_are_solid() {
        let plan = Drawing::new().disc((0.0, 0.0), 2.0).block((-0.5, -0.5), (0.5, 0.5));
        assert!(plan.contains(&Point::new(1.0, 0.0)));
        assert!(!plan.contains(&Point::origin()));
        assert!(!plan.mirrored().contains(&Point::new(0.0, -0.4)));
    }
}
