//! The graph of a candidate map: a frame for each visit, joined by travels as measured and by what visits to one place
//! show of each other (seed, section 2.3).

use crate::geometry::Pose;
use crate::patchwork::agreement::{Agreement, Walls};
use crate::patchwork::closures::{Closure, Interrupted};
use crate::patchwork::drive::turned;
use crate::patchwork::{
    Edge, GraphError, Outcome, PoseGraph, PoseId, RelaxError, RelaxOptions, Strain, relax_until,
};
use nalgebra::{Matrix3, SymmetricEigen};

/// A measured travel from the frame of one visit to that of the next: the displacement, and its covariance in the frame
/// it begins in.
pub type Displacement = (Pose, Matrix3<f64>);

/// No displacement is taken for better known than rounding allows, nor for known worse, as variances, metres and radians
/// squared.
const VARIANCES: [f64; 2] = [1e-7, 1e12];

/// The graph of a candidate: a pose for each visit, in their order. `travels` has one for each visit, of the travel that
/// led to it.
pub fn graph(travels: &[Option<Displacement>], closures: &[Closure]) -> Result<PoseGraph, GraphError> {
    let mut graph = PoseGraph::new();
    for visit in 0..travels.len() {
        graph.add_pose(PoseId(visit as u64), None)?;
    }
    for (visit, travel) in travels.iter().enumerate().skip(1) {
        let Some((displacement, covariance)) = travel else { continue };
        // Edges weigh errors as they are seen at their end.
        let turned = turned(-displacement.theta);
        let covariance = turned * covariance * turned.transpose();
        let [from, to] = [visit - 1, visit].map(|visit| PoseId(visit as u64));
        let information = information(&covariance);
        graph.add_edge(Edge { from, to, displacement: *displacement, information })?;
    }
    for Closure { visits, agreement: Agreement { alignment, .. } } in closures {
        let [from, to] = visits.map(|visit| PoseId(visit as u64));
        let information = (alignment.information + alignment.information.transpose()) / 2.0;
        graph.add_edge(Edge { from, to, displacement: alignment.pose, information })?;
    }
    Ok(graph)
}

/// The inverse of a covariance, which may say that some combination of numbers is known without any error, or next to it.
fn information(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let [least, most] = VARIANCES;
    let SymmetricEigen { eigenvectors, eigenvalues } =
        SymmetricEigen::new((covariance + covariance.transpose()) / 2.0);
    let weights = eigenvalues.map(|variance| 1.0 / variance.clamp(least, most));
    let information = eigenvectors * Matrix3::from_diagonal(&weights) * eigenvectors.transpose();
    (information + information.transpose()) / 2.0
}

/// A candidate map relaxed: where the frames of its visits lie, and what strains them.
#[derive(Clone, Debug)]
pub struct LocalFrames {
    /// The frame of each visit, in that of the first visit of its part.
    pub poses: Vec<Pose>,
    /// The closures it rests on.
    pub closures: Vec<Closure>,
    /// The strain of each edge: first the travels measured, in their order, then the closures.
    pub strains: Vec<EdgeStrain>,
    /// The strain of all: the objective, with as many degrees of freedom as numbers are measured beyond those sought.
    pub strain: Strain,
    /// How relaxation ended.
    pub outcome: Outcome,
    /// The part of each visit, by its first visit: a travel that was not measured begins another one, unless what was
    /// measured later joins the two. Nothing is known of where a part lies in another.
    pub parts: Vec<usize>,
    /// The visits whose frames can move without strain, though travels or closures join them to others.
    pub undetermined: Vec<usize>,
}

/// What one edge is strained by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeStrain {
    /// The two visits it joins.
    pub visits: [usize; 2],
    /// What the walls say where it is what two visits to one place show of each other; `None` of a travel.
    pub walls: Option<Walls>,
    /// How much.
    pub strain: Strain,
}

/// Why a candidate was not relaxed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LocalFramesError {
    /// A measurement is none.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The graph is too large.
    #[error(transparent)]
    Relax(#[from] RelaxError),
    /// The caller said so.
    #[error("it was told to stop")]
    Interrupted,
}

impl From<Interrupted> for LocalFramesError {
    fn from(_: Interrupted) -> LocalFramesError {
        LocalFramesError::Interrupted
    }
}

