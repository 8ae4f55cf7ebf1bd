//! What two visits to one place say of where they lie to each other: their LPMs are laid onto each other.

use crate::geometry::{Point, Pose, wrap_angle};
use crate::lpm::Lpm;
use crate::patchwork::alignment::{Alignment, Around};
use crate::patchwork::submap::Submap;
use crate::sensor::surface::Surface;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// What one visit shows, in a frame with the axes of the observation and its origin at the point of the place.
#[derive(Clone, Debug)]
pub struct Neighbourhood {
    /// The walls around; none where the trace has stars alone.
    pub walls: Submap,
    /// Outward bearings of the slots of the star, radians.
    pub bearings: Vec<Option<f64>>,
}

/// How two visits to one place lie to each other, and what their walls say of its being one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// The frame of the later visit in that of the earlier one.
    pub alignment: Alignment,
    /// Whether that is by their walls.
    pub walls: Walls,
}

/// What the walls of two visits say of their being to one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walls {
    /// They lie on each other.
    Alike,
    /// They do not, wherever they are laid: this is hardly one place, unless it was rearranged.
    Differ,
    /// There are none on one of the visits.
    Untold,
}

/// How far the points of a place, as found on two visits, are apart at most, metres; and how far bearings may mislead,
/// radians.
const REACH: f64 = 1.5;
const TURN: f64 = 0.3;

impl Neighbourhood {
    /// What an LPM shows of the place at a point of it; `None` where `interrupted` said to stop.
    pub fn new(
        lpm: &Lpm,
        point: &Point,
        bearings: Vec<Option<f64>>,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let moved = |wall: &Surface| Surface { at: wall.at - point.coords, ..*wall };
        let walls = Submap::of_grid(&lpm.grid, interrupted)?;
        Some(Neighbourhood { walls: Submap::new(walls.surfaces().iter().map(moved)), bearings })
    }

    /// What a bare star shows.
    pub fn of_star(bearings: Vec<Option<f64>>) -> Self {
        Neighbourhood { walls: Submap::default(), bearings }
    }

    /// How a later visit lies to this one, both to one place, when slot `k` of the later star is slot `k + rotation` of
    /// this one. Where walls do not tell, the points of the place and the bearings do, with these standard deviations on
    /// one visit, metres and radians. `None` where nothing does, or `interrupted` said to stop.
    pub fn agreement(
        &self,
        later: &Neighbourhood,
        rotation: usize,
        sigmas: [f64; 2],
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Agreement> {
        let known = self.turn(later, rotation);
        // Where no bearings tell, every direction may be.
        let (about, turn) = known.map_or((0.0, PI), |about| (about, TURN));
        let pose = Pose::new(0.0, 0.0, about);
        let around = Around { pose, reach: REACH, turn };
        match around.align(&later.walls, &self.walls, interrupted) {
            Some(alignment) => Some(Agreement { alignment, walls: Walls::Alike }),
            None => known.map(|_| Agreement { alignment: points(pose, sigmas), walls: self.unlike(later) }),
        }
    }

    /// What walls say that cannot be laid onto each other.
    fn unlike(&self, later: &Neighbourhood) -> Walls {
        match [self, later].iter().any(|visit| visit.walls.surfaces().is_empty()) {
            true => Walls::Untold,
            false => Walls::Differ,
        }
    }

    /// How far the bearings of a later visit are to be turned, on average, to lie on those of this one.
    fn turn(&self, later: &Neighbourhood, rotation: usize) -> Option<f64> {
        let size = self.bearings.len().max(1);
        let mut turns = later.bearings.iter().enumerate().filter_map(|(slot, bearing)| {
            let known = (*self.bearings.get((slot + rotation) % size)?)?;
            Some(wrap_angle(known - (*bearing)?))
        });
        let about = turns.next()?;
        let (sum, count) =
            turns.fold((0.0, 1.0), |(sum, count), turn| (sum + wrap_angle(turn - about), count + 1.0));
        Some(wrap_angle(about + sum / count))
    }
}

/// What is left where walls do not tell: the point of the place and the bearings, each found twice.
fn points(pose: Pose, [extent, bearing]: [f64; 2]) -> Alignment {
    let variances = Vector3::new(extent * extent, extent * extent, bearing * bearing) * 2.0;
    Alignment {
        pose,
        information: Matrix3::from_diagonal(&variances.map(f64::recip)),
        share: 0.0,
        stray: 0.0,
    }
}
