//! Where to draw the places of a topological map: a schematic layout without metres.
//!
//! The slots of a star are spread evenly around the place. Travelled segments are springs that want to leave each
//! end in its slot's direction and to be one unit long; the first place stands at the origin. On corridor grids
//! the layout is the grid. It is a picture, not a measurement: frames and metres belong to the patchwork.

use crate::export::{GraphGateway, MapGraph};
use crate::geometry::{Point, Vector, bearing, direction, wrap_angle};
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

/// A travelled segment as seen from one end: that end, and the far one.
type Spring = (GraphGateway, GraphGateway);

impl Layout {
    /// The layout of a map. Linear in its segments for each of a fixed number of rounds.
    pub fn of(map: &MapGraph) -> Layout {
        let sizes: Vec<usize> = map.places.iter().map(|place| place.size).collect();
        let positions = vec![Point::origin(); sizes.len()];
        let mut layout = Layout { headings: vec![FRAC_PI_2; sizes.len()], positions, sizes };
        let springs = springs(map);
        layout.spread(&springs);
        for _ in 0..ROUNDS {
            layout.relax(&springs);
        }
        layout
    }

    /// Where a place is drawn, y upward, one unit a segment.
    pub fn position(&self, place: usize) -> Point {
        self.positions[place]
    }

    /// The direction in which a slot faces.
    pub fn facing(&self, at: GraphGateway) -> f64 {
        self.headings[at.place] - TAU * f64::from(at.slot) / self.sizes[at.place] as f64
    }

    /// Each place beside the one it was first reached from.
    fn spread(&mut self, springs: &[Vec<Spring>]) {
        let mut placed = vec![false; self.sizes.len()];
        let mut queue: VecDeque<usize> = (0..self.sizes.len()).take(1).collect();
        placed.iter_mut().take(1).for_each(|first| *first = true);
        while let Some(place) = queue.pop_front() {
            for &(here, far) in &springs[place] {
                if !std::mem::replace(&mut placed[far.place], true) {
                    self.headings[far.place] += wrap_angle(self.facing(here) + PI - self.facing(far));
                    self.positions[far.place] = self.positions[place] + direction(self.facing(here));
                    queue.push_back(far.place);
                }
            }
        }
    }

    fn relax(&mut self, springs: &[Vec<Spring>]) {
        for (place, ends) in springs.iter().enumerate().skip(1).filter(|(_, ends)| !ends.is_empty()) {
            let count = ends.len() as f64;
            let wishes: Vector = ends.iter().map(|&(here, far)| self.wish(here, far)).sum();
            self.positions[place] = Point::from(wishes / count);
            let lean: f64 = ends.iter().map(|&(here, far)| self.lean(here, far)).sum();
            self.headings[place] += 0.5 * lean / count;
        }
    }

    /// Where a segment would have the place of its near end.
    fn wish(&self, here: GraphGateway, far: GraphGateway) -> Vector {
        let along = direction(self.facing(far)) - direction(self.facing(here));
        let along = along.try_normalize(1e-6).unwrap_or_else(|| direction(self.facing(far)));
        self.positions[far.place].coords + along
    }

    /// By how much a segment would have the place of its near end turned.
    fn lean(&self, here: GraphGateway, far: GraphGateway) -> f64 {
        let seen = self.positions[far.place] - self.positions[here.place];
        let straight = wrap_angle(bearing(&seen) - self.facing(here));
        let opposed = wrap_angle(self.facing(far) + PI - self.facing(here));
        if seen.norm() < 1e-6 { opposed } else { (straight + opposed) / 2.0 }
    }
}

/// The travelled segments at each place.
fn springs(map: &MapGraph) -> Vec<Vec<Spring>> {
    let mut springs = vec![Vec::new(); map.places.len()];
    for segment in &map.segments {
        let [a, b] = segment.ends;
        springs[a.place].push((a, b));
        springs[b.place].push((b, a));
    }
    springs
}
