//! Reading a graph file: either format, line by line, within bounds.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::format::InformationOrder;
use crate::patchwork::pose_graph::format::line::{Line, parse};
use crate::patchwork::pose_graph::graph::{Edge, PoseGraph, PoseId, is_information};
use nalgebra::Matrix3;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Read};

/// A graph as read, its poses in ascending order of their names.
#[derive(Clone, Debug)]
pub struct ReadGraph {
    /// The graph.
    pub graph: PoseGraph,
    /// The order that the information of the edges was read in.
    pub order: InformationOrder,
    /// What a reader of the answer should know of the file.
    pub notes: Vec<String>,
}

/// What is wrong with a file, and how to mend it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// A line cannot be used.
    #[error("line {line}: {what}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// What was found and what expected.
        what: String,
    },
    /// Reading failed.
    #[error("after line {line}: cannot be read: {what}")]
    Read {
        /// The last line read.
        line: usize,
        /// What the system says.
        what: String,
    },
}

/// How long a line is at most, bytes.
const LONGEST_LINE: u64 = 4096;
/// How many lines are read at most.
const MOST_LINES: usize = 50_000_000;

/// An edge with its line, its information as it stands there.
struct RawEdge {
    line: usize,
    from: PoseId,
    to: PoseId,
    displacement: Pose,
    information: [f64; 6],
    toro: bool,
}

#[derive(Default)]
struct Raw {
    vertices: BTreeMap<PoseId, (usize, Pose)>,
    edges: Vec<RawEdge>,
    fixed: Vec<(usize, PoseId)>,
    repeated_vertices: usize,
}

/// Reads a g2o or TORO graph; poses that only edges name are there without a guess.
///
/// The order of information is that of the tags, unless under it some matrix is no inverse covariance and under the other
/// one all are: then it is the other one, and a note says so. An order given overrides both.
pub fn read_graph(input: impl BufRead, order: Option<InformationOrder>) -> Result<ReadGraph, FormatError> {
    let raw = read_lines(input)?;
    let mut notes = vec![];
    let order = match order {
        Some(order) => order,
        None => likely_order(&raw.edges, &mut notes),
    };
    let graph = assemble(&raw, order)?;
    notes.extend(remarks(&raw, &graph));
    Ok(ReadGraph { graph, order, notes })
}

fn read_lines(mut input: impl BufRead) -> Result<Raw, FormatError> {
    let mut raw = Raw::default();
    let mut buffer = Vec::new();
    for line in 1.. {
        buffer.clear();
        let bad = |what: String| FormatError::Line { line, what };
        let read = input.by_ref().take(LONGEST_LINE + 1).read_until(b'\n', &mut buffer);
        let failed = |error: std::io::Error| FormatError::Read { line: line - 1, what: error.to_string() };
        if read.map_err(failed)? == 0 {
            break;
        }
        if buffer.len() as u64 > LONGEST_LINE {
            return Err(bad(format!("longer than {LONGEST_LINE} bytes, expected one vertex or edge a line")));
        }
        if line > MOST_LINES {
            return Err(bad(format!("more than {MOST_LINES} lines, expected a smaller graph")));
        }
        let text = std::str::from_utf8(&buffer).map_err(|_| bad("no text, expected g2o or TORO".into()))?;
        take(&mut raw, line, parse(text).map_err(bad)?)?;
    }
    Ok(raw)
}

fn take(raw: &mut Raw, line: usize, said: Line) -> Result<(), FormatError> {
    match said {
        Line::Nothing => {}
        Line::Vertex(id, pose) => match raw.vertices.insert(id, (line, pose)) {
            Some((_, before)) if before == pose => raw.repeated_vertices += 1,
            Some((first, _)) => {
                let what = format!(
                    "pose {id} was given otherwise on line {first}, expected each once; rename one or leave it out"
                );
                return Err(FormatError::Line { line, what });
            }
            None => {}
        },
        Line::Edge { from, to, displacement, information, toro } => {
            raw.edges.push(RawEdge { line, from, to, displacement, information, toro });
        }
        Line::Fix(ids) => raw.fixed.extend(ids.into_iter().map(|id| (line, id))),
    }
    Ok(())
}

fn matrix(numbers: &[f64; 6], order: InformationOrder) -> Matrix3<f64> {
    let mut matrix = Matrix3::zeros();
    for (number, (row, column)) in numbers.iter().zip(order.places()) {
        matrix[(row, column)] = *number;
        matrix[(column, row)] = *number;
    }
    matrix
}

fn likely_order(edges: &[RawEdge], notes: &mut Vec<String>) -> InformationOrder {
    let toro = edges.first().is_some_and(|edge| edge.toro);
    let by_tag = if toro { InformationOrder::Toro } else { InformationOrder::G2o };
    let all = |order| edges.iter().all(|edge| is_information(&matrix(&edge.information, order)));
    if all(by_tag) || !all(by_tag.other()) {
        return by_tag;
    }
    let (tagged, other) = (by_tag.name(), by_tag.other().name());
    notes.push(format!(
        "the tags are those of {tagged}, but only in the order of {other} are the information matrices inverse \
         covariances: read in that order; --information-order says otherwise"
    ));
    by_tag.other()
}

fn assemble(raw: &Raw, order: InformationOrder) -> Result<PoseGraph, FormatError> {
    let at = |line: usize| {
        move |error: crate::patchwork::pose_graph::GraphError| {
            let mend = match error {
                crate::patchwork::pose_graph::GraphError::Information => format!(
                    "; read in the order of {}: is it that of {}? --information-order tells",
                    order.name(),
                    order.other().name()
                ),
                _ => String::new(),
            };
            FormatError::Line { line, what: format!("{error}{mend}") }
        }
    };
    let mut graph = PoseGraph::new();
    let named: BTreeSet<PoseId> =
        raw.edges.iter().flat_map(|edge| [edge.from, edge.to]).chain(raw.vertices.keys().copied()).collect();
    for id in named {
        let vertex = raw.vertices.get(&id);
        graph.add_pose(id, vertex.map(|(_, pose)| *pose)).map_err(at(vertex.map_or(0, |(line, _)| *line)))?;
    }
    for edge in &raw.edges {
        let RawEdge { line, from, to, displacement, information, .. } = *edge;
        let information = matrix(&information, order);
        graph.add_edge(Edge { from, to, displacement, information }).map_err(at(line))?;
    }
    for (line, id) in &raw.fixed {
        graph.hold(*id).map_err(at(*line))?;
    }
    Ok(graph)
}

fn remarks(raw: &Raw, graph: &PoseGraph) -> Vec<String> {
    let mut pairs = BTreeSet::new();
    let ends = raw.edges.iter().map(|edge| (edge.from.min(edge.to), edge.from.max(edge.to)));
    let repeated = ends.filter(|pair| !pairs.insert(*pair)).count();
    let unplaced = graph.len() - raw.vertices.len();
    let remark = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
    let without = if raw.vertices.is_empty() { 0 } else { unplaced };
    [
        remark(repeated, "edges join poses that another edge joins: all count"),
        remark(raw.repeated_vertices, "vertices are there twice, with one value"),
        remark(without, "poses have no vertex: they are placed by their edges"),
        raw.vertices.is_empty().then(|| "there are no vertices: poses are placed by the odometry".into()),
    ]
    .into_iter()
    .flatten()
    .filter(|_| !graph.is_empty())
    .collect()
}
