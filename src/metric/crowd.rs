//! Whether all places can lie apart at once.
//!
//! Where a known building is taken for new, each of its places lies on a known one, and none of them so surely that it could not
//! lie elsewhere. But they hang together: where one moves aside all do, and not all find room between the known ones. So
//! the least chi-square is sought with which all loops close and any two places lie apart.
//!
//! That two places lie apart is that one lies beyond a side of a polygon around the other: one condition of several
//! (disjunctive programming, Balas 1979). Branch and bound (Land and Doig 1960): least squares beyond the sides chosen so
//! far; if that takes more chi-square than their gate, by the profile of the likelihood too ([`crate::metric::profile`]),
//! the branch ends; else each side around a place comes next that lies within another's polygon. If no place does, all can
//! lie apart, to first order.
//!
//! The gate of some sides is that of as many degrees of freedom as of them bear: of one cone and covariance, chi-square is so
//! distributed given which ones do (Wollan and Dykstra 1986). Here the sides are chosen by the data and the covariance is a
//! bound ([`crate::metric::share`]), so that it is a rule that this law suggests; how often it fails is counted, not proven
//! (`cargo xtask evaluate`).

use crate::geometry::{Vector, direction};
use crate::metric::layout::{Layout, Span};
use crate::metric::leg::lever;
use crate::metric::profile::{Line, pulls, taken};
use crate::metric::uncertainty::quantile;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, RowVector3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Sides of the polygon within the circle.
const SIDES: usize = 12;
/// At most so many sets of sides are looked at.
const STEPS: usize = 400;
/// How much chi-square it is to take to first order to come to lines looked at before the sides, in gates.
const NEARER: [f64; 2] = [1.5, 3.0];

/// What it takes at least to have all places apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Crowd {
    /// Chi-square beyond that of the loops alone.
    pub(super) chi_square: f64,
    /// The gate that it exceeds.
    pub(super) gate: f64,
    /// Visits to places that are in each other's way, each pair once.
    pub(super) spans: Vec<Span>,
}

/// Sides, each by the two visits and its number.
type Sides = Vec<(usize, usize, usize)>;

impl Layout {
    /// What it takes to have some visits, ascending and measured in between, all so far from each other, if more than is
    /// likely. `None` where they may lie apart, and where that is not found out.
    pub(super) fn crowd(&self, visits: &[usize], radius: f64) -> Option<Crowd> {
        let mut search = Search::new(self, visits, radius)?;
        search.branch(&mut Vec::new())?;
        let ended = search.ended.into_values().flatten();
        ended.min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
    }

    /// The gate of some conditions together, as far as all loops leave it.
    fn gate(&self, conditions: usize) -> f64 {
        // No less than that of one place and another, which is a position.
        let degrees = conditions.max(2);
        self.left(degrees, quantile(degrees))
    }
}

/// The search for a way to have all places apart, to first order.
struct Search<'a> {
    layout: &'a Layout,
    visits: &'a [usize],
    /// The covariances of loops and the twist from the first of the visits to each, in units of the loops.
    known: Vec<DMatrix<f64>>,
    /// The radius of the circles, and how far from their middles the sides of the polygons are.
    radius: f64,
    at: f64,
    steps: usize,
    /// What it takes to come beyond sides that bear in a branch, if that ends it.
    ended: BTreeMap<Sides, Option<Crowd>>,
}

/// A side as a condition on errors.
#[derive(Clone)]
struct Side {
    id: (usize, usize, usize),
    span: Span,
    /// How far beyond it the later visit lies, metres.
    misses: f64,
    /// What a twist of the span moves along its direction.
    moves: RowVector3<f64>,
    /// The covariance of that and the loops, in units of the loops.
    known: DVector<f64>,
}

/// Least squares beyond some sides.
struct Solved {
    chi_square: f64,
    /// Those of the sides that bear, and the factor of their covariance.
    bearing: Vec<Side>,
    root: Option<DMatrix<f64>>,
    /// How far each visit twists.
    twists: Vec<Vector3<f64>>,
}

