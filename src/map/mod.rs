//! The topological map: places with their stars, joined by path segments into paths (seed, sections 3.1 and 4.3).
//!
//! A map is a *rotation system*: every place lists its directed paths clockwise, and a path segment joins two
//! outward gateways. Places, path segments, paths and distinctive states all follow from these two facts. Maps
//! are immutable values; an extension is a new map. Symbols only: no metres, no views, no history.

mod abnormality;
mod atlas;
mod boundaries;
mod canonical;
mod id;
mod path;
mod place_set;
mod region;
mod star_table;
mod topological;
mod trail;

pub use abnormality::Abnormality;
pub use canonical::CanonicalMap;
pub use id::{DstateId, PathId, PlaceId, SegmentId};
pub use path::{BoundSlot, DirectedPath, Paths, Stop, TopoPath};
pub use region::{Beside, Conflict, Crossing, PathRegions, Regions};
pub use topological::{MapError, Segment, TopologicalMap};

pub(crate) use atlas::Atlas;
pub(crate) use boundaries::Boundaries;
pub(crate) use place_set::PlaceSet;
pub(crate) use star_table::{InternedStar, StarId, StarTable};
pub(crate) use trail::{Face, face_segments, path_from_end, places_beyond};
