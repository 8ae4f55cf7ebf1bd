//! Path segments as lines on the floor: they cross nowhere, and lead past no place that is not one of their own.
//!
//! The robot went along each, and told the way. Between two places it strayed from the straight line by so much at most; so
//! where two such strips cross from side to side, the ways within them have met (an arc that joins two opposite sides of a
//! parallelogram meets every arc that joins the other two). On one floor ways meet at places alone, as the axiom of
//! planarity has it of the map. From where it starts in a place to the middle of it nothing else leads through.

use crate::geometry::Pose;
use crate::metric::bound::{Bound, Edge};
use crate::metric::frames::Story;
use std::collections::BTreeSet;

/// Segments whose ends are nearer to each other than this are lines without a direction, metres.
const SHORTEST: f64 = 1.0;

/// A path segment, as first travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// The visits it was travelled between, and their places.
    pub(super) visits: [usize; 2],
    pub(super) places: [usize; 2],
    /// How far the way strayed from the straight line between the visits, at most, metres.
    pub(super) stray: f64,
}

/// What cannot be on one floor, of the segments and first visits to places by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Obstruction {
    /// Two segments cross.
    Crossing { one: usize, other: usize },
    /// A segment leads past a place.
    Passing { segment: usize, visit: usize },
}

/// How an obstruction is none: of four ways one has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Clear {
    /// Both ends of a segment lie on one side of another, or within its strip.
    Aside { segment: usize, other: usize, left: bool },
    /// A place lies on one side of a segment, beyond the clearance.
    Off { segment: usize, visit: usize, left: bool },
    /// A place lies beyond one of a segment's ends.
    Past { segment: usize, visit: usize, forwards: bool },
}

/// The segments travelled since a visit, and the first visits to places.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    pub(super) all: Vec<Segment>,
    /// The first visits, each with its place.
    pub(super) firsts: Vec<(usize, usize)>,
    /// How near to a place no way leads but to it, metres.
    pub(super) clearance: f64,
}

impl Segments {
    /// Those of a story whose ways the trace told, among first visits to places. No travel but a measured one leads to a visit
    /// after the first of these.
    ///
    /// A place is a neighbourhood, as wide as places are apart at least: who comes within half of that comes to it. The middles
    /// of places are found to within so much on each visit.
    pub(super) fn new(story: &Story<'_>, firsts: &[usize], separation: f64) -> Segments {
        let parameters = story.parameters;
        let since = firsts.first().map_or(story.latest(), |&first| first);
        let mut known = BTreeSet::new();
        let mut segment = |visit: usize| {
            let mut ends = story.ends(visit)?;
            ends.sort_unstable();
            let travelled = story.stays[visit].travelled?;
            // Of a line that is shorter errors turn the ends around.
            let stray = travelled.stray.filter(|_| travelled.length >= separation.min(SHORTEST))?;
            let visits = [visit - 1, visit];
            known.insert(ends).then(|| Segment {
                visits,
                places: visits.map(|visit| story.place(visit)),
                stray,
            })
        };
        Segments {
            all: (since + 1..=story.latest()).filter_map(&mut segment).collect(),
            firsts: firsts.iter().map(|&visit| (visit, story.place(visit))).collect(),
            clearance: separation / 2.0 - parameters.sigmas * parameters.extent_sigma,
        }
    }

    /// What obstructs what where visits lie so, by more than `met` metres. Quadratic in the segments.
    pub(super) fn obstructions(&self, poses: &[Pose], met: f64) -> Vec<Obstruction> {
        let pairs = (0..self.all.len())
            .flat_map(|one| (0..one).map(move |other| Obstruction::Crossing { one, other }));
        let passing =
            |segment| self.firsts.iter().map(move |&(visit, _)| Obstruction::Passing { segment, visit });
        let all = pairs.chain((0..self.all.len()).flat_map(passing));
        let blocked = |one: &Obstruction| {
            self.is_near(one, poses) && self.bears(one) && !self.is_clear(one, poses, met)
        };
        all.filter(blocked).collect()
    }

