//! What relaxation promises, on random graphs, beside a dense reference, and on what is hardly a graph.

use super::*;
use crate::geometry::{Pose, wrap_angle};
use nalgebra::{DMatrix, DVector, Matrix3};
use proptest::prelude::*;

mod endings;

fn edge(from: u64, to: u64, displacement: Pose, information: Matrix3<f64>) -> Edge {
    Edge { from: PoseId(from), to: PoseId(to), displacement, information }
}

fn graph(guesses: &[Option<Pose>], edges: &[Edge]) -> PoseGraph {
    let mut graph = PoseGraph::new();
    (0..).zip(guesses).for_each(|(id, guess)| graph.add_pose(PoseId(id), *guess).unwrap());
    edges.iter().for_each(|edge| graph.add_edge(*edge).unwrap());
    graph
}

fn relaxed(graph: &PoseGraph) -> Relaxation {
    relax(graph, &RelaxOptions::default()).unwrap()
}

fn from(graph: &PoseGraph, start: Start) -> Relaxation {
    relax(graph, &RelaxOptions { start, ..RelaxOptions::default() }).unwrap()
}

fn information() -> impl Strategy<Value = Matrix3<f64>> {
    prop::array::uniform9(-1.0..1.0).prop_map(|n: [f64; 9]| {
        let root = Matrix3::from_row_slice(&n) * 3.0;
        let square = root * root.transpose() + Matrix3::from_diagonal_element(5.0);
        (square + square.transpose()) / 2.0
    })
}

fn pose(size: f64) -> impl Strategy<Value = Pose> {
    (-size..size, -size..size, -3.1..3.1).prop_map(|(x, y, theta)| Pose::new(x, y, theta))
}

/// A true layout, a chain through it and some loops, with errors of a size.
fn measured(error: f64) -> impl Strategy<Value = (Vec<Pose>, Vec<Edge>)> {
    (3_usize..12).prop_flat_map(move |count| {
        let loops = prop::collection::vec((0..count, 1..count), 0..8);
        let noise = prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0), count + 8);
        let weights = prop::collection::vec(information(), count + 8);
        (prop::collection::vec(pose(10.0), count), loops, noise, weights).prop_map(
            move |(truth, loops, noise, weights)| {
                let pairs = (1..count).map(|k| (k - 1, k));
                let pairs = pairs.chain(loops.into_iter().map(|(a, ahead)| (a, (a + ahead) % count)));
                let edges = pairs.zip(noise).zip(weights).map(|(((a, b), (x, y, t)), information)| {
                    let slip = Pose::new(error * x, error * y, error * t / 3.0);
                    let between = truth[a].between(&truth[b]).compose(&slip);
                    edge(a as u64, b as u64, between, information)
                });
                let edges = edges.collect();
                (truth, edges)
            },
        )
    })
}

fn apart(a: &Pose, b: &Pose) -> f64 {
    let between = a.between(b);
    between.x.abs().max(between.y.abs()).max(between.theta.abs())
}

