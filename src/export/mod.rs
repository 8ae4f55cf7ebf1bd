//! What leaves the process: the wire types of reports and maps, and pictures.
//!
//! [`Report`] is the one object that `topostar map --json` prints and the service answers from; [`MapGraph`] is a
//! candidate's map as JSON. Both are made from plain values of `abduction` and `map` and hold nothing else.

pub mod answer_set;
mod graph;
mod report;
mod sheet;
mod extraction;
mod extraction_svg;
mod layout;
mod map_svg;
mod map_text;

pub use extraction::Extraction;
pub use extraction_svg::extraction_svg;
pub use graph::{
    GraphBeside, GraphCrossing, GraphDstate, GraphGateway, GraphPath, GraphPlace, GraphRegions, GraphSegment,
    MapGraph,
};
pub use layout::Layout;
pub use map_svg::map_svg;
pub use map_text::{map_text, place_type};
pub use report::{
    Assertion, Count, Extinction, Preferred, Relation, Report, StopReason, Strategy, profile_name,
};
