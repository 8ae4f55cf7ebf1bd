//! Places and path segments on one floor, moved out of each other's way, to first order.
//!
//! That two places lie apart, or that a segment is clear of what is in its way, is that one of several linear conditions on
//! errors holds; what several take together is a least-squares problem under inequalities.

use crate::geometry::{Pose, lever};
use crate::metric::bound::Bound;
use crate::metric::condition::{Condition, ahead};
use crate::metric::conflicts::Ways;
use crate::metric::crowd::InTheWay;
use crate::metric::layout::{Layout, Span};
use crate::metric::profile::{Reached, pulls, taken};
use crate::metric::segments::{Clear, Segments};
use crate::metric::sides::{Pair, Side, inner};
use crate::metric::witness::Witness;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Rotation2};
use rustc_hash::FxHashMap;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

/// How far within a bound a visit is on it, metres: rounding, and pulls that are not quite the best.
const MET: f64 = 1e-3;

/// At most so many covariances are remembered, some 30 MB.
const COVARIANCES: usize = 1 << 20;

/// One of several ways in which two things have room beside each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Apart {
    /// Two places.
    Beyond(Side),
    /// A segment, and a place or another segment.
    Clear(Clear),
}

/// Places and segments on one floor.
pub(super) struct Floor<'a> {
    layout: &'a Layout,
    segments: &'a Segments,
    /// How far apart places are, metres.
    separation: f64,
    /// The first visit that all is seen from.
    since: usize,
    /// The covariances of loops and the twist from there to each visit, in units of the loops.
    known: Vec<DMatrix<f64>>,
    made: RefCell<Made>,
}

/// A condition of having room, made once.
struct Known {
    apart: Apart,
    /// The bound that it is made of, and how many were made before.
    bound: Bound,
    number: u32,
    condition: Condition,
}

/// Conditions made so far, and the covariances asked for.
#[derive(Default)]
struct Made {
    conditions: FxHashMap<Apart, Vec<Rc<Known>>>,
    count: u32,
    /// Never more than [`COVARIANCES`]; asked for again they are the same.
    covariances: FxHashMap<(u32, u32), f64>,
}

/// Least squares within some bounds.
pub(super) struct Solved {
    /// What it takes beyond the chi-square of the loops.
    pub(super) chi_square: f64,
    /// Those of the bounds that bear, and the factor of their covariance.
    bearing: Vec<Rc<Known>>,
    root: Option<DMatrix<f64>>,
    /// How hard these pull.
    pulls: Vec<f64>,
}

impl Solved {
    /// What the bounds that bear are for, ascending, each once.
    pub(super) fn bearing(&self) -> Vec<Apart> {
        let bearing: BTreeSet<Apart> = self.bearing.iter().map(|known| known.apart).collect();
        bearing.into_iter().collect()
    }

    /// How many bounds bear.
    pub(super) fn degrees(&self) -> usize {
        self.bearing.len()
    }
}

