//! A drawing of one extraction: grid, skeleton, gateways, path fragments, and the star listed beside them.

use crate::export::sheet::{COLORS, DOUBTFUL, FAINT, INK, sheet};
use crate::export::visits_svg::least;
use crate::geometry::{Point, Pose, Vector, bearing, direction};
use crate::grid::{Cell, OccupancyGrid};
use crate::star::{ControlLaw, Direction, PlaceDescription, Rejected, Slot};
use svg::node::element::{Circle, Group, Line, Path, Polyline, Rectangle, Text};

/// Side of the map, user units.
const MAP: f64 = 640.0;
/// Width of the listing.
const LISTING: f64 = 460.0;
const PADDING: f64 = 20.0;
const LINE_HEIGHT: f64 = 30.0;
const REMARK_HEIGHT: f64 = 24.0;

/// An SVG document of a described place, the robot's pose in it, and the openings that are no gateways.
pub fn extraction_svg(place: &PlaceDescription, robot: &Pose, rejected: &[Rejected]) -> String {
    extraction_svg_with(place, robot, rejected, &[])
}

/// The same with remarks below, a line each.
pub fn extraction_svg_with(
    place: &PlaceDescription,
    robot: &Pose,
    rejected: &[Rejected],
    remarks: &[String],
) -> String {
    let (width, height) = panel_size(place);
    let remark = |(line, words): (usize, &String)| {
        let below = height + REMARK_HEIGHT * (line as f64 + 0.5);
        Text::new(words).set("font-size", 15).set("fill", DOUBTFUL).set("x", PADDING).set("y", below)
    };
    let sheet = sheet(width, height + REMARK_HEIGHT * remarks.len() as f64);
    let document = sheet.add(panel(place, robot, rejected));
    remarks.iter().enumerate().map(remark).fold(document, |document, line| document.add(line)).to_string()
}

/// Width and height of the drawing of a place, user units.
pub(super) fn panel_size(place: &PlaceDescription) -> (f64, f64) {
    let height = (MAP + 2.0 * PADDING).max(place.star.slots().len() as f64 * LINE_HEIGHT + 130.0);
    (MAP + LISTING + 3.0 * PADDING, height)
}

/// The drawing of a place, its top left corner at the origin.
pub(super) fn panel(place: &PlaceDescription, robot: &Pose, rejected: &[Rejected]) -> Group {
    let view = View::around(&place.grid);
    let group =
        Group::new().add(grid(&place.grid, &view)).add(skeleton(place, &view)).add(fragments(place, &view));
    let group = if rejected.is_empty() { group } else { group.add(openings(rejected, &view)) };
    group.add(gateways(place, &view)).add(robot_mark(robot, &view)).add(scale_bar(&view)).add(listing(place))
}

/// From metres of the LPM frame to user units, y downward.
struct View {
    low: Point,
    scale: f64,
}

impl View {
    /// The view that holds all known cells.
    fn around(grid: &OccupancyGrid) -> Self {
        let known = grid.cells().iter().enumerate().filter(|(_, cell)| **cell != Cell::Unknown);
        let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
        for (i, _) in known {
            let point = grid.info().center(grid.info().index(i));
            (low, high) = (low.inf(&point), high.sup(&point));
        }
        let extent = (high - low).max().max(grid.info().resolution) + 2.0 * grid.info().resolution;
        let middle = nalgebra::center(&low, &high);
        View { low: middle - Vector::new(extent, extent) / 2.0, scale: MAP / extent }
    }

    fn at(&self, point: &Point) -> (f64, f64) {
        let offset = (point - self.low) * self.scale;
        (PADDING + offset.x, PADDING + MAP - offset.y)
    }

    fn line(&self, from: &Point, to: &Point) -> Line {
        let (a, b) = (self.at(from), self.at(to));
        Line::new().set("x1", a.0).set("y1", a.1).set("x2", b.0).set("y2", b.1)
    }

    fn dot(&self, center: &Point, radius: f64) -> Circle {
        let at = self.at(center);
        Circle::new().set("cx", at.0).set("cy", at.1).set("r", radius)
    }
}

