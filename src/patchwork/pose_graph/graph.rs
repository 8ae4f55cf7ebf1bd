//! The pose graph: poses, and what was measured between them.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::parts::parts;
use nalgebra::{Matrix3, SymmetricEigen};
use rustc_hash::FxHashMap;
use std::fmt;

/// The name of a pose: the number of a vertex in a file, of a place, of a visit. Names need not be contiguous.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PoseId(pub u64);

impl fmt::Display for PoseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A measured displacement: the pose of one frame in another, and how sure that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The frame in which was measured.
    pub from: PoseId,
    /// The frame that was measured.
    pub to: PoseId,
    /// `from_from_to`: metres and radians.
    pub displacement: Pose,
    /// The inverse of the covariance of x, y and heading of the error `displacement^-1 from^-1 to`, in the frame
    /// measured. Symmetric and positive semidefinite.
    pub information: Matrix3<f64>,
}

/// Poses with names, some with a first guess, and the displacements measured between them.
///
/// A growing value: every addition is checked, and one that is refused changes nothing. What is in it can be
/// relaxed, whatever it is: parts without a connection and poses that nothing determines are told, not refused.
#[derive(Clone, Debug, Default)]
pub struct PoseGraph {
    ids: Vec<PoseId>,
    guesses: Vec<Option<Pose>>,
    held: Vec<bool>,
    edges: Vec<Edge>,
    ends: Vec<[u32; 2]>,
    index: FxHashMap<PoseId, u32>,
}

/// Why an addition to a pose graph is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GraphError {
    /// A name stands for one pose.
    #[error("pose {0} is there already, expected a new name")]
    DuplicatePose(PoseId),
    /// An end of an edge, or a pose to hold, is not there.
    #[error("pose {0} is not there, expected one that was added before")]
    UnknownPose(PoseId),
    /// A pose measured against itself says nothing of any pose.
    #[error("the edge leads from pose {0} to itself, expected two poses")]
    SelfEdge(PoseId),
    /// A number is infinite or none.
    #[error("a number is not finite, expected metres and radians")]
    NotFinite,
    /// The information is no inverse covariance.
    #[error(
        "the information matrix is not symmetric with eigenvalues of 0 or more, expected the inverse of a covariance"
    )]
    Information,
    /// A pose can be held only where it is known to be.
    #[error("pose {0} is to be held but has no value, expected one")]
    HeldWithoutValue(PoseId),
    /// There are as many poses as can be counted.
    #[error("there are more than {MAX_POSES} poses")]
    TooMany,
}

/// How many poses a graph holds at most.
pub const MAX_POSES: usize = 20_000_000;

impl PoseGraph {
    /// No poses.
    pub fn new() -> Self {
        PoseGraph::default()
    }

    /// Adds a pose, with a first guess of its value or without. The first one fixes the gauge of its part.
    pub fn add_pose(&mut self, id: PoseId, guess: Option<Pose>) -> Result<(), GraphError> {
        if self.index.contains_key(&id) {
            return Err(GraphError::DuplicatePose(id));
        }
        if guess.is_some_and(|pose| !pose.is_finite()) {
            return Err(GraphError::NotFinite);
        }
        let number = u32::try_from(self.ids.len()).ok().filter(|n| (*n as usize) < MAX_POSES);
        self.index.insert(id, number.ok_or(GraphError::TooMany)?);
        self.ids.push(id);
        self.guesses.push(guess.map(|pose| Pose::new(pose.x, pose.y, pose.theta)));
        self.held.push(false);
        Ok(())
    }

    /// Adds a measurement between two poses that are there. Repeated measurements of one displacement all count. Information
    /// that is below zero by the rounding of files is taken as zero there.
    pub fn add_edge(&mut self, edge: Edge) -> Result<(), GraphError> {
        let number = |id| self.index.get(&id).copied().ok_or(GraphError::UnknownPose(id));
        let ends = [number(edge.from)?, number(edge.to)?];
        if edge.from == edge.to {
            return Err(GraphError::SelfEdge(edge.from));
        }
        if !edge.displacement.is_finite() || !edge.information.iter().all(|n| n.is_finite()) {
            return Err(GraphError::NotFinite);
        }
        if !is_information(&edge.information) {
            return Err(GraphError::Information);
        }
        self.ends.push(ends);
        self.edges.push(Edge { information: semidefinite(edge.information), ..edge });
        Ok(())
    }