/// The same minimum by dense normal equations and the Jacobians of the edges, from a start.
fn dense(graph: &PoseGraph, mut poses: Vec<Pose>) -> (Vec<Pose>, f64, DMatrix<f64>) {
    let unknowns = 3 * poses.len();
    let cost = |poses: &[Pose]| graph.strains(poses).unwrap().iter().map(|s| s.chi_square).sum::<f64>();
    let mut normal = DMatrix::zeros(unknowns, unknowns);
    for _ in 0..100 {
        normal = DMatrix::zeros(unknowns, unknowns);
        let mut slope = DVector::zeros(unknowns);
        for edge in graph.edges() {
            let ends = [edge.from, edge.to].map(|id| graph.number(id).unwrap());
            let [from, to] = ends.map(|end| poses[end]);
            let error = edge.error(&from, &to);
            let jacobians = edge.error_jacobians(&from, &to);
            for (i, jacobian) in ends.iter().zip(&jacobians) {
                let mut part = slope.fixed_rows_mut::<3>(3 * i);
                part += jacobian.transpose() * edge.information * error;
                for (j, other) in ends.iter().zip(&jacobians) {
                    let mut block = normal.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                    block += jacobian.transpose() * edge.information * other;
                }
            }
        }
        // The first pose stays.
        normal = normal.remove_rows(0, 3).remove_columns(0, 3);
        let step = normal.clone().cholesky().unwrap().solve(&slope.remove_rows(0, 3));
        let mut length = 1.0;
        let before = cost(&poses);
        loop {
            let mut moved = poses.clone();
            for (k, pose) in moved.iter_mut().enumerate().skip(1) {
                let by = step.fixed_rows::<3>(3 * (k - 1)) * length;
                *pose = Pose::new(pose.x - by.x, pose.y - by.y, pose.theta - by.z);
            }
            if cost(&moved) <= before || length < 1e-6 {
                poses = moved;
                break;
            }
            length /= 2.0;
        }
        if step.norm() < 1e-11 {
            break;
        }
    }
    (poses.clone(), cost(&poses), normal)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exact_data_gives_no_strain((truth, edges) in measured(0.0), start in 0..3_usize) {
        let start = [Start::Odometry, Start::Rotations, Start::Best][start];
        let graph = graph(&vec![None; truth.len()], &edges);
        let answer = from(&graph, start);
        prop_assert_eq!(answer.outcome, Outcome::Converged);
        prop_assert!(answer.objective < 1e-16, "{}", answer.objective);
        for (k, pose) in answer.poses.iter().enumerate() {
            prop_assert!(apart(pose, &truth[0].between(&truth[k])) < 1e-7);
        }
    }

    #[test]
    fn the_minimum_is_that_of_dense_normal_equations((truth, edges) in measured(0.2)) {
        let guesses: Vec<Option<Pose>> = truth.iter().copied().map(Some).collect();
        let graph = graph(&guesses, &edges);
        let (poses, objective, normal) = dense(&graph, truth);
        let mut relaxer = Relaxer::new(&graph, &RelaxOptions { start: Start::Guesses, ..RelaxOptions::default() }).unwrap();
        let answer = relaxer.relax().unwrap();
        prop_assert_eq!(answer.outcome, Outcome::Converged);
        prop_assert!((answer.objective - objective).abs() <= 1e-7 * (1.0 + objective));
        for (a, b) in answer.poses.iter().zip(&poses) {
            prop_assert!(apart(a, b) < 1e-4, "{:?} {:?}", a, b);
        }
        let covariance = normal.try_inverse().unwrap();
        for pose in 1..poses.len() {
            let expected = covariance.fixed_view::<3, 3>(3 * pose - 3, 3 * pose - 3).into_owned();
            let found = relaxer.covariance(PoseId(pose as u64)).unwrap();
            prop_assert!((found - expected).abs().max() < 1e-3 * expected.abs().max(), "{} {}", found, expected);
        }
        prop_assert_eq!(relaxer.covariance(PoseId(0)), Some(Matrix3::zeros()));
        prop_assert_eq!(relaxer.covariance(PoseId(99)), None);
    }

    #[test]
    fn moving_the_gauge_moves_all_poses_and_no_strain((truth, edges) in measured(0.2), by in pose(30.0)) {
        let here: Vec<Option<Pose>> = truth.iter().copied().map(Some).collect();
        let there: Vec<Option<Pose>> = truth.iter().map(|pose| Some(by.compose(pose))).collect();
        let [here, there] = [here, there].map(|guesses| from(&graph(&guesses, &edges), Start::Guesses));
        prop_assert!((here.objective - there.objective).abs() <= 1e-7 * (1.0 + here.objective));
        for (a, b) in here.poses.iter().zip(&there.poses) {
            prop_assert!(apart(&by.compose(a), b) < 1e-4);
        }
        prop_assert_eq!(here.gauge, vec![PoseId(0)]);
        prop_assert_eq!(apart(&there.poses[0], &by.compose(&truth[0])), 0.0);
    }

    /// Chi-square grows by no edge that agrees, and every edge adds three numbers that were measured.
    #[test]
    fn an_edge_that_agrees_lowers_strain_per_degree_of_freedom(
        (truth, edges) in measured(0.2), ends in (0..100_usize, 1..100_usize), information in information(),
    ) {
        let guesses: Vec<Option<Pose>> = truth.iter().copied().map(Some).collect();
        let mut graph = graph(&guesses, &edges);
        let before = from(&graph, Start::Guesses);
        let (a, ahead) = (ends.0 % truth.len(), 1 + ends.1 % (truth.len() - 1));
        let b = (a + ahead) % truth.len();
        let agreed = before.poses[a].between(&before.poses[b]);
        graph.add_edge(edge(a as u64, b as u64, agreed, information)).unwrap();
        let after = from(&graph.with_guesses(&before.poses), Start::Guesses);
        prop_assert_eq!(after.degrees_of_freedom, before.degrees_of_freedom + 3);
        prop_assert!(after.objective <= before.objective * (1.0 + 1e-8) + 1e-15);
        if before.degrees_of_freedom > 0 {
            let [less, more] = [&after, &before].map(|a| a.objective / a.degrees_of_freedom as f64);
            prop_assert!(less <= more * (1.0 + 1e-8) + 1e-15);
        }
    }

    #[test]
    fn cost_never_rises(
        (truth, edges) in measured(2.0), guesses in prop::collection::vec(pose(50.0), 12), loss in 0..4_usize,
    ) {
        let guesses: Vec<Option<Pose>> = guesses.into_iter().take(truth.len()).map(Some).collect();
        let graph = graph(&guesses, &edges);
        let width = 1.0;
        let losses = [Loss::Squared, Loss::Huber { width }, Loss::Cauchy { width }, Loss::GemanMcClure { width }];
        let options = RelaxOptions { loss: losses[loss], ..RelaxOptions::default() };
        let answer = relax(&graph, &options).unwrap();
        for trial in &answer.trials {
            prop_assert!(trial.costs.windows(2).all(|pair| pair[1] <= pair[0]), "{:?}", trial);
        }
        prop_assert!(answer.cost <= answer.trials[0].costs[0]);
        prop_assert!(answer.poses.iter().all(Pose::is_finite));
    }

    #[test]
    fn the_order_of_edges_changes_no_bit((truth, edges) in measured(0.5), seed in any::<u64>()) {
        let guesses: Vec<Option<Pose>> = truth.iter().copied().map(Some).collect();
        let mut shuffled = edges.clone();
        for k in (1..shuffled.len()).rev() {
            shuffled.swap(k, (seed.rotate_left(k as u32) % (k as u64 + 1)) as usize);
        }
        let answer = relaxed(&graph(&guesses, &edges));
        let other = relaxed(&graph(&guesses, &shuffled));
        prop_assert_eq!(&answer, &other);
        let none = vec![None; truth.len()];
        prop_assert_eq!(relaxed(&graph(&none, &edges)), relaxed(&graph(&none, &shuffled)));
    }
}

