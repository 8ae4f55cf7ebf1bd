//! What cannot be on one floor, by the definitions: places nearer to each other than places are, ways that cross, ways that lead
//! past a place.

use crate::measured_reference::Told;
use nalgebra::Vector3;
use topostar::geometry::{Pose, Vector};

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
    /// A line, how near to it a visit may not be but next to its ends, how far these reach, and the visit.
    Passing { line: [usize; 2], near: f64, ends: f64, visit: usize },
}

/// The ways of a story: every travel, if none before it went along the same segment.
fn ways(told: &Told<'_>, separation: f64) -> Vec<Way> {
    let new = |&to: &usize| (1..to).all(|before| told.ends(before) != told.ends(to));
    let way = |to: usize| {
        let visits = [to - 1, to];
        Way { visits, places: visits.map(|visit| told.story[visit].0), stray: stray(told, to) }
    };
    let far = |way: &Way| {
        let line = told.travel(way.visits[1], &Vector3::zeros(), &Vector3::zeros());
        line.x.hypot(line.y) >= separation.min(1.0)
    };
    (1..=told.latest()).filter(new).map(way).filter(far).collect()
}

/// By every point that the trace tells, and by what a heading may have bent of the way, and turned of the line.
fn stray(told: &Told<'_>, to: usize) -> f64 {
    let (before, motion) = (&told.seen[to - 1], told.seen[to].motion.as_ref().unwrap());
    let end = told.travel(to, &Vector3::zeros(), &Vector3::zeros()).position().coords;
    let start = Pose::new(motion.start.x, motion.start.y, motion.heading.unwrap());
    let way: Vec<Vector> =
        motion.shape.iter().map(|point| start.transform_point(point) - before.middle).collect();
    let from_line = |at: &Vector| (end.x * at.y - end.y * at.x).abs() / end.norm();
    let pieces: f64 = (1..way.len()).map(|k| (way[k] - way[k - 1]).norm()).sum();
    let length = pieces.max(end.norm());
    let bent = length * length / end.norm() * motion.covariance[8].sqrt() / 48f64.sqrt();
    let started = if motion.start_given { 0.0 } else { told.bounds.extent_sigma };
    way.iter().map(from_line).fold(0.0, f64::max) + told.bounds.sigmas * (bent + started)
}

/// All that may be in each other's way, where places are so far apart.
pub(crate) fn obstacles(told: &Told<'_>, separation: f64) -> Vec<Obstacle> {
    let ways = ways(told, separation);
    let clearance = separation / 2.0 - told.bounds.sigmas * told.bounds.extent_sigma;
    let mut found = Vec::new();
    for (k, one) in ways.iter().enumerate() {
        for other in &ways[..k] {
            if one.places.iter().all(|place| !other.places.contains(place)) {
                found.push(Obstacle::Crossing([one, other].map(|way| (way.visits, way.stray))));
            }
        }
        let near = clearance - one.stray;
        let first = |&visit: &usize| told.first(told.story[visit].0) == visit;
        for visit in (0..=told.latest()).filter(first) {
            if near > 0.0 && !one.places.contains(&told.story[visit].0) {
                found.push(Obstacle::Passing { line: one.visits, near, ends: clearance, visit });
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
            Obstacle::Passing { line, near, ends, visit } => {
                let (along, aside, length) = seen(line, visit);
                (near - aside.abs()).min(along - ends).min(length - ends - along)
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
            Obstacle::Passing { line, near, visit, .. } if way < 2 => near - aside(line, visit),
            Obstacle::Passing { line: [from, to], ends, visit, .. } => {
                let (line, off) = (at(to) - at(from), at(visit) - at(from));
                let along = line.dot(&off) / line.norm();
                if way == 2 { along - ends } else { line.norm() - ends - along }
            }
        };
        out.max(0.0)
    }
}
