//! The laws `distance` and `angle`: what odometry and bearings say of a story.
//!
//! Shares with [`crate::metric`] the parameters and nothing else: derivatives are differences, differences of angles
//! are tightened through all three at a time, and chains get shorter until none does.

use crate::abduction::Visit;
use crate::geometry::{Pose, Vector, direction, wrap_angle};
use crate::metric::MetricParameters;
use crate::reference::told::{Story, travels};
use crate::trace::{Motion, Sighting};
use std::f64::consts::FRAC_PI_4;

/// The laws that [`Measured`] judges.
pub const MEASURED: [&str; 2] = ["distance", "angle"];

/// The least and the most that a quantity may be: metres or radians.
pub type Interval = (f64, f64);

/// What was measured on a trace, and the laws that it has to obey.
///
/// A law speaks of the latest travel of a story; a story obeys it if each of its beginnings does. Costs are polynomial
/// in the visits, but of a high degree.
#[derive(Clone, Debug)]
pub struct Measured {
    parameters: MetricParameters,
    /// For each observation bounds on the distance of its place from the one before.
    lengths: Vec<Option<Interval>>,
    /// For each observation the outward bearings of its slots in its frame.
    bearings: Vec<Vec<Option<f64>>>,
    headings: Vec<Option<Heading>>,
    /// The first observation that a measured travel led to.
    since: Option<usize>,
}

/// How far the frame of an observation is turned in that of the one before.
#[derive(Clone, Copy, Debug)]
struct Heading {
    turn: f64,
    /// The sum of the deviations of what it is made of.
    sigma: f64,
    /// The variance of the whole displacement, a radian being worth so many metres.
    weight: f64,
}

/// A known turn between two frames; of a place, or of a visit by so many more than there are places.
struct Link {
    ends: [usize; 2],
    heading: Heading,
}

impl Measured {
    /// What was measured on a trace, to be judged with these bounds.
    pub fn new(seen: &[Sighting], parameters: MetricParameters) -> Measured {
        let travels = |k: usize| Some((seen[k].motion.as_ref()?, seen.get(k.checked_sub(1)?)?, &seen[k]));
        let travelled = |k: usize| {
            travels(k).map(|(motion, before, now)| Travelled { motion, before, now, parameters: &parameters })
        };
        let all = 0..seen.len();
        Measured {
            parameters,
            lengths: all.clone().map(|k| travelled(k).map(|travelled| travelled.length())).collect(),
            bearings: seen
                .iter()
                .map(|it| it.star.slots().iter().map(|slot| slot.bearing).collect())
                .collect(),
            headings: all.clone().map(|k| travelled(k)?.heading()).collect(),
            since: all.clone().find(|&k| travelled(k).is_some()),
        }
    }

    /// Whether any travel was measured. If none was, every story obeys the laws.
    pub fn any(&self) -> bool {
        self.since.is_some()
    }

    /// For each observation, bounds on the length of the travel that led to it, metres.
    pub fn lengths(&self) -> &[Option<Interval>] {
        &self.lengths
    }

    /// For each observation and slot, bounds on the outward bearing in the frame of the observation, radians. None
    /// before the first measured travel, nor where bounds are too wide to judge by.
    pub fn bearings(&self) -> Vec<Vec<Option<Interval>>> {
        let reach = self.reach();
        let judged =
            |k: usize| reach < FRAC_PI_4 && self.since.is_some_and(|since| k >= since.saturating_sub(1));
        let bounds = |bearing: &Option<f64>| bearing.map(|bearing| (bearing - reach, bearing + reach));
        let all = self.bearings.iter().enumerate();
        all.map(|(k, slots)| slots.iter().map(|slot| bounds(slot).filter(|_| judged(k))).collect()).collect()
    }

    /// Whether the latest travel of a story obeys a law; true of laws that are not in [`MEASURED`]. The story has to
    /// obey `star-match`.
    pub fn obeys(&self, visits: &[Visit], story: &Story, law: &str) -> bool {
        match (law, story.len().checked_sub(1)) {
            ("distance", Some(latest)) => self.lengths_meet(visits, story, latest),
            ("angle", Some(latest)) => {
                let first = story[..latest].iter().all(|visit| visit.0 != story[latest].0);
                let judged = self.since.is_some_and(|since| since <= latest);
                first || !judged || (self.directions_meet(story) && self.headings_close(story))
            }
            _ => true,
        }
    }

