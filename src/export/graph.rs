//! A candidate's map as a JSON graph.

use crate::abduction::Candidate;
use crate::export::strain::{StrainSum, wire_pose};
use crate::map::{
    Abnormality, Beside, BoundSlot, Crossing, DstateId, PathRegions, Paths, PlaceId, Regions, Segment,
    TopoPath, TopologicalMap,
};
use crate::patchwork::local_frames::LocalFrames;
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
    /// Where the places lie once what was measured between them is relaxed; left out where no travel was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<GraphPoses>,
    /// What strains the map then; left out where no travel was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<StrainSum>,
}

/// The frames of places and visits: x, y in metres and heading in radians, in the frame of the first observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GraphPoses {
    /// The frame of each place, by its number: that of its first visit, as its star is.
    pub places: Vec<[f64; 3]>,
    /// The frame of each visit, by observation: its origin is the point of the place, its axes are those of the observation.
    pub visits: Vec<[f64; 3]>,
    /// The observation that the frame of each visit hangs on, by observation: 0 for all, unless a travel was not measured
    /// and nothing measured later joins what it parts. Poses that hang on different observations say nothing of each other.
    pub parts: Vec<usize>,
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
    /// What lies to its left and right, as seen in the direction `+`.
    pub regions: GraphRegions,
}

/// The two sides of a path. What the evidence says holds unless it comes by an abnormal path.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphRegions {
    /// The places to its left, by number.
    pub left: Vec<GraphBeside>,
    /// The places to its right, by number.
    pub right: Vec<GraphBeside>,
    /// The paths for which this one is no boundary, as they cross it twice or curl back to it: the fewest without
    /// which no place is on both sides, or on the path and beside it.
    pub abnormal: Vec<u32>,
}

/// A place beside a path.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphBeside {
    /// The number of the place.
    pub place: usize,
    /// Why it is there.
    pub evidence: Vec<GraphCrossing>,
}

/// A path that leaves another to one side.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
pub struct GraphCrossing {
    /// The number of the place at which it leaves.
    pub at: usize,
    /// The number of the path that leaves.
    pub path: u32,
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
        let (paths, regions) = (Paths::of(map), Regions::of(map));
        let abnormal = regions.abnormalities();
        let path = |(path, regions)| GraphPath::of(path, GraphRegions::of(regions, &abnormal));
        MapGraph {
            places: map.places().map(|place| GraphPlace::of(map, &paths, place)).collect(),
            paths: paths.iter().zip(regions.iter()).map(path).collect(),
            segments: map.segments().iter().map(GraphSegment::of).collect(),
            frontier: frontier(map).map(GraphGateway::of).collect(),
            robot: GraphGateway::of(candidate.robot),
            poses: None,
            strain: None,
        }
    }

    /// The same with where the places of the candidate lie, and what strains it.
    #[must_use]
    pub fn with_frames(self, candidate: &Candidate, frames: &LocalFrames) -> MapGraph {
        let visits: Vec<[f64; 3]> = frames.poses.iter().map(wire_pose).collect();
        let mut places = Vec::new();
        for (visit, pose) in candidate.visits.iter().zip(&visits) {
            // Places are numbered by first visit.
            if visit.place.index() == places.len() {
                places.push(*pose);
            }
        }
        let poses = GraphPoses { places, visits, parts: frames.parts.clone() };
        MapGraph { poses: Some(poses), strain: Some(StrainSum::of(frames)), ..self }
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
    fn of(path: &TopoPath, regions: GraphRegions) -> GraphPath {
        let places = path.places().map(PlaceId::index).collect();
        GraphPath { id: path.id.0, places, closed: path.closed, regions }
    }
}

impl GraphRegions {
    fn of(regions: &PathRegions, abnormal: &[Abnormality]) -> GraphRegions {
        let side = |side: &[Beside]| side.iter().map(GraphBeside::of).collect();
        let mine = abnormal.iter().filter(|it| it.path == regions.path);
        GraphRegions {
            left: side(&regions.left),
            right: side(&regions.right),
            abnormal: mine.map(|it| it.carrier.0).collect(),
        }
    }
}

impl GraphBeside {
    fn of(beside: &Beside) -> GraphBeside {
        let crossing = |it: &Crossing| GraphCrossing { at: it.at.index(), path: it.carrier.0 };
        GraphBeside { place: beside.place.index(), evidence: beside.evidence.iter().map(crossing).collect() }
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
