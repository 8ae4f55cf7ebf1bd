//! Bounds on where visits lie, each a half-plane that a visit is to lie in, and how errors move it there.

use crate::geometry::{Pose, Vector, lever};
use crate::metric::layout::Span;
use nalgebra::{RowVector2, RowVector3};

/// A half-plane that a visit is to lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bound {
    pub(super) edge: Edge,
    /// The visit.
    pub(super) visit: usize,
    /// How far beyond the edge, metres.
    pub(super) by: f64,
}

/// Where a half-plane begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Edge {
    /// Across a direction at an earlier visit, in whose frame it is.
    At { visit: usize, direction: Vector },
    /// Along the straight line from one visit to another: what is left of it, or right.
    Along { line: [usize; 2], left: bool },
    /// Across the straight line from one visit to another, at the latter: what lies further on.
    Past { line: [usize; 2] },
}

/// How far a visit lies within a half-plane, and how errors change that, to first order.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    /// Metres; below zero, it lies outside.
    pub(super) within: f64,
    /// By how much it is less for a twist of each of some spans, which add up.
    pub(super) twists: Vec<(Span, RowVector3<f64>)>,
}

impl Bound {
    /// How far within the half-plane the visit lies, metres.
    pub(super) fn within(&self, poses: &[Pose]) -> f64 {
        let at = |visit: usize| poses[visit].position();
        let beyond = match self.edge {
            Edge::At { visit, direction } => {
                poses[visit].rotate(&direction).dot(&(at(self.visit) - at(visit)))
            }
            Edge::Along { line: [from, to], left } => {
                let aside = along(poses, [from, to]).perp(&(at(self.visit) - at(from)));
                if left { aside } else { -aside }
            }
            Edge::Past { line } => along(poses, line).dot(&(at(self.visit) - at(line[1]))),
        };
        beyond - self.by
    }

    /// The same, and how errors change it, where visits lie so.
    pub(super) fn linear(&self, poses: &[Pose]) -> Linear {
        let moved = |visit: usize, along: &Vector| -> RowVector3<f64> {
            let at = poses[visit].position().coords;
            RowVector2::new(along.x, along.y) * lever(&at).fixed_rows::<2>(0)
        };
        let twists = match self.edge {
            Edge::At { visit, direction } => {
                vec![twist(visit, self.visit, moved(self.visit, &poses[visit].rotate(&direction)))]
            }
            Edge::Along { line: [from, to], left } => {
                let seen = Seen::new(poses, [from, to], self.visit);
                let aside = if left { seen.aside } else { -seen.aside };
                let swung = moved(to, &(aside * -seen.share));
                vec![twist(from, self.visit, moved(self.visit, &aside)), twist(from, to, swung)]
            }
            Edge::Past { line: [from, to] } => {
                let seen = Seen::new(poses, [from, to], self.visit);
                let swung = moved(to, &(seen.aside * seen.off - seen.along));
                vec![twist(from, self.visit, moved(self.visit, &seen.along)), twist(from, to, swung)]
            }
        };
        Linear { within: self.within(poses), twists }
    }
}

/// A visit as seen along a straight line between two others.
struct Seen {
    along: Vector,
    aside: Vector,
    /// How far along the line the visit lies, and how far aside, in lengths of the line.
    share: f64,
    off: f64,
}

impl Seen {
    fn new(poses: &[Pose], line: [usize; 2], visit: usize) -> Seen {
        let along = along(poses, line);
        let [from, to] = line.map(|end| poses[end].position());
        let (seen, length) = (poses[visit].position() - from, (to - from).norm().max(f64::MIN_POSITIVE));
        let (share, off) = (along.dot(&seen) / length, along.perp(&seen) / length);
        Seen { along, aside: Vector::new(-along.y, along.x), share, off }
    }
}

/// The direction of the straight line from one visit to another.
fn along(poses: &[Pose], [from, to]: [usize; 2]) -> Vector {
    let line = poses[to].position() - poses[from].position();
    line.try_normalize(0.0).unwrap_or_else(Vector::x)
}

/// A twist from one visit to another, whichever comes first.
fn twist(from: usize, to: usize, moved: RowVector3<f64>) -> (Span, RowVector3<f64>) {
    if from <= to { (Span { from, to }, moved) } else { (Span { from: to, to: from }, -moved) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    const VISITS: usize = 4;

    fn poses() -> impl Strategy<Value = Vec<Pose>> {
        let pose = (-20.0..20.0, -20.0..20.0, -3.0..3.0).prop_map(|(x, y, theta)| Pose::new(x, y, theta));
        prop::collection::vec(pose, VISITS)
    }

    fn bounds() -> impl Strategy<Value = Bound> {
        let visits = Just((0..VISITS).collect::<Vec<_>>()).prop_shuffle();
        (visits, 0usize..4, -3.0..3.0).prop_map(|(visits, which, angle)| {
            let line = [visits[0], visits[1]];
            let edge = match which {
                0 => Edge::At { visit: 0, direction: crate::geometry::direction(angle) },
                1 => Edge::Along { line, left: true },
                2 => Edge::Along { line, left: false },
                _ => Edge::Past { line },
            };
            Bound { edge, visit: if which == 0 { 1 + visits[0] % 3 } else { visits[2] }, by: angle }
        })
    }

    /// Errors twist each visit about the origin, and all that comes after it the same way.
    fn twisted(poses: &[Pose], visit: usize, axis: usize, by: f64) -> Vec<Pose> {
        let one = Vector3::ith(axis, by);
        let moved = |(at, pose): (usize, &Pose)| {
            if at < visit {
                return *pose;
            }
            let moved = lever(&pose.position().coords) * one;
            Pose { x: pose.x - moved.x, y: pose.y - moved.y, theta: pose.theta - moved.z }
        };
        poses.iter().enumerate().map(moved).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn errors_move_visits_as_differences_say(poses in poses(), bound in bounds()) {
            let away = |a: usize, b: usize| (poses[a].position() - poses[b].position()).norm() > 1.0;
            prop_assume!((0..VISITS).all(|a| (0..a).all(|b| away(a, b))));
            let linear = bound.linear(&poses);
            prop_assert_eq!(linear.within, bound.within(&poses));
            for (visit, axis) in (1..VISITS).flat_map(|visit| (0..3).map(move |axis| (visit, axis))) {
                let step = 1e-6;
                let [less, more] = [-step, step].map(|by| bound.within(&twisted(&poses, visit, axis, by)));
                let holds = |span: &Span| span.from < visit && visit <= span.to;
                let told: f64 =
                    linear.twists.iter().filter(|(span, _)| holds(span)).map(|(_, row)| -row[axis]).sum();
                let found = (more - less) / (2.0 * step);
                prop_assert!((found - told).abs() < 1e-5 * (1.0 + told.abs()), "{} {} {} {}", visit, axis, found, told);
            }
        }
    }
}
