//! Recorded pose graphs: the best objectives known, from good starts, bad ones and none.

use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use topostar::geometry::Pose;
use topostar::patchwork::format::{InformationOrder, ReadGraph, read_graph, write_g2o};
use topostar::patchwork::{
    Edge, IncrementalGraph, Outcome, PoseGraph, RelaxOptions, Relaxation, Relaxer, Start, relax,
};

/// The best objectives known; that of FR079 is our own, from every start.
const BEST: [(&str, f64); 7] = [
    ("MIT.g2o", 41.163269),
    ("CSAIL.g2o", 40.555129),
    ("intel.g2o", 45.004696),
    ("FR079_P_toro.graph", 37.599116),
    ("manhattan.g2o", 3549.0368),
    ("manhattanOlson3500_olson.g2o", 146.076745),
    ("city10000.g2o", 511.985164),
];

fn read(file: &str) -> ReadGraph {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/posegraphs");
    let content = MultiGzDecoder::new(File::open(folder.join(format!("{file}.gz"))).unwrap());
    read_graph(BufReader::new(content), None).unwrap()
}

fn from(graph: &PoseGraph, start: Start) -> Relaxation {
    relax(graph, &RelaxOptions { start, ..RelaxOptions::default() }).unwrap()
}

fn assert_best(file: &str, answer: &Relaxation, best: f64) {
    assert_eq!(answer.outcome, Outcome::Converged, "{file}");
    assert!((answer.objective / best - 1.0).abs() < 1e-6, "{file}: {}", answer.objective);
    assert!(answer.undetermined.is_empty() && answer.parts.len() == 1 && answer.gauge.len() == 1, "{file}");
    let rising = answer.trials.iter().any(|trial| trial.costs.windows(2).any(|pair| pair[1] > pair[0]));
    assert!(!rising, "{file}");
}

#[test]
fn recorded_graphs_reach_the_best_known() {
    for (file, best) in BEST {
        let graph = read(file).graph;
        assert_best(file, &from(&graph, Start::Best), best);
        // The file's poses do not matter.
        assert_best(file, &from(&graph, Start::Rotations), best);
    }
}

#[test]
fn recorded_graphs_come_out_of_starts_that_are_all_wrong() {
    for (file, best) in BEST {
        let graph = read(file).graph;
        let zero = vec![Pose::IDENTITY; graph.len()];
        assert_best(file, &from(&graph.with_guesses(&zero), Start::Best), best);
        let wild = |k: usize| {
            let k = k as f64;
            Pose::new(500.0 * (k * 12.9898).sin(), 500.0 * (k * 78.233).cos(), k * 37.7)
        };
        let wild: Vec<Pose> = (0..graph.len()).map(wild).collect();
        assert_best(file, &from(&graph.with_guesses(&wild), Start::Best), best);
    }
}

/// Measured turns off by up to so many radians, by a rule that looks like chance.
fn with_turned_edges(graph: &PoseGraph, radians: f64) -> PoseGraph {
    let mut turned = PoseGraph::new();
    for (id, guess) in graph.ids().iter().zip(graph.guesses()) {
        turned.add_pose(*id, *guess).unwrap();
    }
    for (k, edge) in graph.edges().iter().enumerate() {
        let z = &edge.displacement;
        let sum: f64 = (1..=12).map(|n| ((k as f64 * 7.31 + f64::from(n)) * 43.7585).sin()).sum();
        // The sum of twelve sines in these steps stays within 8.2 or a little more.
        let displacement = Pose::new(z.x, z.y, z.theta + radians * sum / 8.2);
        turned.add_edge(Edge { displacement, ..*edge }).unwrap();
    }
    turned
}

/// From the relaxed poses of the graph as it was recorded there is a descent too: no other start may end above it.
#[test]
fn graphs_whose_turns_are_badly_measured_end_as_low_as_from_the_true_layout() {
    for file in ["manhattan.g2o", "MIT.g2o", "intel.g2o", "CSAIL.g2o"] {
        let graph = read(file).graph;
        let truth = from(&graph, Start::Best).poses;
        for radians in [0.1, 0.2, 0.3] {
            let turned = with_turned_edges(&graph, radians);
            let informed = from(&turned.with_guesses(&truth), Start::Guesses);
            let answer = from(&turned.without_guesses(), Start::Best);
            let over = answer.objective / informed.objective - 1.0;
            assert!(over < 1e-5, "{file} {radians}: {} {}", answer.objective, informed.objective);
        }
    }
}

#[test]
fn information_in_the_order_of_toro_is_read_as_such() {
    let fr079 = read("FR079_P_toro.graph");
    assert_eq!(
        (fr079.order, fr079.notes.iter().any(|note| note.contains("order"))),
        (InformationOrder::Toro, false)
    );
    // The ground truths have the tags of the one and the order of the other.
    let truth = read("city10000_groundtruth.txt");
    assert_eq!(truth.order, InformationOrder::G2o);
    assert!(truth.notes[0].contains("read in that order"));
    let again = read_graph(write_g2o(&fr079.graph).as_bytes(), None).unwrap();
    assert_eq!(again.graph.edges(), fr079.graph.edges());
}

#[test]
fn a_graph_fed_pose_by_pose_ends_near_the_best() {
    for (file, best) in [BEST[1], BEST[2]] {
        let graph = read(file).graph;
        let mut growing = IncrementalGraph::new(RelaxOptions::default());
        for (id, edges) in graph.in_order() {
            growing.add_pose(id, None).unwrap();
            edges.iter().for_each(|edge| growing.add_edge(*edge).unwrap());
            growing.relax().unwrap();
        }
        let poses: Vec<Pose> = growing.poses().iter().map(|pose| pose.unwrap()).collect();
        let objective: f64 = growing.graph().strains(&poses).unwrap().iter().map(|s| s.chi_square).sum();
        assert!((objective / best - 1.0).abs() < 1e-5, "{file}: {objective}");
    }
}

/// The covariance is what the objective says: a pose held a standard deviation off costs one more.
#[test]
fn holding_a_pose_a_standard_deviation_off_costs_one() {
    let graph = read("intel.g2o").graph;
    let mut relaxer = Relaxer::new(&graph, &RelaxOptions::default()).unwrap();
    let answer = relaxer.relax().unwrap();
    let number = graph.len() - 1;
    let covariance = relaxer.covariance(graph.ids()[number]).unwrap();
    let sigma = covariance[(0, 0)].sqrt();
    // A thousandth of it, so that errors stay linear; along the way that x drags the other two.
    let by = covariance.column(0) / sigma * 1e-3;
    let mut poses = answer.poses.clone();
    let pose = poses[number];
    poses[number] = Pose::new(pose.x + by.x, pose.y + by.y, pose.theta + by.z);
    let mut held = graph.with_guesses(&poses);
    [0, number].iter().for_each(|k| held.hold(graph.ids()[*k]).unwrap());
    let options = RelaxOptions { start: Start::Guesses, tolerance: 1e-14, ..RelaxOptions::default() };
    let [free, held] =
        [&graph.with_guesses(&answer.poses), &held].map(|graph| relax(graph, &options).unwrap().objective);
    assert!(((held - free) * 1e6 - 1.0).abs() < 1e-2, "{}", (held - free) * 1e6);
}