    /// Whether the rectangles around both, with the clearance of a place, have a point in common: straight lines that cross do, and
    /// what is in nobody's strip is clear.
    fn is_near(&self, obstruction: &Obstruction, poses: &[Pose]) -> bool {
        let ends = |segment: usize| self.all[segment].visits;
        let (one, other, by) = match *obstruction {
            Obstruction::Crossing { one, other } => (ends(one), ends(other), 0.0),
            Obstruction::Passing { segment, visit } => (ends(segment), [visit; 2], self.clearance),
        };
        let meet = |along: fn(&Pose) -> f64| {
            let [(a, b), (c, d)] = [one, other].map(|ends| {
                let [from, to] = ends.map(|end| along(&poses[end]));
                (from.min(to), from.max(to))
            });
            a <= d + by && c <= b + by
        };
        meet(|pose| pose.x) && meet(|pose| pose.y)
    }

    /// The ways to be clear of an obstruction.
    pub(super) fn ways(&self, obstruction: &Obstruction) -> [Clear; 4] {
        match *obstruction {
            Obstruction::Crossing { one, other } => {
                let aside = |segment, other, left| Clear::Aside { segment, other, left };
                [
                    aside(one, other, true),
                    aside(one, other, false),
                    aside(other, one, true),
                    aside(other, one, false),
                ]
            }
            Obstruction::Passing { segment, visit } => [
                Clear::Off { segment, visit, left: true },
                Clear::Off { segment, visit, left: false },
                Clear::Past { segment, visit, forwards: true },
                Clear::Past { segment, visit, forwards: false },
            ],
        }
    }

    /// What it is to be clear of an obstruction in one way: all of some bounds.
    pub(super) fn bounds(&self, way: &Clear) -> Vec<Bound> {
        match *way {
            Clear::Aside { segment, other, left } => {
                let Segment { visits: line, stray, .. } = self.all[segment];
                self.all[other]
                    .visits
                    .map(|visit| Bound { edge: Edge::Along { line, left }, visit, by: -stray })
                    .into()
            }
            Clear::Off { segment, visit, left } => {
                let Segment { visits: line, stray, .. } = self.all[segment];
                vec![Bound { edge: Edge::Along { line, left }, visit, by: self.clearance - stray }]
            }
            Clear::Past { segment, visit, forwards } => {
                let [from, to] = self.all[segment].visits;
                let line = if forwards { [from, to] } else { [to, from] };
                // Next to its ends the robot is at other places, of which it is not told how far they reach.
                vec![Bound { edge: Edge::Past { line }, visit, by: -self.clearance }]
            }
        }
    }

    /// Whether the two have nothing to do with each other on the map, and one can be in the way of the other on the floor.
    fn bears(&self, obstruction: &Obstruction) -> bool {
        match *obstruction {
            Obstruction::Crossing { one, other } => {
                let [one, other] = [one, other].map(|segment| self.all[segment].places);
                !one.iter().any(|place| other.contains(place))
            }
            Obstruction::Passing { segment, visit } => {
                let Segment { places, stray, .. } = self.all[segment];
                let own = |&(first, place): &(usize, usize)| first == visit && places.contains(&place);
                stray < self.clearance && !self.firsts.iter().any(own)
            }
        }
    }

    /// Whether a visit is part of it.
    pub(super) fn concerns(&self, obstruction: &Obstruction, visit: usize) -> bool {
        let led = |segment: usize| self.all[segment].visits[1] == visit;
        match *obstruction {
            Obstruction::Crossing { one, other } => led(one) || led(other),
            Obstruction::Passing { segment, visit: passed } => led(segment) || passed == visit,
        }
    }

    fn is_clear(&self, obstruction: &Obstruction, poses: &[Pose], met: f64) -> bool {
        let holds = |way: &Clear| self.bounds(way).iter().all(|bound| bound.within(poses) >= -met);
        self.ways(obstruction).iter().any(holds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use proptest::prelude::*;

    /// A way from one point to another that strays from the straight line to either side, with sharp corners.
    fn way(ends: [Point; 2], strays: &[f64]) -> Vec<Point> {
        let along: Vector = ends[1] - ends[0];
        let aside = Vector::new(-along.y, along.x).normalize();
        let corner = |(k, stray): (usize, &f64)| {
            ends[0] + along * ((k + 1) as f64 / (strays.len() + 1) as f64) + aside * *stray
        };
        [ends[0]].into_iter().chain(strays.iter().enumerate().map(corner)).chain([ends[1]]).collect()
    }

    /// Whether two ways meet, piece by piece.
    fn meet(one: &[Point], other: &[Point]) -> bool {
        let side = |a: &Point, b: &Point, c: &Point| (b - a).perp(&(c - a));
        let cross = |a: &[Point], b: &[Point]| {
            side(&a[0], &a[1], &b[0]) * side(&a[0], &a[1], &b[1]) <= 0.0
                && side(&b[0], &b[1], &a[0]) * side(&b[0], &b[1], &a[1]) <= 0.0
        };
        one.windows(2).any(|a| other.windows(2).any(|b| cross(a, b)))
    }

    fn points() -> impl Strategy<Value = [Point; 4]> {
        prop::array::uniform4((-10.0..10.0, -10.0..10.0).prop_map(|(x, y)| Point::new(x, y)))
    }

    fn two(strays: [f64; 2], clearance: f64) -> Segments {
        let [a, b] = strays;
        let all = vec![
            Segment { visits: [0, 1], places: [0, 1], stray: a },
            Segment { visits: [2, 3], places: [2, 3], stray: b },
        ];
        Segments { all, firsts: vec![(0, 0), (1, 1), (2, 2), (3, 3)], clearance }
    }

    fn poses(points: &[Point]) -> Vec<Pose> {
        points.iter().map(|point| Pose::new(point.x, point.y, 0.0)).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4096, failure_persistence: None, ..ProptestConfig::default() })]

