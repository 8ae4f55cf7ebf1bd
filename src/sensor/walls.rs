//! The walls around the robot, remembered while they are near.

use crate::geometry::{Point, Vector};
use crate::sensor::surface::Surface;

/// Normals that differ by more than 45 degrees are of different walls, or of the two sides of one: the cosine.
const SAME_WALL: f64 = 0.7;
/// So many sightings make a wall as sure as it gets, so that it can still be corrected.
const SURE: f64 = 20.0;

/// A piece of wall: the mean of what was seen of it in one square of the plane.
#[derive(Clone, Copy, Debug)]
struct Element {
    sightings: f64,
    surface: Surface,
    /// How far the robot had driven when it was last seen, metres.
    driven: f64,
}

/// A window of squares that moves with the robot. A square that leaves on one side gives its memory to one that comes
/// in on the other, so that memory is bounded and nothing far away or long ago is remembered.
#[derive(Clone, Debug)]
pub(super) struct Walls {
    side: f64,
    squares: i32,
    /// Whose memory each place of the window is; apart from the elements, as most places looked up hold none.
    squares_in: Vec<Option<[i32; 2]>>,
    elements: Vec<Option<Element>>,
    memory: f64,
    driven: f64,
}

impl Walls {
    /// No walls yet, in a window of so many metres of squares with this side; what was seen so many metres of driving ago
    /// is forgotten.
    pub(super) fn new(window: f64, side: f64, memory: f64) -> Self {
        let squares = (window / side).ceil().clamp(1.0, 4096.0) as i32;
        let places = (squares * squares) as usize;
        Walls {
            side,
            squares,
            squares_in: vec![None; places],
            elements: vec![None; places],
            memory,
            driven: 0.0,
        }
    }

    /// The robot has driven on by so many metres.
    pub(super) fn drive(&mut self, length: f64) {
        self.driven += length;
    }

    /// Remembers a surface given in the frame of the window.
    pub(super) fn add(&mut self, seen: Surface) {
        let Some(square) = self.square(&seen.at) else { return };
        let (slot, driven) = (self.slot(square), self.driven);
        let known = self.element(square).is_some();
        match &mut self.elements[slot] {
            Some(element) if known => {
                element.add(&seen);
                element.driven = driven;
            }
            other => {
                *other = Some(Element { sightings: 1.0, surface: seen, driven });
                self.squares_in[slot] = Some(square);
            }
        }
    }

    /// The wall nearest to a surface, within reach, that faces the same way: of those in the ring of squares around it that is
    /// the first to hold one, and in the next. One in the corner of a ring may be further away, by the root of two, than one
    /// beyond the next ring that is not looked at.
    pub(super) fn nearest(&self, to: &Surface, reach: f64) -> Option<Surface> {
        let here = self.square(&to.at)?;
        let middle = here.map(|v| v.rem_euclid(self.squares));
        let mut last = (reach / self.side).ceil() as i32;
        let mut best: Option<(f64, Surface)> = None;
        let mut ring = 0;
        while ring <= last {
            for offset in ring_around(ring) {
                if best.is_some_and(|(nearest, _)| self.gap(&to.at, here, offset) > nearest) {
                    continue;
                }
                let Some(Element { surface, .. }) = self.element_beside(here, middle, offset) else {
                    continue;
                };
                let away = (surface.at - to.at).norm();
                let same = away < reach && surface.normal.dot(&to.normal) > SAME_WALL;
                if same && best.is_none_or(|(nearest, _)| away < nearest) {
                    best = Some((away, *surface));
                    last = last.min(ring + 1);
                }
            }
            ring += 1;
        }
        best.map(|(_, surface)| surface)
    }

    fn element(&self, square: [i32; 2]) -> Option<&Element> {
        self.element_in(self.slot(square), square)
    }

    fn element_in(&self, slot: usize, square: [i32; 2]) -> Option<&Element> {
        if self.squares_in[slot] != Some(square) {
            return None;
        }
        self.elements[slot].as_ref().filter(|element| self.driven - element.driven <= self.memory)
    }

    /// A bound below which no point of the square so many columns and rows beside that of a point comes to it. What is
    /// known of a square lies in it, but for rounding.
    fn gap(&self, at: &Point, here: [i32; 2], offset: [i32; 2]) -> f64 {
        let along = |at: f64, here: i32, offset: i32| {
            let border = f64::from(here + i32::from(offset < 0) + offset) * self.side;
            if offset == 0 { 0.0 } else { (at - border).abs() }
        };
        let (x, y) = (along(at.x, here[0], offset[0]), along(at.y, here[1], offset[1]));
        x.max(y) - 1e-6
    }

    /// The element of the square so many columns and rows beside one, of which the place in the window is known.
    fn element_beside(&self, here: [i32; 2], middle: [i32; 2], away: [i32; 2]) -> Option<&Element> {
        let wrapped = |k: usize| {
            let at = middle[k] + away[k];
            // Mostly no more than one window away.
            if (0..self.squares).contains(&at) { at } else { at.rem_euclid(self.squares) }
        };
        let slot = (wrapped(1) * self.squares + wrapped(0)) as usize;
        self.element_in(slot, [here[0] + away[0], here[1] + away[1]])
    }

    /// The square of a point, if it is one that can be counted.
    fn square(&self, at: &Point) -> Option<[i32; 2]> {
        let square = [at.x, at.y].map(|v| (v / self.side).floor());
        square.iter().all(|v| v.abs() < 1e9).then(|| square.map(|v| v as i32))
    }

    fn slot(&self, square: [i32; 2]) -> usize {
        let [x, y] = square.map(|v| v.rem_euclid(self.squares));
        (y * self.squares + x) as usize
    }
}

