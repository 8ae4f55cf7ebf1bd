//! A map as a drawing: places, paths in colours, segments, unexplored gateways and dead ends.

use crate::export::sheet::{COLORS, FAINT, INK, sheet};
use crate::export::{GraphDstate, GraphGateway, GraphPlace, GraphSegment, Layout, MapGraph};
use crate::geometry::{Point, Vector, direction};
use crate::trace::wire_star::WireControl;
use svg::node::element::{Circle, Group, Line, Path, Text};

/// User units a segment.
const UNIT: f64 = 150.0;
const MARGIN: f64 = 100.0;
const HEADER: f64 = 56.0;
const PLACE_RADIUS: f64 = 19.0;
const STUB: f64 = 44.0;

/// An SVG document of a map, under a title and one line of explanation.
pub fn map_svg(map: &MapGraph, title: &str, subtitle: &str) -> String {
    let drawing = Drawing::new(map);
    let (width, height) = drawing.size();
    let document = sheet(width, height)
        .add(label(title, 24.0, 30.0, 17.0, INK).set("font-weight", "600"))
        .add(label(subtitle, 24.0, 50.0, 12.5, FAINT))
        .add(drawing.segments())
        .add(drawing.stubs())
        .add(drawing.places())
        .add(label(LEGEND[0], 24.0, height - 32.0, 11.0, FAINT))
        .add(label(LEGEND[1], 24.0, height - 16.0, 11.0, FAINT));
    document.to_string()
}

const LEGEND: [&str; 2] = [
    "one colour a path; dashed: a gateway not explored yet; yellow: the robot",
    "bar: a path ends, blocked; ring: a path ends in the open, where no control law applies",
];

struct Drawing<'a> {
    map: &'a MapGraph,
    layout: Layout,
    low: Point,
    high: Point,
}

impl<'a> Drawing<'a> {
    fn new(map: &'a MapGraph) -> Drawing<'a> {
        let layout = Layout::of(map);
        let (mut low, mut high) = (Point::origin(), Point::origin());
        for place in &map.places {
            let at = layout.position(place.id);
            (low, high) = (low.inf(&at), high.sup(&at));
        }
        Drawing { map, layout, low, high }
    }

    fn size(&self) -> (f64, f64) {
        let extent = (self.high - self.low) * UNIT;
        (round((extent.x + 2.0 * MARGIN).max(620.0)), round(extent.y + 2.0 * MARGIN + HEADER))
    }

    /// From layout units, y upward, to user units, y downward.
    fn at(&self, point: &Point) -> Vector {
        let (width, _) = self.size();
        let left = (width - (self.high.x - self.low.x) * UNIT) / 2.0;
        let offset = (point - self.low) * UNIT;
        Vector::new(left + offset.x, HEADER + MARGIN + (self.high.y - self.low.y) * UNIT - offset.y)
    }

    /// The direction in which a slot is drawn.
    fn out(&self, at: GraphGateway) -> Vector {
        let facing = direction(self.layout.facing(at));
        Vector::new(facing.x, -facing.y)
    }

    fn color(&self, at: GraphGateway) -> &'static str {
        let dstate = &self.map.places[at.place].dstates[usize::from(at.slot)];
        COLORS[dstate.path as usize % COLORS.len()]
    }

    fn segments(&self) -> Group {
        let group = Group::new().set("fill", "none").set("stroke-width", 6).set("stroke-linecap", "round");
        self.map.segments.iter().fold(group, |group, segment| group.add(self.segment(segment)))
    }

    /// A segment leaves each end in its slot's direction.
    fn segment(&self, segment: &GraphSegment) -> Path {
        let [from, to] = segment.ends;
        let (a, b) = (self.at(&self.layout.position(from.place)), self.at(&self.layout.position(to.place)));
        let pull = 0.4 * (b - a).norm().max(0.5 * UNIT);
        let (c, d) = (a + self.out(from) * pull, b + self.out(to) * pull);
        let data = format!("M{} C{} {} {}", pair(&a), pair(&c), pair(&d), pair(&b));
        Path::new().set("d", data).set("stroke", self.color(from))
    }

    /// What leads on unexplored, and where paths end.
    fn stubs(&self) -> Group {
        let group = Group::new().set("fill", "none").set("stroke-width", 4);
        self.map.places.iter().fold(group, |group, place| {
            let open = place.dstates.iter().filter(|dstate| dstate.far_end.is_none());
            open.fold(group, |group, dstate| group.add(self.stub(place, dstate)))
        })
    }

    fn stub(&self, place: &GraphPlace, dstate: &GraphDstate) -> Group {
        let at = GraphGateway { place: place.id, slot: dstate.slot };
        let (from, out, color) = (self.at(&self.layout.position(place.id)), self.out(at), self.color(at));
        if dstate.navigable {
            let way = line(&from, &(from + out * STUB), color).set("stroke-dasharray", "5 5");
            return Group::new().add(way);
        }
        let end = from + out * (PLACE_RADIUS + 9.0);
        let group = Group::new().add(line(&from, &end, color));
        match dstate.control {
            WireControl::DeadEnd => {
                let across = Vector::new(-out.y, out.x) * 9.0;
                group.add(line(&(end - across), &(end + across), color))
            }
            _ => {
                let ring = end + out * 5.0;
                let ring = Circle::new().set("cx", round(ring.x)).set("cy", round(ring.y)).set("r", 5);
                group.add(ring.set("stroke", color))
            }
        }
    }

    fn places(&self) -> Group {
        self.map.places.iter().fold(Group::new(), |group, place| {
            let at = self.at(&self.layout.position(place.id));
            let here = self.map.robot.place == place.id;
            let circle = Circle::new().set("cx", round(at.x)).set("cy", round(at.y)).set("r", PLACE_RADIUS);
            let circle = circle.set("fill", if here { "#ffe08a" } else { "white" });
            let number = label(&place.id.to_string(), at.x, at.y + 6.0, 17.0, INK);
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
