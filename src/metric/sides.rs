//! Places moved beyond sides of polygons around each other, to first order.
//!
//! What is beyond a circle around a place is beyond a side of the polygon within the circle. That a place lies beyond a
//! side is one linear condition on errors; what several take together is a least-squares problem under inequalities.

use crate::geometry::{Pose, Vector, direction};
use crate::metric::conflicts::Ways;
use crate::metric::layout::{Layout, Span};
use crate::metric::leg::lever;
use crate::metric::profile::{Line, pulls, taken};
use crate::metric::witness::Witness;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Rotation2, RowVector3, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// Sides of a square, and of the polygon that has three for each of them.
const COARSE: usize = 4;
const FINE: usize = 3 * COARSE;
/// How far within a side a place is on it, metres: rounding, and pulls that are not quite the best.
const MET: f64 = 1e-3;

/// A side of a polygon around a place, as a bound to another one, both by their positions among the visits looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub(super) from: usize,
    pub(super) to: usize,
    /// How many sides the polygon has, and which of them it is.
    of: usize,
    number: usize,
}

/// Two visits within each other's polygon, by position.
pub(super) struct Pair {
    pub(super) from: usize,
    pub(super) to: usize,
    /// How the later one lies in the frame of the other.
    off: Vector,
    /// The covariance of that, which loops and sides that bear leave.
    open: Matrix2<f64>,
}

impl Pair {
    /// The sides of a polygon around the earlier visit.
    fn around(&self, of: usize) -> impl Iterator<Item = Side> + use<> {
        let Pair { from, to, .. } = *self;
        (0..of).map(move |number| Side { from, to, of, number })
    }

    /// What it takes to come beyond a side at this distance from the middle, to first order and by itself.
    fn takes(&self, side: Side, at: f64) -> f64 {
        let outward = side.outward();
        let variance = outward.dot(&(self.open * outward)).max(f64::MIN_POSITIVE);
        (at - outward.dot(&self.off)).max(0.0).powi(2) / variance
    }
}

/// The polygons around some visits.
pub(super) struct Polygons<'a> {
    layout: &'a Layout,
    visits: &'a [usize],
    /// The covariances of loops and the twist from the first of the visits to each, in units of the loops.
    known: Vec<DMatrix<f64>>,
    /// The radius of the circles.
    radius: f64,
}

/// A side as a condition on errors.
struct Condition {
    side: Side,
    span: Span,
    /// How far beyond it the later visit lies, metres.
    misses: f64,
    /// What a twist of the span moves along its direction.
    moves: RowVector3<f64>,
    /// The covariance of that and the loops, in units of the loops.
    known: DVector<f64>,
}

/// Least squares beyond some sides.
pub(super) struct Solved {
    /// What it takes beyond the chi-square of the loops.
    pub(super) chi_square: f64,
    /// Those of the sides that bear, and the factor of their covariance.
    bearing: Vec<Condition>,
    root: Option<DMatrix<f64>>,
    /// How far each visit twists.
    twists: Vec<Vector3<f64>>,
}

impl Side {
    /// Whether it is one of the many.
    fn is_fine(&self) -> bool {
        self.of == FINE
    }

    /// Its direction, in the frame of the visit that it is around.
    fn outward(&self) -> Vector {
        direction(self.number as f64 / self.of as f64 * TAU)
    }

    /// How far from the middle it is, in radii.
    fn at(&self) -> f64 {
        (PI / self.of as f64).cos()
    }

    /// The three that what is outside of the circle towards this one is beyond.
    fn parts(&self) -> impl Iterator<Item = Side> {
        let middle = 3 * self.number + FINE;
        (middle - 1..=middle + 1).map(|number| Side { of: FINE, number: number % FINE, ..*self })
    }
}

impl Solved {
    /// The sides that bear, ascending.
    pub(super) fn bearing(&self) -> Vec<Side> {
        let mut sides: Vec<Side> = self.bearing.iter().map(|condition| condition.side).collect();
        sides.sort_unstable();
        sides
    }
}