impl Element {
    fn add(&mut self, seen: &Surface) {
        let known = &mut self.surface;
        if known.normal.dot(&seen.normal) <= 0.0 {
            // The other side of a thin wall, or something new: what is seen more often stays.
            self.sightings -= 1.0;
            if self.sightings <= 0.0 {
                *self = Element { sightings: 1.0, surface: *seen, ..*self };
            }
            return;
        }
        self.sightings = (self.sightings + 1.0).min(SURE);
        known.at += (seen.at - known.at) / self.sightings;
        let normal: Vector = known.normal + (seen.normal - known.normal) / self.sightings;
        // Both face one half of the plane, so that their mean is not nothing.
        known.normal = normal.try_normalize(0.0).unwrap_or(known.normal);
    }
}

/// The offsets of the squares at a distance of `ring` from one, in the maximum norm.
fn ring_around(ring: i32) -> impl Iterator<Item = [i32; 2]> {
    (-ring..=ring).flat_map(move |dy| {
        let step = if dy.abs() == ring { 1 } else { 2 * ring as usize };
        (-ring..=ring).step_by(step.max(1)).map(move |dx| [dx, dy])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::direction;
    use proptest::prelude::*;
    use proptest::test_runner::TestRunner;
    use std::cell::Cell;
    use std::collections::BTreeMap;

    /// What was seen in each square, and when: no window, no memory shared.
    struct Slow {
        squares: i64,
        memory: f64,
        driven: f64,
        seen: BTreeMap<[i64; 2], Element>,
    }

    const SIDE: f64 = 0.1;

    fn square(at: &Point) -> [i64; 2] {
        [at.x, at.y].map(|v| (v / SIDE).floor() as i64)
    }

    impl Slow {
        fn add(&mut self, surface: Surface) {
            let square = square(&surface.at);
            let (now, squares, memory) = (self.driven, self.squares, self.memory);
            self.seen.retain(|other, element| {
                let apart = |k: usize| (other[k] - square[k]) % squares == 0;
                let pushed_out = *other != square && apart(0) && apart(1);
                !pushed_out && now - element.driven <= memory
            });
            let new = Element { sightings: 1.0, surface, driven: now };
            match self.seen.get_mut(&square) {
                Some(known) => {
                    known.add(&surface);
                    known.driven = now;
                }
                None => drop(self.seen.insert(square, new)),
            }
        }

        fn nearest(&self, to: &Surface, reach: f64) -> Option<Surface> {
            let here = square(&to.at);
            let ring = |square: &[i64; 2]| (square[0] - here[0]).abs().max((square[1] - here[1]).abs());
            let known = self.seen.iter().filter(|(_, element)| self.driven - element.driven <= self.memory);
            let same = known
                .map(|(square, element)| (square, element.surface))
                .filter(|(_, one)| one.normal.dot(&to.normal) > SAME_WALL);
            let away = |one: &Surface| (one.at - to.at).norm();
            let same: Vec<(i64, Surface)> =
                same.filter(|(_, one)| away(one) < reach).map(|(square, one)| (ring(square), one)).collect();
            let first = same.iter().map(|(ring, _)| *ring).min()?;
            let looked_at = same.into_iter().filter(|(ring, _)| *ring <= first + 1).map(|(_, one)| one);
            looked_at.min_by(|a, b| away(a).total_cmp(&away(b)))
        }
    }

    /// A window of a metre whose squares are met again and again, walls mostly alike, on a way longer than they are remembered.
    #[test]
    fn walls_are_those_of_a_list_of_all_that_was_seen() {
        let surface = (-1.2..1.2f64, -1.2..1.2f64, -0.5..1.5f64);
        let step = (surface.clone(), surface, prop_oneof![3 => Just(0.0), 1 => 0.0..1.0f64]);
        let found = Cell::new(0);
        let mut runner =
            TestRunner::new(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() });
        let outcome = runner.run(&prop::collection::vec(step, 0..150), |steps| {
            let surface =
                |(x, y, angle): (f64, f64, f64)| Surface { at: Point::new(x, y), normal: direction(angle) };
            let mut walls = Walls::new(1.0, SIDE, 5.0);
            let mut slow = Slow { squares: 10, memory: 5.0, driven: 0.0, seen: BTreeMap::new() };
            for (seen, to, length) in steps {
                walls.drive(length);
                slow.driven += length;
                walls.add(surface(seen));
                slow.add(surface(seen));
                let to = surface(to);
                prop_assert_eq!(walls.nearest(&to, 0.4), slow.nearest(&to, 0.4));
                found.set(found.get() + usize::from(slow.nearest(&to, 0.4).is_some()));
            }
            Ok(())
        });
        outcome.unwrap();
        assert!(found.get() > 1000, "{}", found.get());
    }

    #[test]
    fn what_left_the_window_is_forgotten() {
        let mut walls = Walls::new(10.0, 0.1, 40.0);
        let wall = |x: f64| Surface { at: Point::new(x, 0.05), normal: direction(0.0) };
        walls.add(wall(1.05));
        assert!(walls.nearest(&wall(1.05), 0.5).is_some());
        walls.add(wall(11.05));
        assert!(walls.nearest(&wall(1.05), 0.5).is_none());
        assert!(walls.nearest(&wall(11.05), 0.5).is_some());
        walls.drive(41.0);
        assert!(walls.nearest(&wall(11.05), 0.5).is_none());
        walls.add(wall(f64::NAN));
        assert!(walls.nearest(&wall(1e300), 0.5).is_none());
    }
}
