//! Two pictures of one place laid onto each other: what the robot saw around one frame, and around another.
//!
//! Points are laid onto lines as in scan matching ([`crate::sensor::scan_matching`]), with no odometry to hold them:
//! the frames may be a drift of metres apart. So the best of many starts is taken first (Olson 2009, "Real-time
//! correlative scan matching", as to the score), and where the two do not show the same walls there is no alignment.

use crate::geometry::{Pose, wrap_angle};
use crate::patchwork::submap::Submap;
use crate::sensor::surface::Surface;
use nalgebra::{Matrix3, Vector3};

/// How one submap lies on another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// The frame of the one laid on, in that of the other: `other_from_one`.
    pub pose: Pose,
    /// The inverse of its covariance, x, y, heading in the frame of the one laid on.
    pub information: Matrix3<f64>,
    /// How many of its walls lie on a wall of the other, as a share of the walls of the one that has fewer: at most 1.
    pub share: f64,
    /// How far these lie from it, metres, root mean square.
    pub stray: f64,
}

/// Where one submap may lie on another: around a pose, within so many metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Around {
    /// The middle of where it may lie.
    pub pose: Pose,
    /// Metres along each axis.
    pub reach: f64,
    /// Radians to either side.
    pub turn: f64,
}

/// Noise of a point of a wall, metres: of a range, and of what a wall is not straight.
const NOISE: f64 = 0.03;
/// Points side by side err together; so many of them tell as much as one alone.
const ALIKE: f64 = 25.0;
/// Starts are so far apart, metres and radians: within the reach of the rounds that follow.
const STEP: f64 = 0.5;
const STEP_TURN: f64 = 0.1;
/// Walls nearer than this count for a start, metres.
const SCORED: f64 = 0.25;
/// At most so many points make the score of a start.
const SCORING: usize = 120;
/// Reaches of the rounds of matching, metres, and the steps of each at most.
const REACHES: [f64; 3] = [1.0, 0.5, 0.25];
const STEPS: usize = 6;
/// So many pieces of wall are compared between two questions whether to stop.
const TOGETHER: usize = 4096;
/// Two submaps show the same walls where so many of the smaller one's are found on the other, so near on average.
const SHARE: f64 = 0.5;
const STRAY: f64 = 0.08;
/// What holds an alignment along walls that fix no pose, as those of a corridor: a standard deviation of some 30 m or radians.
const HELD: f64 = 1e-3;

impl Around {
    /// The best alignment, if both submaps show the same walls; `None` too where `interrupted` said to stop, which is asked
    /// before each start and now and then when walls are compared. Costs the starts times the points that score them.
    pub fn align(&self, one: &Submap, other: &Submap, interrupted: &dyn Fn() -> bool) -> Option<Alignment> {
        let thinned = one.surfaces().len().div_ceil(SCORING).max(1);
        let score = |start: &Pose| {
            let sample = one.surfaces().iter().step_by(thinned);
            sample.filter(|surface| other.nearest(&moved(surface, start), SCORED).is_some()).count()
        };
        let mut best: Option<(usize, Pose)> = None;
        for start in self.starts() {
            if interrupted() {
                return None;
            }
            let score = score(&start);
            if best.is_none_or(|(most, _)| score > most) {
                best = Some((score, start));
            }
        }
        let held = Matrix3::from_diagonal_element(HELD);
        settle(one, other, best?.1, &held, interrupted).filter(Alignment::is_same)
    }

    fn starts(&self) -> impl Iterator<Item = Pose> {
        let Around { pose, reach, turn } = *self;
        let steps = |reach: f64, step: f64| {
            let count = (reach / step).ceil() as i32;
            (-count..=count).map(move |k| f64::from(k) * step)
        };
        // From the middle outwards would prefer what is expected among equals; the score decides, the first one wins.
        steps(turn, STEP_TURN).flat_map(move |t| {
            steps(reach, STEP).flat_map(move |x| {
                steps(reach, STEP).map(move |y| Pose::new(pose.x + x, pose.y + y, pose.theta + t))
            })
        })
    }
}

impl Alignment {
    /// Whether both submaps show the same walls.
    pub fn is_same(&self) -> bool {
        self.share >= SHARE && self.stray <= STRAY
    }
}

