//! The patchwork of a map: where its places lie, what strains them, and one grid of all that was seen.

use crate::abduction::{Assignment, Report};
use crate::cli::failure::Failure;
use crate::cli::files::Named;
use crate::cli::input::Way;
use crate::export::{
    self, MapStrain, RelaxationOutcome, StrainSum, WallsCompared, WayRelaxed, WayStrain, map_png, map_yaml,
};
use crate::geometry::Pose;
use crate::grid::OccupancyGrid;
use crate::grid::occupancy::MAX_SIDE;
use crate::patchwork::assembly::{RelaxedDrive, Stop};
use crate::patchwork::closures::{Agreements, Closure};
use crate::patchwork::format::{write_g2o, write_trajectory};
use crate::patchwork::local_frames::{LocalFrames, LocalFramesError, graph};
use crate::patchwork::merged::{Canvas, MergeError};
use crate::patchwork::survey::Survey;
use crate::patchwork::ties::Ties;

/// A candidate map relaxed.
pub(super) struct Patchwork<'a> {
    pub(super) strain: MapStrain,
    /// The way of a log, scan by scan.
    pub(super) trajectories: Option<Trajectories>,
    survey: &'a Survey,
    way: &'a Way,
    frames: LocalFrames,
    /// The frames of a log's way, relaxed.
    driven: Vec<Pose>,
}

/// The pose at every scan with its stamp.
pub(super) struct Trajectories {
    pub(super) by_map: Vec<(f64, Pose)>,
    pub(super) by_scans: Vec<(f64, Pose)>,
}

/// The patchwork of a candidate, the visits of which are of these observations; nothing where no travel was measured.
pub(super) fn patchwork<'a>(
    survey: &'a Survey,
    agreements: &mut Agreements<'_>,
    candidate: &[Assignment],
    way: &'a Way,
    told: &[Option<usize>],
) -> Result<Option<Patchwork<'a>>, LocalFramesError> {
    if !survey.is_measured() {
        return Ok(None);
    }
    let frames = survey.relax(candidate, agreements, &|| false)?;
    let strain = MapStrain::of(&frames);
    if way.drive.frames().is_empty() {
        return Ok(Some(Patchwork { strain, trajectories: None, survey, way, frames, driven: Vec::new() }));
    }
    // The origin of a visit's frame is the point of its place, not that of its LPM.
    let stop = |(visit, observation): (usize, &Option<usize>)| {
        let (stop, point) = (way.stops.get((*observation)?)?, survey.point(visit)?);
        let local_from_visit = stop.local_from_visit.compose(&Pose::new(point.x, point.y, 0.0));
        Some((visit, Stop { local_from_visit, ..*stop }))
    };
    let (visits, stops): (Vec<usize>, Vec<Stop>) = told.iter().enumerate().filter_map(stop).unzip();
    let stop_of = |visit: usize| visits.iter().position(|&other| other == visit);
    let closures = frames.closures.iter().filter_map(|closure| {
        let [earlier, later] = closure.visits.map(stop_of);
        Some(Closure { visits: [earlier?, later?], ..*closure })
    });
    let relaxed = RelaxedDrive::new(&way.drive, &stops, &closures.collect::<Vec<_>>())?;
    let trajectories = Some(Trajectories {
        by_map: way.drive.trajectory(&relaxed.by_map.poses),
        by_scans: way.drive.trajectory(&relaxed.by_scans.poses),
    });
    let strain = MapStrain { way: Some(WayStrain::of(&relaxed)), ..strain };
    Ok(Some(Patchwork { strain, trajectories, survey, way, frames, driven: relaxed.by_scans.poses }))
}

impl Patchwork<'_> {
    /// The files of the patchwork: the grid as a `map_server` pair, a picture of the same by odometry alone, the graph of the
    /// visits, and the way of a log. Cells are of so many metres, if that is not too many cells.
    pub(super) fn files(&self, resolution: f64) -> Result<Vec<Named>, Failure> {
        let (mut files, mut resolution) = (Vec::new(), resolution);
        if let Some(grid) = self.grid(resolution) {
            // What is beside it is to be compared with it.
            resolution = grid.info().resolution;
            files.push(("patchwork.png".to_owned(), map_png(&grid).map_err(broken)?));
            files.push(("patchwork.yaml".to_owned(), map_yaml(&grid, "patchwork.png").into_bytes()));
        }
        if let Some(grid) = self.grid_by_odometry(resolution)? {
            files.push(("odometry.png".to_owned(), map_png(&grid).map_err(broken)?));
        }
        let graph = graph(&self.survey.travels(), &self.frames.closures).map_err(broken)?;
        let graph = graph.with_guesses(&self.frames.poses);
        files.push(("patchwork.g2o".to_owned(), write_g2o(&graph).into_bytes()));
        if let Some(trajectories) = &self.trajectories {
            files.push(("trajectory.tum".to_owned(), write_trajectory(&trajectories.by_scans).into_bytes()));
        }
        Ok(files)
    }

    /// The scans of a log along its way, or else the LPMs of a trace.
    fn grid(&self, resolution: f64) -> Option<OccupancyGrid> {
        fitted("patchwork.png", resolution, |canvas| match self.driven.is_empty() {
            true => self.survey.grid(&self.frames, canvas, &|| false),
            false => self.way.drive.grid(&self.driven, canvas),
        })
    }

    /// The same where the robot was by its odometry.
    fn grid_by_odometry(&self, resolution: f64) -> Result<Option<OccupancyGrid>, Failure> {
        let frames = self.way.drive.frames();
        if !frames.is_empty() {
            let poses: Vec<Pose> = frames.iter().map(|frame| frame.sweep.odom_from_robot).collect();
            return Ok(fitted("odometry.png", resolution, |canvas| self.way.drive.grid(&poses, canvas)));
        }
        let open = LocalFrames::relax(&self.survey.travels(), Vec::new(), &|| false).map_err(broken)?;
        Ok(fitted("odometry.png", resolution, |canvas| self.survey.grid(&open, canvas, &|| false)))
    }
}

