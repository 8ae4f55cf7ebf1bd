//! The graph of a candidate map: a frame for each visit, joined by travels as measured and by what visits to one place
//! show of each other (seed, section 2.3).

use crate::abduction::Assignment;
use crate::geometry::Pose;
use crate::patchwork::agreement::{Agreement, Neighbourhood, Walls};
use crate::patchwork::assembly::Closure;
use crate::patchwork::drive::turned;
use crate::patchwork::{
    Edge, GraphError, Outcome, PoseGraph, PoseId, RelaxError, RelaxOptions, Strain, relax_until,
};
use nalgebra::{Matrix3, SymmetricEigen};
use std::cell::Cell;
use std::collections::BTreeMap;

/// A measured travel from the frame of one visit to that of the next: the displacement, and its covariance in the frame
/// it begins in.
pub type Displacement = (Pose, Matrix3<f64>);

/// No displacement is taken for better known than rounding allows, nor for known worse, as variances, metres and radians
/// squared.
const VARIANCES: [f64; 2] = [1e-7, 1e12];

/// What a visit shows; `None` where there is nothing to show, or where the second said to stop.
type Show<'a> = dyn Fn(usize, &dyn Fn() -> bool) -> Option<Neighbourhood> + 'a;

/// What visits show of each other, remembered: candidates ask for the same pairs.
pub struct Agreements<'a> {
    show: Box<Show<'a>>,
    shown: BTreeMap<usize, Option<Neighbourhood>>,
    /// Standard deviations of the middle of a place, metres, and of a bearing, radians, as found on one visit.
    sigmas: [f64; 2],
    known: Known,
}

/// What pairs of visits show of each other, where that was asked before. It stays so however the trace goes on. A pair is
/// found by its later visit, its first visit, and the rotation.
#[derive(Clone, Debug, Default)]
pub struct Known(BTreeMap<(usize, usize, u8), Option<Agreement>>);

impl Known {
    /// How many pairs are remembered at most: half a megabyte.
    pub const MOST: usize = 4096;

    /// Remembers more pairs. Where there is no room for all, those whose later visits are the oldest are forgotten: fewest
    /// candidates still differ there.
    pub fn extend(&mut self, more: Known) {
        for (pair, agreement) in more.0 {
            self.0.insert(pair, agreement);
            if self.0.len() > Known::MOST {
                self.0.pop_first();
            }
        }
    }
}

impl<'a> Agreements<'a> {
    /// Of visits, each of which is asked what it shows when a pair first needs it.
    pub fn new(
        show: impl Fn(usize, &dyn Fn() -> bool) -> Option<Neighbourhood> + 'a,
        sigmas: [f64; 2],
    ) -> Self {
        Agreements { show: Box::new(show), shown: BTreeMap::new(), sigmas, known: Known::default() }
    }

    /// The same, some pairs of which are known.
    #[must_use]
    pub fn knowing(self, known: Known) -> Self {
        Agreements { known, ..self }
    }

    /// The pairs that are known by now.
    pub fn into_known(self) -> Known {
        self.known
    }

