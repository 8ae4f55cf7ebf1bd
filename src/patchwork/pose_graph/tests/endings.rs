//! How relaxation ends: near the least or not, in time or not, and what it took.

use super::*;
use std::cell::Cell;

/// A ring walked twice, with what was recognised; errors of about a standard deviation, by a rule that looks like chance.
fn ring(laps: u64) -> (Vec<Pose>, Vec<Edge>) {
    let turn = std::f64::consts::TAU / 20.0;
    let step = Pose::new(1.0, 0.0, turn);
    let slip = |k: u64| {
        let [x, y, t] = [1.3, 2.7, 4.1].map(|n| (k as f64 * 12.9898 + n).sin() * 1e-3);
        Pose::new(x, y, t)
    };
    let count = 20 * laps;
    let mut poses = vec![Pose::IDENTITY];
    (1..=count as usize).for_each(|k| poses.push(poses[k - 1].compose(&step)));
    let information = Matrix3::identity() * 1e6;
    let driven = (0..count).map(|k| edge(k, k + 1, step.compose(&slip(k)), information));
    let known = (20..=count).map(|k| edge(k - 20, k, slip(3 * k + 1), information));
    (poses, driven.chain(known).collect())
}

fn strain(graph: &PoseGraph, poses: &[Pose]) -> f64 {
    graph.strains(poses).unwrap().iter().map(|strain| strain.chi_square).sum()
}

fn near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < 1e-6
}

/// What is told is the strain of the poses given; and converged means within a millionth of the least.
fn assert_honest(graph: &PoseGraph, answer: &Relaxation, best: f64) {
    assert!(near(answer.objective, strain(graph, &answer.poses)), "{answer:?}");
    let least = near(answer.objective, best);
    assert!(least || answer.outcome == Outcome::Stalled, "{:?} {} {best}", answer.outcome, answer.objective);
}

#[test]
fn far_from_the_origin_converged_is_still_the_least() {
    let (poses, edges) = ring(2);
    let here = graph(&poses.iter().copied().map(Some).collect::<Vec<_>>(), &edges);
    let best = relaxed(&here).objective;
    assert!(best > 1.0, "{best}");
    for away in [1e3, 1e6, 1e9, 1e12, 1e15] {
        let there = |pose: &Pose| Some(Pose::new(pose.x + away, pose.y - away, pose.theta));
        let there = graph(&poses.iter().map(there).collect::<Vec<_>>(), &edges);
        for start in [Start::Best, Start::Guesses, Start::Odometry, Start::Rotations] {
            let answer = from(&there, start);
            assert_honest(&there, &answer, best);
            assert_eq!(answer.outcome == Outcome::Converged, away < 1e12, "{away} {start:?}");
        }
    }
}

/// The same where the pose that is held is as far away, so that no origin is near both.
#[test]
fn far_from_the_gauge_converged_is_still_the_least() {
    let (poses, edges) = ring(2);
    let best = relaxed(&graph(&vec![None; poses.len()], &edges)).objective;
    for away in [1e3, 1e6, 1e9, 1e12] {
        let mut far = PoseGraph::new();
        far.add_pose(PoseId(99), Some(Pose::new(-away, 0.0, 0.0))).unwrap();
        (0..).zip(&poses).for_each(|(k, pose)| far.add_pose(PoseId(k), Some(*pose)).unwrap());
        edges.iter().for_each(|edge| far.add_edge(*edge).unwrap());
        // So little is known of a turn as moves the far end by a metre.
        let loose = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, away * away));
        far.add_edge(edge(99, 0, Pose::new(away, 0.0, 0.0), loose)).unwrap();
        let answer = from(&far, Start::Guesses);
        assert_honest(&far, &answer, best);
        assert!(answer.outcome == Outcome::Converged || away > 1e6, "{away} {:?}", answer.outcome);
    }
}