    /// The intervals of all travels along the segment of the latest one have a point in common.
    fn lengths_meet(&self, visits: &[Visit], story: &Story, latest: usize) -> bool {
        let segment = |&(a, b): &((usize, usize), (usize, usize))| (a.min(b), a.max(b));
        let segments: Vec<_> = travels(visits, story).iter().map(segment).collect();
        let along = (1..=latest).filter(|&k| segments[k - 1] == segments[latest - 1] && latest > 0);
        let (least, most) = along
            .filter_map(|k| self.lengths[k])
            .fold((f64::MIN, f64::MAX), |(least, most), (low, high)| (low.max(least), high.min(most)));
        least <= most
    }

    fn reach(&self) -> f64 {
        self.parameters.sigmas * self.parameters.bearing_sigma
    }

    /// The bearings of a visit by the slots of its place.
    fn of_place(&self, story: &Story, visit: usize) -> Vec<(usize, f64)> {
        let own = &self.bearings[visit];
        let on = |slot: usize| (slot + story[visit].1) % own.len();
        own.iter().enumerate().filter_map(|(slot, bearing)| Some((on(slot), (*bearing)?))).collect()
    }

    /// How far the frame of a visit is turned in that of its place, the frame of the first visit: on average over the
    /// slots that have a bearing on both.
    fn turn(&self, story: &Story, visit: usize) -> Option<f64> {
        let first = story.iter().position(|other| other.0 == story[visit].0)?;
        if first == visit {
            return Some(0.0);
        }
        let known = self.of_place(story, first);
        let common = self.of_place(story, visit).into_iter().filter_map(|(slot, bearing)| {
            known.iter().find(|(other, _)| *other == slot).map(|(_, own)| own - bearing)
        });
        let turns: Vec<f64> = common.collect();
        let about = *turns.first()?;
        let off: f64 = turns.iter().map(|turn| wrap_angle(turn - about)).sum();
        Some(about + off / turns.len() as f64)
    }

    /// Directions of the slots of the latest place, and headings of its visits, that satisfy all bearings: bounds on
    /// all differences, tightened through every third one (Floyd and Warshall), leave none below nothing.
    fn directions_meet(&self, story: &Story) -> bool {
        let (latest, reach) = (story.len() - 1, self.reach());
        let visits: Vec<usize> =
            (0..story.len()).filter(|&visit| story[visit].0 == story[latest].0).collect();
        if reach >= FRAC_PI_4 || self.turn(story, latest).is_none() {
            return true;
        }
        let slots = self.bearings[latest].len();
        let size = slots + visits.len();
        let mut most = vec![vec![f64::INFINITY; size]; size];
        let mut known = vec![None; slots];
        for (at, &visit) in visits.iter().enumerate() {
            let Some(turn) = self.turn(story, visit) else { continue };
            for (slot, bearing) in self.of_place(story, visit) {
                let off = wrap_angle(bearing + turn - *known[slot].get_or_insert(bearing + turn));
                most[slots + at][slot] = off + reach;
                most[slot][slots + at] = reach - off;
            }
        }
        for by in 0..size {
            for a in 0..size {
                for b in 0..size {
                    most[a][b] = most[a][b].min(most[a][by] + most[by][b]);
                }
            }
        }
        (0..size).all(|a| most[a][a] > -ROUNDING)
    }

    /// The heading around the loop of the latest travel and the least uncertain chain between its ends, within the sum
    /// of all bounds.
    fn headings_close(&self, story: &Story) -> bool {
        let latest = story.len() - 1;
        let (Some(direct), Some(arrival)) = (self.headings[latest], self.turn(story, latest)) else {
            return true;
        };
        let Some(chain) = self.chain(story, latest) else { return true };
        let sigma = direct.sigma + chain.sigma + self.parameters.bearing_sigma;
        wrap_angle(direct.turn - chain.turn - arrival).abs() <= self.parameters.sigmas * sigma
    }

    /// The least uncertain chain from the visit before the latest to the place of the latest: Bellman and Ford.
    fn chain(&self, story: &Story, latest: usize) -> Option<Heading> {
        let places = 1 + story.iter().map(|visit| visit.0).max()?;
        let links = self.links(story, latest, places);
        let mut best: Vec<Option<Heading>> = vec![None; places + latest];
        best[places + latest - 1] = Some(Heading { turn: 0.0, sigma: 0.0, weight: 0.0 });
        loop {
            let mut settled = true;
            for Link { ends: [a, b], heading } in &links {
                for (from, to, sign) in [(*a, *b, 1.0), (*b, *a, -1.0)] {
                    let Some(before) = best[from] else { continue };
                    let weight = before.weight + heading.weight;
                    if best[to].is_none_or(|known| weight < known.weight) {
                        let (turn, sigma) = (before.turn + sign * heading.turn, before.sigma + heading.sigma);
                        best[to] = Some(Heading { turn, sigma, weight });
                        settled = false;
                    }
                }
            }
            if settled {
                return best[story[latest].0];
            }
        }
    }