#[test]
fn a_graph_of_nothing_is_relaxed() {
    let answer = relaxed(&PoseGraph::new());
    assert_eq!((answer.outcome, answer.objective, answer.iterations), (Outcome::Converged, 0.0, 0));
    assert!(answer.poses.is_empty() && answer.parts.is_empty() && answer.gauge.is_empty());
    let here = Pose::new(1.0, 2.0, 3.0);
    let answer = relaxed(&graph(&[Some(here)], &[]));
    assert_eq!((answer.poses, answer.outcome), (vec![here], Outcome::Converged));
    assert_eq!(answer.parts, [Part { first: PoseId(0), poses: 1 }]);
}

#[test]
fn parts_are_named_and_each_has_its_gauge() {
    let ahead = Pose::new(1.0, 0.0, 0.0);
    let unit = Matrix3::identity();
    let graph =
        graph(&[None; 6], &[edge(0, 1, ahead, unit), edge(3, 4, ahead, unit), edge(4, 5, ahead, unit)]);
    let answer = relaxed(&graph);
    let part = |first, poses| Part { first: PoseId(first), poses };
    assert_eq!(answer.parts, [part(0, 2), part(2, 1), part(3, 3)]);
    assert_eq!(answer.gauge, [PoseId(0), PoseId(2), PoseId(3)]);
    assert_eq!(answer.poses[5], Pose::new(2.0, 0.0, 0.0));
    assert!(answer.undetermined.is_empty() && answer.outcome == Outcome::Converged);
}

#[test]
fn held_poses_are_the_gauge_and_stay() {
    let ahead = Pose::new(1.0, 0.0, 0.0);
    let unit = Matrix3::identity();
    let there = Some(Pose::new(4.0, 0.0, 0.0));
    let mut graph = graph(&[None, None, there], &[edge(0, 1, ahead, unit), edge(1, 2, ahead, unit)]);
    graph.hold(PoseId(2)).unwrap();
    let answer = relaxed(&graph);
    assert_eq!(answer.gauge, [PoseId(2)]);
    assert_eq!(answer.poses[0], Pose::new(2.0, 0.0, 0.0));
    assert!(answer.objective < 1e-20);
}