impl Solved {
    fn sides(&self) -> Sides {
        let mut sides: Sides = self.bearing.iter().map(|side| side.id).collect();
        sides.sort_unstable();
        sides
    }
}

impl<'a> Search<'a> {
    fn new(layout: &'a Layout, visits: &'a [usize], radius: f64) -> Option<Search<'a>> {
        let first = *visits.first()?;
        let known = visits.iter().map(|&to| layout.known(Span { from: first, to }, None));
        Some(Search {
            layout,
            visits,
            known: known.collect::<Option<_>>()?,
            radius,
            // What is beyond the circle is beyond a side of the polygon in it.
            at: radius * (PI / SIDES as f64).cos(),
            steps: 0,
            ended: BTreeMap::new(),
        })
    }

    /// Ends all branches beyond some sides; `None` if one of them does not end. As deep as there are pairs of visits.
    fn branch(&mut self, sides: &mut Sides) -> Option<()> {
        self.steps += 1;
        if self.steps > STEPS {
            return None;
        }
        let solved = self.solve(sides);
        if solved.chi_square > self.layout.gate(solved.bearing.len()) && self.ends(&solved.sides()) {
            return Some(());
        }
        let (from, to, off) = self.next(&solved)?;
        // A pair still within a side chosen for it is one that no errors move: more sides around it tell nothing.
        if sides.iter().any(|&(one, other, _)| (one, other) == (from, to)) {
            return None;
        }
        let mut around: Vec<usize> = (0..SIDES).collect();
        // The side that is easiest to reach first: if there is a way it is soon found.
        let along = |side: &usize| self.along(from, *side).dot(&off);
        around.sort_by(|a, b| along(b).total_cmp(&along(a)));
        for side in around {
            sides.push((from, to, side));
            self.branch(sides)?;
            sides.pop();
        }
        Some(())
    }

    /// Whether more than their gate is taken by the sides that bear, also where first order does not hold.
    fn ends(&mut self, sides: &Sides) -> bool {
        if !self.ended.contains_key(sides) {
            self.ended.insert(sides.clone(), self.beyond(sides));
        }
        self.ended[sides].is_some()
    }

    /// Two visits within each other's polygon, by their places in the list, and how the later one lies; none if no two are.
    /// Those that take most to come out of it end most branches.
    fn next(&self, solved: &Solved) -> Option<(usize, usize, Vector)> {
        let pairs = (1..self.visits.len()).flat_map(|to| (0..to).map(move |from| (from, to)));
        let off = |(from, to): (usize, usize)| {
            let moved = self.moves(to) * (solved.twists[to] - solved.twists[from]);
            (from, to, self.off(from, to) - moved)
        };
        let within = |(from, _, off): &(usize, usize, Vector)| {
            off.norm() < self.radius
                && (0..SIDES).all(|side| self.along(*from, side).dot(off) < self.at - MET)
        };
        let takes = |(from, to, off): (usize, usize, Vector)| {
            let covariance = self.left_open(solved, from, to);
            let side = |side: usize| {
                let along = self.along(from, side);
                (self.at - along.dot(&off)).powi(2) / along.dot(&(covariance * along)).max(f64::MIN_POSITIVE)
            };
            ((0..SIDES).map(side).fold(f64::INFINITY, f64::min), (from, to, off))
        };
        let most = pairs.map(off).filter(within).map(takes).max_by(|a, b| a.0.total_cmp(&b.0));
        most.map(|(_, pair)| pair)
    }

    /// The covariance of where a visit lies, seen from another, that the loops and the sides which bear leave.
    fn left_open(&self, solved: &Solved, from: usize, to: usize) -> Matrix2<f64> {
        let span = Span { from: self.visits[from], to: self.visits[to] };
        let (moves, known) = (self.moves(to), &self.known[to] - &self.known[from]);
        let mut covariance =
            moves * (self.layout.shared(span, span) - known.tr_mul(&known)) * moves.transpose();
        let bearing = solved.bearing.len();
        let mut shared = DMatrix::zeros(bearing, 2);
        for (row, side) in solved.bearing.iter().enumerate() {
            let entry =
                self.layout.shared(span, side.span) * side.moves.transpose() - known.tr_mul(&side.known);
            shared.set_row(row, &(moves * entry).transpose());
        }
        if let Some(root) = &solved.root
            && root.solve_lower_triangular_mut(&mut shared)
        {
            covariance -= shared.tr_mul(&shared).fixed_view::<2, 2>(0, 0);
        }
        covariance
    }

    fn solve(&self, sides: &Sides) -> Solved {
        let sides: Vec<Side> = sides.iter().map(|&side| self.side(side)).collect();
        let covariance =
            DMatrix::from_fn(sides.len(), sides.len(), |k, l| self.covariance(&sides[k], &sides[l]));
        let misses = DVector::from_iterator(sides.len(), sides.iter().map(|side| side.misses));
        let pulls = pulls(&covariance, &misses);
        let chi_square = taken(&covariance, &misses, &pulls);
        let bear: Vec<usize> = (0..sides.len()).filter(|&side| pulls[side] < 0.0).collect();
        let root =
            covariance.select_rows(&bear).select_columns(&bear).cholesky().map(|factor| factor.unpack());
        let first = self.visits[0];
        let twist = |(at, &to): (usize, &usize)| {
            let own = Span { from: first, to };
            bear.iter().fold(Vector3::zeros(), |twist, &k| {
                let side = &sides[k];
                let shared = self.layout.shared(own, side.span) * side.moves.transpose();
                twist + (shared - self.known[at].tr_mul(&side.known)) * pulls[k]
            })
        };
        let twists = self.visits.iter().enumerate().map(twist).collect();
        let bearing =
            sides.iter().enumerate().filter(|(at, _)| bear.contains(at)).map(|(_, side)| side.clone());
        Solved { chi_square, bearing: bearing.collect(), root, twists }
    }

    fn side(&self, id: (usize, usize, usize)) -> Side {
        let (from, to, side) = id;
        let along = self.along(from, side);
        let moves = along.transpose() * self.moves(to);
        Side {
            id,
            span: Span { from: self.visits[from], to: self.visits[to] },
            misses: along.dot(&self.off(from, to)) - self.at,
            known: (&self.known[to] - &self.known[from]) * moves.transpose(),
            moves,
        }
    }

    fn covariance(&self, one: &Side, other: &Side) -> f64 {
        let shared = one.moves * self.layout.shared(one.span, other.span) * other.moves.transpose();
        shared.x - one.known.dot(&other.known)
    }

    /// What it takes to come beyond some sides, if that is more than their gate. Near lines are found where those far out
    /// are not.
    fn beyond(&self, sides: &Sides) -> Option<Crowd> {
        let gate = self.layout.gate(sides.len());
        let shares = NEARER.map(|gates| (gates * gate / self.solve(sides).chi_square).sqrt());
        let line = |id: (usize, usize, usize), share: f64| {
            let Side { span, misses, .. } = self.side(id);
            let direction = direction(id.2 as f64 / SIDES as f64 * TAU);
            Line { span, direction, at: self.at + (1.0 - share) * misses.min(0.0) }
        };
        let lines = |share: f64| -> Vec<Line> { sides.iter().map(|&id| line(id, share)).collect() };
        let mut takes = shares.into_iter().filter(|&share| share < 1.0).chain([1.0]);
        let takes = takes.find_map(|share| self.layout.to_reach(&lines(share)).filter(|&takes| takes > gate));
        let spans = sides.iter().map(|&id| self.side(id).span).collect();
        Some(Crowd { chi_square: takes?, gate, spans })
    }

    /// A side's direction in the world, seen from a visit.
    fn along(&self, from: usize, side: usize) -> Vector {
        self.layout.poses[self.visits[from]].rotate(&direction(side as f64 / SIDES as f64 * TAU))
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

/// How far within a side a place is on it, metres: rounding, and pulls that are not quite the best.
const MET: f64 = 1e-3;
