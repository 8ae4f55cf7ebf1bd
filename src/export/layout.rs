//! Where to draw the places of a topological map: a schematic layout without metres.
//!
//! The slots of a star are spread evenly around the place. Travelled segments are springs that want to leave each
//! end in its slot's direction and to be one unit long; the first place stands at the origin. On corridor grids
//! the layout is the grid. It is a picture, not a measurement: frames and metres belong to the patchwork.

use crate::geometry::{Point, Vector, bearing, direction, wrap_angle};
use crate::map::{DstateId, PlaceId, TopologicalMap};
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rounds of relaxation; errors fall below a pixel long before for maps that can be read as a picture.
const ROUNDS: usize = 400;

/// Position and orientation of each place, by number.
#[derive(Clone, Debug)]
pub struct Layout {
    positions: Vec<Point>,
    /// Direction of slot 0 of each place.
    headings: Vec<f64>,
    sizes: Vec<usize>,
}

impl Layout {
    /// The layout of a map. Linear in its segments for each of a fixed number of rounds.
    pub fn of(map: &TopologicalMap) -> Layout {
        let sizes: Vec<usize> = map.places().map(|place| map.star(place).size()).collect();
        let positions = vec![Point::origin(); sizes.len()];
        let mut layout = Layout { headings: vec![FRAC_PI_2; sizes.len()], positions, sizes };
        layout.spread(map);
        let springs = springs(map);
        for _ in 0..ROUNDS {
            layout.relax(&springs);
        }
        layout
    }

    /// Where a place is drawn, y upward, one unit a segment.
    pub fn position(&self, place: PlaceId) -> Point {
        self.positions[place.index()]
    }

    /// The direction in which a slot faces.
    pub fn facing(&self, dstate: DstateId) -> f64 {
        let place = dstate.place.index();
        self.headings[place] - TAU * f64::from(dstate.slot.0) / self.sizes[place] as f64
    }

    /// Each place beside the one it was first reached from.
    fn spread(&mut self, map: &TopologicalMap) {
        let mut seen = vec![false; self.sizes.len()];
        let mut queue: VecDeque<PlaceId> = map.places().take(1).collect();
        seen.iter_mut().take(1).for_each(|first| *first = true);
        while let Some(place) = queue.pop_front() {
            for dstate in map.dstates_at(place) {
                let Some(far) = map.far_end(dstate) else { continue };
                let q = far.place.index();
                if !std::mem::replace(&mut seen[q], true) {
                    self.headings[q] += wrap_angle(self.facing(dstate) + PI - self.facing(far));
                    self.positions[q] = self.positions[place.index()] + direction(self.facing(dstate));
                    queue.push_back(far.place);
                }
            }
        }
    }

    fn relax(&mut self, springs: &[Vec<(DstateId, DstateId)>]) {
        for (place, ends) in springs.iter().enumerate().skip(1).filter(|(_, ends)| !ends.is_empty()) {
            let wish = |(here, far): &(DstateId, DstateId)| {
                let along = direction(self.facing(*far)) - direction(self.facing(*here));
                let along = along.try_normalize(1e-6).unwrap_or_else(|| direction(self.facing(*far)));
                self.positions[far.place.index()].coords + along
            };
            let count = ends.len() as f64;
            self.positions[place] = Point::from(ends.iter().map(wish).sum::<Vector>() / count);
            let lean = |(here, far): &(DstateId, DstateId)| {
                let seen = self.positions[far.place.index()] - self.positions[place];
                let straight = wrap_angle(bearing(&seen) - self.facing(*here));
                let opposed = wrap_angle(self.facing(*far) + PI - self.facing(*here));
                if seen.norm() < 1e-6 { opposed } else { (straight + opposed) / 2.0 }
            };
            self.headings[place] += 0.5 * ends.iter().map(lean).sum::<f64>() / count;
        }
    }
}

/// The segments at each place, its own end first.
fn springs(map: &TopologicalMap) -> Vec<Vec<(DstateId, DstateId)>> {
    let at = |place| map.dstates_at(place).filter_map(|here| Some((here, map.far_end(here)?))).collect();
    map.places().map(at).collect()
}
