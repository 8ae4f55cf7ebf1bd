//! What leaves the process: the wire types of reports and maps, and pictures.
//!
//! [`Report`] is the one object that `topostar map --json` prints and the service answers from; [`MapGraph`] is a
//! candidate's map as JSON. Both are made from plain values of `abduction` and `map` and hold nothing else.
//! [`ViewReport`] is the same for a trace of views, made from values of `classic`.

mod branches;
mod difference;
mod explanation;
mod explanation_text;
pub mod answer_set;
mod graph;
mod grid;
mod mending;
mod outlook;
mod pose_errors;
mod poses_svg;
mod refutation;
mod relaxation;
mod report;
mod sheet;
mod standstill;
mod strain;
mod ties;
mod extraction;
mod extraction_svg;
mod layout;
mod map_server;
mod map_svg;
mod map_text;
mod truth;
mod visits_svg;
mod view_report;
mod view_text;

pub use branches::{EndedBranches, TreeExtent, TreeNode};
pub use difference::{Difference, Pairs, Side};
pub use explanation::{Explanation, Reason, ReasonKind, Rival, Visits};
pub use explanation_text::{explanation_text, visits_text};
pub use extraction::Extraction;
pub use extraction_svg::{extraction_svg, extraction_svg_with};
pub use graph::{
    GraphBeside, GraphCrossing, GraphDstate, GraphGateway, GraphPath, GraphPlace, GraphPoses, GraphRegions,
    GraphSegment, MapGraph,
};
pub use grid::GridDocument;
pub use layout::Layout;
pub use map_server::{map_pgm, map_png, map_yaml};
pub use map_svg::map_svg;
pub use map_text::{map_text, place_type};
pub use mending::{Mending, Misreading, MisreadingKind, mending_text};
pub use outlook::{Outlook, PredictedSlot, Prediction, Prospect};
pub use pose_errors::{PoseError, PoseErrorRow, PoseErrors};
pub use poses_svg::poses_svg;
pub use refutation::{Alternative, EndedBranch, Refutation};
pub use relaxation::{GrowthReport, PartSize, RelaxationReport, RelaxationSeconds, StrainedEdge};
pub use report::{
    Assertion, Bound, Count, Extinction, Preferred, Relation, Report, StopReason, Strategy, profile_name,
};
pub use standstill::{Dissenting, Doubt, Standstill, standstill_text};
pub use strain::{
    MapStrain, RelaxationOutcome, StrainSum, StrainedSpan, WallsCompared, WayRelaxed, WayStrain,
};
pub use ties::{TieOrder, TieStrain, Ties};
pub use truth::{Mark, Repeated, Truth};
pub use view_report::{PreferredViews, ViewReport, ViewStopReason, ViewStrategy};
pub use view_text::view_text;
pub use visits_svg::{Visited, visits_svg};
