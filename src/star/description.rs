//! From a local perceptual model to the star of the place in which the robot stands.

use crate::gateway::{Gateway, GatewayParameters, Neighborhood, find_gateways};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::grid::{
    CleaningParameters, DistanceField, OccupancyGrid, SkeletonError, SkeletonGraph, SkeletonParameters,
    Surroundings, clean, skeletonize,
};
use crate::lpm::Lpm;
use crate::star::assembly::{Directed, clockwise, directed, number};
use crate::star::fragments::{FragmentParameters, pair};
use crate::star::projection::{Projection, project};
use crate::star::{GatewayId, SlotIndex, SmallScaleStar, StarError};
use std::f64::consts::{FRAC_PI_3, PI};
use thiserror::Error;

/// What perception takes from the robot and its surroundings. One set of defaults serves all LPMs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerceptionParameters {
    /// What is too small to matter.
    pub cleaning: CleaningParameters,
    /// Reach of wall following, width of passages, extent of the window.
    pub skeleton: SkeletonParameters,
    /// What makes a place and a gateway.
    pub gateway: GatewayParameters,
    /// When two gateways are ends of one path fragment.
    pub fragment: FragmentParameters,
}

/// A path fragment in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentTrace {
    /// The gateway of its first listed outward side.
    pub gateway: GatewayId,
    /// The gateway at its other end, unless it terminates.
    pub partner: Option<GatewayId>,
    /// Where its projection across the place ends, if it terminates; LPM frame.
    pub projection: Option<Point>,
}

/// The local topology of a place and the geometry it was read from. Points are in the LPM frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceDescription {
    /// The star, listed from the arrival slot, or from the slot the robot faces.
    pub star: SmallScaleStar,
    /// The slot on which the robot came in, if its pose tells.
    pub arrival: Option<SlotIndex>,
    /// The outward slot nearest to the robot's heading.
    pub facing: SlotIndex,
    /// The gateways; that with [`GatewayId`] `n` is at index `n - 1`.
    pub gateways: Vec<Gateway>,
    /// The path fragments; that with number `n` is at index `n - 1`.
    pub fragments: Vec<FragmentTrace>,
    /// The middle of the place.
    pub center: Point,
    /// Distance from the middle to the nearest obstacle, metres.
    pub clearance: f64,
    /// The edges of the skeleton.
    pub skeleton: Vec<Vec<Point>>,
    /// The grid as cleaned before anything was measured on it.
    pub grid: OccupancyGrid,
}

/// Why a place could not be described.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DescribeError {
    /// The robot's pose holds a number that is not finite.
    #[error("the robot's pose is not finite")]
    Pose,
    /// There is no skeleton.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
    /// No gateway was found.
    #[error("the place has no gateway, expected at least one")]
    NoGateway,
    /// The slots do not make a star.
    #[error(transparent)]
    Star(#[from] StarError),
}

/// Describes the place in which the robot stands. Pure: the same LPM gives the same description.
pub fn describe(lpm: &Lpm, parameters: &PerceptionParameters) -> Result<PlaceDescription, DescribeError> {
    if !lpm.robot_pose.is_finite() {
        return Err(DescribeError::Pose);
    }
    let grid = clean(&lpm.grid, &parameters.cleaning);
    let distance = DistanceField::new(&grid);
    let (graph, place) = settle(lpm, &grid, &distance, parameters)?;
    let comfort_distance = parameters.skeleton.comfort_distance;
    let fragments = pair(&place.gateways, &parameters.fragment);
    let projections: Vec<Option<Projection>> = fragments
        .iter()
        .map(|f| match f.partner {
            Some(_) => None,
            None => Some(project(&place.gateways[f.gateway], &grid, &distance, comfort_distance)),
        })
        .collect();
    let all = directed(&place.center, &place.gateways, &fragments, &projections);
    let entry = entry(&place.gateways, &lpm.robot_pose);
    let came_in = all.iter().position(|one| entry.is_some() && one.inward == entry);
    let start = came_in.or_else(|| toward(&all, lpm.robot_pose.theta)).ok_or(DescribeError::NoGateway)?;
    let listing = clockwise(all, start);
    let (slots, order) = number(&listing);
    let facing = toward(&listing, lpm.robot_pose.theta).ok_or(DescribeError::NoGateway)?;
    Ok(PlaceDescription {
        star: SmallScaleStar::new(slots)?,
        arrival: came_in.map(|_| SlotIndex(0)),
        facing: SlotIndex(facing as u8),
        gateways: order.iter().map(|&gateway| place.gateways[gateway].clone()).collect(),
        fragments: traces(&listing, &order, &projections),
        center: place.center,
        clearance: place.clearance,
        skeleton: polylines(&graph, &grid),
        grid,
    })
}