#[test]
fn poses_that_nothing_determines_are_named() {
    let ahead = Pose::new(1.0, 0.0, 0.0);
    let unit = Matrix3::identity();
    let turns_only = Matrix3::from_diagonal(&nalgebra::Vector3::new(0.0, 0.0, 1.0));
    // 3 hangs on 2 by a heading alone, and 4 on 3 by everything: both float.
    let edges = [
        edge(0, 1, ahead, unit),
        edge(1, 2, ahead, unit),
        edge(2, 3, ahead, turns_only),
        edge(3, 4, ahead, unit),
        edge(0, 5, ahead, unit),
    ];
    let graph = graph(&[None; 6], &edges);
    let mut relaxer = Relaxer::new(&graph, &RelaxOptions::default()).unwrap();
    let answer = relaxer.relax().unwrap();
    assert_eq!(answer.undetermined, [PoseId(3), PoseId(4)]);
    assert_eq!(answer.outcome, Outcome::Converged);
    assert!(answer.objective < 1e-12 && answer.poses.iter().all(Pose::is_finite));
    assert_eq!(relaxer.covariance(PoseId(3)), None);
    let near = relaxer.covariance(PoseId(2)).unwrap();
    let expected = Matrix3::new(2.0, 0.0, 0.0, 0.0, 3.0, 1.0, 0.0, 1.0, 2.0);
    assert!((near - expected).abs().max() < 1e-6, "{near}");
}

#[test]
fn information_of_nothing_leaves_all_but_the_gauge_undetermined() {
    let ahead = Pose::new(1.0, 0.0, 0.0);
    let answer = relaxed(&graph(
        &[None; 3],
        &[edge(0, 1, ahead, Matrix3::zeros()), edge(1, 2, ahead, Matrix3::zeros())],
    ));
    assert_eq!(answer.undetermined, [PoseId(1), PoseId(2)]);
    assert_eq!((answer.objective, answer.degrees_of_freedom), (0.0, 0));
    assert_eq!(answer.outcome, Outcome::Converged);
}

/// What the rounding of a file put below zero is no direction in which strain falls without end.
#[test]
fn strain_is_never_below_zero() {
    let ahead = |x: f64| Pose::new(x, 0.0, 0.0);
    let rounded = Matrix3::from_diagonal(&nalgebra::Vector3::new(-1.0, 1e7, 1e7));
    let edges =
        [(0, 1, 1.0), (1, 2, 1.0), (0, 2, 3.0)].map(|(from, to, x)| edge(from, to, ahead(x), rounded));
    let answer = relaxed(&graph(&[Some(ahead(0.0)), Some(ahead(1.0)), Some(ahead(2.0))], &edges));
    assert!((0.0..1e-9).contains(&answer.objective), "{}", answer.objective);
    assert_eq!((answer.outcome, answer.undetermined), (Outcome::Converged, vec![PoseId(1), PoseId(2)]));
    assert!(answer.poses.iter().all(|pose| pose.x.abs() < 10.0), "{:?}", answer.poses);
}

#[test]
fn a_long_chain_is_determined() {
    let ahead = Pose::new(1.0, 0.0, 0.01);
    let edges: Vec<Edge> = (0..20_000).map(|k| edge(k, k + 1, ahead, Matrix3::identity() * 50.0)).collect();
    let answer = relaxed(&graph(&vec![None; 20_001], &edges));
    assert!(
        answer.undetermined.is_empty() && answer.outcome == Outcome::Converged,
        "{:?}",
        answer.undetermined.len()
    );
    assert!(answer.objective < 1e-10, "{}", answer.objective);
}

/// A ring of poses from which any start must come out: all zero, and far off.
#[test]
fn no_guess_is_so_bad_that_it_does_harm() {
    let count = 200_u64;
    let turn = std::f64::consts::TAU / count as f64;
    let step = Pose::new(1.0, 0.0, turn);
    let mut edges: Vec<Edge> =
        (1..count).map(|k| edge(k - 1, k, step, Matrix3::identity() * 100.0)).collect();
    edges.push(edge(count - 1, 0, step, Matrix3::identity() * 100.0));
    let zero = vec![Some(Pose::IDENTITY); count as usize];
    let wild: Vec<Option<Pose>> = (0..count)
        .map(|k| {
            Some(Pose::new((k as f64 * 7.7).sin() * 90.0, (k as f64 * 3.1).cos() * 90.0, k as f64 * 2.3))
        })
        .collect();
    for guesses in [zero, wild] {
        let answer = relaxed(&graph(&guesses, &edges));
        assert_eq!(answer.outcome, Outcome::Converged);
        assert!(answer.objective < 1e-12, "{}", answer.objective);
        assert!(wrap_angle(answer.poses[199].theta - answer.poses[0].theta + turn).abs() < 1e-7);
    }
}

