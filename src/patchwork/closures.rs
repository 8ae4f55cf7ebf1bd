//! The closures of a candidate map: where it says that a visit was to a place known before, and how the frames of the two
//! visits lie, as far as what was seen on them tells.

use crate::abduction::Assignment;
use crate::patchwork::agreement::{Agreement, Neighbourhood};
use std::cell::Cell;
use std::collections::BTreeMap;

/// Two visits to one place, and how their frames lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// Number of the earlier visit, and of the later one.
    pub visits: [usize; 2],
    /// What they show of each other.
    pub agreement: Agreement,
}

/// The caller said to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it was told to stop")]
pub struct Interrupted;

/// What a visit shows; `None` where there is nothing to show, or where the second said to stop.
type Show<'a> = dyn Fn(usize, &dyn Fn() -> bool) -> Option<Neighbourhood> + 'a;

/// What visits show of each other, remembered: candidates ask for the same pairs.
pub struct Agreements<'a> {
    show: Box<Show<'a>>,
    shown: BTreeMap<usize, Option<Neighbourhood>>,
    /// Standard deviations of the middle of a place, metres, and of a bearing, radians, as found on one visit.
    sigmas: [f64; 2],
    known: Known,
}

/// What pairs of visits show of each other, where that was asked before. It stays so however the trace goes on. A pair is
/// found by its later visit, its first visit, and the rotation.
#[derive(Clone, Debug, Default)]
pub struct Known(BTreeMap<(usize, usize, u8), Option<Agreement>>);

impl Known {
    /// How many pairs are remembered at most: half a megabyte.
    pub const MOST: usize = 4096;

    /// Remembers more pairs. Where there is no room for all, those whose later visits are the oldest are forgotten: fewest
    /// candidates still differ there.
    pub fn extend(&mut self, more: Known) {
        for (pair, agreement) in more.0 {
            self.0.insert(pair, agreement);
            if self.0.len() > Known::MOST {
                self.0.pop_first();
            }
        }
    }
}

impl<'a> Agreements<'a> {
    /// Of visits, each of which is asked what it shows when a pair first needs it.
    pub fn new(
        show: impl Fn(usize, &dyn Fn() -> bool) -> Option<Neighbourhood> + 'a,
        sigmas: [f64; 2],
    ) -> Self {
        Agreements { show: Box::new(show), shown: BTreeMap::new(), sigmas, known: Known::default() }
    }

    /// The same, some pairs of which are known.
    #[must_use]
    pub fn knowing(self, known: Known) -> Self {
        Agreements { known, ..self }
    }

    /// The pairs that are known by now.
    pub fn into_known(self) -> Known {
        self.known
    }