impl PlaceDescription {
    /// The outward slot whose bearing is nearest to a heading of the LPM frame, radians; the first of equals.
    pub fn outward_slot_toward(&self, heading: f64) -> Option<SlotIndex> {
        let away = |slot: &SlotIndex| {
            let slot = self.star.slot(*slot).filter(|slot| slot.outward.is_some())?;
            slot.bearing.map(|bearing| wrap_angle(bearing - heading).abs())
        };
        let outward = self.star.indices().filter_map(|slot| away(&slot).map(|angle| (angle, slot)));
        outward.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, slot)| slot)
    }
}

/// How far the middle of a place may move before the window around it is laid anew, metres, and how often it is.
const SETTLED: f64 = 0.25;
const ROUNDS: usize = 3;

/// The skeleton and the gateways in the window around the middle of the place, which is first looked for where it was
/// before, else around the robot: a robot at the edge of a place does not see the same window as one in its middle, but the same place.
fn settle(
    lpm: &Lpm,
    grid: &OccupancyGrid,
    distance: &DistanceField,
    parameters: &PerceptionParameters,
) -> Result<(SkeletonGraph, Neighborhood), DescribeError> {
    let robot = lpm.robot_pose.position();
    let look = |middle: Point| {
        let around = Surroundings { robot, middle, trail: &lpm.trail };
        let skeleton = skeletonize(grid, distance, &around, &parameters.skeleton)?;
        let mut graph = SkeletonGraph::new(&skeleton, distance);
        let place = find_gateways(&mut graph, distance, &middle, &parameters.skeleton, &parameters.gateway);
        place.map(|place| (graph, place)).ok_or(DescribeError::NoGateway)
    };
    let mut middle = lpm.middle.unwrap_or(robot);
    let mut seen = look(middle)?;
    for _ in 1..ROUNDS {
        if (seen.1.center - middle).norm() <= SETTLED {
            break;
        }
        middle = seen.1.center;
        seen = look(middle)?;
    }
    Ok(seen)
}

/// The gateway through which the robot came in: it faces away from it and stands near its axis, inside.
fn entry(gateways: &[Gateway], robot: &Pose) -> Option<usize> {
    let misfit = |gateway: &Gateway| {
        let turned = wrap_angle(robot.theta - gateway.bearing - PI).abs();
        let offset = robot.position() - gateway.center;
        let aside = gateway.outward().perp(&offset).abs() / gateway.width;
        (turned <= FRAC_PI_3).then_some(turned / FRAC_PI_3 + aside)
    };
    let fits = gateways.iter().enumerate().filter_map(|(i, gateway)| Some((misfit(gateway)?, i)));
    fits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, gateway)| gateway)
}

/// The outward directed fragment nearest to a heading.
fn toward(all: &[Directed], heading: f64) -> Option<usize> {
    let away = |one: &Directed| wrap_angle(one.bearing - heading).abs();
    let outward = all.iter().enumerate().filter(|(_, one)| one.outward.is_some());
    outward.min_by(|a, b| away(a.1).total_cmp(&away(b.1))).map(|(i, _)| i)
}

