//! One line of a graph file: its words as numbers and names.

use crate::geometry::Pose;
use crate::patchwork::pose_graph::PoseId;

/// What a line of a file says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Line {
    /// Nothing, or a comment, or a parameter that no pose depends on.
    Nothing,
    /// A pose.
    Vertex(PoseId, Pose),
    /// A measurement, and whether the tag is TORO's.
    Edge { from: PoseId, to: PoseId, displacement: Pose, information: [f64; 6], toro: bool },
    /// Poses not to be moved.
    Fix(Vec<PoseId>),
}

const VERTEX: &str = "id x y theta";
const EDGE: &str = "from to x y theta and the six numbers of the information matrix";

/// Reads a line, or says what was expected.
pub(super) fn parse(text: &str) -> Result<Line, String> {
    let content = text.split('#').next().unwrap_or_default();
    let mut words = content.split_ascii_whitespace();
    let Some(tag) = words.next() else { return Ok(Line::Nothing) };
    let words: Vec<&str> = words.collect();
    match tag {
        "VERTEX_SE2" | "VERTEX2" => {
            let [id, rest @ ..] = exactly::<4>(tag, &words, VERTEX)?;
            Ok(Line::Vertex(name(id)?, pose(rest)?))
        }
        "EDGE_SE2" | "EDGE2" => {
            let [from, to, x, y, theta, rest @ ..] = exactly::<11>(tag, &words, EDGE)?;
            let mut information = [0.0; 6];
            for (number, word) in information.iter_mut().zip(rest) {
                *number = finite(word)?;
            }
            let displacement = pose([x, y, theta])?;
            let (from, to, toro) = (name(from)?, name(to)?, tag == "EDGE2");
            Ok(Line::Edge { from, to, displacement, information, toro })
        }
        "FIX" if words.is_empty() => Err("FIX names no pose, expected FIX id".into()),
        "FIX" => words.iter().map(|word| name(word)).collect::<Result<_, _>>().map(Line::Fix),
        "PARAMS_SE2OFFSET" => Ok(Line::Nothing),
        _ => Err(unknown(tag)),
    }
}

fn unknown(tag: &str) -> String {
    let known = "expected VERTEX_SE2, EDGE_SE2 or FIX as in g2o, or VERTEX2 or EDGE2 as in TORO";
    match tag {
        "VERTEX_XY" | "EDGE_SE2_XY" | "EDGE_BEARING_SE2_XY" | "BR" | "LANDMARK" => {
            format!("{tag} is of a landmark, {known}: graphs of poses are relaxed, without landmarks")
        }
        "VERTEX_SE3:QUAT" | "EDGE_SE3:QUAT" | "VERTEX3" | "EDGE3" => {
            format!("{tag} is of a pose in space, {known}: poses lie in the plane here")
        }
        "EQUIV" => format!(
            "EQUIV makes two poses one, {known}: name one of them by the other's number throughout, and leave this line out"
        ),
        _ => {
            let shown: String = tag.chars().take(40).collect();
            format!("unknown word {shown:?}, {known}")
        }
    }
}

fn exactly<'a, const N: usize>(tag: &str, words: &[&'a str], what: &str) -> Result<[&'a str; N], String> {
    let found = words.len();
    words.try_into().map_err(|_| {
        let cut = if found < N { "; the line may have been cut off" } else { "" };
        format!("{tag} has {found} words after it, expected {N}: {what}{cut}")
    })
}

fn name(word: &str) -> Result<PoseId, String> {
    let bad = |_| format!("{word:?} names no pose, expected a whole number of 0 or more");
    word.parse().map(PoseId).map_err(bad)
}

fn finite(word: &str) -> Result<f64, String> {
    let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{word:?} is no number, expected a finite one, with a point and no comma"))
}

fn pose(words: [&str; 3]) -> Result<Pose, String> {
    let [x, y, theta] = words;
    Ok(Pose::new(finite(x)?, finite(y)?, finite(theta)?))
}
