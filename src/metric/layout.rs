//! All visits laid out at once: what every loop closed so far says of where they lie and of how odometry drifts.
//!
//! The errors of travels are those of [`crate::metric::share`], each with a part of its own and one that is the same on all.
//! A loop joins a visit to the first one to the same place. That it closes is a condition on errors: least squares
//! under conditions (Gauss), linearised where the errors were last thought to be, until they stay. In world
//! coordinates the error of a travel is a twist at the origin, `A e`, and what it does to a pose at `q` is
//! `lever(q) A e`: so the covariance of two loops is that of the travels they share, a difference of two sums over
//! beginnings of the trace. A travel that was not measured ends what is laid out together. With `c` loops a solution
//! takes `c^3` steps.
//!
//! All loops together have a chi-square, and so has each loop or pair of places given those before it. The sum has as
//! many degrees of freedom as both, so that a test has its own gate and what the gate of the sum leaves it, whichever
//! is less ([`Layout::left`]).

use crate::geometry::{Pose, Vector, lever, rotation, wrap_angle};
use crate::metric::chain::link;
use crate::metric::frames::Story;
use crate::metric::loops::Loops;
use crate::metric::share::{Share, Travel};
use crate::metric::uncertainty::{TAIL, Uncertainty, exceeded};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Two visits; the second one is later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) from: usize,
    pub(super) to: usize,
}

/// A span that is closed, as both visits are to one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loop {
    pub(super) span: Span,
    /// How much more the later visit's frame is turned, where bearings tell.
    pub(super) turn: Option<f64>,
    /// The variances of x, y and heading that each of the two visits adds.
    pub(super) stay: Vector3<f64>,
}

/// The visits laid out.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) travels: Vec<Option<Travel>>,
    /// The frame of each visit, in that of the first one since the last travel that was not measured.
    pub(super) poses: Vec<Pose>,
    pub(super) loops: Vec<Loop>,
    /// The errors as estimated, in standard deviations: three of each travel of its own, then those that are the same on all.
    errors: DVector<f64>,
    /// What an error of the travel to each visit is as a twist at the origin.
    twists: Vec<Matrix3<f64>>,
    /// Sums over the travels up to each visit: covariances of own errors, effects of common ones, estimated errors.
    own: Vec<Matrix3<f64>>,
    common: Vec<Matrix3<f64>>,
    sums: Vec<Vector3<f64>>,
    /// The factor of the covariance of the loops, and what closes them in its units.
    root: DMatrix<f64>,
    whitened: DVector<f64>,
    /// The covariances of loops and headings in its units, a column a visit.
    pub(super) headings: DMatrix<f64>,
}

/// Variance of what is not known, square radians.
const UNKNOWN: f64 = 1e4;
/// At most so many linearisations, and the change of an error that ends them.
const ROUNDS: usize = 20;
const SETTLED: f64 = 1e-5;

impl Layout {
    /// The layout of all visits of a story by the loops among the first `assigned` ones.
    pub(super) fn new(story: &Story<'_>, assigned: usize, share: Share) -> Option<Layout> {
        let loops: Vec<Loop> = (1..assigned).filter_map(|visit| closed(story, visit)).collect();
        let leg = |visit: usize| story.stays[visit].travelled.as_ref()?.leg.as_ref();
        let travels: Vec<Option<Travel>> =
            (0..=story.latest()).map(|visit| leg(visit).map(|leg| share.of(leg))).collect();
        let visits = travels.len();
        let mut layout = Layout {
            travels,
            poses: vec![Pose::IDENTITY; visits],
            loops: Vec::new(),
            errors: DVector::zeros(3 * visits + 3),
            twists: vec![Matrix3::identity(); visits],
            own: vec![Matrix3::zeros(); visits],
            common: vec![Matrix3::zeros(); visits],
            sums: vec![Vector3::zeros(); visits],
            root: DMatrix::zeros(0, 0),
            whitened: DVector::zeros(0),
            headings: DMatrix::zeros(0, visits),
        };
        layout.place();
        // A few loops first: they tell the drift that may leave a far end turned around.
        let mut few = 1;
        while few < loops.len() {
            layout.loops = loops[..few].to_vec();
            layout.adjust()?;
            few *= 2;
        }
        layout.loops = loops;
        let settled =
            (0..ROUNDS).try_fold(false, |settled, _| Some(settled || layout.adjust()? < SETTLED))?;
        layout.solve()?;
        // Where errors do not come to rest, as no likely ones close the loops, that is all there is to know.
        (settled || !layout.agrees()).then_some(())?;
        layout.headings = layout.all_headings()?;
        Some(layout)
    }

