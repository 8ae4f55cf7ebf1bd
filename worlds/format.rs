//! The fields of a world file as they are written; `README.md` beside this file describes them.

use serde::Deserialize;

/// A whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireWorld {
    pub(super) title: String,
    pub(super) story: String,
    pub(super) drawing: WireDrawing,
    pub(super) place: Vec<WirePlace>,
    pub(super) walk: WireWalk,
    pub(super) expect: WireExpectations,
}

/// Open shapes minus solid shapes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireDrawing {
    pub(super) open: Vec<WireShape>,
    #[serde(default)]
    pub(super) solid: Vec<WireShape>,
}

/// One shape; exactly one of `corridor`, `disc` and `polygon` says which.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireShape {
    pub(super) corridor: Option<Vec<[f64; 2]>>,
    pub(super) width: Option<f64>,
    pub(super) disc: Option<[f64; 2]>,
    pub(super) radius: Option<f64>,
    pub(super) polygon: Option<Vec<[f64; 2]>>,
}

/// A place.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WirePlace {
    pub(super) name: String,
    pub(super) at: [f64; 2],
    pub(super) slots: Vec<WireSlot>,
}

/// A directed path fragment.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireSlot {
    pub(super) name: String,
    pub(super) fragment: u32,
    pub(super) bearing: f64,
    pub(super) out: Option<String>,
    pub(super) control: WireControl,
    #[serde(default = "usual_reach")]
    pub(super) reach: f64,
}

/// The control laws by their names in traces.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum WireControl {
    Midline,
    LeftWall,
    RightWall,
    DeadEnd,
    None,
}

/// The walk.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireWalk {
    pub(super) start: String,
    pub(super) leave: Vec<String>,
}

/// What must come out, by profile.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireExpectations {
    pub(super) paper: WireExpectation,
    pub(super) default: WireExpectation,
    pub(super) measured: Option<WireExpectation>,
}

/// What must come out in one profile.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireExpectation {
    pub(super) candidates: Vec<usize>,
    pub(super) created: usize,
    pub(super) minimal: WireMinimal,
    pub(super) truth: WireTruth,
}

/// The minimum.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WireMinimal {
    pub(super) paths: usize,
    pub(super) places: usize,
    pub(super) ties: usize,
}

/// What becomes of the true map.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum WireTruth {
    Minimal,
    Candidate,
    Refuted { axiom: String, observation: usize },
}

/// The distance from the middle of a junction of two-metre corridors to its gateways.
fn usual_reach() -> f64 {
    1.0
}
