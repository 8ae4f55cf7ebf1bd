//! Files as they are met: both formats, their traps, and what is no graph.

use super::*;
use crate::geometry::Pose;
use crate::patchwork::pose_graph::{Edge, PoseGraph, PoseId};
use nalgebra::Matrix3;
use proptest::prelude::*;

fn read(text: &str) -> Result<ReadGraph, String> {
    read_graph(text.as_bytes(), None).map_err(|error| error.to_string())
}

fn refused(text: &str) -> String {
    read(text).unwrap_err()
}

const BOTH: [&str; 2] = [
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 8.4 0.2 1.5\nFIX 0\nEDGE_SE2 0 1 8.4 0.2 1.5 400 1 2 300 3 2500\n",
    "# TORO\nVERTEX2 0 0 0 0\nVERTEX2 1 8.4 0.2 1.5\nEDGE2 0 1 8.4 0.2 1.5 400 1 300 2500 2 3\n",
];

#[test]
fn both_formats_say_the_same_in_their_own_orders() {
    let [g2o, toro] = BOTH.map(|text| read(text).unwrap());
    assert_eq!(g2o.graph.edges(), toro.graph.edges());
    let information = Matrix3::new(400.0, 1.0, 2.0, 1.0, 300.0, 3.0, 2.0, 3.0, 2500.0);
    assert_eq!(g2o.graph.edges()[0].information, information);
    assert_eq!((g2o.order, toro.order), (InformationOrder::G2o, InformationOrder::Toro));
    assert_eq!((g2o.graph.held(), toro.graph.held()), (&[true, false][..], &[false, false][..]));
    assert_eq!(g2o.notes, Vec::<String>::new());
}

#[test]
fn an_order_that_cannot_be_is_not_taken() {
    let mixed = read("EDGE2 0 1 1 0 0 50 0 0 50 0 100\nEDGE2 1 2 1 0 0 50 0 0 50 0 100\n").unwrap();
    assert_eq!(mixed.order, InformationOrder::G2o);
    assert!(mixed.notes[0].contains("--information-order"), "{:?}", mixed.notes);
    let diagonal = Matrix3::from_diagonal(&nalgebra::Vector3::new(50.0, 50.0, 100.0));
    assert_eq!(mixed.graph.edges()[0].information, diagonal);
    let insisted = read_graph(&b"\nEDGE2 0 1 1 0 0 50 0 0 50 0 100\n"[..], Some(InformationOrder::Toro));
    let error = insisted.unwrap_err().to_string();
    assert!(error.starts_with("line 2: the information matrix"), "{error}");
    assert!(error.contains("is it that of g2o?"), "{error}");
}

#[test]
fn names_need_not_be_contiguous_nor_in_order() {
    let text = "EDGE_SE2 900 7 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 900 5 0 0\nEDGE_SE2 7 18446744073709551615 1 0 0 1 0 0 1 0 1\n";
    let read = read(text).unwrap();
    assert_eq!(read.graph.ids(), [PoseId(7), PoseId(900), PoseId(u64::MAX)]);
    assert_eq!(read.graph.guesses(), [None, Some(Pose::new(5.0, 0.0, 0.0)), None]);
    assert_eq!(read.notes, ["2 poses have no vertex: they are placed by their edges"]);
}

#[test]
fn repeated_edges_count_and_are_noted() {
    let read = read("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 0 -1 0 0 1 0 0 1 0 1\n").unwrap();
    assert_eq!(read.graph.edges().len(), 2);
    assert!(read.notes[0].starts_with("1 edges join poses that another edge joins"), "{:?}", read.notes);
}