    /// Chi-square of all loops together, and its degrees of freedom.
    pub(super) fn chi_square(&self) -> (f64, usize) {
        let degrees = self.loops.iter().map(|closed| 2 + usize::from(closed.turn.is_some())).sum();
        (self.whitened.norm_squared(), degrees)
    }

    /// All loops together.
    pub(super) fn loops_together(&self) -> Loops {
        let (chi_square, degrees) = self.chi_square();
        Loops { chi_square, degrees }
    }

    /// Whether likely errors close all loops.
    pub(super) fn agrees(&self) -> bool {
        let (chi_square, degrees) = self.chi_square();
        exceeded(chi_square, degrees) >= TAIL
    }

    /// What the gate of all loops together leaves for a test of so many degrees of freedom, at most its own gate.
    pub(super) fn left(&self, degrees: usize, gate: f64) -> f64 {
        self.loops_together().left(degrees, gate)
    }

    /// Whether all travels of the span are measured.
    pub(super) fn joins(&self, span: Span) -> bool {
        self.travels[span.from + 1..=span.to].iter().all(Option::is_some)
    }

    /// How far a loop is from being closed, by all the other loops: the displacement and its uncertainty, which is
    /// judged at `gate` standard deviations.
    pub(super) fn off(&self, closing: &Loop, gate: f64) -> Option<(Vector3<f64>, Uncertainty)> {
        let span = closing.span;
        let known = self.known(span, Some(closing))?;
        let mean = self.condition(closing) - known.transpose() * &self.whitened;
        let covariance = self.shared(span, span) + self.stays(closing, closing) - known.transpose() * &known;
        let moves = lever(&at(&self.poses[span.to]));
        let covariance = moves * covariance * moves.transpose();
        Some((moves * mean, Uncertainty { covariance, slack: self.slack(span, gate) }))
    }

    /// The covariance of where a visit lies, seen from an earlier one.
    pub(super) fn between(&self, span: Span) -> Option<Matrix3<f64>> {
        let known = self.known(span, None)?;
        let moves = lever(&at(&self.poses[span.to]));
        Some(moves * (self.shared(span, span) - known.transpose() * &known) * moves.transpose())
    }

    /// Lays out the visits by the errors as estimated.
    fn place(&mut self) {
        for visit in 1..self.poses.len() {
            let before = visit - 1;
            let Some(travel) = &self.travels[visit] else {
                self.poses[visit] = Pose::IDENTITY;
                (self.own[visit], self.common[visit], self.sums[visit]) =
                    (self.own[before], self.common[before], self.sums[before]);
                continue;
            };
            let error = self.error(visit, &self.errors);
            let gone = Vector3::new(travel.pose.x, travel.pose.y, travel.pose.theta) - error;
            let (from, turn) = (self.poses[before], rotation(self.poses[before].theta));
            let to = turn * gone + Vector3::new(from.x, from.y, from.theta);
            self.poses[visit] = Pose::new(to.x, to.y, to.z);
            let twist = lever(&-at(&self.poses[visit])) * turn;
            self.own[visit] = self.own[before] + twist * travel.own * twist.transpose();
            self.common[visit] = self.common[before] + twist * travel.common;
            self.sums[visit] = self.sums[before] + twist * error;
            self.twists[visit] = twist;
        }
    }

