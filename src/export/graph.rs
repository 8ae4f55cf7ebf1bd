//! A candidate's map as a JSON graph.

use crate::abduction::Candidate;
use crate::map::{BoundSlot, DstateId, Paths, PlaceId, Segment, TopoPath, TopologicalMap};
use crate::trace::wire_star::{WireControl, WireDirection};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The topological map of a candidate: places with their stars bound to paths, paths, path segments and the
/// frontier.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct MapGraph {
    /// Places, by number.
    pub places: Vec<GraphPlace>,
    /// Paths, travelled or not, by number.
    pub paths: Vec<GraphPath>,
    /// Travelled path segments, by number.
    pub segments: Vec<GraphSegment>,
    /// Gateways whose far end is not known yet.
    pub frontier: Vec<GraphGateway>,
    /// The distinctive state the robot is at after the last observation.
    pub robot: GraphGateway,
}

/// A place.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphPlace {
    /// Its number, by first visit.
    pub id: usize,
    /// The number of slots of its star, which is that of its distinctive states.
    pub size: usize,
    /// Its distinctive states, clockwise.
    pub dstates: Vec<GraphDstate>,
}

/// A distinctive state: a slot of a place's star, facing outward along a directed path.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphDstate {
    /// The slot, as at the first visit to the place.
    pub slot: u8,
    /// The path it faces along.
    pub path: u32,
    /// The direction along that path.
    pub direction: WireDirection,
    /// Whether the robot can travel on; if not, the path ends here in this direction.
    pub navigable: bool,
    /// How to travel on.
    pub control: WireControl,
    /// The gateway at the far end of the path segment, if it was travelled.
    pub far_end: Option<GraphGateway>,
}

/// A path.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphPath {
    /// Its number.
    pub id: u32,
    /// The places on it, in the direction `+`.
    pub places: Vec<usize>,
    /// Whether its last place leads on to the first; never so under the axiom `path-order`.
    pub closed: bool,
}

/// A travelled path segment.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphSegment {
    /// Its number.
    pub id: u32,
    /// The gateways it joins, the lower one first.
    pub ends: [GraphGateway; 2],
}

/// A place and a slot of its star.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct GraphGateway {
    /// The number of the place.
    pub place: usize,
    /// The slot of its star.
    pub slot: u8,
}

impl MapGraph {
    /// The graph of a candidate.
    pub fn of(candidate: &Candidate) -> MapGraph {
        let map = candidate.map.as_ref();
        let paths = Paths::of(map);
        MapGraph {
            places: map.places().map(|place| GraphPlace::of(map, &paths, place)).collect(),
            paths: paths.iter().map(GraphPath::of).collect(),
            segments: map.segments().iter().map(GraphSegment::of).collect(),
            frontier: frontier(map).map(GraphGateway::of).collect(),
            robot: GraphGateway::of(candidate.robot),
        }
    }
}

/// The dstates that can be travelled from and have no far end.
fn frontier(map: &TopologicalMap) -> impl Iterator<Item = DstateId> {
    let navigable = |d: &DstateId| map.star(d.place).slots()[usize::from(d.slot.0)].navigable;
    map.dstates().filter(move |dstate| map.far_end(*dstate).is_none() && navigable(dstate))
}

impl GraphPlace {
    fn of(map: &TopologicalMap, paths: &Paths, place: PlaceId) -> GraphPlace {
        let bound = paths.bound_star(map, place);
        let dstates: Vec<_> = bound.into_iter().map(|slot| GraphDstate::of(map, slot)).collect();
        GraphPlace { id: place.index(), size: dstates.len(), dstates }
    }
}

impl GraphDstate {
    fn of(map: &TopologicalMap, BoundSlot { dstate, along, terminates }: BoundSlot) -> GraphDstate {
        GraphDstate {
            slot: dstate.slot.0,
            path: along.path.0,
            direction: along.direction.into(),
            navigable: !terminates,
            control: map.star(dstate.place).slots()[usize::from(dstate.slot.0)].control.into(),
            far_end: map.far_end(dstate).map(GraphGateway::of),
        }
    }
}

impl GraphPath {
    fn of(path: &TopoPath) -> GraphPath {
        GraphPath { id: path.id.0, places: path.places().map(PlaceId::index).collect(), closed: path.closed }
    }
}

impl GraphSegment {
    fn of(segment: &Segment) -> GraphSegment {
        GraphSegment { id: segment.id.0, ends: segment.ends.map(GraphGateway::of) }
    }
}

impl GraphGateway {
    /// The wire form of a dstate.
    pub fn of(dstate: DstateId) -> GraphGateway {
        GraphGateway { place: dstate.place.index(), slot: dstate.slot.0 }
    }
}
