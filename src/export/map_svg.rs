//! A candidate's map as a drawing: places, paths in colours, segments, unexplored gateways and dead ends.

use crate::abduction::Candidate;
use crate::export::layout::Layout;
use crate::geometry::{Point, Vector, direction};
use crate::map::{DstateId, Paths, TopologicalMap};
use crate::star::ControlLaw;
use svg::Document;
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Text};

/// User units a segment.
const UNIT: f64 = 150.0;
const MARGIN: f64 = 90.0;
const HEADER: f64 = 56.0;
const PLACE_RADIUS: f64 = 19.0;
const STUB: f64 = 44.0;
/// Okabe and Ito's colours, told apart by colour-blind readers; one a path, in turn.
const COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d00"];
const INK: &str = "#1f2933";
const FAINT: &str = "#7b8794";

/// An SVG document of a map, under a title and one line of explanation.
pub fn map_svg(candidate: &Candidate, title: &str, subtitle: &str) -> String {
    let map = candidate.map.as_ref();
    let sheet = Sheet::new(map);
    let (width, height) = sheet.size();
    let document = Document::new()
        .set("viewBox", (0.0, 0.0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "Inter, 'DejaVu Sans', Helvetica, Arial, sans-serif")
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", "white"))
        .add(label(title, 24.0, 30.0, 17.0, INK).set("font-weight", "600"))
        .add(label(subtitle, 24.0, 50.0, 12.5, FAINT))
        .add(sheet.segments(map))
        .add(sheet.stubs(map))
        .add(sheet.places(candidate))
        .add(label(LEGEND, 24.0, height - 16.0, 11.0, FAINT));
    document.to_string()
}

const LEGEND: &str =
    "one colour a path; dashed: gateway not explored; bar: dead end; ring: open, no control law";

struct Sheet {
    layout: Layout,
    paths: Paths,
    low: Point,
    high: Point,
}

impl Sheet {
    fn new(map: &TopologicalMap) -> Sheet {
        let layout = Layout::of(map);
        let origin = (Point::origin(), Point::origin());
        let (low, high) = map
            .places()
            .map(|place| layout.position(place))
            .fold(origin, |(low, high), at| (low.inf(&at), high.sup(&at)));
        Sheet { layout, paths: Paths::of(map), low, high }
    }

    fn size(&self) -> (f64, f64) {
        let extent = (self.high - self.low) * UNIT;
        ((extent.x + 2.0 * MARGIN).max(560.0), extent.y + 2.0 * MARGIN + HEADER)
    }

    /// From layout units, y upward, to user units, y downward.
    fn at(&self, point: &Point) -> Vector {
        let (width, _) = self.size();
        let left = (width - (self.high.x - self.low.x) * UNIT) / 2.0;
        let offset = (point - self.low) * UNIT;
        Vector::new(left + offset.x, HEADER + MARGIN + (self.high.y - self.low.y) * UNIT - offset.y)
    }

    fn out(&self, dstate: DstateId) -> Vector {
        let facing = direction(self.layout.facing(dstate));
        Vector::new(facing.x, -facing.y)
    }

    fn color(&self, map: &TopologicalMap, dstate: DstateId) -> &'static str {
        COLORS[self.paths.along(map, dstate).path.0 as usize % COLORS.len()]
    }

    /// Segments leave each end in its slot's direction.
    fn segments(&self, map: &TopologicalMap) -> Group {
        let curve = |[from, to]: [DstateId; 2]| {
            let (a, b) =
                (self.at(&self.layout.position(from.place)), self.at(&self.layout.position(to.place)));
            let pull = 0.4 * (b - a).norm().max(0.5 * UNIT);
            let (c, d) = (a + self.out(from) * pull, b + self.out(to) * pull);
            let data = format!("M{} C{} {} {}", pair(&a), pair(&c), pair(&d), pair(&b));
            Path::new().set("d", data).set("stroke", self.color(map, from))
        };
        let group = Group::new().set("fill", "none").set("stroke-width", 6).set("stroke-linecap", "round");
        map.segments().iter().map(|segment| curve(segment.ends)).fold(group, Group::add)
    }

    /// What leads on unexplored, and where paths end.
    fn stubs(&self, map: &TopologicalMap) -> Group {
        let open = map.dstates().filter(|&dstate| map.far_end(dstate).is_none());
        open.fold(Group::new().set("fill", "none").set("stroke-width", 4), |group, dstate| {
            let slot = map.star(dstate.place).slots()[usize::from(dstate.slot.0)];
            let from = self.at(&self.layout.position(dstate.place));
            let out = self.out(dstate);
            let color = self.color(map, dstate);
            if slot.navigable {
                return group.add(line(&from, &(from + out * STUB), color).set("stroke-dasharray", "5 5"));
            }
            let end = from + out * (PLACE_RADIUS + 9.0);
            let group = group.add(line(&from, &end, color));
            if slot.control == ControlLaw::DeadEnd {
                let across = Vector::new(-out.y, out.x) * 9.0;
                group.add(line(&(end - across), &(end + across), color))
            } else {
                let ring = end + out * 5.0;
                group.add(Circle::new().set("cx", ring.x).set("cy", ring.y).set("r", 5).set("stroke", color))
            }
        })
    }

    fn places(&self, candidate: &Candidate) -> Group {
        candidate.map.places().fold(Group::new(), |group, place| {
            let at = self.at(&self.layout.position(place));
            let here = candidate.robot.place == place;
            let circle = Circle::new().set("cx", round(at.x)).set("cy", round(at.y)).set("r", PLACE_RADIUS);
            let circle = circle.set("fill", if here { "#fff3c4" } else { "white" });
            let number = label(&place.index().to_string(), at.x, at.y + 6.0, 17.0, INK);
            group
                .add(circle.set("stroke", INK).set("stroke-width", 2))
                .add(number.set("text-anchor", "middle").set("font-weight", "600"))
        })
    }
}

fn line(from: &Vector, to: &Vector, color: &str) -> Line {
    Line::new()
        .set("x1", round(from.x))
        .set("y1", round(from.y))
        .set("x2", round(to.x))
        .set("y2", round(to.y))
        .set("stroke", color)
}

fn label(text: &str, x: f64, y: f64, size: f64, color: &str) -> Text {
    Text::new(text).set("x", round(x)).set("y", round(y)).set("font-size", size).set("fill", color)
}

fn pair(point: &Vector) -> String {
    format!("{:.1} {:.1}", point.x, point.y)
}

/// Tenths of a unit: finer differences between machines do not show.
fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
