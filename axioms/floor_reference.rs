//! What cannot be on one floor, by the definitions: places nearer to each other than places are, ways that cross, ways that lead
//! past a place.

use crate::measured_reference::Told;
use nalgebra::Vector3;
use topostar::geometry::{Point, Pose, Vector};

/// A path segment as first travelled: the visits, their places, how far the robot strayed from the straight line between.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    visits: [usize; 2],
    places: [usize; 2],
    stray: f64,
}

/// Two things that are not to be in each other's way, by visits.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Obstacle {
    /// Two lines, each with how far from it a way may be.
    Crossing([([usize; 2], f64); 2]),
    /// A line, how near to it a visit may not be, and the visit.
    Passing([usize; 2], f64, usize),
}

/// The ways of a story: every travel, if none before it went along the same segment.
fn ways(told: &Told<'_>) -> Vec<Way> {
    let new = |&to: &usize| (1..to).all(|before| told.ends(before) != told.ends(to));
    let way = |to: usize| {
        let visits = [to - 1, to];
        Way { visits, places: visits.map(|visit| told.story[visit].0), stray: stray(told, to) }
    };
    (1..=told.latest()).filter(new).map(way).collect()
}

/// By every point that the trace tells, and by what a heading may have bent a way that looks straight.
fn stray(told: &Told<'_>, to: usize) -> f64 {
    let (before, motion) = (&told.seen[to - 1], told.seen[to].motion.as_ref().unwrap());
    let end = told.travel(to, &Vector3::zeros(), &Vector3::zeros()).position().coords;
    let start = Pose::new(motion.start.x, motion.start.y, motion.heading.unwrap());
    let from_line = |point: &Point| {
        let at: Vector = start.transform_point(point) - before.middle;
        (end.x * at.y - end.y * at.x).abs() / end.norm()
    };
    let bent = told.bounds.sigmas * end.norm() * motion.covariance[8].sqrt() / 48f64.sqrt();
    motion.shape.iter().map(from_line).fold(0.0, f64::max) + bent
}

/// All that may be in each other's way.
pub(crate) fn obstacles(told: &Told<'_>) -> Vec<Obstacle> {
    let ways = ways(told);
    let mut found = Vec::new();
    for (k, one) in ways.iter().enumerate() {
        for other in &ways[..k] {
            if one.places.iter().all(|place| !other.places.contains(place)) {
                found.push(Obstacle::Crossing([one, other].map(|way| (way.visits, way.stray))));
            }
        }
        let near = told.bounds.clearance - one.stray;
        let first = |&visit: &usize| told.first(told.story[visit].0) == visit;
        for visit in (0..=told.latest()).filter(first) {
            if near > 0.0 && !one.places.contains(&told.story[visit].0) {
                found.push(Obstacle::Passing(one.visits, near, visit));
            }
        }
    }
    found
}

impl Obstacle {
    /// By how much errors have to move one of the two at least, where visits lie so, as far as the nearest way out goes; nought
    /// where they are out of each other's way. Metres.
    pub(crate) fn lacks(&self, poses: &[Pose]) -> f64 {
        let at = |visit: usize| poses[visit].position();
        let seen = |[from, to]: [usize; 2], visit: usize| {
            let (line, off) = (at(to) - at(from), at(visit) - at(from));
            let length = line.norm();
            (line.dot(&off) / length, (line.x * off.y - line.y * off.x) / length, length)
        };
        let out = match *self {
            Obstacle::Crossing(lines) => {
                let aside = |(line, stray): ([usize; 2], f64), ends: [usize; 2]| {
                    let off = ends.map(|end| seen(line, end).1);
                    (-stray - off[0].min(off[1])).min(off[0].max(off[1]) - stray)
                };
                aside(lines[0], lines[1].0).min(aside(lines[1], lines[0].0))
            }
            Obstacle::Passing(line, near, visit) => {
                let (along, aside, length) = seen(line, visit);
                (near - aside.abs()).min(along).min(length - along)
            }
        };
        out.max(0.0)
    }

    /// The same for one of four ways out.
    pub(crate) fn lacks_on(&self, way: usize, poses: &[Pose]) -> f64 {
        let at = |visit: usize| poses[visit].position();
        let sign = if way.is_multiple_of(2) { 1.0 } else { -1.0 };
        let aside = |[from, to]: [usize; 2], visit: usize| {
            let (line, off) = (at(to) - at(from), at(visit) - at(from));
            sign * (line.x * off.y - line.y * off.x) / line.norm()
        };
        let out = match *self {
            Obstacle::Crossing(lines) => {
                let (line, stray) = lines[way / 2];
                let off = lines[1 - way / 2].0.map(|end| aside(line, end));
                -stray - off[0].min(off[1])
            }
            Obstacle::Passing(line, near, visit) if way < 2 => near - aside(line, visit),
            Obstacle::Passing([from, to], _, visit) => {
                let (line, off) = (at(to) - at(from), at(visit) - at(from));
                let along = line.dot(&off) / line.norm();
                if way == 2 { along } else { line.norm() - along }
            }
        };
        out.max(0.0)
    }
}
