//! The measurements of a trace, growing by a visit at a time.

use crate::abduction::{AxiomId, Clash, Evidence, Learned, Proposal};
use crate::geometry::Pose;
use crate::metric::breach::Breach;
use crate::metric::crowd::{Patience, Room};
use crate::metric::frames::{Story, learned};
use crate::metric::layout::Span;
use crate::metric::leg::Travelled;
use crate::metric::share::SHARES;
use crate::metric::{MetricParameters, angle, apart, closure, distance};
use crate::star::SlotIndex;
use crate::trace::Sighting;
use nalgebra::Matrix3;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What was measured on a trace, from its first observation to the latest.
///
/// An immutable value: [`Measurements::with`] gives another one, which shares all visits with it, at the cost of a
/// pointer a visit. As [`Evidence`] it says nothing as long as no travel has odometry and a covariance, and across a
/// travel that has none it knows nothing.
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    parameters: MetricParameters,
    stays: Vec<Arc<Stay>>,
    last: Option<Arc<Sighting>>,
    /// The first observation that a measured travel led to.
    since: Option<usize>,
    /// Shared by all that are made from one.
    problems: Arc<AtomicU64>,
}

/// What was measured on one visit and on the travel to it. Slots are those of the star as observed.
#[derive(Debug)]
pub(super) struct Stay {
    /// Outward bearings of the slots in the frame of the visit, radians.
    pub(super) bearings: Vec<Option<f64>>,
    /// The slot of the visit before by which the robot left.
    pub(super) departure: Option<SlotIndex>,
    /// The slot whose outward gateway it came in by.
    pub(super) gateway: SlotIndex,
    /// The travel.
    pub(super) travelled: Option<Travelled>,
}

impl Measurements {
    /// No measurements yet, to be judged with these bounds.
    pub fn new(parameters: MetricParameters) -> Self {
        Measurements { parameters, ..Measurements::default() }
    }

    /// These measurements and those of one more observation.
    #[must_use]
    pub fn with(&self, sighting: &Sighting) -> Measurements {
        let before = self.last.as_deref();
        let travel = sighting.motion.as_ref().zip(before);
        let travelled =
            travel.map(|(motion, before)| Travelled::new(motion, before, sighting, &self.parameters));
        let stay = Stay {
            bearings: sighting.star.slots().iter().map(|slot| slot.bearing).collect(),
            departure: sighting.departure,
            gateway: sighting.star.opposite(sighting.arrival),
            travelled,
        };
        let since = self.since.or(travelled.map(|_| self.stays.len()));
        let stays = self.stays.iter().cloned().chain([Arc::new(stay)]).collect();
        let (last, problems) = (Some(Arc::new(sighting.clone())), Arc::clone(&self.problems));
        Measurements { parameters: self.parameters, stays, last, since, problems }
    }

    /// Whether any travel was measured.
    pub fn any(&self) -> bool {
        self.since.is_some()
    }

    /// How many least-squares problems were solved in searches for room, by these measurements and all that were made from the
    /// same ones, of each search at most as many as it may solve: what was done, whatever it took and on how many threads. No
    /// answer depends on it.
    pub fn problems(&self) -> u64 {
        self.problems.load(Ordering::Relaxed)
    }

    /// The travel to each observation as measured: the frame of the observation in that of the one before, and the
    /// covariance of x, y, heading in the latter. Frames have the axes of the observation and their origin at the point
    /// of the place. `None` for the first observation, and where the heading at its beginning or the travel was not
    /// measured.
    pub fn displacements(&self) -> Vec<Option<(Pose, Matrix3<f64>)>> {
        let displacement = |stay: &Arc<Stay>| {
            let leg = stay.travelled?.leg?;
            Some((leg.pose, leg.odometry + leg.stay))
        };
        self.stays.iter().map(displacement).collect()
    }

    /// Whether any travel was measured, so that [`Measurements::displacements`] has it.
    pub fn any_displacement(&self) -> bool {
        self.stays.iter().any(|stay| stay.travelled.is_some_and(|travelled| travelled.leg.is_some()))
    }