#[test]
fn what_is_no_graph_is_refused_with_its_line() {
    for (text, said) in [
        (
            "\nVERTEX_SE2 0 0 0\n",
            "line 2: VERTEX_SE2 has 3 words after it, expected 4: id x y theta; the line may have been cut off",
        ),
        ("VERTEX_SE2 0 0 0 0 0\n", "expected 4: id x y theta"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n", "expected 11"),
        ("VERTEX_SE2 0 0 nan 0\n", "line 1: \"nan\" is no number, expected a finite one"),
        ("VERTEX_SE2 0 0 inf 0\n", "finite"),
        ("VERTEX_SE2 0 0 1e999 0\n", "finite"),
        ("VERTEX_SE2 0 1,5 0 0\n", "no comma"),
        ("VERTEX_SE2 -1 0 0 0\n", "\"-1\" names no pose"),
        (
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 1 0 0\n",
            "line 3: pose 0 was given otherwise on line 2",
        ),
        ("EDGE_SE2 4 4 1 0 0 1 0 0 1 0 1\n", "line 1: the edge leads from pose 4 to itself"),
        ("EDGE_SE2 0 1 1 0 0 -1 0 0 1 0 1\n", "information matrix is not symmetric"),
        ("FIX\n", "expected FIX id"),
        ("FIX 3\n", "line 1: pose 3 is not there"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 1\n", "line 2: pose 1 is to be held but has no value"),
        ("VERTEX_XY 0 0 0\n", "landmark"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "in space"),
        ("EQUIV 0 1\n", "makes two poses one"),
        ("{\"seq\":0}\n", "unknown word"),
    ] {
        let error = refused(text);
        assert!(error.contains(said) && error.starts_with("line "), "{text:?}: {error}");
    }
    let error = read_graph(&b"VERTEX_SE2 0 \xff 0 0\n"[..], None).unwrap_err().to_string();
    assert!(error.contains("no text"), "{error}");
    assert!(refused(&"x".repeat(1 << 20)).contains("longer than 4096 bytes"));
}

#[test]
fn nothing_is_a_graph_without_poses() {
    for text in ["", "\n\n", "# a comment\n", "PARAMS_SE2OFFSET 0 0 0 0\n"] {
        let read = read(text).unwrap();
        assert!(read.graph.is_empty() && read.notes.is_empty(), "{text:?}");
    }
}

#[test]
fn a_trajectory_has_eight_columns_and_single_spaces() {
    let mut graph = PoseGraph::new();
    graph.add_pose(PoseId(3), Some(Pose::new(1.5, -2.0, std::f64::consts::PI))).unwrap();
    graph.add_pose(PoseId(4), None).unwrap();
    let text = write_tum(&graph);
    assert_eq!(text.lines().count(), 1);
    let words: Vec<f64> = text.trim_end().split(' ').map(|word| word.parse().unwrap()).collect();
    assert_eq!(words[..7], [3.0, 1.5, -2.0, 0.0, 0.0, 0.0, 1.0]);
    assert!(words[7].abs() < 1e-15 && words.len() == 8);
}

fn graphs() -> impl Strategy<Value = PoseGraph> {
    let number = -1e3..1e3;
    let pose = (number.clone(), number, -3.1..3.1).prop_map(|(x, y, theta)| Pose::new(x, y, theta));
    let root = prop::array::uniform9(-10.0..10.0).prop_map(|n: [f64; 9]| Matrix3::from_row_slice(&n));
    let edge = (0..6_u64, 1..6_u64, pose.clone(), root);
    (prop::collection::vec(prop::option::of(pose), 6), prop::collection::vec(edge, 0..12)).prop_map(
        |(guesses, edges)| {
            let mut graph = PoseGraph::new();
            let ids = (0..).map(|k: u64| PoseId(10 * k));
            ids.zip(guesses).for_each(|(id, guess)| graph.add_pose(id, guess).unwrap());
            for (from, ahead, displacement, root) in edges {
                let [from, to] = [from, (from + ahead) % 6].map(|k| PoseId(10 * k));
                let square = root * root.transpose();
                let information = (square + square.transpose()) / 2.0;
                graph.add_edge(Edge { from, to, displacement, information }).unwrap();
            }
            if graph.guesses()[0].is_some() {
                graph.hold(PoseId(0)).unwrap();
            }
            graph
        },
    )
}

proptest! {
    #[test]
    fn what_is_written_reads_back_to_the_last_bit(graph in graphs()) {
        for (text, order) in [
            (write_g2o(&graph), InformationOrder::G2o),
            (write_toro(&graph), InformationOrder::Toro),
        ] {
            let read = read_graph(text.as_bytes(), Some(order)).unwrap().graph;
            prop_assert_eq!(read.edges(), graph.edges());
            for (id, guess) in graph.ids().iter().zip(graph.guesses()) {
                let number = read.number(*id);
                prop_assert_eq!(number.and_then(|n| read.guesses()[n]), *guess);
            }
        }
    }

    #[test]
    fn a_file_cut_off_anywhere_is_read_or_refused(graph in graphs(), share in 0.0..1.0) {
        let text = write_g2o(&graph);
        let cut = &text[..(text.len() as f64 * share) as usize];
        if let Err(error) = read_graph(cut.as_bytes(), Some(InformationOrder::G2o)) {
            prop_assert!(error.to_string().starts_with("line "), "{}", error);
        }
    }

    #[test]
    fn noise_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = read_graph(&bytes[..], None);
    }
}