/// The fragments in the order of their numbers.
fn traces(listing: &[Directed], order: &[usize], projections: &[Option<Projection>]) -> Vec<FragmentTrace> {
    let id = |gateway: usize| order.iter().position(|&g| g == gateway).map(|i| GatewayId(i as u32 + 1));
    let mut seen: Vec<usize> = Vec::new();
    let mut traces = Vec::new();
    for one in listing {
        if seen.contains(&one.fragment) {
            continue;
        }
        seen.push(one.fragment);
        let ends = [one.outward, one.inward].map(|gateway| gateway.and_then(id));
        let (gateway, partner) = match ends {
            [Some(out), partner] => (out, partner),
            [None, Some(inward)] => (inward, None),
            [None, None] => continue,
        };
        let projection = projections[one.fragment].map(|projection| projection.end);
        traces.push(FragmentTrace { gateway, partner, projection });
    }
    traces
}

fn polylines(graph: &SkeletonGraph, grid: &OccupancyGrid) -> Vec<Vec<Point>> {
    let line = |cells: &[_]| cells.iter().map(|&cell| grid.info().center(cell)).collect();
    graph.graph.edge_weights().map(|edge| line(&edge.cells)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::star::ControlLaw;
    use crate::worlds::drawing::{Drawing, window};
    use std::f64::consts::FRAC_PI_2;

    fn tee(robot_pose: Pose) -> PlaceDescription {
        let plan =
            Drawing::new().corridor((-9.0, 0.0), (9.0, 0.0), 2.0).corridor((0.0, 0.0), (0.0, -9.0), 2.0);
        let grid = plan.render(&window(12.0, 0.1, Point::origin(), 0.0), &Point::origin()).unwrap();
        describe(&Lpm::new(grid, robot_pose), &PerceptionParameters::default()).unwrap()
    }

    /// On its way between two places the robot stands as near to the one as to the other.
    #[test]
    fn the_place_is_the_one_whose_middle_is_known() {
        let plan = Drawing::new()
            .corridor((-9.0, 0.0), (15.0, 0.0), 2.0)
            .corridor((0.0, 0.0), (0.0, -9.0), 2.0)
            .corridor((6.0, 0.0), (6.0, 9.0), 2.0);
        let grid = plan.render(&window(16.0, 0.1, Point::new(3.0, 0.0), 0.0), &Point::origin()).unwrap();
        for (middle, heading) in [(0.0, std::f64::consts::PI), (6.0, 0.0)] {
            for x in [1.2, 2.0, 3.0, 4.0, 4.8] {
                let middle = Point::new(middle, 0.0);
                let lpm = Lpm { middle: Some(middle), ..Lpm::new(grid.clone(), Pose::new(x, 0.1, heading)) };
                let place = describe(&lpm, &PerceptionParameters::default()).unwrap();
                assert!((place.center - middle).norm() < 0.5, "{x}: {}", place.center);
                assert_eq!((place.gateways.len(), place.arrival.is_some()), (3, true), "{x}");
            }
        }
    }

    #[test]
    fn the_listing_begins_where_the_robot_came_in() {
        let place = tee(Pose::new(0.0, -0.9, FRAC_PI_2));
        assert_eq!(place.arrival, Some(SlotIndex(0)));
        let slot = &place.star.slots()[0];
        assert_eq!(
            (slot.outward, slot.inward, slot.control),
            (None, Some(GatewayId(2)), ControlLaw::DeadEnd)
        );
        assert!((place.gateways[1].center.y + 1.0).abs() < 0.15);
    }

    #[test]
    fn a_robot_that_came_in_nowhere_lists_from_the_slot_it_faces() {
        let place = tee(Pose::new(0.0, 0.0, -FRAC_PI_2));
        assert_eq!((place.arrival, place.facing), (None, SlotIndex(0)));
        assert_eq!(place.star.slots()[0].outward, Some(GatewayId(1)));
        assert!((place.gateways[0].bearing + FRAC_PI_2).abs() < 0.1);
    }

    #[test]
    fn headings_choose_the_nearest_outward_slot() {
        let place = tee(Pose::new(0.0, -0.9, FRAC_PI_2));
        let toward = |heading: f64| place.outward_slot_toward(heading).and_then(|slot| place.star.slot(slot));
        assert!(toward(2.9).and_then(|slot| slot.bearing).is_some_and(|bearing| bearing.cos() < -0.9));
        assert!(toward(-1.2).and_then(|slot| slot.bearing).is_some_and(|bearing| bearing.sin() < -0.9));
    }
}