    /// Holds a pose at its guess: relaxation does not move it. Without any, the first pose of each part is held.
    pub fn hold(&mut self, id: PoseId) -> Result<(), GraphError> {
        let number = *self.index.get(&id).ok_or(GraphError::UnknownPose(id))? as usize;
        if self.guesses[number].is_none() {
            return Err(GraphError::HeldWithoutValue(id));
        }
        self.held[number] = true;
        Ok(())
    }

    /// How many poses there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The names of the poses, in the order in which they were added.
    pub fn ids(&self) -> &[PoseId] {
        &self.ids
    }

    /// The first guesses, pose by pose.
    pub fn guesses(&self) -> &[Option<Pose>] {
        &self.guesses
    }

    /// Whether each pose is held at its guess.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// The measurements, in the order in which they were added.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The two ends of each edge, as numbers of poses in the order of [`PoseGraph::ids`].
    pub(super) fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// The poses in the order in which they were added, each with the measurements between it and those before it: as a robot
    /// that drives would tell of them.
    pub fn in_order(&self) -> impl Iterator<Item = (PoseId, Vec<Edge>)> {
        let mut edges_of = vec![vec![]; self.len()];
        for (edge, [a, b]) in self.edges.iter().zip(&self.ends) {
            edges_of[*a.max(b) as usize].push(*edge);
        }
        self.ids.iter().copied().zip(edges_of)
    }

    /// The part of each pose, by the number of the first pose that edges join it to.
    pub fn parts(&self) -> Vec<usize> {
        parts(self).into_iter().map(|part| part as usize).collect()
    }

    /// The number of a pose in the order of [`PoseGraph::ids`].
    pub fn number(&self, id: PoseId) -> Option<usize> {
        self.index.get(&id).map(|number| *number as usize)
    }

    /// The same graph with other guesses, pose by pose, as after relaxation; those of poses left out stay.
    #[must_use]
    pub fn with_guesses(&self, poses: &[Pose]) -> PoseGraph {
        let mut graph = self.clone();
        for (guess, pose) in graph.guesses.iter_mut().zip(poses).filter(|(_, pose)| pose.is_finite()) {
            *guess = Some(*pose);
        }
        graph
    }

    /// The same graph without first guesses; held poses keep theirs.
    #[must_use]
    pub fn without_guesses(&self) -> PoseGraph {
        let mut graph = self.clone();
        for (guess, _) in graph.guesses.iter_mut().zip(&graph.held).filter(|(_, held)| !**held) {
            *guess = None;
        }
        graph
    }
}

/// How far below zero rounding may put an eigenvalue, relative to the largest entry: files have six digits, so that each of
/// three entries of a row is off by five millionths of itself at most.
const ROUNDING: f64 = 1.5e-5;
/// The same of our own rounding: what is below zero by no more is written and read as it is.
const LAST_DIGITS: f64 = 1e-12;

/// Whether a matrix is symmetric and positive semidefinite, up to the rounding of files.
pub(super) fn is_information(information: &Matrix3<f64>) -> bool {
    let slack = ROUNDING * information.abs().max();
    (information - information.transpose()).abs().max() <= slack && is_semidefinite(information, ROUNDING)
}

/// Whether no eigenvalue is below zero by more than a share of the largest entry. Most matrices are positive definite, and then
/// Cholesky is the fastest proof.
fn is_semidefinite(matrix: &Matrix3<f64>, share: f64) -> bool {
    let slack = (share * matrix.abs().max()).max(f64::MIN_POSITIVE);
    (matrix + Matrix3::from_diagonal_element(slack)).cholesky().is_some()
}