impl LocalFrames {
    /// Relaxes a candidate. `travels` has one for each visit, of the travel that led to it. `interrupted` is asked before
    /// each factorisation.
    pub fn relax(
        travels: &[Option<Displacement>],
        closures: Vec<Closure>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<LocalFrames, LocalFramesError> {
        let graph = graph(travels, &closures)?;
        let relaxed = relax_until(&graph, &RelaxOptions::default(), interrupted)?;
        if relaxed.outcome == Outcome::Interrupted {
            return Err(LocalFramesError::Interrupted);
        }
        let number = |id: PoseId| id.0 as usize;
        let walls = closures.iter().map(|closure| Some(closure.agreement.walls));
        let travels = graph.edges().len() - closures.len();
        let walls = std::iter::repeat_n(None, travels).chain(walls);
        let strains = graph.strains(&relaxed.poses).unwrap_or_default();
        let strains = graph.edges().iter().zip(walls).zip(strains).map(|((edge, walls), strain)| {
            EdgeStrain { visits: [number(edge.from), number(edge.to)], walls, strain }
        });
        Ok(LocalFrames {
            strains: strains.collect(),
            strain: Strain { chi_square: relaxed.objective, degrees_of_freedom: relaxed.degrees_of_freedom },
            outcome: relaxed.outcome,
            parts: graph.parts(),
            undetermined: relaxed.undetermined.into_iter().map(number).collect(),
            poses: relaxed.poses,
            closures,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, direction, wrap_angle};
    use crate::patchwork::agreement::Neighbourhood;
    use crate::patchwork::alignment::Alignment;
    use crate::patchwork::closures::Agreements;
    use crate::patchwork::closures::block::{assigned, corner, middle, walked};
    use crate::patchwork::submap::Submap;
    use crate::sensor::surface::Surface;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use std::cell::Cell;

    proptest! {
        /// A rank of two, as two wheels measure, of one or of nought: whatever a trace may say.
        #[test]
        fn a_travel_is_an_edge_however_little_its_covariance_holds(
            ways in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 0..4),
            scale in prop_oneof![Just(0.0), Just(1e-12), Just(1e-3), Just(1e200)],
        ) {
            let way = |way: &[f64; 3]| Vector3::from(*way) * Vector3::from(*way).transpose() * scale;
            let covariance: Matrix3<f64> = ways.iter().map(way).sum();
            let travels = [None, Some((Pose::new(4.0, 1.0, 0.7), covariance))];
            let frames = LocalFrames::relax(&travels, Vec::new(), &|| false).unwrap();
            prop_assert_eq!(frames.strains.len(), 1);
            let travelled = frames.poses[0].inverse().compose(&frames.poses[1]);
            prop_assert!((travelled.position() - Point::new(4.0, 1.0)).norm() < 1e-6, "{:?}", travelled);
        }
    }

    fn frames() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
        prop::collection::vec((-0.3..0.3f64, -0.3..0.3f64, -3.1..3.1f64), 5..9)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn exact_travels_around_a_block_are_not_strained(frames in frames()) {
            let (truth, travels, mut agreements) = walked(&frames);
            let closures = agreements.closures(&assigned(frames.len()), &|| false).unwrap();
            prop_assert_eq!(closures.len(), frames.len() - 4);
            let relaxed = LocalFrames::relax(&travels, closures, &|| false).unwrap();
            prop_assert!(relaxed.strain.chi_square < 0.5, "{:?}", relaxed.strain);
            prop_assert_eq!(relaxed.strain.degrees_of_freedom, 3 * (frames.len() - 4));
            for (pose, true_pose) in relaxed.poses.iter().zip(&truth) {
                let off = truth[0].between(true_pose).inverse().compose(&relaxed.poses[0].between(pose));
                prop_assert!(off.x.hypot(off.y) < 0.1 && off.theta.abs() < 0.02, "{off:?}");
            }
        }

        /// Odometry that bends leaves its end away from the beginning; closures bring it back, strained.
        #[test]
        fn drift_is_spread_over_the_loop(frames in frames(), bent in 0.05..0.15f64) {
            let (truth, mut travels, mut agreements) = walked(&frames);
            for (displacement, _) in travels.iter_mut().flatten() {
                displacement.theta = wrap_angle(displacement.theta + bent);
            }
            let open = LocalFrames::relax(&travels, Vec::new(), &|| false).unwrap();
            prop_assert!(open.strain.chi_square < 1e-6 && open.strain.degrees_of_freedom == 0);
            let closures = agreements.closures(&assigned(frames.len()), &|| false).unwrap();
            let relaxed = LocalFrames::relax(&travels, closures, &|| false).unwrap();
            let off = |poses: &[Pose]| {
                let there = truth[0].between(&truth[4]).inverse().compose(&poses[0].between(&poses[4]));
                there.x.hypot(there.y)
            };
            prop_assert!(off(&relaxed.poses) < 0.1 && off(&open.poses) > 0.5, "{} {}", off(&relaxed.poses), off(&open.poses));
            prop_assert!(relaxed.strain.chi_square > open.strain.chi_square);
        }
    }

    #[test]
    fn a_closure_says_what_the_walls_do() {
        let (_, travels, mut agreements) = walked(&[(0.1, 0.0, 0.3); 8]);
        let walls = |agreements: &mut Agreements<'_>, candidate: &[crate::abduction::Assignment]| {
            let closures = agreements.closures(candidate, &|| false).unwrap();
            let frames = LocalFrames::relax(&travels[..candidate.len()], closures, &|| false).unwrap();
            frames.strains.iter().map(|edge| edge.walls).collect::<Vec<_>>()
        };
        let (travel, alike) = (None, Some(Walls::Alike));
        assert_eq!(
            walls(&mut agreements, &assigned(6)),
            [travel, travel, travel, travel, travel, alike, alike]
        );
        // The bearings of the first corner, in a round room.
        let mut wrong = assigned(3);
        wrong[2].place = wrong[0].place;
        let round = (0..300).map(|step| {
            let out = direction(f64::from(step) * 0.021);
            Surface { at: middle(0) + out * 2.5, normal: -out }
        });
        let round = Neighbourhood { walls: Submap::new(round), ..corner(0, &Pose::IDENTITY) };
        let seen = [corner(0, &Pose::IDENTITY), corner(1, &Pose::IDENTITY), round];
        let mut others = Agreements::new(move |visit, _| seen.get(visit).cloned(), [0.25, 0.05]);
        assert_eq!(walls(&mut others, &wrong), [travel, travel, Some(Walls::Differ)]);
        let star = |_: usize, _: &dyn Fn() -> bool| Some(Neighbourhood::of_star(vec![Some(0.0), Some(2.0)]));
        let mut stars = Agreements::new(star, [0.25, 0.05]);
        assert_eq!(walls(&mut stars, &wrong), [travel, travel, Some(Walls::Untold)]);
    }

