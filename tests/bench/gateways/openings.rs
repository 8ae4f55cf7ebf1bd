//! Openings that are known to be there, and how many of them are found.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};
use topostar::gateway::Gateway;
use topostar::geometry::{Point, Pose, bearing, wrap_angle};
use topostar::grid::{CellIndex, DistanceField, OccupancyGrid};
use topostar::star::{PerceptionParameters, describe};

use crate::maps;

/// A gateway is at an opening if it lies within this distance of its middle and this angle of its normal.
const NEAR: f64 = 0.5;
const ALIKE: f64 = 0.61;
/// Up to this clear width a gateway is one of a door, metres; only those are counted for precision.
pub(super) const DOOR: f64 = 1.4;

/// An opening in a wall with its two jambs, and where a robot may stand before it.
pub(super) struct Opening {
    pub(super) jambs: [Point; 2],
    pub(super) poses: Vec<Pose>,
}

impl Opening {
    pub(super) fn middle(&self) -> Point {
        nalgebra::center(&self.jambs[0], &self.jambs[1])
    }

    pub(super) fn width(&self) -> f64 {
        (self.jambs[0] - self.jambs[1]).norm()
    }

    /// Direction through the opening, either way.
    fn normal(&self) -> f64 {
        bearing(&(self.jambs[1] - self.jambs[0])) + FRAC_PI_2
    }

    /// Distance of a gateway from the middle and angle of its normal, if it lies at this opening.
    fn misfit(&self, gateway: &Gateway) -> Option<(f64, f64)> {
        let away = (nalgebra::center(&gateway.ends[0], &gateway.ends[1]) - self.middle()).norm();
        let turned = wrap_angle(gateway.bearing - self.normal()).abs();
        let turned = turned.min(PI - turned);
        (away <= NEAR && turned <= ALIKE).then_some((away, turned))
    }
}

/// The openings that the map shows open, and how many it does not: a robot 0.7 m wide gets through from one pose to the
/// other without leaving the surroundings of the opening.
pub(super) fn open_ones(map: &OccupancyGrid, openings: Vec<Opening>) -> (Vec<Opening>, usize) {
    let distance = DistanceField::new(map);
    let count = openings.len();
    let open: Vec<Opening> = openings.into_iter().filter(|opening| passable(&distance, opening)).collect();
    let closed = count - open.len();
    (open, closed)
}

fn passable(distance: &DistanceField, opening: &Opening) -> bool {
    let info = distance.info();
    let [Some(start), Some(goal)] = [0, 1].map(|k| info.cell_at(&opening.poses.get(k)?.position())) else {
        return false;
    };
    let fits =
        |at: CellIndex| distance.clearance(at) >= 0.35 && (info.center(at) - opening.middle()).norm() <= 2.0;
    let mut seen = BTreeSet::from([start]);
    let mut stack = vec![start];
    while let Some(at) = stack.pop() {
        stack.extend(info.neighbors(at, false).filter(|&next| fits(next) && seen.insert(next)));
    }
    seen.contains(&goal)
}

/// What came out for a number of openings.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) openings: usize,
    /// Openings found from one side at least.
    pub(super) found: usize,
    pub(super) poses: usize,
    /// Poses from which the opening before the robot was found.
    pub(super) hits: usize,
    /// Poses at which no star came out.
    pub(super) failed: usize,
    /// Gateways as wide as a door, and those of them that lie at an opening.
    pub(super) doors: usize,
    pub(super) true_doors: usize,
    distances: Vec<f64>,
    angles: Vec<f64>,
    pub(super) missed: Vec<String>,
}

impl Tally {
    /// Looks at every opening from all its poses.
    pub(super) fn look(
        &mut self,
        map: &OccupancyGrid,
        openings: &[Opening],
        parameters: &PerceptionParameters,
    ) {
        for opening in openings {
            let before = self.hits;
            opening.poses.iter().for_each(|pose| self.look_from(map, openings, opening, pose, parameters));
            self.openings += 1;
            self.found += usize::from(self.hits > before);
        }
    }

    /// With all that came out elsewhere.
    pub(super) fn add(&mut self, other: Tally) {
        for (sum, one) in [
            (&mut self.openings, other.openings),
            (&mut self.found, other.found),
            (&mut self.poses, other.poses),
            (&mut self.hits, other.hits),
            (&mut self.failed, other.failed),
            (&mut self.doors, other.doors),
            (&mut self.true_doors, other.true_doors),
        ] {
            *sum += one;
        }
        self.distances.extend(other.distances);
        self.angles.extend(other.angles);
    }

    fn look_from(
        &mut self,
        map: &OccupancyGrid,
        openings: &[Opening],
        sought: &Opening,
        pose: &Pose,
        parameters: &PerceptionParameters,
    ) {
        self.poses += 1;
        let Ok(place) = describe(&maps::lpm(map, pose), parameters) else {
            self.failed += 1;
            self.missed.push(format!("no star at {:.2},{:.2},{:.2}", pose.x, pose.y, pose.theta));
            return;
        };
        maps::draw(&place, pose, &format!("{:.2},{:.2},{:.2}", pose.x, pose.y, pose.theta));
        match place
            .gateways
            .iter()
            .filter_map(|gateway| sought.misfit(gateway))
            .min_by(|a, b| a.0.total_cmp(&b.0))
        {
            Some((away, turned)) => {
                self.hits += 1;
                self.distances.push(away);
                self.angles.push(turned.to_degrees());
            }
            None => self.missed.push(format!("missed at {:.2},{:.2},{:.2}", pose.x, pose.y, pose.theta)),
        }
        for gateway in place.gateways.iter().filter(|gateway| gateway.width <= DOOR) {
            self.doors += 1;
            self.true_doors += usize::from(openings.iter().any(|opening| opening.misfit(gateway).is_some()));
        }
    }

    pub(super) fn line(&mut self) -> String {
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        let [distance, angle] = [&mut self.distances, &mut self.angles].map(|values| {
            values.sort_by(f64::total_cmp);
            let at =
                |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN);
            [at(0.5), at(0.9)]
        });
        format!(
            "{:3} of {:3} found ({:5.1} %), {:3} of {:3} poses ({:5.1} %), {:2} without star; of {:3} gateways of \
             door width {:3} true ({:5.1} %); distance {:.2} m, tenth {:.2}; angle {:.1} deg, tenth {:.1}",
            self.found,
            self.openings,
            share(self.found, self.openings),
            self.hits,
            self.poses,
            share(self.hits, self.poses),
            self.failed,
            self.doors,
            self.true_doors,
            share(self.true_doors, self.doors),
            distance[0],
            distance[1],
            angle[0],
            angle[1],
        )
    }
}
