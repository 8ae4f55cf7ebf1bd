//! A world as an SVG: its floor plan, its places and the walk.

use crate::geometry::{Point, direction};
use crate::worlds::drawing::{Drawing, Shape};
use crate::worlds::world::{Exit, Place, PlaceSlot, World};
use svg::Document;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Line, Path, Polygon, Rectangle, Text};

/// User units a metre.
const SCALE: f64 = 12.0;
/// Solid ground around the plan, metres.
const MARGIN: f64 = 3.0;
const SOLID: &str = "#7b8794";
const OPEN: &str = "#ffffff";
/// Okabe and Ito's colours, told apart by colour-blind readers.
const PLACE: &str = "#0072b2";
const WALK: &str = "#d55e00";

/// An SVG document of a world, north up: white is open, dots are places, short lines are their gateways, and the
/// coloured line is the walk from place to place.
pub fn picture(world: &World) -> String {
    let (low, high) = extent(&world.drawing);
    let size = (high - low) * SCALE;
    let document = Document::new()
        .set("viewBox", (0.0, 0.0, size.x, size.y))
        .set("width", size.x)
        .set("height", size.y)
        .set("font-family", "Inter, 'DejaVu Sans', Helvetica, Arial, sans-serif");
    let to_page = |point: &Point| ((point.x - low.x) * SCALE, (high.y - point.y) * SCALE);
    let ground = Rectangle::new().set("width", size.x).set("height", size.y).set("fill", SOLID);
    document
        .add(ground)
        .add(shapes(&world.drawing.open, OPEN, &to_page))
        .add(shapes(&world.drawing.solid, SOLID, &to_page))
        .add(walk(world, &to_page))
        .add(places(world, &to_page))
        .to_string()
}

fn shapes(shapes: &[Shape], fill: &str, to_page: &impl Fn(&Point) -> (f64, f64)) -> Group {
    let mut group = Group::new().set("fill", fill);
    for shape in shapes {
        group = match shape {
            Shape::Disc { center, radius } => {
                let (x, y) = to_page(center);
                group.add(Circle::new().set("cx", x).set("cy", y).set("r", radius * SCALE))
            }
            _ => group.add(Polygon::new().set("points", listed(&corners(shape), to_page))),
        };
    }
    group
}

/// From place to place through the gateways.
fn walk(world: &World, to_page: &impl Fn(&Point) -> (f64, f64)) -> Path {
    let visits = world.visits();
    let mut way = Data::new();
    if let Some(first) = visits.first() {
        way = way.move_to(to_page(&world.places[first.place].at));
    }
    for (here, next) in visits.iter().zip(visits.iter().skip(1)) {
        let (from, to) = (&world.places[here.place], &world.places[next.place]);
        let Some(out) = here.departure.map(|slot| &from.slots[slot.0 as usize]) else { continue };
        let entry = &to.slots[to.slots[next.arrival.0 as usize].opposite.0 as usize];
        let end = gateway(to, entry);
        way = way.line_to(to_page(&gateway(from, out)));
        if let Some((turn_in, turn_out, radius, left)) = bend(from, out, to, entry) {
            let (x, y) = to_page(&turn_out);
            let arc = (radius * SCALE, radius * SCALE, 0.0, 0.0, if left { 0.0 } else { 1.0 }, x, y);
            way = way.line_to(to_page(&turn_in)).elliptical_arc_to(arc);
        }
        way = way.line_to(to_page(&end)).line_to(to_page(&to.at));
    }
    Path::new()
        .set("d", way)
        .set("fill", "none")
        .set("stroke", WALK)
        .set("stroke-opacity", 0.5)
        .set("stroke-width", 0.5 * SCALE)
}

/// The arc that a way takes between two gateways that do not face each other: where it starts and ends, its
/// radius, and whether it turns left. It begins or ends at one of the two gateways.
fn bend(from: &Place, out: &PlaceSlot, to: &Place, entry: &PlaceSlot) -> Option<(Point, Point, f64, bool)> {
    let (start, end) = (gateway(from, out), gateway(to, entry));
    let (ahead, back) = (direction(out.bearing), direction(entry.bearing));
    let turn = ahead.perp(&back);
    let (s, t) = ((end - start).perp(&back) / turn, (end - start).perp(&ahead) / turn);
    let meets = turn.abs() > 1e-6 && s > 0.0 && t > 0.0;
    let tangent = s.min(t);
    let corner = start + ahead * s;
    let half_angle = ahead.dot(&back).clamp(-1.0, 1.0).acos() / 2.0;
    meets.then(|| (corner - ahead * tangent, corner - back * tangent, tangent * half_angle.tan(), turn < 0.0))
}

fn places(world: &World, to_page: &impl Fn(&Point) -> (f64, f64)) -> Group {
    let mut group = Group::new().set("fill", PLACE).set("stroke", PLACE).set("font-size", 1.6 * SCALE);
    for place in &world.places {
        for slot in place.slots.iter().filter(|slot| slot.exit != Exit::Closed) {
            let middle = gateway(place, slot);
            let along = direction(slot.bearing + std::f64::consts::FRAC_PI_2);
            let ((x1, y1), (x2, y2)) = (to_page(&(middle - along)), to_page(&(middle + along)));
            let line = Line::new().set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2);
            group = group.add(line.set("stroke-width", 0.2 * SCALE));
        }
        let (x, y) = to_page(&place.at);
        let label = Text::new(&place.name).set("x", x + 0.6 * SCALE).set("y", y - 0.6 * SCALE);
        group = group
            .add(Circle::new().set("cx", x).set("cy", y).set("r", 0.5 * SCALE))
            .add(label.set("stroke", "none"));
    }
    group
}

fn gateway(place: &Place, slot: &PlaceSlot) -> Point {
    place.at + direction(slot.bearing) * slot.reach
}

fn extent(drawing: &Drawing) -> (Point, Point) {
    let margin = direction(std::f64::consts::FRAC_PI_4) * MARGIN * std::f64::consts::SQRT_2;
    let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
    for corner in drawing.open.iter().flat_map(corners) {
        (low, high) = (low.inf(&corner), high.sup(&corner));
    }
    (low - margin, high + margin)
}

/// The corners of a shape; of a disc those of the square around it.
fn corners(shape: &Shape) -> Vec<Point> {
    match shape {
        Shape::Corridor { from, to, width } => {
            let along = (to - from).normalize() * (width / 2.0);
            let across = nalgebra::Vector2::new(-along.y, along.x);
            vec![from - across, to - across, to + across, from + across]
        }
        Shape::Disc { center, radius } => {
            let side = nalgebra::Vector2::new(*radius, 0.0);
            let up = nalgebra::Vector2::new(0.0, *radius);
            vec![center - side - up, center + side - up, center + side + up, center - side + up]
        }
        Shape::Polygon(corners) => corners.clone(),
    }
}

fn listed(points: &[Point], to_page: &impl Fn(&Point) -> (f64, f64)) -> String {
    let texts: Vec<String> = points
        .iter()
        .map(|point| {
            let (x, y) = to_page(point);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    texts.join(" ")
}