impl<'a> Polygons<'a> {
    /// The polygons within circles around some visits, ascending and measured in between.
    pub(super) fn new(layout: &'a Layout, visits: &'a [usize], radius: f64) -> Option<Polygons<'a>> {
        let first = *visits.first()?;
        let known = visits.iter().map(|&to| layout.known(Span { from: first, to }, None));
        let known = known.collect::<Option<_>>()?;
        Some(Polygons { layout, visits, known, radius })
    }

    /// The least that it takes to come beyond some sides, all at once.
    pub(super) fn solve(&self, sides: &[Side]) -> Solved {
        let conditions: Vec<Condition> = sides.iter().map(|&side| self.condition(side)).collect();
        let size = conditions.len();
        let mut covariance = DMatrix::zeros(size, size);
        for (k, one) in conditions.iter().enumerate() {
            for (l, other) in conditions[..=k].iter().enumerate() {
                let entry = self.covariance(one, other);
                (covariance[(k, l)], covariance[(l, k)]) = (entry, entry);
            }
        }
        let misses = DVector::from_iterator(size, conditions.iter().map(|condition| condition.misses));
        let pulls = pulls(&covariance, &misses);
        let chi_square = taken(&covariance, &misses, &pulls);
        let bear: Vec<usize> = (0..size).filter(|&side| pulls[side] < 0.0).collect();
        let root =
            covariance.select_rows(&bear).select_columns(&bear).cholesky().map(|factor| factor.unpack());
        let first = self.visits[0];
        let twist = |(at, &to): (usize, &usize)| {
            let own = Span { from: first, to };
            bear.iter().fold(Vector3::zeros(), |twist, &k| {
                let condition = &conditions[k];
                let shared = self.layout.shared(own, condition.span) * condition.moves.transpose();
                twist + (shared - self.known[at].tr_mul(&condition.known)) * pulls[k]
            })
        };
        let twists = self.visits.iter().enumerate().map(twist).collect();
        let bearing = conditions.into_iter().enumerate().filter(|(at, _)| bear.contains(at));
        Solved { chi_square, bearing: bearing.map(|(_, condition)| condition).collect(), root, twists }
    }

    /// Two visits within each other's polygon, if any two are, where all lie as `poses` say or, without these, as they do to
    /// first order: of all those that take most to come out of it, as they end most branches. Not those beyond a part in
    /// `settled`.
    pub(super) fn within(&self, solved: &Solved, settled: &[Side], poses: Option<&[Pose]>) -> Option<Pair> {
        let settled = settled.iter().filter(|side| side.is_fine()).map(|side| (side.from, side.to));
        let settled: BTreeSet<(usize, usize)> = settled.collect();
        let pairs = (1..self.visits.len()).flat_map(|to| (0..to).map(move |from| (from, to)));
        let pairs = pairs.filter(|pair| !settled.contains(pair));
        let pair = |(from, to): (usize, usize)| {
            let off = match poses {
                Some(poses) => {
                    let [begin, end] = [from, to].map(|at| poses[self.visits[at]]);
                    begin.inverse().rotate(&(end.position() - begin.position()))
                }
                None => {
                    let moved = self.moves(to) * (solved.twists[to] - solved.twists[from]);
                    let begin = self.layout.poses[self.visits[from]];
                    begin.inverse().rotate(&(self.off(from, to) - moved))
                }
            };
            Pair { from, to, off, open: Matrix2::zeros() }
        };
        let within = |pair: &Pair| {
            let inside = |side: Side| side.outward().dot(&pair.off) < self.at(side) - MET;
            pair.off.norm() < self.radius && pair.around(FINE).all(inside)
        };
        let takes = |pair: Pair| {
            let pair = Pair { open: self.left_open(solved, &pair), ..pair };
            (
                pair.around(FINE).map(|side| pair.takes(side, self.at(side))).fold(f64::INFINITY, f64::min),
                pair,
            )
        };
        let most = pairs.map(pair).filter(within).map(takes).max_by(|a, b| a.0.total_cmp(&b.0));
        most.map(|(_, pair)| pair)
    }

    /// What two visits within each other's polygon may be beyond, what takes least first: a side of the square or, where one of
    /// these was chosen, a part of it. None where no errors move the visits beyond a part chosen: more sides tell nothing then.
    pub(super) fn ways(&self, pair: &Pair, chosen: &[Side]) -> Option<Ways<Side>> {
        let known = chosen.iter().filter(|side| (side.from, side.to) == (pair.from, pair.to));
        let (whole, mut parts): (_, Vec<Side>) = match known.max_by_key(|side| side.of) {
            None => (None, pair.around(COARSE).collect()),
            Some(side) if side.is_fine() => return None,
            Some(side) => (Some(*side), side.parts().collect()),
        };
        let takes = |side: &Side| pair.takes(*side, self.at(*side));
        parts.sort_by(|a, b| takes(a).total_cmp(&takes(b)));
        Some(Ways { whole, parts })
    }

    /// Errors with which all visits lie beyond each other's polygon, if these do, within a gate over the least.
    pub(super) fn witness(&self, found: &Layout, least: f64, gate: f64) -> Option<Witness> {
        Witness::new(found, self.visits, self.radius * (PI / FINE as f64).cos(), least, gate)
    }

    /// The two visits of a side.
    pub(super) fn span(&self, side: Side) -> Span {
        Span { from: self.visits[side.from], to: self.visits[side.to] }
    }

    /// Sides as lines, each nearer by the rest of a share of how far the visit is from it.
    pub(super) fn lines(&self, sides: &[Side], share: f64) -> Vec<Line> {
        let line = |&side: &Side| Line {
            span: self.span(side),
            direction: side.outward(),
            at: self.at(side) + (1.0 - share) * self.misses(side).min(0.0),
        };
        sides.iter().map(line).collect()
    }

    /// The covariance of where a visit lies, in the frame of another, that the loops and the sides which bear leave.
    fn left_open(&self, solved: &Solved, &Pair { from, to, .. }: &Pair) -> Matrix2<f64> {
        let span = Span { from: self.visits[from], to: self.visits[to] };
        let (moves, known) = (self.moves(to), &self.known[to] - &self.known[from]);
        let mut covariance =
            moves * (self.layout.shared(span, span) - known.tr_mul(&known)) * moves.transpose();
        let mut shared = DMatrix::zeros(solved.bearing.len(), 2);
        for (row, condition) in solved.bearing.iter().enumerate() {
            let entry = self.layout.shared(span, condition.span) * condition.moves.transpose()
                - known.tr_mul(&condition.known);
            shared.set_row(row, &(moves * entry).transpose());
        }
        if let Some(root) = &solved.root
            && root.solve_lower_triangular_mut(&mut shared)
        {
            covariance -= shared.tr_mul(&shared).fixed_view::<2, 2>(0, 0);
        }
        let back = Rotation2::new(-self.layout.poses[self.visits[from]].theta);
        back.matrix() * covariance * back.matrix().transpose()
    }

    fn condition(&self, side: Side) -> Condition {
        let moves = self.along(side).transpose() * self.moves(side.to);
        Condition {
            side,
            span: self.span(side),
            misses: self.misses(side),
            known: (&self.known[side.to] - &self.known[side.from]) * moves.transpose(),
            moves,
        }
    }

    fn misses(&self, side: Side) -> f64 {
        self.along(side).dot(&self.off(side.from, side.to)) - self.at(side)
    }

    fn covariance(&self, one: &Condition, other: &Condition) -> f64 {
        let shared = one.moves * self.layout.shared(one.span, other.span) * other.moves.transpose();
        shared.x - one.known.dot(&other.known)
    }

    /// A side's direction in the world.
    fn along(&self, side: Side) -> Vector {
        self.layout.poses[self.visits[side.from]].rotate(&side.outward())
    }

    /// How far from the middle of its circle a side is, metres.
    fn at(&self, side: Side) -> f64 {
        self.radius * side.at()
    }

    /// Where a visit lies, seen from another, along the axes of the world.
    fn off(&self, from: usize, to: usize) -> Vector {
        let at = |visit: usize| self.layout.poses[self.visits[visit]].position();
        at(to) - at(from)
    }

    /// What a twist moves at a visit.
    fn moves(&self, visit: usize) -> Matrix2x3<f64> {
        lever(&self.layout.poses[self.visits[visit]].position().coords).fixed_rows::<2>(0).into_owned()
    }
}
