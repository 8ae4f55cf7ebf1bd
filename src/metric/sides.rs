//! Sides of polygons around places.
//!
//! What is beyond a circle around a place is beyond a side of the polygon within the circle. That a place lies beyond a
//! side is one linear condition on errors.

use crate::geometry::{Vector, direction};
use crate::metric::bound::{Bound, Edge};
use crate::metric::layout::Span;
use nalgebra::Matrix2;
use std::f64::consts::{PI, TAU};

/// Sides of a square, and of the polygon that has three for each of them.
const COARSE: usize = 4;
const FINE: usize = 3 * COARSE;

/// A side of a polygon around an earlier visit, as a bound to a later one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Side {
    from: usize,
    to: usize,
    /// How many sides the polygon has, and which of them it is.
    of: usize,
    number: usize,
}

/// Two visits within each other's polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) span: Span,
    /// How the later one lies in the frame of the other.
    pub(super) off: Vector,
    /// The covariance of that, which loops and bounds that bear leave.
    pub(super) open: Matrix2<f64>,
}

/// How near to its middle a polygon comes that lies within a circle, and is not left where visits are further apart.
pub(super) fn inner(radius: f64) -> f64 {
    radius * (PI / FINE as f64).cos()
}

impl Side {
    /// The two visits.
    pub(super) fn span(&self) -> Span {
        Span { from: self.from, to: self.to }
    }

    /// Whether it is one of the many.
    pub(super) fn is_fine(&self) -> bool {
        self.of == FINE
    }

    /// What lies beyond it, of the polygon within a circle.
    pub(super) fn bound(&self, radius: f64) -> Bound {
        let edge = Edge::At { visit: self.from, direction: self.outward() };
        Bound { edge, visit: self.to, by: self.at(radius) }
    }

    /// Its direction, in the frame of the visit that it is around.
    fn outward(&self) -> Vector {
        direction(self.number as f64 / self.of as f64 * TAU)
    }

    /// How far from the middle it is.
    fn at(&self, radius: f64) -> f64 {
        radius * (PI / self.of as f64).cos()
    }

    /// The three that what is outside of the circle towards this one is beyond.
    fn parts(&self) -> impl Iterator<Item = Side> + use<> {
        let (whole, middle) = (*self, 3 * self.number + FINE);
        (middle - 1..=middle + 1).map(move |number| Side { of: FINE, number: number % FINE, ..whole })
    }
}

impl Pair {
    /// Whether the later visit is within the polygon around the other, by more than `met` metres.
    pub(super) fn is_within(&self, radius: f64, met: f64) -> bool {
        let inside = |side: Side| side.outward().dot(&self.off) < side.at(radius) - met;
        self.off.norm() < radius && self.around(FINE).all(inside)
    }

    /// What it takes at least to come out of the polygon, to first order and by itself.
    pub(super) fn takes(&self, radius: f64) -> f64 {
        self.around(FINE).map(|side| self.beyond(side, radius)).fold(f64::INFINITY, f64::min)
    }

    /// What the later visit may be beyond, what takes least first: a side of the square or, where one of these was chosen, a part
    /// of it.
    pub(super) fn ways(&self, chosen: Option<Side>, radius: f64) -> Vec<Side> {
        let mut ways: Vec<Side> = match chosen {
            None => self.around(COARSE).collect(),
            Some(side) => side.parts().collect(),
        };
        ways.sort_by(|a, b| self.beyond(*a, radius).total_cmp(&self.beyond(*b, radius)));
        ways
    }

    /// The sides of a polygon around the earlier visit.
    fn around(&self, of: usize) -> impl Iterator<Item = Side> + use<> {
        let Span { from, to } = self.span;
        (0..of).map(move |number| Side { from, to, of, number })
    }

    fn beyond(&self, side: Side, radius: f64) -> f64 {
        let outward = side.outward();
        let variance = outward.dot(&(self.open * outward)).max(f64::MIN_POSITIVE);
        (side.at(radius) - outward.dot(&self.off)).max(0.0).powi(2) / variance
    }
}