    #[test]
    fn a_travel_that_was_not_measured_begins_another_part() {
        let (_, mut travels, _) = walked(&[(0.0, 0.0, 0.0); 3]);
        travels[2] = None;
        let relaxed = LocalFrames::relax(&travels, Vec::new(), &|| false).unwrap();
        assert_eq!(relaxed.parts, [0, 0, 2]);
        assert_eq!(LocalFrames::relax(&[], Vec::new(), &|| false).unwrap().poses, []);
    }

    /// Two bare walls hold a frame aside and turned as it is, and let it slide.
    #[test]
    fn what_a_corridor_alone_joins_is_not_determined() {
        let (_, mut travels, _) = walked(&[(0.0, 0.0, 0.0); 3]);
        travels[2] = None;
        let alignment = Alignment {
            pose: Pose::IDENTITY,
            information: Matrix3::from_diagonal(&Vector3::new(0.0, 1e4, 1e4)),
            share: 1.0,
            stray: 0.0,
        };
        let closure = Closure { visits: [0, 2], agreement: Agreement { alignment, walls: Walls::Alike } };
        let relaxed = LocalFrames::relax(&travels, vec![closure], &|| false).unwrap();
        assert_eq!((&relaxed.undetermined, &relaxed.parts), (&vec![2], &vec![0; 3]));
        assert_eq!((relaxed.outcome, relaxed.strain.degrees_of_freedom), (Outcome::Converged, 0));
        travels[2] = travels[1];
        assert!(LocalFrames::relax(&travels, vec![closure], &|| false).unwrap().undetermined.is_empty());
    }

    /// Wherever it is told to stop, it stops, and says no more than that.
    #[test]
    fn relaxing_stops_when_told_to() {
        let (_, mut travels, mut agreements) = walked(&[(0.1, 0.0, 0.3); 8]);
        for (displacement, _) in travels.iter_mut().flatten() {
            displacement.theta = wrap_angle(displacement.theta + 0.1);
        }
        let whole = agreements.closures(&assigned(8), &|| false).unwrap();
        assert!(matches!(agreements.closures(&assigned(8), &|| true), Err(Interrupted)));
        let asked = Cell::new(0);
        let after = |most: usize| {
            asked.set(0);
            let interrupted = || asked.replace(asked.get() + 1) >= most;
            LocalFrames::relax(&travels, whole.clone(), &interrupted).map(|frames| frames.poses)
        };
        let poses = after(usize::MAX).unwrap();
        let steps = asked.get();
        assert!(steps > 2, "{steps}");
        for most in 0..steps {
            assert!(matches!(after(most), Err(LocalFramesError::Interrupted)), "{most} of {steps}");
        }
        assert_eq!(after(steps).unwrap(), poses);
    }
}