        /// Ways that stray as far as they do have met where their segments are said to cross, and come as near to a place as is
        /// said where a segment is said to pass it.
        #[test]
        fn what_is_obstructed_has_met(
            points in points(),
            strays in prop::array::uniform2(prop::collection::vec(-1.5..1.5, 0..6)),
        ) {
            prop_assume!((points[1] - points[0]).norm() > 0.1 && (points[3] - points[2]).norm() > 0.1);
            let ways = [0, 1].map(|k| way([points[2 * k], points[2 * k + 1]], &strays[k]));
            let most = strays.map(|strays| strays.iter().fold(0.0_f64, |most, stray| most.max(stray.abs())));
            let segments = two(most, 2.0);
            for found in segments.obstructions(&poses(&points), 0.0) {
                match found {
                    Obstruction::Crossing { .. } => prop_assert!(meet(&ways[0], &ways[1])),
                    Obstruction::Passing { segment, visit } => {
                        let near = |piece: &[Point]| {
                            let (along, off) = (piece[1] - piece[0], points[visit] - piece[0]);
                            let share = (along.dot(&off) / along.norm_squared()).clamp(0.0, 1.0);
                            (off - along * share).norm() < 2.0
                        };
                        prop_assert!(ways[segment].windows(2).any(near));
                    }
                }
            }
        }

        /// What is looked at first, rectangles, leaves out nothing that is in the way of another.
        #[test]
        fn what_obstructs_is_near(
            points in points(),
            strays in prop::array::uniform2(0.0..1.5),
            met in prop_oneof![Just(0.0), Just(1e-3)],
        ) {
            let (segments, poses) = (two(strays, 2.0), poses(&points));
            let passing = |segment| (0..4).map(move |visit| Obstruction::Passing { segment, visit });
            let crossing = [Obstruction::Crossing { one: 1, other: 0 }].into_iter();
            let all = crossing.chain((0..2).flat_map(passing));
            let blocked =
                all.filter(|one| segments.bears(one) && !segments.is_clear(one, &poses, met)).collect::<Vec<_>>();
            prop_assert_eq!(segments.obstructions(&poses, met), blocked);
        }

        /// Straight lines that cross are found to, and those that do not are not.
        #[test]
        fn straight_lines_cross_as_they_do(points in points()) {
            let segments = two([0.0; 2], 0.0);
            let found = segments.obstructions(&poses(&points), 0.0);
            let crosses = found.contains(&Obstruction::Crossing { one: 1, other: 0 });
            prop_assert_eq!(crosses, meet(&points[..2], &points[2..]));
        }
    }

    #[test]
    fn segments_that_meet_at_a_place_cross_nowhere() {
        let points = [[0.0, 0.0], [10.0, 0.0], [5.0, -5.0], [5.0, 5.0]].map(|[x, y]| Point::new(x, y));
        let mut segments = two([0.1; 2], 1.0);
        assert_eq!(segments.obstructions(&poses(&points), 0.0), [Obstruction::Crossing { one: 1, other: 0 }]);
        segments.all[1].places[0] = 0;
        assert_eq!(segments.obstructions(&poses(&points), 0.0), []);
        // What strays farther than its ends lie from the other one may have gone around it.
        let far = two([5.5, 0.1], 1.0);
        assert_eq!(far.obstructions(&poses(&points), 0.0), []);
    }
}