    /// The covariance of the loops, factored, and their conditions.
    pub(super) fn solve(&mut self) -> Option<()> {
        let size = 3 * self.loops.len();
        let (mut covariance, mut conditions) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (i, one) in self.loops.iter().enumerate() {
            conditions.fixed_rows_mut::<3>(3 * i).copy_from(&self.condition(one));
            for (j, other) in self.loops[..=i].iter().enumerate() {
                let entry = self.shared(one.span, other.span) + self.stays(one, other);
                covariance.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&entry);
            }
        }
        self.root = covariance.cholesky()?.unpack();
        self.root.solve_lower_triangular_mut(&mut conditions).then_some(())?;
        self.whitened = conditions;
        Some(())
    }

    /// What closes the loops, in units of their covariance.
    pub(super) fn whitened(&self) -> &DVector<f64> {
        &self.whitened
    }

    /// The errors as estimated, in standard deviations.
    pub(super) fn errors(&self) -> &DVector<f64> {
        &self.errors
    }

    /// The errors of a span as estimated.
    pub(super) fn gathered(&self, span: Span) -> Vector3<f64> {
        self.sums[span.to] - self.sums[span.from]
    }

    /// Where visits lie to first order if the errors change by so much.
    pub(super) fn moved(&self, ahead: &DVector<f64>) -> Vec<Pose> {
        let mut twist = Vector3::zeros();
        let moved = |(visit, pose): (usize, &Pose)| {
            twist = match self.travels[visit] {
                Some(_) => twist + self.twists[visit] * self.error(visit, ahead),
                None => Vector3::zeros(),
            };
            let moved = lever(&at(pose)) * twist;
            Pose { x: pose.x - moved.x, y: pose.y - moved.y, theta: pose.theta - moved.z }
        };
        self.poses.iter().enumerate().map(moved).collect()
    }

    /// What errors of the travel to a visit come to.
    fn error(&self, visit: usize, errors: &DVector<f64>) -> Vector3<f64> {
        let own = errors.fixed_rows::<3>(3 * visit);
        let common = errors.fixed_rows::<3>(3 * self.poses.len());
        self.travels[visit]
            .as_ref()
            .map_or(Vector3::zeros(), |travel| travel.root * own + travel.common * common)
    }

    /// Estimates the errors anew; the largest change, in standard deviations.
    fn adjust(&mut self) -> Option<f64> {
        self.solve()?;
        let ahead = self.ahead(self.whitened.clone(), &[])?;
        self.go(&ahead, 1.0);
        Some(ahead.amax())
    }

    /// How far it is from the errors to what they are by what pulls at the loops, in units of their covariance, and at more
    /// spans; in standard deviations.
    pub(super) fn ahead(
        &self,
        mut pull: DVector<f64>,
        beside: &[(Span, Vector3<f64>)],
    ) -> Option<DVector<f64>> {
        self.root.tr_solve_lower_triangular_mut(&mut pull).then_some(())?;
        let mut errors = DVector::zeros(self.errors.len());
        let mut common = Vector3::zeros();
        // What starts and ends to pull at each visit.
        let mut pulls = vec![Vector3::zeros(); self.poses.len() + 1];
        let loops = self.loops.iter().enumerate();
        let pulled = loops.map(|(i, one)| (one.span, pull.fixed_rows::<3>(3 * i).into_owned()));
        for (span, pull) in pulled.chain(beside.iter().copied()) {
            common += self.common(span).tr_mul(&pull);
            pulls[span.from + 1] += pull;
            pulls[span.to + 1] -= pull;
        }
        let mut pulled = Vector3::zeros();
        for (visit, pull) in pulls.iter().enumerate().take(self.poses.len()) {
            pulled += pull;
            let Some(travel) = &self.travels[visit] else { continue };
            let own = travel.root.transpose() * (self.twists[visit].transpose() * pulled);
            errors.fixed_rows_mut::<3>(3 * visit).copy_from(&own);
        }
        errors.fixed_rows_mut::<3>(3 * self.poses.len()).copy_from(&common);
        Some(errors - &self.errors)
    }

    /// Changes the errors by so much of what is ahead.
    pub(super) fn go(&mut self, ahead: &DVector<f64>, way: f64) {
        self.errors.axpy(way, ahead, 1.0);
        self.place();
    }

    /// Changes all errors that travels have of their own by so many standard deviations, up or down in no order (multiplicative
    /// hashing, Knuth 1973). The order is that from the last travel back.
    pub(super) fn shake(&mut self, by: f64) {
        for (visit, _) in self.travels.iter().enumerate().filter(|(_, travel)| travel.is_some()) {
            for at in 3 * visit..3 * visit + 3 {
                let hash = ((self.errors.len() - at) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                self.errors[at] += if hash >> 40 & 1 == 0 { by } else { -by };
            }
        }
        self.place();
    }

    /// What the errors of a loop, linearised, come to.
    fn condition(&self, closing: &Loop) -> Vector3<f64> {
        let Span { from, to } = closing.span;
        let (begin, end) = (&self.poses[from], &self.poses[to]);
        let turn = closing.turn.map_or(0.0, |turn| wrap_angle(end.theta - begin.theta - turn));
        let off = Vector3::new(end.x - begin.x, end.y - begin.y, turn);
        lever(&-at(end)) * off + self.sums[to] - self.sums[from]
    }

    /// The covariance of the errors of two spans.
    pub(super) fn shared(&self, one: Span, other: Span) -> Matrix3<f64> {
        let own = self.own(one, other).unwrap_or_else(Matrix3::zeros);
        own + self.common(one) * self.common(other).transpose()
    }

    /// The same of the errors that travels have of their own, if the spans have travels in common.
    pub(super) fn own(&self, one: Span, other: Span) -> Option<Matrix3<f64>> {
        let (from, to) = (one.from.max(other.from), one.to.min(other.to));
        (from < to).then(|| self.own[to] - self.own[from])
    }

    /// What the errors that are the same on all travels do to a span.
    pub(super) fn common(&self, span: Span) -> Matrix3<f64> {
        self.common[span.to] - self.common[span.from]
    }

    /// A covariance with the loops, in units of theirs.
    pub(super) fn in_units(&self, mut covariance: DVector<f64>) -> Option<DVector<f64>> {
        self.root.solve_lower_triangular_mut(&mut covariance).then_some(covariance)
    }

    /// The covariance that two loops have of the visits they have in common. Both ends of a loop are one spot: what either
    /// adds is taken where the loop ends, so that no heading swings what lies between the two.
    fn stays(&self, one: &Loop, other: &Loop) -> Matrix3<f64> {
        if one.span.from != other.span.from {
            return Matrix3::zeros();
        }
        let mut stay = one.stay;
        if one.span.to == other.span.to {
            let heading = if one.turn.is_some() { one.stay.z } else { UNKNOWN };
            stay += Vector3::new(one.stay.x, one.stay.y, heading);
        }
        let [to, and] = [one, other].map(|closing| lever(&-at(&self.poses[closing.span.to])));
        to * Matrix3::from_diagonal(&stay) * and.transpose()
    }

    /// The covariance of the loops and a span, in units of the loops.
    pub(super) fn known(&self, span: Span, closing: Option<&Loop>) -> Option<DMatrix<f64>> {
        let mut covariance = DMatrix::zeros(3 * self.loops.len(), 3);
        for (i, one) in self.loops.iter().enumerate() {
            let stays = closing.map_or(Matrix3::zeros(), |closing| self.stays(one, closing));
            let entry = self.shared(one.span, span) + stays;
            covariance.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&entry);
        }
        self.root.solve_lower_triangular_mut(&mut covariance).then_some(covariance)
    }

    fn all_headings(&self) -> Option<DMatrix<f64>> {
        let mut covariance = DMatrix::zeros(3 * self.loops.len(), self.poses.len());
        for (i, one) in self.loops.iter().enumerate() {
            for to in 0..self.poses.len() {
                let column: Matrix3<f64> = self.shared(one.span, Span { from: 0, to });
                covariance.fixed_view_mut::<3, 1>(3 * i, to).copy_from(&column.column(2));
            }
        }
        self.root.solve_lower_triangular_mut(&mut covariance).then_some(covariance)
    }
}

/// The loop that a visit closes with the first one to its place since the last travel that was not measured.
pub(super) fn closed(story: &Story<'_>, visit: usize) -> Option<Loop> {
    let measured =
        |&visit: &usize| story.stays[visit].travelled.is_some_and(|travelled| travelled.leg.is_some());
    let since = (1..=visit).rev().find(|visit| !measured(visit)).unwrap_or(0);
    let from = (since..visit).find(|&before| story.place(before) == story.place(visit))?;
    let turns = link(story, visit).zip(link(story, from));
    let extent = story.parameters.extent_sigma.powi(2);
    let stay = Vector3::new(extent, extent, story.parameters.bearing_sigma.powi(2));
    let turn = turns.map(|(to, from)| to.pose.theta - from.pose.theta);
    Some(Loop { span: Span { from, to: visit }, turn, stay })
}

fn at(pose: &Pose) -> Vector {
    pose.position().coords
}
