//! What a trace tells the patchwork: a frame for each observation, what was measured between them, and what was seen
//! around each.

use crate::geometry::{Point, Pose};
use crate::grid::{GridError, OccupancyGrid};
use crate::lpm::Lpm;
use crate::metric::Measurements;
use crate::patchwork::agreement::Neighbourhood;
use crate::patchwork::local_frames::Displacement;
use crate::patchwork::merged::{Piece, merged};
use crate::star::PerceptionParameters;
use crate::trace::perceive::perceive;
use crate::trace::{Event, EventKind, Experience, ExperienceError, Percept};

/// What a trace tells the patchwork. Frames have the axes of the observation and their origin at the point of the place.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The travel to each observation as measured.
    pub travels: Vec<Option<Displacement>>,
    /// What each shows.
    pub visits: Vec<Neighbourhood>,
    /// The point of the place in the frame of each observation, and the grid there, if it came as one.
    grids: Vec<(Point, Option<OccupancyGrid>)>,
}

impl Survey {
    /// Of the events of a trace. Costs a description of each LPM.
    pub fn of<'a>(events: impl IntoIterator<Item = &'a Event>) -> Result<Survey, ExperienceError> {
        let describe = |lpm: &Lpm, first| perceive(lpm, first, &PerceptionParameters::default());
        let mut experience = Experience::new();
        let mut measured = Measurements::default();
        let mut survey = Survey::default();
        for event in events {
            let Some(sighting) = experience.accept(event, &describe)? else { continue };
            measured = measured.with(&sighting);
            let bearings = sighting.star.slots().iter().map(|slot| slot.bearing).collect();
            let lpm = lpm(event);
            survey.visits.push(match lpm {
                Some(lpm) => Neighbourhood::new(lpm, &sighting.middle, bearings),
                None => Neighbourhood::of_star(bearings),
            });
            survey.grids.push((sighting.middle, lpm.map(|lpm| lpm.grid.clone())));
        }
        survey.travels = measured.displacements();
        Ok(survey)
    }

    /// Whether any travel was measured.
    pub fn is_measured(&self) -> bool {
        self.travels.iter().any(Option::is_some)
    }

    /// The point of the place in the frame of an observation, metres.
    pub fn point(&self, observation: usize) -> Option<Point> {
        Some(self.grids.get(observation)?.0)
    }

    /// All grids laid over each other, with the frames of the observations in these poses, in cells of so many metres;
    /// `None` where the trace has none.
    pub fn grid(&self, poses: &[Pose], resolution: f64) -> Result<Option<OccupancyGrid>, GridError> {
        let mut found: Vec<(&OccupancyGrid, Pose)> = Vec::new();
        for ((point, grid), pose) in self.grids.iter().zip(poses) {
            let back = Pose::new(-point.x, -point.y, 0.0);
            found.extend(grid.iter().map(|grid| (grid, pose.compose(&back))));
        }
        let pieces: Vec<Piece<'_>> = found.iter().map(|&(grid, pose)| Piece { grid, pose }).collect();
        merged(&pieces, resolution)
    }
}

fn lpm(event: &Event) -> Option<&Lpm> {
    let EventKind::Observation(seen) = &event.kind else { return None };
    match &seen.percept {
        Percept::Lpm(lpm) => Some(lpm),
        Percept::Star { .. } | Percept::View(_) => None,
    }
}