#[test]
fn a_robust_loss_does_without_an_edge_that_lies() {
    let ahead = Pose::new(1.0, 0.0, 0.0);
    let unit = Matrix3::identity() * 100.0;
    let mut edges: Vec<Edge> = (0..20).map(|k| edge(k, k + 1, ahead, unit)).collect();
    edges.extend((0..19).map(|k| edge(k, k + 2, Pose::new(2.0, 0.0, 0.0), unit)));
    edges.push(edge(0, 20, Pose::new(3.0, 9.0, 2.0), unit));
    let graph = graph(&[None; 21], &edges);
    let far = |loss| {
        let options = RelaxOptions { loss, start: Start::Odometry, ..RelaxOptions::default() };
        let answer = relax(&graph, &options).unwrap();
        apart(&answer.poses[20], &Pose::new(20.0, 0.0, 0.0))
    };
    assert!(far(Loss::Squared) > 1.0);
    assert!(far(Loss::GemanMcClure { width: 1.0 }) < 1e-3);
    assert!(far(Loss::Cauchy { width: 1.0 }) < far(Loss::Squared) / 2.0);
}

/// What grows piece by piece ends where it would have ended as a whole.
fn grown(truth: &[Pose], edges: &[Edge]) -> (IncrementalGraph, Vec<Update>) {
    let mut growing = IncrementalGraph::new(RelaxOptions::default());
    let mut updates = vec![];
    growing.add_pose(PoseId(0), Some(truth[0])).unwrap();
    for pose in 1..truth.len() as u64 {
        growing.add_pose(PoseId(pose), None).unwrap();
        let news = edges.iter().filter(|edge| edge.from.0.max(edge.to.0) == pose);
        news.for_each(|edge| growing.add_edge(*edge).unwrap());
        updates.push(growing.relax().unwrap());
    }
    (growing, updates)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_grows_ends_where_the_whole_does((truth, edges) in measured(0.05)) {
        let (growing, updates) = grown(&truth, &edges);
        let poses: Vec<Pose> = growing.poses().iter().map(|pose| pose.unwrap()).collect();
        let whole = from(&growing.graph().with_guesses(&poses), Start::Guesses);
        let objective: f64 = growing.graph().strains(&poses).unwrap().iter().map(|s| s.chi_square).sum();
        prop_assert!(objective <= whole.objective * (1.0 + 1e-5) + 1e-9, "{} {}", objective, whole.objective);
        for (a, b) in poses.iter().zip(&whole.poses) {
            prop_assert!(apart(a, b) < 1e-3);
        }
        prop_assert!(updates.iter().all(|update| update.outcome == Outcome::Converged));
    }
}

#[test]
fn growth_relaxes_what_it_touches() {
    let ahead = Pose::new(1.0, 0.0, std::f64::consts::FRAC_PI_2);
    let slip = Pose::new(1.1, 0.0, std::f64::consts::FRAC_PI_2);
    let unit = Matrix3::identity();
    // Two squares that share pose 4, each closed with an error by its last edge.
    let mut edges: Vec<Edge> = (0..8).map(|k| edge(k, k + 1, ahead, unit)).collect();
    edges.retain(|edge| edge.from.0 != 4);
    edges.push(edge(3, 0, slip, unit));
    edges.push(edge(4, 5, slip, unit));
    edges.push(edge(8, 5, slip, unit));
    let start = vec![Pose::IDENTITY; 9];
    let (growing, updates) = grown(&start, &edges);
    let relaxed: Vec<usize> = updates.iter().map(|update| update.relaxed).collect();
    // Ends of chains cost nothing; a loop costs its own poses but the one it hangs on.
    assert_eq!(relaxed, [0, 0, 3, 0, 0, 0, 0, 3]);
    assert_eq!(growing.poses()[0], Some(Pose::IDENTITY));
}