fn grid(grid: &OccupancyGrid, view: &View) -> Group {
    let outline = Rectangle::new().set("x", PADDING).set("y", PADDING).set("width", MAP).set("height", MAP);
    let group = Group::new().add(outline.set("fill", "#e4e7eb"));
    let layer = |cell: Cell, color: &str| {
        let path = Path::new().set("d", runs(grid, view, cell)).set("fill", color);
        // Neighbouring runs must not show seams.
        path.set("stroke", color).set("stroke-width", 0.5)
    };
    group.add(layer(Cell::Free, "#ffffff")).add(layer(Cell::Occupied, "#3e4c59"))
}

/// Every horizontal run of one kind of cell as a closed outline.
fn runs(grid: &OccupancyGrid, view: &View, wanted: Cell) -> String {
    let info = grid.info();
    let corner = |x: usize, y: usize| {
        let local = Point::new(x as f64 * info.resolution, y as f64 * info.resolution);
        let at = view.at(&info.origin.transform_point(&local));
        format!("{:.1} {:.1}", at.0, at.1)
    };
    let mut data = String::new();
    for (y, row) in grid.cells().chunks(info.width).enumerate() {
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            let end = x + run.len();
            if run.first() == Some(&wanted) {
                let corners = [corner(x, y), corner(end, y), corner(end, y + 1), corner(x, y + 1)];
                data.push_str(&format!("M{}Z", corners.join("L")));
            }
            x = end;
        }
    }
    data
}

fn skeleton(place: &PlaceDescription, view: &View) -> Group {
    let mut group = Group::new().set("fill", "none").set("stroke", FAINT).set("stroke-width", 1.5);
    for edge in &place.skeleton {
        let points: Vec<String> = edge.iter().map(|point| pair(view.at(point))).collect();
        group = group.add(Polyline::new().set("points", points.join(" ")));
    }
    let circle = view.dot(&place.center, place.clearance * view.scale).set("stroke-dasharray", "2 5");
    group.add(circle).add(view.dot(&place.center, 4.0).set("fill", FAINT))
}

fn pair(at: (f64, f64)) -> String {
    format!("{:.1},{:.1}", at.0, at.1)
}

fn color(fragment: usize) -> &'static str {
    COLORS[fragment % COLORS.len()]
}

fn fragments(place: &PlaceDescription, view: &View) -> Group {
    let mut group = Group::new().set("fill", "none").set("stroke-width", 3).set("stroke-linecap", "round");
    for (i, fragment) in place.fragments.iter().enumerate() {
        let from = &place.gateways[fragment.gateway.0 as usize - 1];
        let partner = fragment.partner.map(|partner| place.gateways[partner.0 as usize - 1].center);
        let Some(to) = partner.or(fragment.projection) else { continue };
        let line = view.line(&from.center, &to).set("stroke", color(i)).set("stroke-opacity", 0.55);
        group = group.add(if partner.is_some() { line } else { line.set("stroke-dasharray", "7 7") });
        if partner.is_none() {
            let (end, across) = (to, Vector::new(-from.outward().y, from.outward().x) * (9.0 / view.scale));
            group = group.add(view.line(&(end + across), &(end - across)).set("stroke", color(i)));
        }
    }
    group
}

fn gateways(place: &PlaceDescription, view: &View) -> Group {
    let mut group = Group::new().set("stroke-width", 4).set("stroke-linecap", "round");
    for (i, gateway) in place.gateways.iter().enumerate() {
        let on = |f: &crate::star::FragmentTrace| {
            [Some(f.gateway), f.partner].contains(&Some(crate::star::GatewayId(i as u32 + 1)))
        };
        let color = color(place.fragments.iter().position(on).unwrap_or(0));
        let unit = gateway.outward() / view.scale;
        let label = view.at(&(gateway.center + unit * 52.0));
        let text = Text::new(format!("{}", i + 1)).set("x", label.0).set("y", label.1 + 6.0);
        let margin = Text::new(percent(gateway.margin)).set("x", label.0).set("y", label.1 + 28.0);
        let margin =
            margin.set("text-anchor", "middle").set("font-size", 14).set("fill", doubt(gateway.margin));
        group = group
            .add(view.line(&gateway.ends[0], &gateway.ends[1]).set("stroke", color))
            .add(arrow(view, &gateway.center, &gateway.outward(), 34.0, color))
            .add(Circle::new().set("cx", label.0).set("cy", label.1).set("r", 12).set("fill", color))
            .add(text.set("text-anchor", "middle").set("font-size", 16).set("fill", "white"))
            .add(margin.set("stroke-width", 0));
    }
    group
}

