//! What strains a map once its local frames are relaxed into one patchwork.

use crate::geometry::Pose;
use crate::patchwork::agreement::Walls;
use crate::patchwork::assembly::RelaxedDrive;
use crate::patchwork::local_frames::{EdgeStrain, LocalFrames};
use crate::patchwork::{Outcome, Relaxation};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The strain of a map: how far travels and closures are from agreeing, in units of their uncertainty. It ranks nothing
/// that the axioms have not left equal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MapStrain {
    /// What strains it.
    #[serde(flatten)]
    pub strain: StrainSum,
    /// The pose of the place of each observation on that visit, in the frame of the first: x, y in metres and heading in
    /// radians. Axes are those of the observation.
    pub poses: Vec<[f64; 3]>,
    /// The way of a log, which is relaxed as well.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub way: Option<WayStrain>,
}

/// The way of a log relaxed: a frame every half metre of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WayStrain {
    /// How many frames it has.
    pub frames: usize,
    /// By odometry, scan matching and the visits that the map takes for one place.
    pub by_map: WayRelaxed,
    /// By pairs of frames on different passes too, laid onto each other.
    pub by_scans: WayRelaxed,
    /// How many pairs that are.
    pub passes: usize,
}

/// How the relaxation of a way ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WayRelaxed {
    /// Chi-square of all that joins the frames.
    pub chi_square: f64,
    /// Numbers measured less numbers sought.
    pub degrees_of_freedom: usize,
    /// How many steps it took.
    pub iterations: usize,
    /// How it ended.
    pub outcome: RelaxationOutcome,
}

/// How a relaxation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RelaxationOutcome {
    /// No step would gain anything.
    Converged,
    /// The bound on steps was reached.
    OutOfIterations,
    /// It was told to stop.
    Interrupted,
    /// Rounding keeps it above the least: numbers are too large or too far apart.
    Stalled,
    /// It is beyond what a number holds.
    Overflow,
}

impl From<Outcome> for RelaxationOutcome {
    fn from(outcome: Outcome) -> RelaxationOutcome {
        match outcome {
            Outcome::Converged => RelaxationOutcome::Converged,
            Outcome::OutOfIterations => RelaxationOutcome::OutOfIterations,
            Outcome::Interrupted => RelaxationOutcome::Interrupted,
            Outcome::Stalled => RelaxationOutcome::Stalled,
            Outcome::Overflow => RelaxationOutcome::Overflow,
        }
    }
}

impl WayStrain {
    /// Of a drive relaxed.
    pub fn of(drive: &RelaxedDrive) -> WayStrain {
        WayStrain {
            frames: drive.by_map.poses.len(),
            by_map: WayRelaxed::of(&drive.by_map),
            by_scans: WayRelaxed::of(&drive.by_scans),
            passes: drive.passes,
        }
    }
}

impl WayRelaxed {
    fn of(answer: &Relaxation) -> WayRelaxed {
        WayRelaxed {
            chi_square: answer.objective,
            degrees_of_freedom: answer.degrees_of_freedom,
            iterations: answer.iterations,
            outcome: answer.outcome.into(),
        }
    }
}

/// The strain of a map relaxed, in all and edge by edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Strain)]
pub struct StrainSum {
    /// Chi-square of all edges.
    pub chi_square: f64,
    /// Numbers measured less numbers sought.
    pub degrees_of_freedom: usize,
    /// Whether relaxation has come to rest.
    pub converged: bool,
    /// How it ended.
    pub outcome: RelaxationOutcome,
    /// The observations whose poses can move without strain, so that where they lie says nothing, though travels or closures
    /// join them to others.
    pub undetermined: Vec<usize>,
    /// What each travel and each closure is strained by.
    pub edges: Vec<StrainedSpan>,
}

/// The strain between two observations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StrainedSpan {
    /// The two observations.
    pub observations: [usize; 2],
    /// Whether this is the travel between them, or else that both are at one place.
    pub travelled: bool,
    /// What the walls seen on the two visits say of their being to one place; null of a travel.
    pub walls: Option<WallsCompared>,
    /// Its chi-square.
    pub chi_square: f64,
    /// How many numbers it measures.
    pub degrees_of_freedom: usize,
}

/// What the walls seen on two visits say of their being to one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallsCompared {
    /// They lie on each other, and the closure says how.
    Alike,
    /// They do not, wherever they are laid: the closure joins the points of the place and the bearings.
    Differ,
    /// A visit shows none: the same closure.
    Untold,
}

impl WallsCompared {
    fn of(walls: Walls) -> WallsCompared {
        match walls {
            Walls::Alike => WallsCompared::Alike,
            Walls::Differ => WallsCompared::Differ,
            Walls::Untold => WallsCompared::Untold,
        }
    }
}

impl MapStrain {
    /// Of a candidate relaxed.
    pub fn of(frames: &LocalFrames) -> MapStrain {
        let poses = frames.poses.iter().map(wire_pose).collect();
        MapStrain { strain: StrainSum::of(frames), poses, way: None }
    }
}

/// A pose as x, y in metres and heading in radians.
pub(super) fn wire_pose(pose: &Pose) -> [f64; 3] {
    [pose.x, pose.y, pose.theta]
}

impl StrainSum {
    /// Of a candidate relaxed.
    pub fn of(frames: &LocalFrames) -> StrainSum {
        let span = |edge: &EdgeStrain| StrainedSpan {
            observations: edge.visits,
            travelled: edge.walls.is_none(),
            walls: edge.walls.map(WallsCompared::of),
            chi_square: edge.strain.chi_square,
            degrees_of_freedom: edge.strain.degrees_of_freedom,
        };
        StrainSum {
            chi_square: frames.strain.chi_square,
            degrees_of_freedom: frames.strain.degrees_of_freedom,
            converged: frames.outcome == Outcome::Converged,
            outcome: frames.outcome.into(),
            undetermined: frames.undetermined.clone(),
            edges: frames.strains.iter().map(span).collect(),
        }
    }
}