/// Gauss and Newton from a start, which `trust` holds (the inverse of a covariance in the other's frame); `None` where
/// walls do not fix a pose, or `interrupted` said to stop.
pub fn settle(
    one: &Submap,
    other: &Submap,
    start: Pose,
    trust: &Matrix3<f64>,
    interrupted: &dyn Fn() -> bool,
) -> Option<Alignment> {
    let mut pose = start;
    let mut found = None;
    for reach in REACHES {
        for _ in 0..STEPS {
            let mut sums = Sums::default();
            for some in one.surfaces().chunks(TOGETHER) {
                if interrupted() {
                    return None;
                }
                sums.compare(some, other, &pose, reach);
            }
            let away = Vector3::new(pose.x - start.x, pose.y - start.y, wrap_angle(pose.theta - start.theta));
            let step = (sums.information + trust).try_inverse()? * (sums.pull + trust * away);
            pose = Pose::new(pose.x - step.x, pose.y - step.y, pose.theta - step.z);
            found = Some(sums);
            if step.norm() < 1e-4 {
                break;
            }
        }
    }
    let Sums { information, near, squares, .. } = found?;
    let fewer = one.surfaces().len().min(other.surfaces().len());
    let (sin, cos) = pose.theta.sin_cos();
    let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    Some(Alignment {
        pose,
        information: turned.transpose() * information * turned / ALIKE,
        share: (near / fewer.max(1) as f64).min(1.0),
        stray: (squares / near.max(1.0)).sqrt(),
    })
}

#[derive(Clone, Copy, Default)]
struct Sums {
    information: Matrix3<f64>,
    pull: Vector3<f64>,
    near: f64,
    squares: f64,
}

impl Sums {
    /// Adds what some pieces of wall lie off those of a submap, at a pose in its frame.
    fn compare(&mut self, seen: &[Surface], walls: &Submap, pose: &Pose, reach: f64) {
        for surface in seen {
            let there = moved(surface, pose);
            let Some(wall) = walls.nearest(&there, reach) else { continue };
            let off = wall.normal.dot(&(there.at - wall.at));
            let arm = there.at - pose.position();
            let slope = Vector3::new(wall.normal.x, wall.normal.y, arm.perp(&wall.normal));
            // Cauchy's weight: what does not fit counts less.
            let weight = 1.0 / (NOISE * NOISE + off * off / 4.0);
            self.information += slope * slope.transpose() * weight;
            self.pull += slope * (weight * off);
            self.near += 1.0;
            self.squares += off * off;
        }
    }
}