    /// The closures of a candidate: each visit to a known place, with the first visit there. `interrupted` is asked
    /// before each, and while walls are looked for.
    pub fn closures(
        &mut self,
        candidate: &[Assignment],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Vec<Closure>, Interrupted> {
        let mut first: BTreeMap<usize, usize> = BTreeMap::new();
        let mut closures = Vec::new();
        for (visit, assigned) in candidate.iter().enumerate() {
            if interrupted() {
                return Err(Interrupted);
            }
            let known = *first.entry(assigned.place.index()).or_insert(visit);
            if known == visit {
                continue;
            }
            if let Some(agreement) = self.between(known, visit, assigned.rotation, interrupted)? {
                closures.push(Closure { visits: [known, visit], agreement });
            }
        }
        Ok(closures)
    }

    fn between(
        &mut self,
        first: usize,
        later: usize,
        rotation: u8,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<Agreement>, Interrupted> {
        if let Some(known) = self.known.0.get(&(later, first, rotation)) {
            return Ok(*known);
        }
        // Remembered only where it was not told to stop: what a visit shows is then all of it.
        let stopped = Cell::new(false);
        let stop = || {
            stopped.set(stopped.get() || interrupted());
            stopped.get()
        };
        for visit in [first, later] {
            if self.shown.contains_key(&visit) {
                continue;
            }
            let shows = (self.show)(visit, &stop);
            if stopped.get() {
                return Err(Interrupted);
            }
            self.shown.insert(visit, shows);
        }
        let [one, other] = [first, later].map(|visit| self.shown.get(&visit).and_then(Option::as_ref));
        let found = one
            .zip(other)
            .and_then(|(one, other)| one.agreement(other, usize::from(rotation), self.sigmas, &stop));
        if stopped.get() {
            return Err(Interrupted);
        }
        self.known.0.insert((later, first, rotation), found);
        Ok(found)
    }
}

/// A block walked around, for tests: what is measured and what is seen on the way.
#[cfg(test)]
pub(super) mod block {
    use super::*;
    use crate::geometry::{Point, Pose, direction, wrap_angle};
    use crate::map::PlaceId;
    use crate::patchwork::alignment::moved;
    use crate::patchwork::local_frames::Displacement;
    use crate::patchwork::submap::Submap;
    use crate::sensor::surface::Surface;
    use nalgebra::{Matrix3, Vector3};
    use std::f64::consts::FRAC_PI_2;

    /// The corners of a square block walked around twice, and the walls of each, which differ.
    pub(in crate::patchwork) fn corner(place: usize, world_from_visit: &Pose) -> Neighbourhood {
        let back = world_from_visit.inverse();
        let sides =
            [(0.0, -1.0), (0.0, 1.0 + 0.3 * place as f64), (0.5, -1.2), (0.5 + 0.1 * place as f64, 1.0)];
        let walls = sides.iter().enumerate().flat_map(|(k, (angle, offset))| {
            let angle: f64 = angle + FRAC_PI_2 * (k % 2) as f64;
            let (normal, along) = (direction(angle), direction(angle + FRAC_PI_2));
            (-40..40).map(move |step| {
                let at = middle(place) + normal * *offset + along * (0.1 * f64::from(step));
                Surface { at, normal: if *offset < 0.0 { normal } else { -normal } }
            })
        });
        let walls = walls.map(|wall| moved(&wall, &back));
        let bearings = [0.0, 2.0].map(|bearing| Some(wrap_angle(bearing - world_from_visit.theta)));
        Neighbourhood { walls: Submap::new(walls), bearings: bearings.to_vec() }
    }

    pub(in crate::patchwork) fn middle(place: usize) -> Point {
        [Point::new(0.0, 0.0), Point::new(20.0, 0.0), Point::new(20.0, 15.0), Point::new(0.0, 15.0)]
            [place % 4]
    }

    pub(in crate::patchwork) fn assigned(visits: usize) -> Vec<Assignment> {
        let place = |visit: usize| PlaceId::new(visit % 4).unwrap();
        (0..visits).map(|visit| Assignment { place: place(visit), rotation: 0 }).collect()
    }

    /// Frames near the middles, the exact displacements between them, and what was seen.
    pub(in crate::patchwork) fn walked(
        frames: &[(f64, f64, f64)],
    ) -> (Vec<Pose>, Vec<Option<Displacement>>, Agreements<'static>) {
        let pose = |(visit, &(x, y, theta)): (usize, &(f64, f64, f64))| {
            Pose::new(middle(visit).x + x, middle(visit).y + y, theta)
        };
        let truth: Vec<Pose> = frames.iter().enumerate().map(pose).collect();
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 0.04, 0.01));
        let travel = |pair: &[Pose]| Some((pair[0].between(&pair[1]), covariance));
        let travels = std::iter::once(None).chain(truth.windows(2).map(travel)).collect();
        let seen: Vec<Neighbourhood> =
            truth.iter().enumerate().map(|(visit, pose)| corner(visit % 4, pose)).collect();
        (truth, travels, Agreements::new(move |visit, _| seen.get(visit).cloned(), [0.25, 0.05]))
    }
}

#[cfg(test)]
mod tests {
    use super::block::{assigned, walked};
    use super::*;

    #[test]
    fn what_is_known_of_pairs_is_not_looked_for_again() {
        let (_, _, mut agreements) = walked(&[(0.1, 0.0, 0.3); 8]);
        let found = agreements.closures(&assigned(8), &|| false).unwrap();
        let mut known = Known::default();
        known.extend(agreements.into_known());
        let blind = |_, _: &dyn Fn() -> bool| panic!("it is known");
        let again =
            Agreements::new(blind, [0.25, 0.05]).knowing(known).closures(&assigned(8), &|| false).unwrap();
        assert_eq!((found.len(), &found), (4, &again));
    }

    #[test]
    fn the_pairs_of_the_latest_visits_are_remembered() {
        let pairs =
            |visits: std::ops::Range<usize>| Known(visits.map(|visit| ((visit, 0, 0), None)).collect());
        let mut known = Known::default();
        known.extend(pairs(1..Known::MOST));
        known.extend(pairs(Known::MOST..Known::MOST + 100));
        known.extend(pairs(1..50));
        assert_eq!(known.0.len(), Known::MOST);
        assert_eq!(known.0.keys().next(), Some(&(100, 0, 0)));
        assert_eq!(known.0.keys().last(), Some(&(Known::MOST + 99, 0, 0)));
    }

    /// Where a visit was not shown to its end, it is shown again when it is asked for next.
    #[test]
    fn what_was_not_shown_to_its_end_is_not_remembered() {
        let (_, _, mut whole) = walked(&[(0.1, 0.0, 0.3); 8]);
        let (_, _, other) = walked(&[(0.1, 0.0, 0.3); 8]);
        let show = |visit, interrupted: &dyn Fn() -> bool| {
            if interrupted() { None } else { (other.show)(visit, interrupted) }
        };
        let mut agreements = Agreements::new(show, [0.25, 0.05]);
        let asked = Cell::new(0);
        // The first to be shown anything is the visit at 4, after which it is asked again.
        let stop = || asked.replace(asked.get() + 1) >= 5;
        assert!(matches!(agreements.closures(&assigned(8), &stop), Err(Interrupted)));
        let closures = agreements.closures(&assigned(8), &|| false).unwrap();
        assert_eq!(closures, whole.closures(&assigned(8), &|| false).unwrap());
    }
}