/// The nearest positive semidefinite matrix (Higham 1988), but for the last digits: along a direction of negative information
/// strain would fall without end.
fn semidefinite(information: Matrix3<f64>) -> Matrix3<f64> {
    if is_semidefinite(&information, LAST_DIGITS) {
        return information;
    }
    let SymmetricEigen { eigenvectors, eigenvalues } =
        SymmetricEigen::new((information + information.transpose()) / 2.0);
    let clamped = Matrix3::from_diagonal(&eigenvalues.map(|value| value.max(0.0)));
    let nearest = eigenvectors * clamped * eigenvectors.transpose();
    (nearest + nearest.transpose()) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn edge(from: u64, to: u64) -> Edge {
        let displacement = Pose::new(1.0, 0.0, 0.0);
        Edge { from: PoseId(from), to: PoseId(to), displacement, information: Matrix3::identity() }
    }

    #[test]
    fn what_is_refused_changes_nothing() {
        let mut graph = PoseGraph::new();
        graph.add_pose(PoseId(7), Some(Pose::IDENTITY)).unwrap();
        graph.add_pose(PoseId(3), None).unwrap();
        assert_eq!(graph.add_pose(PoseId(7), None), Err(GraphError::DuplicatePose(PoseId(7))));
        let nowhere = Some(Pose { x: f64::NAN, y: 0.0, theta: 0.0 });
        assert_eq!(graph.add_pose(PoseId(8), nowhere), Err(GraphError::NotFinite));
        assert_eq!(graph.hold(PoseId(3)), Err(GraphError::HeldWithoutValue(PoseId(3))));
        assert_eq!(graph.hold(PoseId(4)), Err(GraphError::UnknownPose(PoseId(4))));
        assert_eq!(graph.add_edge(edge(7, 7)), Err(GraphError::SelfEdge(PoseId(7))));
        assert_eq!(graph.add_edge(edge(7, 4)), Err(GraphError::UnknownPose(PoseId(4))));
        let indefinite = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, -1.0, 1.0));
        assert_eq!(
            graph.add_edge(Edge { information: indefinite, ..edge(7, 3) }),
            Err(GraphError::Information)
        );
        let lopsided = Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        assert_eq!(
            graph.add_edge(Edge { information: lopsided, ..edge(7, 3) }),
            Err(GraphError::Information)
        );
        let infinite = Matrix3::identity() * f64::INFINITY;
        assert_eq!(graph.add_edge(Edge { information: infinite, ..edge(7, 3) }), Err(GraphError::NotFinite));
        assert_eq!((graph.len(), graph.edges().len()), (2, 0));
        graph.add_edge(Edge { information: Matrix3::zeros(), ..edge(7, 3) }).unwrap();
        graph.add_edge(edge(3, 7)).unwrap();
        assert_eq!(graph.edges().len(), 2);
    }

    fn taken(information: Matrix3<f64>) -> Matrix3<f64> {
        let mut graph = PoseGraph::new();
        [7, 3].iter().for_each(|id| graph.add_pose(PoseId(*id), None).unwrap());
        graph.add_edge(Edge { information, ..edge(7, 3) }).unwrap();
        graph.edges()[0].information
    }

    proptest! {
        /// What measures less than three numbers, as a file has it.
        #[test]
        fn information_of_six_digits_is_taken_and_nowhere_below_zero(
            ways in prop::collection::vec(prop::array::uniform3(-3.0..3.0f64), 1..3), scale in -3..8,
        ) {
            let way = |way: &[f64; 3]| nalgebra::Vector3::from(*way) * nalgebra::Vector3::from(*way).transpose();
            let exact = ways.iter().map(way).sum::<Matrix3<f64>>() * 10_f64.powi(scale);
            let written = exact.map(|n| format!("{n:.5e}").parse::<f64>().unwrap());
            let (lifted, size) = (taken(written), exact.abs().max());
            prop_assert!(lifted.symmetric_eigenvalues().min() > -1e-11 * size, "{lifted}");
            prop_assert!((lifted - exact).abs().max() < 3e-5 * size, "{lifted} {exact}");
            prop_assert_eq!(taken(lifted), lifted);
        }
    }

    /// What rounding left below zero is lifted, and nothing else is touched.
    #[test]
    fn information_is_nowhere_below_zero() {
        let diagonal = |x: f64| Matrix3::from_diagonal(&nalgebra::Vector3::new(x, 1e7, 1e7));
        assert!((taken(diagonal(-1.0)) - diagonal(0.0)).abs().max() < 1e-8);
        for kept in [diagonal(0.0), diagonal(1.0), Matrix3::from_element(1e300), Matrix3::zeros()] {
            assert_eq!(taken(kept), kept);
        }
    }
}