/// A piece of wall in another frame: `pose` is `other_from_one`.
pub fn moved(surface: &Surface, pose: &Pose) -> Surface {
    Surface { at: pose.transform_point(&surface.at), normal: pose.rotate(&surface.normal) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use proptest::prelude::*;

    /// The walls along a polyline, facing left of its direction.
    fn walls(corners: &[(f64, f64)]) -> Vec<Surface> {
        let sides = corners.windows(2).map(|pair| [pair[0], pair[1]].map(|(x, y)| Point::new(x, y)));
        sides
            .flat_map(|[from, to]| {
                let along = (to - from).normalize();
                let normal = Vector::new(-along.y, along.x);
                let count = ((to - from).norm() / 0.07) as usize;
                (0..=count).map(move |k| Surface { at: from + along * (0.07 * k as f64), normal })
            })
            .collect()
    }

    /// A junction without symmetry, with a niche.
    fn junction() -> Vec<Surface> {
        let mut all = walls(&[(-8.0, -1.0), (-1.2, -1.0), (-1.2, -7.0)]);
        all.extend(walls(&[(1.0, -7.0), (1.0, -1.0), (8.0, -1.0)]));
        all.extend(walls(&[(8.0, 1.0), (3.0, 1.0), (3.0, 2.0), (2.0, 2.0), (2.0, 1.0), (-8.0, 1.0)]));
        all
    }

    fn pose() -> impl Strategy<Value = Pose> {
        (-1.4..1.4f64, -1.4..1.4f64, -0.28..0.28f64).prop_map(|(x, y, theta)| Pose::new(x, y, theta))
    }

    proptest! {
        #[test]
        fn a_junction_is_laid_onto_itself(displaced in pose(), turn in -3.1..3.1f64) {
            let about = Pose::new(0.0, 0.0, turn);
            let truth = about.compose(&displaced);
            let back = truth.inverse();
            let one = Submap::new(junction().iter().map(|surface| moved(surface, &back)));
            let other = Submap::new(junction());
            let found = Around { pose: about, reach: 1.5, turn: 0.3 }.align(&one, &other, &|| false).unwrap();
            let off = truth.inverse().compose(&found.pose);
            prop_assert!(off.x.hypot(off.y) < 0.03 && off.theta.abs() < 0.01, "{off:?} {found:?}");
        }

        /// The information is that of the error seen in the frame laid on: it turns with it.
        #[test]
        fn a_corridor_tells_nothing_along_it(turn in -3.1..3.1f64) {
            let corridor = || walls(&[(-8.0, -1.0), (8.0, -1.0)]).into_iter().chain(walls(&[(8.0, 1.0), (-8.0, 1.0)]));
            let frame = Pose::new(0.0, 0.0, turn);
            let one = Submap::new(corridor().map(|surface| moved(&surface, &frame.inverse())));
            let trust = Matrix3::from_diagonal_element(1e-3);
            let found = settle(&one, &Submap::new(corridor()), frame, &trust, &|| false).unwrap();
            let along = frame.inverse().rotate(&Vector::new(1.0, 0.0));
            let along = Vector3::new(along.x, along.y, 0.0);
            let aside = Vector3::new(-along.y, along.x, 0.0);
            let told = |v: Vector3<f64>| v.dot(&(found.information * v));
            prop_assert!(told(along) < 1e-3 * told(aside), "{} {}", told(along), told(aside));
        }
    }

    /// Along a bare corridor any place is as good, but its walls are the same: none are found that differ.
    #[test]
    fn corridors_lie_on_each_other() {
        let around = Around { pose: Pose::IDENTITY, reach: 1.5, turn: 0.3 };
        for turn in [0.0, std::f64::consts::FRAC_PI_2, 1.0] {
            let frame = Pose::new(0.0, 0.0, turn);
            let corridor =
                walls(&[(-8.0, -1.0), (8.0, -1.0)]).into_iter().chain(walls(&[(8.0, 1.0), (-8.0, 1.0)]));
            let corridor = Submap::new(corridor.map(|surface| moved(&surface, &frame)));
            let found = around.align(&corridor, &corridor, &|| false).unwrap();
            let off = frame.inverse().rotate(&found.pose.position().coords);
            assert!(off.x.abs() < 1.5 && off.y.abs() < 0.03 && found.pose.theta.abs() < 0.01, "{found:?}");
        }
    }

    /// Of two visits one may see further than the other.
    #[test]
    fn a_part_lies_on_the_whole_and_the_whole_on_the_part() {
        let around = Around { pose: Pose::IDENTITY, reach: 1.5, turn: 0.3 };
        let whole = Submap::new(junction());
        let part = Submap::new(junction().into_iter().filter(|wall| wall.at.coords.norm() < 3.5));
        assert!(part.surfaces().len() * 2 < whole.surfaces().len());
        for (one, other) in [(&whole, &part), (&part, &whole)] {
            let found = around.align(one, other, &|| false).unwrap();
            assert!(found.pose.position().coords.norm() < 0.03 && found.share <= 1.0, "{found:?}");
        }
    }

    #[test]
    fn what_shows_other_walls_is_not_laid_on() {
        let around = Around { pose: Pose::IDENTITY, reach: 1.5, turn: 0.3 };
        let room = Submap::new(walls(&[(-3.0, -2.5), (3.5, -2.5), (3.5, 3.0), (-3.0, 3.0), (-3.0, -2.5)]));
        let align = |one: &Submap, other: &Submap| around.align(one, other, &|| false);
        assert_eq!(align(&room, &Submap::new(junction())), None);
        assert_eq!(align(&room, &Submap::default()), None);
        assert_eq!(align(&Submap::default(), &room), None);
    }

    #[test]
    fn laying_on_stops_wherever_it_is_told_to() {
        let around = Around { pose: Pose::IDENTITY, reach: 1.5, turn: 0.3 };
        let junction = Submap::new(junction());
        let asked = std::cell::Cell::new(0);
        let after = |most: usize| {
            asked.set(0);
            around.align(&junction, &junction, &|| asked.replace(asked.get() + 1) >= most)
        };
        let found = after(usize::MAX).unwrap();
        let questions = asked.get();
        assert!(questions > 343, "{questions}");
        assert_eq!([0, 342, 343, questions - 1].map(after), [None; 4]);
        assert_eq!(after(questions), Some(found));
    }
}
