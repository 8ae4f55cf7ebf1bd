//! What a trace tells the patchwork: a frame for each observation, what was measured between them, and what was seen
//! around each.

use crate::abduction::Assignment;
use crate::geometry::{Point, Pose};
use crate::grid::OccupancyGrid;
use crate::lpm::Lpm;
use crate::metric::{Measurements, MetricParameters};
use crate::patchwork::agreement::Neighbourhood;
use crate::patchwork::closures::Agreements;
use crate::patchwork::local_frames::{Displacement, LocalFrames, LocalFramesError};
use crate::patchwork::merged::{Canvas, MergeError, Piece, merged};
use crate::star::PerceptionParameters;
use crate::trace::perceive::perceive;
use crate::trace::{Event, EventKind, Experience, ExperienceError, Percept, Sighting};
use std::sync::Arc;

/// What a trace tells the patchwork. Frames have the axes of the observation and their origin at the point of the place.
///
/// An immutable value: [`Survey::with`] gives another one, which shares all that was seen with it, at the cost of a
/// pointer an observation. Walls are looked for only where a candidate needs them.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    measurements: Measurements,
    seen: Vec<Arc<Seen>>,
}

/// One observation.
#[derive(Debug)]
struct Seen {
    event: Arc<Event>,
    /// The point of the place in the frame of the observation.
    point: Point,
    /// Outward bearings of the slots of the star.
    bearings: Vec<Option<f64>>,
}

impl Survey {
    /// Of the events of a trace. Costs a description of each LPM.
    pub fn of<'a>(events: impl IntoIterator<Item = &'a Arc<Event>>) -> Result<Survey, ExperienceError> {
        let describe = |lpm: &Lpm, first| perceive(lpm, first, &PerceptionParameters::default());
        let mut experience = Experience::new();
        let mut survey = Survey::default();
        for event in events {
            if let Some(sighting) = experience.accept(event, &describe)? {
                survey = survey.with(event, &sighting);
            }
        }
        Ok(survey)
    }

    /// The same and one more observation: the event, and what it told.
    #[must_use]
    pub fn with(&self, event: &Arc<Event>, sighting: &Sighting) -> Survey {
        let seen = Seen {
            event: Arc::clone(event),
            point: sighting.middle,
            bearings: sighting.star.slots().iter().map(|slot| slot.bearing).collect(),
        };
        Survey {
            measurements: self.measurements.with(sighting),
            seen: self.seen.iter().cloned().chain([Arc::new(seen)]).collect(),
        }
    }

    /// How many observations there are.
    pub fn len(&self) -> usize {
        self.seen.len()
    }

    /// Whether there is no observation.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// What was measured, as the axioms take it.
    pub fn measurements(&self) -> &Measurements {
        &self.measurements
    }

    /// Whether any travel was measured.
    pub fn is_measured(&self) -> bool {
        self.measurements.any() && self.measurements.any_displacement()
    }

    /// Whether any observation came as a grid.
    pub fn has_grids(&self) -> bool {
        self.seen.iter().any(|seen| seen.lpm().is_some())
    }

    /// The travel to each observation as measured.
    pub fn travels(&self) -> Vec<Option<Displacement>> {
        self.measurements.displacements()
    }

    /// The point of the place in the frame of an observation, metres.
    pub fn point(&self, observation: usize) -> Option<Point> {
        Some(self.seen.get(observation)?.point)
    }

    /// What an observation shows of its place; `None` where there is none, or `interrupted` said to stop. Costs the cells of
    /// its LPM.
    pub fn neighbourhood(&self, observation: usize, interrupted: &dyn Fn() -> bool) -> Option<Neighbourhood> {
        let seen = self.seen.get(observation)?;
        match seen.lpm() {
            Some(lpm) => Neighbourhood::new(lpm, &seen.point, seen.bearings.clone(), interrupted),
            None => Some(Neighbourhood::of_star(seen.bearings.clone())),
        }
    }

    /// What its observations show of each other, with the bounds of the measured axioms.
    pub fn agreements(&self) -> Agreements<'_> {
        let MetricParameters { extent_sigma, bearing_sigma, .. } = MetricParameters::default();
        let show = |observation, interrupted: &dyn Fn() -> bool| self.neighbourhood(observation, interrupted);
        Agreements::new(show, [extent_sigma, bearing_sigma])
    }

    /// A candidate relaxed; `agreements` are those of this survey. Stops where `interrupted` says so.
    pub fn relax(
        &self,
        candidate: &[Assignment],
        agreements: &mut Agreements<'_>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<LocalFrames, LocalFramesError> {
        let closures = agreements.closures(candidate, interrupted)?;
        LocalFrames::relax(&self.travels(), closures, interrupted)
    }

    /// The grids of all observations that hang together with the first, laid over each other with the frames as they lie;
    /// `None` where there are none.
    pub fn grid(
        &self,
        frames: &LocalFrames,
        canvas: &Canvas,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<OccupancyGrid>, MergeError> {
        let placed = self.seen.iter().zip(&frames.poses).zip(&frames.parts);
        let pieces: Vec<Piece<'_>> = placed
            .filter(|(_, part)| **part == 0)
            .filter_map(|((seen, pose), _)| {
                let back = Pose::new(-seen.point.x, -seen.point.y, 0.0);
                Some(Piece { grid: &seen.lpm()?.grid, pose: pose.compose(&back) })
            })
            .collect();
        merged(&pieces, canvas, interrupted)
    }
}

impl Seen {
    fn lpm(&self) -> Option<&Lpm> {
        let EventKind::Observation(seen) = &self.event.kind else { return None };
        match &seen.percept {
            Percept::Lpm(lpm) => Some(lpm),
            Percept::Star { .. } | Percept::View(_) => None,
        }
    }
}
