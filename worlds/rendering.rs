//! Walks through a world as traces of grids: every visit shows the LPM of its place, in a frame of its own.

use crate::geometry::{Point, Pose, direction, wrap_angle};
use crate::grid::{GridError, GridInfo, OccupancyGrid};
use crate::lpm::Lpm;
use crate::star::SlotIndex;
use crate::trace::event::{Event, EventKind, Observation, Percept, Travel, Turn, TurnTarget};
use crate::worlds::random::Random;
use crate::worlds::simulator::push;
use crate::worlds::world::{Place, Visit, World};
use std::f64::consts::PI;

/// Side of the square that an LPM shows, metres.
pub const WINDOW: f64 = 20.0;
/// How far the middle of the square may be from the place's point along each axis, metres.
pub const SHIFT: f64 = 1.0;
/// How far inside a gateway the robot stands on arrival and on departure, metres.
const INSIDE: f64 = 0.3;
/// Standard deviation of a travel's length and sideways drift, as a share of the distance, and of its heading in
/// radians a metre.
const DRIFT: [f64; 3] = [0.02, 0.02, 0.002];
/// Standard deviations that even the shortest travel has: metres, metres, radians.
const LEAST_DRIFT: [f64; 3] = [0.05, 0.05, 0.01];

/// A trace of grids and what is true of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LpmTrace {
    /// The events.
    pub events: Vec<Event>,
    /// The place of each observation, numbered by first visit.
    pub places: Vec<usize>,
    /// Where the frame of each LPM is in the world.
    pub world_from_lpm: Vec<Pose>,
}

/// The walk of a world as the LPMs seen on it, each turned and shifted as the seed says, with noisy odometry
/// between them. Refuses a resolution that makes no grid.
pub fn lpm_trace(world: &World, seed: u64, resolution: f64) -> Result<LpmTrace, GridError> {
    let mut random = Random::new(seed);
    let visits = world.visits();
    let frames: Vec<Pose> =
        visits.iter().map(|visit| frame(&world.places[visit.place], &mut random)).collect();
    let mut events = Vec::new();
    for (step, (visit, world_from_lpm)) in visits.iter().zip(&frames).enumerate() {
        let lpm_from_world = world_from_lpm.inverse();
        let place = &world.places[visit.place];
        let arrival = if step == 0 { facing(place, visit.arrival) } else { entering(place, visit.arrival) };
        let robot_pose = lpm_from_world.compose(&arrival);
        let percept =
            Percept::Lpm(Lpm::new(render(world, world_from_lpm, &arrival, resolution)?, robot_pose));
        push(&mut events, EventKind::Observation(Box::new(Observation { percept })));
        let (Some(departure), Some(next)) = (visit.departure, visits.get(step + 1)) else { break };
        let leaving = leaving(place, departure);
        if departure != visit.arrival {
            let heading = wrap_angle(leaving.theta - world_from_lpm.theta);
            push(&mut events, EventKind::Turn(Turn { target: TurnTarget::Heading(heading), angle: None }));
        }
        let start_from_end = leaving.inverse().compose(&arriving(world, next));
        let travel = drive(&start_from_end, lpm_from_world.compose(&leaving), &mut random);
        push(&mut events, EventKind::Travel(Box::new(travel)));
    }
    Ok(LpmTrace { events, places: world.visited_places(), world_from_lpm: frames })
}

/// What the robot knows of a window around a place once it has looked around.
fn render(
    world: &World,
    world_from_lpm: &Pose,
    robot: &Pose,
    resolution: f64,
) -> Result<OccupancyGrid, GridError> {
    let cells = (WINDOW / resolution).round() as usize;
    let half = cells as f64 * resolution / 2.0;
    let lpm_from_corner = Pose::new(-half, -half, 0.0);
    let info = GridInfo { resolution, width: cells, height: cells, origin: lpm_from_corner };
    let in_world = GridInfo { origin: world_from_lpm.compose(&lpm_from_corner), ..info };
    let drawn = world.drawing.render(&in_world, &robot.position())?;
    OccupancyGrid::new(info, drawn.cells().to_vec())
}

fn frame(place: &Place, random: &mut Random) -> Pose {
    let (x, y) = (place.at.x + random.within(SHIFT), place.at.y + random.within(SHIFT));
    Pose::new(x, y, random.within(PI))
}

fn arriving(world: &World, visit: &Visit) -> Pose {
    entering(&world.places[visit.place], visit.arrival)
}

/// At the first visit the robot stands in the middle.
fn facing(place: &Place, slot: SlotIndex) -> Pose {
    Pose::new(place.at.x, place.at.y, place.slots[slot.0 as usize].bearing)
}

/// Just inside the gateway that a directed fragment comes in by, looking inward.
fn entering(place: &Place, slot: SlotIndex) -> Pose {
    let gateway = place.slots[slot.0 as usize].opposite;
    let outward = leaving(place, gateway);
    Pose::new(outward.x, outward.y, outward.theta + PI)
}

/// Just inside the gateway of a slot, looking outward.
fn leaving(place: &Place, slot: SlotIndex) -> Pose {
    let slot = &place.slots[slot.0 as usize];
    let at: Point = place.at + direction(slot.bearing) * (slot.reach - INSIDE).max(0.0);
    Pose::new(at.x, at.y, slot.bearing)
}

/// A travel as odometry tells it: the true displacement with an error drawn from its covariance.
fn drive(start_from_end: &Pose, lpm_from_start: Pose, random: &mut Random) -> Travel {
    let distance = start_from_end.position().coords.norm();
    let deviation = [0, 1, 2].map(|i| DRIFT[i] * distance + LEAST_DRIFT[i]);
    let error = deviation.map(|sigma| sigma * random.normal());
    let mut covariance = [0.0; 9];
    for (i, sigma) in deviation.iter().enumerate() {
        covariance[4 * i] = sigma * sigma;
    }
    let odometry =
        Pose::new(start_from_end.x + error[0], start_from_end.y + error[1], start_from_end.theta + error[2]);
    Travel {
        odometry: Some(odometry),
        covariance: Some(covariance),
        from_pose: Some(lpm_from_start),
        shape: Vec::new(),
    }
}
