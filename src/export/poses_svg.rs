//! A picture of a pose graph before and after relaxation.

use crate::export::sheet::{COLORS, FAINT, INK, sheet};
use crate::geometry::Pose;
use crate::patchwork::PoseGraph;
use std::fmt::Write;
use svg::node::element::{Path, Text};

/// Side of a panel and its margin, user units.
const PANEL: f64 = 480.0;
const MARGIN: f64 = 32.0;

/// Two panels, each to its own scale: the poses as they were, and as they are; edges between poses that are not next to
/// each other are faint.
pub fn poses_svg(graph: &PoseGraph, before: &[Pose], after: &[Pose]) -> String {
    let mut document = sheet(2.0 * PANEL, PANEL + MARGIN);
    for (panel, (title, poses)) in [("before", before), ("after", after)].into_iter().enumerate() {
        let left = panel as f64 * PANEL;
        let text = Text::new(title)
            .set("x", left + MARGIN)
            .set("y", MARGIN * 0.8)
            .set("font-size", 16)
            .set("fill", INK);
        document = document.add(text);
        for (edges, color, width) in [(false, FAINT, 0.5), (true, COLORS[0], 1.2)] {
            let lines = Path::new()
                .set("d", lines(graph, poses, left, edges))
                .set("fill", "none")
                .set("stroke", color)
                .set("stroke-width", width)
                .set("stroke-linecap", "round");
            document = document.add(lines);
        }
    }
    document.to_string()
}

/// The edges of the way itself, or all others, as lines.
fn lines(graph: &PoseGraph, poses: &[Pose], left: f64, way: bool) -> String {
    let bounds = |of: fn(&Pose) -> f64| {
        let finite = poses.iter().map(of);
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), n| (low.min(n), high.max(n)))
    };
    let ((west, east), (south, north)) = (bounds(|pose| pose.x), bounds(|pose| pose.y));
    let scale = (PANEL - 2.0 * MARGIN) / (east - west).max(north - south).max(f64::MIN_POSITIVE);
    let at = |pose: &Pose| (left + MARGIN + (pose.x - west) * scale, MARGIN + (north - pose.y) * scale);
    let mut path = String::new();
    for edge in graph.edges() {
        let (Some(from), Some(to)) = (graph.number(edge.from), graph.number(edge.to)) else { continue };
        if (from.abs_diff(to) == 1) == way {
            let ((x, y), (u, v)) = (at(&poses[from]), at(&poses[to]));
            // Writing to a string does not fail.
            let _ = write!(path, "M{x:.1} {y:.1}L{u:.1} {v:.1}");
        }
    }
    path
}
