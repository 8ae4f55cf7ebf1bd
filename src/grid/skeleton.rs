//! The Voronoi skeleton of the free space around the robot, reduced to the ways out of the window.
//!
//! It is an extended Voronoi graph: where an expanse wider than the comfort distance leaves the window, the
//! skeleton keeps to the coast of that expanse, the locus at the comfort distance from its wall. An expanse that
//! lies wholly in the window is crossed like any room: it is part of a place. Nothing has to be pruned, since
//! thinning keeps only what joins the exits.

use crate::geometry::Point;
use crate::grid::passable::Core;
use crate::grid::patches::Patches;
use crate::grid::rooms::rooms;
use crate::grid::thinning::thin;
use crate::grid::window::Window;
use crate::grid::{Cell, CellIndex, DistanceField, GridInfo, OccupancyGrid};
use std::collections::VecDeque;
use thiserror::Error;

/// Physical limits of the robot that shape the skeleton, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonParameters {
    /// The farthest a wall may be for the robot to follow it (the D of the extended Voronoi graph). Default 2.5.
    pub comfort_distance: f64,
    /// The narrowest way that counts as one: between an office door (0.9) and a corridor. Default 1.1.
    pub passage_width: f64,
    /// Radius of the neighbourhood of a place: ways lead out where they leave this window around its middle. The
    /// window also ends with the grid. Default 7.
    pub scope: f64,
    /// Width of the robot: where it has driven there is a way, however narrow. Default 0.6.
    pub robot_width: f64,
    /// For a robot that goes into rooms: a space that ends inside the window is a room, and a way into it a way out,
    /// if it is at least so many times as wide as that way; [`SkeletonParameters::for_doors`] has 1.5. Default none:
    /// the robot keeps to corridors, and what ends inside the window is no way.
    pub room_ratio: Option<f64>,
}

/// What a skeleton is looked for around, points of the grid's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings<'a> {
    /// Where the robot is.
    pub robot: Point,
    /// The middle of the window.
    pub middle: Point,
    /// The way the robot came.
    pub trail: &'a [Point],
}

impl Surroundings<'_> {
    /// Of a robot in the middle of its window that does not know how it came there.
    pub fn of(robot: Point) -> Self {
        Surroundings { robot, middle: robot, trail: &[] }
    }
}

impl Default for SkeletonParameters {
    fn default() -> Self {
        SkeletonParameters {
            comfort_distance: 2.5,
            passage_width: 1.1,
            scope: 7.0,
            robot_width: 0.6,
            room_ratio: None,
        }
    }
}

impl SkeletonParameters {
    /// For a robot that goes through office doors and into rooms, wherever it fits: a passage is as wide as the robot
    /// and a cell of 5 cm.
    pub fn for_doors() -> Self {
        SkeletonParameters { passage_width: 0.65, room_ratio: Some(1.5), ..SkeletonParameters::default() }
    }
}

/// The cells of the skeleton and where it ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    /// The cells in row-major order.
    pub cells: Vec<CellIndex>,
    /// Where ways leave the window, one cell each; part of `cells`.
    pub exits: Vec<CellIndex>,
    /// The widest cells of rooms that end inside the window; part of `cells`.
    pub rooms: Vec<CellIndex>,
    /// Where the only way ends, if there is only one; part of `cells`.
    pub dead_end: Option<CellIndex>,
}

/// Why there is no skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SkeletonError {
    /// The robot's position is not in the grid.
    #[error("the robot is outside the grid, expected its position on a cell")]
    OutsideGrid,
    /// No free space that the robot fits into can be reached from where it stands.
    #[error("no free space as wide as the passage width can be reached from the robot's position")]
    NoFreeSpace,
    /// Everything in the window is farther than the comfort distance from any obstacle.
    #[error("no obstacle within the comfort distance of any free space in the window")]
    NothingToFollow,
    /// Free space does not lead out of the window.
    #[error("no way as wide as the passage width leads out of the window")]
    NoWayOut,
}

/// The skeleton of the free space in the window that the robot can reach.
pub fn skeletonize(
    grid: &OccupancyGrid,
    distance: &DistanceField,
    around: &Surroundings,
    parameters: &SkeletonParameters,
) -> Result<Skeleton, SkeletonError> {
    let info = grid.info();
    let start = info.cell_at(&around.robot).ok_or(SkeletonError::OutsideGrid)?;
    let center = info.cell_at(&around.middle).unwrap_or(start);
    // A core cell that near to the end of the window has no obstacle before it: the clearance is greater.
    let window = Window::new(info, center, parameters.scope, parameters.passage_width / 2.0);
    let mut core = Core::new(distance, &window, parameters);
    core.add_trail(around.trail, parameters.robot_width / 2.0);
    let roomy = !core.inside.is_empty();
    core.remove_open_expanses(parameters.comfort_distance);
    if roomy && core.inside.is_empty() {
        return Err(SkeletonError::NothingToFollow);
    }
    let gate = nearest_core_cell(grid, start, &core, parameters).ok_or(SkeletonError::NoFreeSpace)?;
    let members = Patches::new(&core.inside, true).around(gate);
    let exits = core.exits(&members);
    let rooms_at =
        |ratio| rooms(&window.cut, &members, &core.squared, |i| window.on_rim(window.cell(i)), ratio);
    let rooms = parameters.room_ratio.map(rooms_at).unwrap_or_default();
    let dead_end = match (&exits[..], &rooms[..]) {
        ([], [] | [_]) => return Err(SkeletonError::NoWayOut),
        (&[exit], []) => dead_end(exit, &core).filter(|&end| end != exit),
        _ => None,
    };
    let mut anchors = exits.clone();
    anchors.extend(&rooms);
    anchors.extend(dead_end);
    let cells = thin(window.cut.width, &members, &core.squared, &anchors);
    let cell = |&i: &usize| window.cell(i);
    Ok(Skeleton {
        cells: cells.iter().map(cell).collect(),
        exits: exits.iter().map(cell).collect(),
        rooms: rooms.iter().map(cell).collect(),
        dead_end: dead_end.map(|i| window.cell(i)),
    })
}

