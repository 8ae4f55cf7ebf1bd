//! Strain: how far each edge is from what was measured, in units of its uncertainty.

use crate::geometry::{Jacobian, Pose};
use crate::patchwork::pose_graph::graph::{Edge, PoseGraph};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The strain of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// `e' W e` of the error `e = z^-1 (i^-1 j)`: metres along and aside, and radians.
    pub chi_square: f64,
    /// How many numbers the edge measures: the rank of its information.
    pub degrees_of_freedom: usize,
}

impl Strain {
    /// The natural logarithm of the probability that a strain of so many degrees of freedom is as great or greater by chance,
    /// if errors are normal and covariances honest: the upper tail of chi-square. Zero where nothing is compared.
    ///
    /// By this two strains with different degrees of freedom are compared. Their ratios to the degrees of freedom are not:
    /// these scatter by `sqrt(2 / n)`, so that 1.5 is nothing with three degrees of freedom and much with a hundred. As a
    /// logarithm it does not vanish where strain is great.
    pub fn log_probability(&self) -> f64 {
        match self.degrees_of_freedom {
            0 => 0.0,
            _ if self.chi_square <= 0.0 => 0.0,
            degrees => log_upper_tail(degrees as f64 / 2.0, self.chi_square / 2.0),
        }
    }
}

/// The logarithm of the upper incomplete gamma function over the complete one, `a` in halves and `x` above 0: by the
/// series of the lower one, or by the continued fraction of the upper one, whichever converges fast (Abramowitz and
/// Stegun 1964, 6.5.29 and 6.5.31).
fn log_upper_tail(a: f64, x: f64) -> f64 {
    let scale = a * x.ln() - x - log_gamma(a);
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > f64::EPSILON * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (-scale.exp() * sum).ln_1p();
    }
    // From its beginning on, as ratios of successive convergents' numerators and denominators.
    let (mut b, mut upper, mut lower) = (x + 1.0 - a, f64::MAX, 1.0 / (x + 1.0 - a));
    let (mut fraction, mut n) = (lower, 0.0);
    loop {
        n += 1.0;
        let part = n * (a - n);
        b += 2.0;
        lower = 1.0 / (part * lower + b);
        upper = b + part / upper;
        let change = upper * lower;
        fraction *= change;
        if (change - 1.0).abs() <= 2.0 * f64::EPSILON || n > MOST_CONVERGENTS {
            return scale + fraction.ln();
        }
    }
}

/// More convergents than any strain needs: about the root of the degrees of freedom.
const MOST_CONVERGENTS: f64 = 1e6;

/// The logarithm of the gamma function of a multiple of one half.
fn log_gamma(a: f64) -> f64 {
    let (mut at, mut sum) = if a.fract() == 0.0 { (1.0, 0.0) } else { (0.5, PI.sqrt().ln()) };
    while at < a {
        sum += at.ln();
        at += 1.0;
    }
    sum
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
    use crate::patchwork::pose_graph::graph::PoseId;
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

    /// The upper tail of chi-square by integration of its density, to 40 deviations beyond.
    fn integrated(chi_square: f64, degrees: usize) -> f64 {
        let k = degrees as f64;
        let end = chi_square + 40.0 * (2.0 * k).sqrt() + 400.0;
        let log_density =
            |x: f64| (k / 2.0 - 1.0) * x.ln() - x / 2.0 - k / 2.0 * 2_f64.ln() - log_gamma(k / 2.0);
        let steps = 200_000;
        let step = (end - chi_square) / f64::from(steps);
        let middle = |n: i32| chi_square + (f64::from(n) + 0.5) * step;
        (0..steps).map(|n| log_density(middle(n)).exp() * step).sum()
    }

    #[test]
    fn the_probability_of_a_strain_is_the_tail_of_chi_square() {
        for degrees in [1, 2, 3, 7, 18, 60, 301] {
            for share in [0.3, 0.8, 1.0, 1.1, 1.5, 3.0] {
                let chi_square = share * degrees as f64;
                let strain = Strain { chi_square, degrees_of_freedom: degrees };
                let (found, expected) = (strain.log_probability(), integrated(chi_square, degrees).ln());
                assert!(
                    (found - expected).abs() < 1e-3 * expected.abs().max(1.0),
                    "{strain:?} {found} {expected}"
                );
            }
        }
        let strain =
            |chi_square, degrees_of_freedom| Strain { chi_square, degrees_of_freedom }.log_probability();
        assert_eq!((strain(0.0, 5), strain(3.0, 0)), (0.0, 0.0));
        // exp(-x / 2) with two degrees of freedom, however far out.
        assert!((strain(1e5, 2) + 5e4).abs() < 1e-6);
        // The same ratio to the degrees of freedom means less with few of them.
        assert!(strain(1.5 * 3.0, 3) > 50.0 * strain(1.5 * 100.0, 100));
    }

    proptest! {
        #[test]
        fn more_strain_is_less_probable(chi_square in 0.0..1e4f64, more in 0.01..100.0f64, degrees in 1..200_usize) {
            let probability = |chi_square| Strain { chi_square, degrees_of_freedom: degrees }.log_probability();
            prop_assert!(probability(chi_square) <= 1e-12);
            prop_assert!(probability(chi_square + more) <= probability(chi_square));
        }

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