impl<'a> Floor<'a> {
    /// Of first visits and segments measured in between.
    pub(super) fn new(layout: &'a Layout, segments: &'a Segments, separation: f64) -> Option<Floor<'a>> {
        let &(since, _) = segments.firsts.first()?;
        let known = (since..layout.poses.len()).map(|to| layout.known(Span { from: since, to }, None));
        let known = known.collect::<Option<_>>()?;
        Some(Floor { layout, segments, separation, since, known, made: RefCell::default() })
    }

    /// The first visit that all is seen from.
    pub(super) fn since(&self) -> usize {
        self.since
    }

    /// The least that it takes to have all of these hold.
    pub(super) fn solve(&self, chosen: &[Apart]) -> Solved {
        let conditions: Vec<Rc<Known>> = chosen.iter().flat_map(|&apart| self.conditions(apart)).collect();
        let size = conditions.len();
        let mut covariance = DMatrix::zeros(size, size);
        for (k, one) in conditions.iter().enumerate() {
            for (l, other) in conditions[..=k].iter().enumerate() {
                let entry = self.covariance(one, other);
                (covariance[(k, l)], covariance[(l, k)]) = (entry, entry);
            }
        }
        let misses = conditions.iter().map(|known| known.bound.within(&self.layout.poses));
        let misses = DVector::from_iterator(size, misses);
        let pulls = pulls(&covariance, &misses);
        let chi_square = taken(&covariance, &misses, &pulls);
        let bear: Vec<usize> = (0..size).filter(|&bound| pulls[bound] < 0.0).collect();
        let root =
            covariance.select_rows(&bear).select_columns(&bear).cholesky().map(|factor| factor.unpack());
        let bearing = bear.iter().map(|&at| Rc::clone(&conditions[at])).collect();
        Solved { chi_square, bearing, root, pulls: bear.iter().map(|&at| pulls[at]).collect() }
    }

    /// What is to hold of any two things on one spot, where all lie as `poses` say or, without these, as they do to first order: one
    /// of some ways, what takes least first. Those that take most to come apart come first, as they end most branches; those that
    /// were chosen to be apart as far as can be said are left out.
    pub(super) fn clashes(
        &self,
        solved: &Solved,
        chosen: &[Apart],
        poses: Option<&[Pose]>,
    ) -> Vec<Ways<Apart>> {
        let moved = self.moved(solved);
        let poses = poses.unwrap_or(&moved);
        let pairs = self.pairs(poses, chosen).into_iter().map(|pair| {
            let pair = Pair { open: self.left_open(solved, pair.span), ..pair };
            (pair.takes(self.separation), self.sides(&pair, chosen))
        });
        let settled = |ways: &[Clear; 4]| ways.iter().any(|way| chosen.contains(&Apart::Clear(*way)));
        let obstructions = self.segments.obstructions(poses, MET).into_iter();
        let ways = obstructions.map(|found| self.segments.ways(&found)).filter(|ways| !settled(ways));
        let obstructed = ways.map(|ways| {
            let mut ways = ways.map(|way| (self.takes(way, solved, poses), way));
            ways.sort_by(|a, b| a.0.total_cmp(&b.0));
            let parts = ways.iter().map(|(_, way)| Apart::Clear(*way)).collect();
            (ways[0].0, Ways { whole: None, parts })
        });
        let mut clashes: Vec<(f64, Ways<Apart>)> = pairs.chain(obstructed).collect();
        clashes.sort_by(|a, b| b.0.total_cmp(&a.0));
        clashes.into_iter().map(|(_, ways)| ways).collect()
    }

    /// What it is to be apart in some ways, as bounds, each nearer by the rest of a share of what lacks to it.
    pub(super) fn bounds(&self, chosen: &[Apart], share: f64) -> Vec<Bound> {
        let nearer = |bound: Bound| {
            let lacks = bound.within(&self.layout.poses).min(0.0);
            Bound { by: bound.by + (1.0 - share) * lacks, ..bound }
        };
        chosen.iter().flat_map(|&apart| self.bounds_of(apart)).map(nearer).collect()
    }

    /// Those of some that bear where all of them are reached, ascending.
    pub(super) fn bearing(&self, chosen: &[Apart], reached: &Reached) -> Vec<Apart> {
        let owners = chosen.iter().flat_map(|&apart| self.bounds_of(apart).into_iter().map(move |_| apart));
        let owners: Vec<Apart> = owners.collect();
        let bearing: BTreeSet<Apart> = reached.bearing.iter().map(|&bound| owners[bound]).collect();
        bearing.into_iter().collect()
    }

    /// What would be in each other's way if this did not hold.
    pub(super) fn otherwise(&self, apart: &Apart) -> InTheWay {
        let ends = |segment: usize| self.segments.all[segment].visits;
        match *apart {
            Apart::Beyond(side) => InTheWay::Places(side.span()),
            Apart::Clear(Clear::Aside { segment, other, .. }) => {
                InTheWay::Segments(ends(segment.max(other)), ends(segment.min(other)))
            }
            Apart::Clear(Clear::Off { segment, visit, .. } | Clear::Past { segment, visit, .. }) => {
                InTheWay::Passing(ends(segment), visit)
            }
        }
    }

    /// Errors with which all have room, if these have it, within a gate over the least.
    pub(super) fn witness(&self, found: &Layout, least: f64, gate: f64) -> Option<Witness> {
        Witness::new(found, self.segments, inner(self.separation), least, gate)
    }

    /// The sides that the later of two visits may be beyond: of a square or, where one of these was chosen, the parts of it.
    fn sides(&self, pair: &Pair, chosen: &[Apart]) -> Ways<Apart> {
        let whole = chosen.iter().find_map(|apart| match apart {
            Apart::Beyond(side) if side.span() == pair.span => Some(*side),
            _ => None,
        });
        let parts = pair.ways(whole, self.separation);
        Ways { whole: whole.map(Apart::Beyond), parts: parts.into_iter().map(Apart::Beyond).collect() }
    }

    fn bounds_of(&self, apart: Apart) -> Vec<Bound> {
        match apart {
            Apart::Beyond(side) => vec![side.bound(self.separation)],
            Apart::Clear(way) => self.segments.bounds(&way),
        }
    }

    /// Where visits lie to first order.
    fn moved(&self, solved: &Solved) -> Vec<Pose> {
        let bearing = solved.bearing.iter().map(|known| &known.condition);
        let ahead = ahead(self.layout, bearing.zip(solved.pulls.iter().copied()));
        // Some: the factor of the loops was used before.
        ahead.map_or_else(|| self.layout.poses.clone(), |ahead| self.layout.moved(&ahead))
    }

    /// Places on one spot, but those that were put beyond a part of a side.
    fn pairs(&self, poses: &[Pose], chosen: &[Apart]) -> Vec<Pair> {
        let settled = chosen.iter().filter_map(|apart| match apart {
            Apart::Beyond(side) if side.is_fine() => Some((side.span().from, side.span().to)),
            _ => None,
        });
        let settled: BTreeSet<(usize, usize)> = settled.collect();
        let firsts = &self.segments.firsts;
        let pairs = (1..firsts.len()).flat_map(|to| (0..to).map(move |from| (firsts[from].0, firsts[to].0)));
        let pair = |(from, to): (usize, usize)| {
            let off = poses[to].position() - poses[from].position();
            let near = off.norm() < self.separation && !settled.contains(&(from, to));
            let seen = || poses[from].inverse().rotate(&off);
            near.then(|| Pair { span: Span { from, to }, off: seen(), open: Matrix2::zeros() })
        };
        pairs.filter_map(pair).filter(|pair| pair.is_within(self.separation, MET)).collect()
    }

    /// What one way to be clear takes, to first order and beside what bears already, where visits lie so.
    fn takes(&self, way: Clear, solved: &Solved, poses: &[Pose]) -> f64 {
        let takes = |known: Rc<Known>| {
            let lacks = known.bound.within(poses).min(0.0);
            if lacks == 0.0 {
                return 0.0;
            }
            let shared = solved.bearing.iter().map(|other| self.covariance(&known, other));
            let mut shared = DVector::from_iterator(solved.bearing.len(), shared);
            let mut variance = self.covariance(&known, &known);
            if let Some(root) = &solved.root
                && root.solve_lower_triangular_mut(&mut shared)
            {
                variance -= shared.norm_squared();
            }
            lacks.powi(2) / variance.max(f64::MIN_POSITIVE)
        };
        self.conditions(Apart::Clear(way)).into_iter().map(takes).fold(0.0, f64::max)
    }

    /// The covariance of where a visit lies, in the frame of another, that the loops and the bounds which bear leave.
    fn left_open(&self, solved: &Solved, span: Span) -> Matrix2<f64> {
        let known = self.known_of(span);
        let at = self.layout.poses[span.to].position();
        let moves: Matrix2x3<f64> = lever(&at.coords).fixed_rows::<2>(0).into_owned();
        let mut covariance =
            moves * (self.layout.shared(span, span) - known.tr_mul(&known)) * moves.transpose();
        let mut shared = DMatrix::zeros(solved.bearing.len(), 2);
        for (row, bearing) in solved.bearing.iter().enumerate() {
            let entry = bearing.condition.left(span, &known, self.layout);
            shared.set_row(row, &(moves * entry).transpose());
        }
        if let Some(root) = &solved.root
            && root.solve_lower_triangular_mut(&mut shared)
        {
            covariance -= shared.tr_mul(&shared).fixed_view::<2, 2>(0, 0);
        }
        let back = Rotation2::new(-self.layout.poses[span.from].theta);
        back.matrix() * covariance * back.matrix().transpose()
    }

    fn conditions(&self, apart: Apart) -> Vec<Rc<Known>> {
        let Made { conditions, count, .. } = &mut *self.made.borrow_mut();
        let known = |bound: Bound| {
            // Some: the factor of the loops was used before.
            let condition = Condition::new(&bound, self.layout)?;
            *count += 1;
            Some(Rc::new(Known { apart, bound, number: *count, condition }))
        };
        let made = || self.bounds_of(apart).into_iter().filter_map(known).collect();
        conditions.entry(apart).or_insert_with(made).clone()
    }

    fn covariance(&self, one: &Known, other: &Known) -> f64 {
        let (one, other) = if one.number < other.number { (one, other) } else { (other, one) };
        let asked = || one.condition.covariance(&other.condition, self.layout);
        let covariances = &mut self.made.borrow_mut().covariances;
        if covariances.len() >= COVARIANCES {
            covariances.clear();
        }
        *covariances.entry((one.number, other.number)).or_insert_with(asked)
    }

    fn known_of(&self, span: Span) -> DMatrix<f64> {
        &self.known[span.to - self.since] - &self.known[span.from - self.since]
    }
}