/// What strains the preferred map and the way of a log, in words.
pub(super) fn strain_in_words(MapStrain { strain, way, .. }: &MapStrain) -> String {
    let ended = |outcome: RelaxationOutcome| match outcome {
        RelaxationOutcome::Converged => "",
        RelaxationOutcome::OutOfIterations => ", which is not the least: out of steps",
        RelaxationOutcome::Interrupted => ", which is not the least: it was told to stop",
        RelaxationOutcome::Stalled => ", which may not be the least: rounding keeps it from falling",
        RelaxationOutcome::Overflow => ", which is beyond what a number holds",
    };
    let StrainSum { chi_square, degrees_of_freedom, outcome, .. } = strain;
    let mut text = format!(
        "\npatchwork: strain {chi_square:.1} with {degrees_of_freedom} degrees of freedom{}\n",
        ended(*outcome)
    );
    let differ = strain.edges.iter().filter(|edge| edge.walls == Some(WallsCompared::Differ));
    for [first, later] in differ.map(|edge| edge.observations) {
        text += &format!("  the walls seen at observations {first} and {later} do not lie on each other\n");
    }
    let Some(WayStrain { frames, by_map, by_scans, passes }) = way else { return text };
    let both = [("by the map", by_map), ("with passes laid onto each other", by_scans)];
    text += &format!("  the way: {frames} frames, {passes} pairs of them on different passes\n");
    for (by, WayRelaxed { chi_square, degrees_of_freedom, outcome, .. }) in both {
        let ended = ended(*outcome);
        text += &format!(
            "    {by}: strain {chi_square:.1} with {degrees_of_freedom} degrees of freedom{ended}\n"
        );
    }
    text
}

/// Puts maps that are equally simple in the order of what strains them, or tells people why not; what does.
pub(super) fn rank(
    found: &mut Report,
    survey: &Survey,
    agreements: &mut Agreements<'_>,
) -> Option<export::Ties> {
    let ties = or_left_out("the strain of ties", Ties::rank(found, survey, agreements, &|| false))?;
    Some(export::Ties::of(&ties))
}

/// What is made beside a map, or people are told why it is left out: the map does not depend on it.
pub(super) fn or_left_out<T>(what: &str, made: Result<Option<T>, impl std::fmt::Display>) -> Option<T> {
    made.unwrap_or_else(|error| {
        eprintln!("{what} is left out: {error}");
        None
    })
}

/// A grid in cells of so many metres, or, where it would be too large, in coarser ones, which people are told.
fn fitted(
    name: &str,
    resolution: f64,
    make: impl Fn(&Canvas) -> Result<Option<OccupancyGrid>, MergeError>,
) -> Option<OccupancyGrid> {
    let canvas = Canvas { resolution, most_cells: MAX_SIDE * MAX_SIDE };
    let made = match make(&canvas) {
        Err(MergeError::TooLarge { width, height, fitting, .. }) => {
            eprintln!(
                "{name} has cells of {fitting} m, as of {resolution} m it would be {width} x {height} of them"
            );
            make(&Canvas { resolution: fitting, ..canvas })
        }
        made => made,
    };
    or_left_out(name, made)
}

fn broken(error: impl std::fmt::Display) -> Failure {
    Failure::Broken(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Cell, GridInfo};

    #[test]
    fn a_grid_too_large_is_made_in_cells_that_fit() {
        let made = fitted("grid.png", 0.01, |canvas| match canvas.resolution {
            0.03 => {
                let info = GridInfo { resolution: 0.03, width: 1, height: 1, origin: Pose::IDENTITY };
                Ok(Some(OccupancyGrid::new(info, vec![Cell::Free])?))
            }
            _ => Err(MergeError::TooLarge { width: 9000, height: 1, most_cells: 9, fitting: 0.03 }),
        });
        assert!(made.is_some_and(|grid| grid.info().resolution == 0.03));
        let never = MergeError::TooLarge { width: 9000, height: 1, most_cells: 9, fitting: 0.03 };
        assert!(fitted("grid.png", 0.01, |_| Err(never.clone())).is_none());
    }
}