/// What is too narrow to be a gateway, and by how much.
fn openings(rejected: &[Rejected], view: &View) -> Group {
    let mut group = Group::new().set("stroke-width", 3).set("stroke-dasharray", "2 4");
    for one in rejected {
        let (x, y) = view.at(&one.center);
        let label = Text::new(format!("\u{2212}{}", percent(one.margin))).set("x", x).set("y", y - 8.0);
        let label = label.set("text-anchor", "middle").set("font-size", 14).set("fill", doubt(one.margin));
        let line = view.line(&one.ends[0], &one.ends[1]).set("stroke", doubt(one.margin));
        group = group.add(line).add(label.set("stroke-width", 0));
    }
    group
}

/// An arrow from a point, `length` user units long.
fn arrow(view: &View, from: &Point, along: &Vector, length: f64, color: &str) -> Group {
    let unit = along / view.scale;
    let tip = from + unit * length;
    let barb = |side: f64| pair(view.at(&(tip + direction(bearing(along) + side) * (11.0 / view.scale))));
    let head = format!("{} {} {}", pair(view.at(&tip)), barb(2.6), barb(-2.6));
    let shaft = view.line(from, &(from + unit * (length - 6.0)));
    Group::new()
        .add(shaft.set("stroke", color).set("stroke-width", 3))
        .add(svg::node::element::Polygon::new().set("points", head).set("fill", color))
}

fn robot_mark(robot: &Pose, view: &View) -> Group {
    let radius = (0.25 * view.scale).max(7.0);
    let nose = direction(robot.theta) / view.scale;
    let body = view.dot(&robot.position(), radius).set("fill", "#f0e442").set("stroke", INK);
    let tip = robot.position() + nose * (radius * 1.7);
    let line = view.line(&robot.position(), &tip).set("stroke", INK);
    Group::new().set("stroke-width", 2).add(body).add(line)
}

fn scale_bar(view: &View) -> Group {
    let (x, y) = (PADDING + 14.0, PADDING + MAP - 14.0);
    let bar = Line::new().set("x1", x).set("y1", y).set("x2", x + 2.0 * view.scale).set("y2", y);
    let text = Text::new("2 m").set("x", x).set("y", y - 8.0).set("font-size", 15).set("fill", INK);
    Group::new().add(bar.set("stroke", INK).set("stroke-width", 3)).add(text)
}

fn listing(place: &PlaceDescription) -> Group {
    let left = MAP + 2.0 * PADDING + 10.0;
    let title = Text::new("Small-scale star, clockwise").set("font-size", 20).set("font-weight", "bold");
    let arrived =
        if place.arrival.is_some() { "from the arrival slot" } else { "from the slot the robot faces" };
    let subtitle = Text::new(arrived).set("font-size", 14).set("fill", FAINT);
    let mut group = Group::new()
        .set("fill", INK)
        .set("font-size", 16)
        .add(title.set("x", left).set("y", PADDING + 26.0))
        .add(subtitle.set("x", left).set("y", PADDING + 48.0));
    let (unsure, _) = least(place);
    for (row, slot) in place.star.slots().iter().enumerate() {
        let weight = if row == usize::from(unsure.0) { "bold" } else { "normal" };
        let tint = slot.margin.map_or(FAINT, doubt);
        let y = PADDING + 88.0 + row as f64 * LINE_HEIGHT;
        let color = color(slot.fragment.0 as usize - 1);
        let cell = |text: String, x: f64| Text::new(text).set("x", left + x).set("y", y);
        group = group
            .add(
                Rectangle::new()
                    .set("x", left)
                    .set("y", y - 13.0)
                    .set("width", 6)
                    .set("height", 17)
                    .set("fill", color),
            )
            .add(cell(fragment_name(slot), 16.0).set("font-weight", "bold"))
            .add(cell(gateway_names(slot), 80.0))
            .add(cell(format!("{:?}", slot.control), 252.0).set("font-style", style(slot.control)))
            .add(
                cell(slot.margin.map_or_else(String::new, percent), LISTING - 74.0)
                    .set("text-anchor", "end")
                    .set("font-weight", weight)
                    .set("fill", tint),
            )
            .add(cell(degrees(slot), LISTING - 16.0).set("text-anchor", "end").set("fill", FAINT));
    }
    group
}