    /// These measurements as evidence, if there are any.
    pub fn evidence(&self) -> Option<Arc<dyn Evidence>> {
        self.any().then(|| Arc::new(self.clone()) as Arc<dyn Evidence>)
    }

    /// Whether chi-square has to grow by more than a gate, from the least with which all loops close, for the robot to
    /// have stood on two visits so many metres apart, if a proposal holds: the profile of the likelihood, by which
    /// `apart` judges. One answer for each range of the share of heading errors that is the same on all travels: by how
    /// much it grows at least, if that is more than the gate. `None` otherwise; where no likely errors close the loops;
    /// where the way between the visits was not measured; and where it is not found out.
    pub fn to_part(
        &self,
        proposal: &Proposal<'_>,
        visits: [usize; 2],
        distance: f64,
        gate: f64,
    ) -> Vec<Option<f64>> {
        let span = Span { from: visits[0].min(visits[1]), to: visits[0].max(visits[1]) };
        let known = proposal.branch.visits().len();
        let Some(stays) = self.stays.get(..=known).filter(|_| span.to <= known) else { return Vec::new() };
        apart::to_part(&self.story(stays, proposal), span, distance, gate).into()
    }

    /// How many ranges there are of the share of heading errors that is the same on all travels.
    pub const RANGES: usize = SHARES.len();

    /// Whether the robot can have stood so many metres apart on the first visits to any two places, if a proposal holds, all at
    /// once, and path segments whose way is known cross nowhere and lead past no place: by which `apart` judges too, with [`Patience::Short`]. Asked of one range of the share of heading errors that is the
    /// same on all travels, by number; `None` where no likely errors close the loops. What is lacking is lacking as far as a
    /// descent from the likeliest errors finds the least chi-square. What is found is short of the distance by 3.5 % at most,
    /// of which a polygon falls short of a circle, and a centimetre; that it is so, and within the gate, is looked at once
    /// more without derivatives ([`Witness`](crate::metric::Witness)). Up to 6,000 or 120,000 least-squares problems, each cubic in the loops and quadratic in the conditions.
    pub fn room(
        &self,
        proposal: &Proposal<'_>,
        range: usize,
        distance: f64,
        patience: Patience,
    ) -> Option<Room> {
        let known = proposal.branch.visits().len();
        let stays = self.stays.get(..=known).filter(|_| range < Measurements::RANGES)?;
        apart::room(&self.story(stays, proposal), range, distance, patience)
    }

    fn story<'a>(&'a self, stays: &'a [Arc<Stay>], proposal: &Proposal<'a>) -> Story<'a> {
        Story::new(stays, proposal, &self.parameters, &self.problems)
    }

    /// What is made of how the proposal breaks the axiom, if it does.
    fn judge<T>(
        &self,
        axiom: AxiomId,
        proposal: &Proposal<'_>,
        make: impl FnOnce(&Breach, &Story<'_>) -> T,
    ) -> Option<T> {
        let observation = proposal.branch.visits().len();
        let stays = self.stays.get(..=observation)?;
        if self.since.is_none_or(|since| since > observation) {
            return None;
        }
        let story = self.story(stays, proposal);
        let breach = match axiom {
            AxiomId::Distance => distance::breach(&story),
            AxiomId::Angle => angle::breach(&story),
            AxiomId::Closure => closure::breach(&story),
            AxiomId::Apart => apart::breach(&story),
            _ => None,
        };
        breach.map(|breach| make(&breach, &story))
    }
}

impl Evidence for Measurements {
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool {
        self.judge(axiom, proposal, |_, _| ()).is_none()
    }

    fn clash(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> Clash {
        self.judge(axiom, proposal, Breach::clash).unwrap_or_default()
    }

    fn learned(&self, proposal: &Proposal<'_>) -> Learned {
        learned(proposal)
    }
}
