//! Writing graphs and trajectories. Numbers are the shortest that read back to the last bit.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::format::InformationOrder;
use crate::patchwork::pose_graph::graph::{Edge, PoseGraph};
use std::fmt::{Display, Write};

/// The graph in g2o's format, its guesses as vertices; `FIX` for each pose held.
pub fn write_g2o(graph: &PoseGraph) -> String {
    let mut text = vertices(graph, "VERTEX_SE2");
    for (id, _) in graph.ids().iter().zip(graph.held()).filter(|(_, held)| **held) {
        line(&mut text, format_args!("FIX {id}"));
    }
    text + &edges(graph, "EDGE_SE2", InformationOrder::G2o)
}

/// The graph in TORO's format. It has no word for poses held: read back, the graph has the gauge of one without any, the
/// first pose of each part.
pub fn write_toro(graph: &PoseGraph) -> String {
    vertices(graph, "VERTEX2") + &edges(graph, "EDGE2", InformationOrder::Toro)
}

/// The guesses as a TUM trajectory: `stamp x y z qx qy qz qw`, the number of the pose for a stamp.
pub fn write_tum(graph: &PoseGraph) -> String {
    let known = graph.ids().iter().zip(graph.guesses());
    trajectory(known.filter_map(|(id, guess)| Some((id, (*guess)?))))
}

/// Poses with their stamps, seconds, as a TUM trajectory.
pub fn write_trajectory(poses: &[(f64, Pose)]) -> String {
    trajectory(poses.iter().copied())
}

fn trajectory(poses: impl Iterator<Item = (impl Display, Pose)>) -> String {
    let mut text = String::new();
    for (stamp, pose) in poses {
        let (sin, cos) = (pose.theta / 2.0).sin_cos();
        line(&mut text, format_args!("{stamp} {} {} 0 0 0 {sin} {cos}", pose.x, pose.y));
    }
    text
}

fn vertices(graph: &PoseGraph, tag: &str) -> String {
    let mut text = String::new();
    for (id, guess) in graph.ids().iter().zip(graph.guesses()) {
        if let Some(pose) = guess {
            line(&mut text, format_args!("{tag} {id} {} {} {}", pose.x, pose.y, pose.theta));
        }
    }
    text
}

fn edges(graph: &PoseGraph, tag: &str, order: InformationOrder) -> String {
    let mut text = String::new();
    for Edge { from, to, displacement: z, information } in graph.edges() {
        let [a, b, c, d, e, f] = order.places().map(|place| information[place]);
        line(
            &mut text,
            format_args!("{tag} {from} {to} {} {} {} {a} {b} {c} {d} {e} {f}", z.x, z.y, z.theta),
        );
    }
    text
}

fn line(text: &mut String, content: std::fmt::Arguments<'_>) {
    // Writing to a string does not fail.
    let _ = writeln!(text, "{content}");
}
