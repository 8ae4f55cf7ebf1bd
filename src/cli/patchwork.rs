//! The patchwork of a map: where its places lie, what strains them, and one grid of all that was seen.

use crate::abduction::Assignment;
use crate::cli::failure::Failure;
use crate::cli::input::Way;
use crate::export::{MapStrain, map_png, map_yaml};
use crate::geometry::Pose;
use crate::grid::OccupancyGrid;
use crate::metric::MetricParameters;
use crate::patchwork::assembly::{RelaxedDrive, Stop};
use crate::patchwork::format::write_trajectory;
use crate::patchwork::local_frames::{Agreements, LocalFrames};
use crate::patchwork::survey::Survey;
use crate::trace::Event;
use std::sync::Arc;

/// Side of a cell of the patchwork's grid, metres.
const RESOLUTION: f64 = 0.05;

/// A candidate map relaxed.
pub(super) struct Patchwork {
    pub(super) strain: MapStrain,
    /// The way of a log, scan by scan.
    pub(super) trajectories: Option<Trajectories>,
    grid: Option<OccupancyGrid>,
}

/// The pose at every scan with its stamp.
pub(super) struct Trajectories {
    pub(super) by_map: Vec<(f64, Pose)>,
    pub(super) by_scans: Vec<(f64, Pose)>,
}

/// The patchwork of a candidate; nothing where no travel was measured.
pub(super) fn patchwork(
    events: &[Arc<Event>],
    candidate: &[Assignment],
    way: &Way,
) -> Result<Option<Patchwork>, Failure> {
    let broken = |error: &dyn std::fmt::Display| Failure::Broken(error.to_string());
    let survey = Survey::of(events.iter().map(Arc::as_ref)).map_err(|error| broken(&error))?;
    if !survey.is_measured() {
        return Ok(None);
    }
    let MetricParameters { extent_sigma, bearing_sigma, .. } = MetricParameters::default();
    let mut agreements = Agreements::new(survey.visits.clone(), [extent_sigma, bearing_sigma]);
    let closures = agreements.closures(candidate);
    let frames = LocalFrames::relax(&survey.travels, closures).map_err(|error| broken(&error))?;
    let strain = MapStrain::of(&frames);
    if way.drive.frames().is_empty() {
        let grid = survey.grid(&frames.poses, RESOLUTION).map_err(|error| broken(&error))?;
        return Ok(Some(Patchwork { strain, trajectories: None, grid }));
    }
    // The origin of a visit's frame is the point of its place, not that of its LPM.
    let stop = |(visit, stop): (usize, &Stop)| {
        let point = survey.point(visit)?;
        let local_from_visit = stop.local_from_visit.compose(&Pose::new(point.x, point.y, 0.0));
        Some(Stop { local_from_visit, ..*stop })
    };
    let stops: Vec<Stop> = way.stops.iter().enumerate().filter_map(stop).collect();
    let relaxed = RelaxedDrive::new(&way.drive, &stops, &frames.closures).map_err(|error| broken(&error))?;
    let grid = way.drive.grid(&relaxed.by_scans.poses, RESOLUTION).map_err(|error| broken(&error))?;
    let trajectories = Trajectories {
        by_map: way.drive.trajectory(&relaxed.by_map.poses),
        by_scans: way.drive.trajectory(&relaxed.by_scans.poses),
    };
    Ok(Some(Patchwork { strain, trajectories: Some(trajectories), grid }))
}

impl Patchwork {
    /// The files of the patchwork: the grid as a `map_server` pair, and the way of a log.
    pub(super) fn files(&self) -> Result<Vec<(String, Vec<u8>)>, Failure> {
        let mut files = Vec::new();
        if let Some(grid) = &self.grid {
            let png = map_png(grid).map_err(|error| Failure::Broken(error.to_string()))?;
            files.push(("patchwork.png".to_owned(), png));
            files.push(("patchwork.yaml".to_owned(), map_yaml(grid, "patchwork.png").into_bytes()));
        }
        if let Some(trajectories) = &self.trajectories {
            files.push(("trajectory.tum".to_owned(), write_trajectory(&trajectories.by_scans).into_bytes()));
        }
        Ok(files)
    }
}