fn style(control: ControlLaw) -> &'static str {
    match control {
        ControlLaw::DeadEnd | ControlLaw::None => "italic",
        _ => "normal",
    }
}

fn fragment_name(slot: &Slot) -> String {
    let sign = if slot.direction == Direction::Plus { '+' } else { '\u{2212}' };
    format!("PF{}{sign}", slot.fragment.0)
}

fn gateway_names(slot: &Slot) -> String {
    let names =
        [slot.outward.map(|g| format!("gw{} out", g.0)), slot.inward.map(|g| format!("gw{} in", g.0))];
    names.into_iter().flatten().collect::<Vec<_>>().join(" & ")
}

fn percent(margin: f64) -> String {
    format!("{:.0} %", 100.0 * margin)
}

/// What is within a tenth of being decided otherwise stands out.
fn doubt(margin: f64) -> &'static str {
    if margin < 0.1 { DOUBTFUL } else { FAINT }
}

fn degrees(slot: &Slot) -> String {
    slot.bearing.map_or_else(String::new, |bearing| format!("{:.0}\u{b0}", bearing.to_degrees()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lpm::Lpm;
    use crate::star::{PerceptionParameters, describe};
    use crate::worlds::drawing::{Drawing, window};

    #[test]
    fn every_gateway_and_slot_is_drawn() {
        let tee =
            Drawing::new().corridor((-9.0, 0.0), (9.0, 0.0), 2.0).corridor((0.0, 0.0), (0.0, -9.0), 2.0);
        let robot_pose = Pose::new(0.0, -0.8, 1.6);
        let grid = tee.render(&window(12.0, 0.1, Point::origin(), 0.0), &Point::origin()).unwrap();
        let place = describe(&Lpm::new(grid, robot_pose), &PerceptionParameters::default()).unwrap();
        let ends = [Point::new(-0.3, 1.0), Point::new(0.3, 1.0)];
        let narrow = [Rejected { center: Point::new(0.0, 1.0), ends, passage: 0.6, margin: 0.45 }];
        let picture = extraction_svg(&place, &robot_pose, &narrow);
        for text in ["gw1 out &amp; gw3 in", "DeadEnd", "PF2\u{2212}", "2 m", "\u{2212}45 %"] {
            assert!(picture.contains(text), "{text} is missing");
        }
        assert_eq!(picture.matches("Midline").count(), 3);
        let lines = lines(&picture);
        let [x, _, end, _] = *lines.iter().find(|line| line[1] == PADDING + MAP - 14.0).unwrap();
        let metre = (end - x) / 2.0;
        // Of every gateway and opening a line as long as the scale has it, where it lies as seen from the first: y is up.
        let ends: Vec<[Point; 2]> =
            place.gateways.iter().map(|one| one.ends).chain([narrow[0].ends]).collect();
        let of = |[a, b]: [Point; 2]| {
            let alike = |line: &&[f64; 4]| {
                let across = Vector::new(line[2] - line[0], line[1] - line[3]) / metre;
                (across - (b - a)).norm() < 1e-6
            };
            lines.iter().filter(alike).map(|line| Point::new(line[0], -line[1]) / metre).collect::<Vec<_>>()
        };
        let drawn: Vec<Vec<Point>> = ends.iter().map(|&ends| of(ends)).collect();
        let first = drawn[0][0] - ends[0][0];
        for (ends, starts) in ends.iter().zip(&drawn) {
            assert!(starts.iter().any(|at| (at - ends[0] - first).norm() < 1e-6), "{ends:?}: {starts:?}");
        }
    }

    /// The ends of all lines of a picture, in user units.
    fn lines(picture: &str) -> Vec<[f64; 4]> {
        let number = |line: &str, name: &str| -> Option<f64> {
            line.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0.parse().ok()
        };
        let ends = |line: &str| {
            Some([number(line, "x1")?, number(line, "y1")?, number(line, "x2")?, number(line, "y2")?])
        };
        picture.split("<line").skip(1).filter_map(|line| ends(line.split_once('>')?.0)).collect()
    }
}