/// Cells connected to `start` in the order of their distance from it in steps.
fn flood(info: &GridInfo, start: usize, diagonal: bool, inside: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut seen = vec![false; info.width * info.height];
    seen[start] = true;
    let mut cells = vec![start];
    let mut next = 0;
    while next < cells.len() {
        for neighbor in info.neighbors(info.index(cells[next]), diagonal) {
            let i = info.offset(neighbor);
            if !seen[i] && inside(i) {
                seen[i] = true;
                cells.push(i);
            }
        }
        next += 1;
    }
    cells
}

/// The core cell nearest to the robot on a way through free cells. A robot whose own cell is not free may first
/// step out of the obstacle, no further than the passage width.
fn nearest_core_cell(
    grid: &OccupancyGrid,
    start: CellIndex,
    core: &Core,
    parameters: &SkeletonParameters,
) -> Option<usize> {
    let info = grid.info();
    if let Some(i) = core.window.place(start).filter(|&i| core.inside.contains(i)) {
        return Some(i);
    }
    let stuck = grid.cell(start) != Cell::Free;
    let step_out = Window::new(info, start, parameters.passage_width, 0.0);
    let passable = |at: CellIndex| grid.cell(at) == Cell::Free || (stuck && step_out.contains(at));
    let mut seen = vec![false; info.width * info.height];
    let mut queue = VecDeque::from([start]);
    seen[info.offset(start)] = true;
    while let Some(at) = queue.pop_front() {
        if let Some(i) = core.window.place(at).filter(|&i| core.inside.contains(i)) {
            return Some(i);
        }
        for next in info.neighbors(at, false) {
            if passable(next) && !std::mem::replace(&mut seen[info.offset(next)], true) {
                queue.push_back(next);
            }
        }
    }
    None
}

/// The end of the way that begins at the only exit: the ridge above the farthest cell.
fn dead_end(exit: usize, core: &Core) -> Option<usize> {
    let cut = &core.window.cut;
    let mut end = *flood(cut, exit, true, |i| core.inside.contains(i)).last()?;
    loop {
        let around = cut.neighbors(cut.index(end), true).map(|at| cut.offset(at));
        let inside = around.filter(|&i| core.inside.contains(i));
        let steepest = inside.max_by(|&a, &b| core.squared[a].cmp(&core.squared[b]).then(b.cmp(&a)));
        match steepest {
            Some(next) if core.squared[next] > core.squared[end] => end = next,
            _ => return Some(end),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::drawing::{Drawing, window};

    fn skeleton(plan: &Drawing, robot: (f64, f64)) -> Result<(Skeleton, DistanceField), SkeletonError> {
        let robot = Point::new(robot.0, robot.1);
        let grid = plan.render(&window(18.0, 0.1, Point::origin(), 0.0), &robot).unwrap();
        let distance = DistanceField::new(&grid);
        let skeleton =
            skeletonize(&grid, &distance, &Surroundings::of(robot), &SkeletonParameters::default())?;
        Ok((skeleton, distance))
    }

    #[test]
    fn a_wide_hall_that_leaves_the_window_has_a_coast() {
        let hall = Drawing::new().room((-20.0, -4.0), (20.0, 4.0));
        let (skeleton, distance) = skeleton(&hall, (0.0, -2.0)).unwrap();
        assert_eq!(skeleton.exits.len(), 2);
        let clearance = skeleton.cells.iter().map(|&cell| distance.clearance(cell));
        assert!(clearance.clone().all(|c| (2.3..=2.5).contains(&c)), "{:?}", clearance.collect::<Vec<_>>());
        assert!(skeleton.cells.iter().all(|&cell| distance.info().center(cell).y < 0.0));
    }

    #[test]
    fn a_wide_room_in_the_window_is_crossed() {
        let room = Drawing::new().room((-5.0, -5.0), (5.0, 5.0)).corridor((-20.0, 0.0), (20.0, 0.0), 2.0);
        let (skeleton, distance) = skeleton(&room, (0.0, 0.0)).unwrap();
        assert!(skeleton.cells.iter().any(|&cell| distance.clearance(cell) > 4.5));
    }

    #[test]
    fn a_door_is_no_way_out_and_a_corridor_is() {
        let with = |width: f64| {
            let room = Drawing::new().room((-2.0, -2.0), (2.0, 2.0)).corridor((1.0, 0.0), (20.0, 0.0), width);
            skeleton(&room, (0.0, 0.0)).map(|(skeleton, _)| skeleton.exits.len())
        };
        assert_eq!(with(0.9), Err(SkeletonError::NoWayOut));
        assert_eq!(with(1.3), Ok(1));
    }

    #[test]
    fn a_robot_may_stand_a_little_inside_a_wall_but_not_deep() {
        let plan = Drawing::new().corridor((-20.0, 0.0), (20.0, 0.0), 2.0);
        let grid = plan.render(&window(18.0, 0.1, Point::origin(), 0.0), &Point::origin()).unwrap();
        let distance = DistanceField::new(&grid);
        let from = |y: f64| {
            let robot = Point::new(0.0, y);
            skeletonize(
                &grid,
                &distance,
                &Surroundings { middle: Point::origin(), ..Surroundings::of(robot) },
                &SkeletonParameters::default(),
            )
        };
        assert_eq!(from(1.4), from(0.0));
        assert_eq!(from(3.0), Err(SkeletonError::NoFreeSpace));
    }
}