#[test]
fn a_cost_beyond_all_numbers_is_told() {
    let huge = [edge(0, 1, Pose::new(1e200, 0.0, 0.0), Matrix3::identity())];
    let mut held = graph(&[Some(Pose::IDENTITY), Some(Pose::IDENTITY)], &huge);
    let answer = relaxed(&held);
    // One step takes it there.
    assert_eq!((answer.outcome, answer.objective), (Outcome::Converged, 0.0));
    [0, 1].iter().for_each(|id| held.hold(PoseId(*id)).unwrap());
    for loss in [Loss::Squared, Loss::Cauchy { width: 1.0 }, Loss::GemanMcClure { width: 1.0 }] {
        let answer = relax(&held, &RelaxOptions { loss, ..RelaxOptions::default() }).unwrap();
        assert_eq!(answer.outcome, Outcome::Overflow, "{loss:?}");
        assert!(!answer.objective.is_finite() && answer.poses.iter().all(Pose::is_finite), "{loss:?}");
    }
}

/// Wherever it is told to stop, it gives the poses of the least cost that it has come to.
#[test]
fn what_is_interrupted_gives_the_best_so_far() {
    let (poses, mut edges) = ring(2);
    // A loop that lies by two radians, so that the other start is tried as well.
    edges.push(edge(3, 12, Pose::new(0.0, 0.0, 2.0), Matrix3::identity() * 1e4));
    let bent = |k: usize| Some(Pose::new((k as f64).sin() * 9.0, (k as f64).cos() * 9.0, k as f64));
    let graph = graph(&(0..poses.len()).map(bent).collect::<Vec<_>>(), &edges);
    let asked = Cell::new(0);
    let after = |most: usize| {
        asked.set(0);
        let stop = || asked.replace(asked.get() + 1) >= most;
        relax_until(&graph, &RelaxOptions::default(), &stop).unwrap()
    };
    let whole = after(usize::MAX);
    let asks = asked.get();
    assert!(whole.trials.len() == 2 && asks > 10, "{} {asks}", whole.trials.len());
    let mut least = f64::INFINITY;
    for most in 0..asks {
        let answer = after(most);
        assert_eq!(answer.outcome, Outcome::Interrupted, "{most} of {asks}");
        assert!(near(answer.objective, strain(&graph, &answer.poses)), "{most} of {asks}");
        let begun = answer.trials.iter().filter_map(|trial| trial.costs.last().copied());
        assert!(near(answer.cost, begun.fold(f64::INFINITY, f64::min)), "{most} of {asks}");
        // The first asks are those of a start; from then on every step lowers the cost, or the other start is tried.
        assert!(answer.cost <= least * (1.0 + 1e-9) || most < 4, "{most} of {asks}: {} {least}", answer.cost);
        least = least.min(answer.cost);
    }
    assert_eq!(after(asks), whole);
}

/// Every factorisation counts from the analysis of its system on: one that was made anew would begin again at none.
#[test]
fn order_and_analysis_are_made_once_for_all_steps() {
    let (poses, edges) = ring(2);
    let bent = |k: usize| Some(Pose::new((k as f64).sin() * 9.0, (k as f64).cos() * 9.0, k as f64));
    let graph = graph(&(0..poses.len()).map(bent).collect::<Vec<_>>(), &edges);
    let options = RelaxOptions { start: Start::Guesses, ..RelaxOptions::default() };
    let mut relaxer = Relaxer::new(&graph, &options).unwrap();
    assert_eq!(relaxer.factorizations(), 0);
    let steps = relaxer.relax().unwrap().iterations;
    let once = relaxer.factorizations();
    assert!(steps > 3 && once >= steps, "{steps} {once}");
    relaxer.relax().unwrap();
    assert_eq!(relaxer.factorizations(), 2 * once);
    relaxer.covariance(PoseId(7)).unwrap();
    relaxer.covariance(PoseId(8)).unwrap();
    assert_eq!(relaxer.factorizations(), 2 * once + 1);
}