    /// All turns known without the latest travel.
    fn links(&self, story: &Story, latest: usize, places: usize) -> Vec<Link> {
        let MetricParameters { extent_sigma, bearing_sigma: sigma, lever, .. } = self.parameters;
        let weight = 2.0 * extent_sigma.powi(2) + (sigma * lever).powi(2);
        let arrivals = (0..latest).filter_map(|visit| {
            let heading = Heading { turn: self.turn(story, visit)?, sigma, weight };
            Some(Link { ends: [story[visit].0, places + visit], heading })
        });
        let travels = (1..latest).filter_map(|visit| {
            Some(Link { ends: [places + visit - 1, places + visit], heading: self.headings[visit]? })
        });
        arrivals.chain(travels).collect()
    }
}

/// Slack for the rounding of sums, radians.
const ROUNDING: f64 = 1e-9;

/// A measured travel between two observations.
struct Travelled<'a> {
    motion: &'a Motion,
    before: &'a Sighting,
    now: &'a Sighting,
    parameters: &'a MetricParameters,
}

impl Travelled<'_> {
    /// The second place from the first, with errors of odometry and then of the start; in the axes of the first
    /// observation where the heading at the start is known, otherwise in those of the start.
    fn end(&self, by: &[f64; 6]) -> Vector {
        let (motion, gone) = (self.motion, self.motion.odometry);
        let gone = Pose::new(gone.x + by[0], gone.y + by[1], gone.theta + by[2]);
        let Some(heading) = motion.heading else { return gone.position().coords };
        let from = motion.start - self.before.middle;
        let start = Pose::new(from.x + by[3], from.y + by[4], heading + by[5]);
        let arrived = self.now.robot_pose.position() - self.now.middle;
        let arrived = Pose::new(arrived.x, arrived.y, self.now.robot_pose.theta);
        start.compose(&gone).compose(&arrived.inverse()).position().coords
    }

    /// The deviations of where the travel starts, unless the trace says it.
    fn start(&self) -> [f64; 3] {
        let MetricParameters { extent_sigma, bearing_sigma, .. } = *self.parameters;
        let guessed = self.motion.heading.is_some() && !self.motion.start_given;
        if guessed { [extent_sigma, extent_sigma, bearing_sigma] } else { [0.0; 3] }
    }

    /// The variance of a number that depends on where the travel ends.
    fn variance(&self, of: impl Fn(&Vector) -> f64) -> f64 {
        let slope = |axis: usize| {
            let step = 1e-4;
            let [more, less] = [step, -step].map(|step| {
                let mut by = [0.0; 6];
                by[axis] = step;
                of(&self.end(&by))
            });
            (more - less) / (2.0 * step)
        };
        let pairs = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
        let odometry: f64 = pairs.map(|(a, b)| slope(a) * self.motion.covariance[3 * a + b] * slope(b)).sum();
        let start: f64 =
            self.start().iter().enumerate().map(|(at, sigma)| (slope(3 + at) * sigma).powi(2)).sum();
        odometry + start
    }

    fn length(&self) -> Interval {
        let end = self.end(&[0.0; 6]);
        let along = end.try_normalize(0.0).unwrap_or_else(|| direction(0.0));
        let points = 2.0 * self.parameters.extent_sigma.powi(2);
        let reach = self.parameters.sigmas * (self.variance(|end| along.dot(end)) + points).sqrt();
        (end.norm() - reach, end.norm() + reach)
    }

    fn heading(&self) -> Option<Heading> {
        let turn = self.motion.heading? + self.motion.odometry.theta - self.now.robot_pose.theta;
        let (odometry, start) = (self.motion.covariance[8].sqrt(), self.start()[2]);
        let turned = (odometry.powi(2) + start.powi(2)) * self.parameters.lever.powi(2);
        let weight = self.variance(|end| end.x) + self.variance(|end| end.y) + turned;
        Some(Heading { turn, sigma: odometry + start, weight })
    }
}
