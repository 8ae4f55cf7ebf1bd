//! Bounds as conditions on the errors that loops leave, linearised.

use crate::metric::bound::{Bound, Linear};
use crate::metric::layout::{Layout, Span};
use nalgebra::{DMatrix, DVector, RowVector3, Vector3};

/// That a visit is to lie within a bound, as a condition on errors.
#[derive(Debug)]
pub(super) struct Condition {
    linear: Linear,
    /// What the errors that are the same on all travels do to it.
    common: Vector3<f64>,
    /// The covariance of it and the loops, in units of the loops.
    known: DVector<f64>,
}

impl Condition {
    /// As many steps as the square of the loops.
    pub(super) fn new(bound: &Bound, layout: &Layout) -> Option<Condition> {
        let linear = bound.linear(&layout.poses);
        let felt = |(span, moves): &(Span, RowVector3<f64>)| (moves * layout.common(*span)).transpose();
        let common = linear.twists.iter().map(felt).sum();
        let mut condition = Condition { linear, common, known: DVector::zeros(0) };
        let mut known = DVector::zeros(3 * layout.loops.len());
        for (i, closed) in layout.loops.iter().enumerate() {
            known.fixed_rows_mut::<3>(3 * i).copy_from(&condition.shared(closed.span, layout));
        }
        condition.known = layout.in_units(known)?;
        Some(condition)
    }

    /// How far within the bound the visit lies where loops close, metres.
    pub(super) fn within(&self, layout: &Layout) -> f64 {
        let gathered = self.linear.twists.iter().map(|(span, moves)| (moves * layout.gathered(*span)).x);
        self.linear.within + gathered.sum::<f64>() - self.known.dot(layout.whitened())
    }

    /// The covariance of a span and it, as far as travels bring it about.
    pub(super) fn shared(&self, span: Span, layout: &Layout) -> Vector3<f64> {
        let own = self
            .linear
            .twists
            .iter()
            .filter_map(|(other, moves)| Some(layout.own(span, *other)? * moves.transpose()));
        own.sum::<Vector3<f64>>() + layout.common(span) * self.common
    }

    /// The covariance of a span and it that loops leave, where what loops tell of the span is known.
    pub(super) fn left(&self, span: Span, known: &DMatrix<f64>, layout: &Layout) -> Vector3<f64> {
        self.shared(span, layout) - known.tr_mul(&self.known)
    }

    /// The covariance of two that loops leave.
    pub(super) fn covariance(&self, other: &Condition, layout: &Layout) -> f64 {
        let own = |&(span, moves): &(Span, RowVector3<f64>)| {
            let with = |&(beside, also): &(Span, RowVector3<f64>)| {
                Some((moves * layout.own(span, beside)? * also.transpose()).x)
            };
            other.linear.twists.iter().filter_map(with).sum::<f64>()
        };
        let own: f64 = self.linear.twists.iter().map(own).sum();
        own + self.common.dot(&other.common) - self.known.dot(&other.known)
    }
}

/// How far it is from the errors to what they are where loops close and each of some conditions is pulled at so hard; in standard
/// deviations.
pub(super) fn ahead<'a>(
    layout: &Layout,
    pulled: impl Iterator<Item = (&'a Condition, f64)>,
) -> Option<DVector<f64>> {
    let (mut pull, mut beside) = (layout.whitened().clone(), Vec::new());
    for (condition, by) in pulled.filter(|(_, by)| *by != 0.0) {
        pull.axpy(-by, &condition.known, 1.0);
        beside.extend(condition.linear.twists.iter().map(|(span, moves)| (*span, moves.transpose() * by)));
    }
    layout.ahead(pull, &beside)
}