    /// The closures of a candidate: each visit to a known place, with the first visit there. `interrupted` is asked
    /// before each, and while walls are looked for.
    pub fn closures(
        &mut self,
        candidate: &[Assignment],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Vec<Closure>, LocalFramesError> {
        let mut first: BTreeMap<usize, usize> = BTreeMap::new();
        let mut closures = Vec::new();
        for (visit, assigned) in candidate.iter().enumerate() {
            if interrupted() {
                return Err(LocalFramesError::Interrupted);
            }
            let known = *first.entry(assigned.place.index()).or_insert(visit);
            if known == visit {
                continue;
            }
            if let Some(agreement) = self.between(known, visit, assigned.rotation, interrupted)? {
                closures.push(Closure { visits: [known, visit], agreement });
            }
        }
        Ok(closures)
    }

    fn between(
        &mut self,
        first: usize,
        later: usize,
        rotation: u8,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<Agreement>, LocalFramesError> {
        if let Some(known) = self.known.0.get(&(later, first, rotation)) {
            return Ok(*known);
        }
        // Remembered only where it was not told to stop: what a visit shows is then all of it.
        let stopped = Cell::new(false);
        let stop = || {
            stopped.set(stopped.get() || interrupted());
            stopped.get()
        };
        for visit in [first, later] {
            if self.shown.contains_key(&visit) {
                continue;
            }
            let shows = (self.show)(visit, &stop);
            if stopped.get() {
                return Err(LocalFramesError::Interrupted);
            }
            self.shown.insert(visit, shows);
        }
        let [one, other] = [first, later].map(|visit| self.shown.get(&visit).and_then(Option::as_ref));
        let found = one
            .zip(other)
            .and_then(|(one, other)| one.agreement(other, usize::from(rotation), self.sigmas, &stop));
        if stopped.get() {
            return Err(LocalFramesError::Interrupted);
        }
        self.known.0.insert((later, first, rotation), found);
        Ok(found)
    }
}

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

impl LocalFrames {
    /// Relaxes a candidate. `travels` has one for each visit, of the travel that led to it. `interrupted` is asked before
    /// each step.
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
    use crate::map::PlaceId;
    use crate::patchwork::alignment::Alignment;
    use crate::patchwork::submap::Submap;
    use crate::sensor::surface::Surface;
    use nalgebra::Vector3;
    use proptest::prelude::*;

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

    /// The corners of a square block walked around twice, and the walls of each, which differ.
    fn corner(place: usize, world_from_visit: &Pose) -> Neighbourhood {
        let back = world_from_visit.inverse();
        let sides =
            [(0.0, -1.0), (0.0, 1.0 + 0.3 * place as f64), (0.5, -1.2), (0.5 + 0.1 * place as f64, 1.0)];
        let walls = sides.iter().enumerate().flat_map(|(k, (angle, offset))| {
            let angle: f64 = angle + std::f64::consts::FRAC_PI_2 * (k % 2) as f64;
            let (normal, along) = (direction(angle), direction(angle + std::f64::consts::FRAC_PI_2));
            (-40..40).map(move |step| {
                let at = middle(place) + normal * *offset + along * (0.1 * f64::from(step));
                Surface { at, normal: if *offset < 0.0 { normal } else { -normal } }
            })
        });
        let walls = walls.map(|wall| crate::patchwork::alignment::moved(&wall, &back));
        let bearings = [0.0, 2.0].map(|bearing| Some(wrap_angle(bearing - world_from_visit.theta)));
        Neighbourhood { walls: Submap::new(walls), bearings: bearings.to_vec() }
    }

    fn middle(place: usize) -> Point {
        [Point::new(0.0, 0.0), Point::new(20.0, 0.0), Point::new(20.0, 15.0), Point::new(0.0, 15.0)]
            [place % 4]
    }

    fn assigned(visits: usize) -> Vec<Assignment> {
        let place = |visit: usize| PlaceId::new(visit % 4).unwrap();
        (0..visits).map(|visit| Assignment { place: place(visit), rotation: 0 }).collect()
    }

    /// Frames near the middles, the exact displacements between them, and what was seen.
    fn walked(frames: &[(f64, f64, f64)]) -> (Vec<Pose>, Vec<Option<Displacement>>, Agreements<'static>) {
        let pose = |(visit, &(x, y, theta)): (usize, &(f64, f64, f64))| {
            Pose::new(middle(visit).x + x, middle(visit).y + y, theta)
        };
        let truth: Vec<Pose> = frames.iter().enumerate().map(pose).collect();
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 0.04, 0.01));
        let travel = |pair: &[Pose]| Some((pair[0].between(&pair[1]), covariance));
        let travels = std::iter::once(None).chain(truth.windows(2).map(travel)).collect();
        let seen: Vec<Neighbourhood> =
            truth.iter().enumerate().map(|(visit, pose)| corner(visit % 4, pose)).collect();
        (truth, travels, Agreements::new(move |visit, _| seen.get(visit).cloned(), [0.25, 0.05]))
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
        let walls = |agreements: &mut Agreements<'_>, candidate: &[Assignment]| {
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
    fn what_is_known_of_pairs_is_not_looked_for_again() {
        let (_, _, mut agreements) = walked(&[(0.1, 0.0, 0.3); 8]);
        let found = agreements.closures(&assigned(8), &|| false).unwrap();
        let mut known = Known::default();
        known.extend(agreements.into_known());
        let blind = |_, _: &dyn Fn() -> bool| panic!("it is known");
        let again =
            Agreements::new(blind, [0.25, 0.05]).knowing(known).closures(&assigned(8), &|| false).unwrap();
        assert_eq!((found.len(), &found), (4, &again));
    }

    #[test]
    fn the_pairs_of_the_latest_visits_are_remembered() {
        let pairs =
            |visits: std::ops::Range<usize>| Known(visits.map(|visit| ((visit, 0, 0), None)).collect());
        let mut known = Known::default();
        known.extend(pairs(1..Known::MOST));
        known.extend(pairs(Known::MOST..Known::MOST + 100));
        known.extend(pairs(1..50));
        assert_eq!(known.0.len(), Known::MOST);
        assert_eq!(known.0.keys().next(), Some(&(100, 0, 0)));
        assert_eq!(known.0.keys().last(), Some(&(Known::MOST + 99, 0, 0)));
    }

    /// Where a visit was not shown to its end, it is shown again when it is asked for next.
    #[test]
    fn what_was_not_shown_to_its_end_is_not_remembered() {
        let (_, _, mut whole) = walked(&[(0.1, 0.0, 0.3); 8]);
        let (_, _, other) = walked(&[(0.1, 0.0, 0.3); 8]);
        let show = |visit, interrupted: &dyn Fn() -> bool| {
            if interrupted() { None } else { (other.show)(visit, interrupted) }
        };
        let mut agreements = Agreements::new(show, [0.25, 0.05]);
        let asked = Cell::new(0);
        // The first to be shown anything is the visit at 4, after which it is asked again.
        let stop = || asked.replace(asked.get() + 1) >= 5;
        assert!(matches!(agreements.closures(&assigned(8), &stop), Err(LocalFramesError::Interrupted)));
        let closures = agreements.closures(&assigned(8), &|| false).unwrap();
        assert_eq!(closures, whole.closures(&assigned(8), &|| false).unwrap());
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
        assert!(matches!(agreements.closures(&assigned(8), &|| true), Err(LocalFramesError::Interrupted)));
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
