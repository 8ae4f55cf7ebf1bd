//! Strain: how far each edge is from what was measured, in units of its uncertainty.

use crate::geometry::{Jacobian, Pose};
use crate::patchwork::graph::{Edge, PoseGraph};
use nalgebra::{Matrix3, Vector3};

/// The strain of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// `e' W e` of the error `e = z^-1 (i^-1 j)`: metres along and aside, and radians.
    pub chi_square: f64,
    /// How many numbers the edge measures: the rank of its information.
    pub degrees_of_freedom: usize,
}

/// What share of the largest eigenvalue still counts as measured.
const MEASURED: f64 = 1e-9;

impl Edge {
    /// The error of the edge for two poses: what was measured against what they say, as seen from there.
    pub fn error(&self, from: &Pose, to: &Pose) -> Vector3<f64> {
        let error = self.displacement.between(&from.between(to));
        Vector3::new(error.x, error.y, error.theta)
    }

    /// The derivatives of [`Edge::error`] by x, y and heading of both poses.
    pub fn error_jacobians(&self, from: &Pose, to: &Pose) -> [Jacobian; 2] {
        let [_, by_between] = self.displacement.between_jacobians(&from.between(to));
        from.between_jacobians(to).map(|jacobian| by_between * jacobian)
    }

    /// The strain of the edge for two poses.
    pub fn strain(&self, from: &Pose, to: &Pose) -> Strain {
        let error = self.error(from, to);
        let chi_square = error.dot(&(self.information * error));
        Strain { chi_square, degrees_of_freedom: rank(&self.information) }
    }
}

impl PoseGraph {
    /// The strain of each edge for some poses, in the order of the edges. None where there are not as many poses as in
    /// the graph.
    pub fn strains(&self, poses: &[Pose]) -> Option<Vec<Strain>> {
        let strain = |(edge, ends): (&Edge, &[u32; 2])| {
            let [from, to] = ends.map(|end| &poses[end as usize]);
            edge.strain(from, to)
        };
        (poses.len() == self.len()).then(|| self.edges().iter().zip(self.ends()).map(strain).collect())
    }
}

/// The rank of a positive semidefinite matrix.
pub(super) fn rank(information: &Matrix3<f64>) -> usize {
    // Nearly all have full rank; and then the determinant tells at once.
    let size = information.abs().max();
    let scaled = information / size;
    if size > 0.0 && scaled.determinant() > MEASURED {
        return 3;
    }
    let eigenvalues = information.symmetric_eigenvalues();
    eigenvalues.iter().filter(|value| **value > MEASURED * size.max(f64::MIN_POSITIVE)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patchwork::graph::PoseId;
    use proptest::prelude::*;

    fn edge(x: f64, y: f64, theta: f64) -> Edge {
        let displacement = Pose::new(x, y, theta);
        Edge { from: PoseId(0), to: PoseId(1), displacement, information: Matrix3::identity() }
    }

    #[test]
    fn rank_counts_what_is_measured() {
        let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
        assert_eq!(rank(&diagonal(50.0, 1.0, 1e7)), 3);
        assert_eq!(rank(&diagonal(0.0, 0.0, 4.0)), 1);
        assert_eq!(rank(&diagonal(1.0, 0.0, 4.0)), 2);
        assert_eq!(rank(&Matrix3::zeros()), 0);
        assert_eq!(rank(&Matrix3::from_element(1.0)), 1);
    }

    proptest! {
        #[test]
        fn error_jacobians_are_the_numeric_derivatives(
            z in (-5.0..5.0, -5.0..5.0, -3.0..3.0),
            i in (-50.0..50.0, -50.0..50.0, -3.0..3.0),
            j in (-50.0..50.0, -50.0..50.0, -3.0..3.0),
        ) {
            let edge = edge(z.0, z.1, z.2);
            let step = 1e-5;
            let poses = [[i.0, i.1, i.2], [j.0, j.1, j.2]];
            let error = |poses: [[f64; 3]; 2]| {
                let [from, to] = poses.map(|[x, y, theta]| Pose::new(x, y, theta));
                edge.error(&from, &to)
            };
            let [from, to] = poses.map(|[x, y, theta]| Pose::new(x, y, theta));
            let jacobians = edge.error_jacobians(&from, &to);
            for (end, jacobian) in jacobians.iter().enumerate() {
                for k in 0..3 {
                    let moved = |by: f64| {
                        let mut poses = poses;
                        poses[end][k] += by;
                        error(poses)
                    };
                    let mut slope = moved(step) - moved(-step);
                    slope.z = crate::geometry::wrap_angle(slope.z);
                    prop_assert!((slope / (2.0 * step) - jacobian.column(k)).abs().max() < 1e-6);
                }
            }
        }
    }
}
