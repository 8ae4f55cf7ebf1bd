//! Finds visits in a stream of scans.

use crate::geometry::{Point, Pose, wrap_angle};
use crate::grid::GridError;
use crate::lpm::Lpm;
use crate::sensor::{LaserScan, LocalPose};
use crate::star::{PlaceDescription, describe};
use crate::visit::follower::Follower;
use crate::visit::passage::passages;
use crate::visit::sighting::{Seen, Sighting, is_passage, look};
use crate::visit::{Moment, Stage, Visit, VisitParameters};
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_3;

/// A robot that comes back to the place it left last, within so many metres and without another place on the way, has
/// not left it: it has looked around.
const LOOKS_AROUND: f64 = 60.0;

/// Takes scans one by one and gives visits, each as soon as the next one has begun. Memory is bounded by the window
/// and by the way between two visits.
#[derive(Clone, Debug)]
pub struct VisitDetector {
    parameters: VisitParameters,
    follower: Follower,
    /// Where the surroundings are to be judged.
    awaiting: VecDeque<Moment>,
    next: f64,
    /// What was seen since the robot was last at a place, or is still near.
    sightings: VecDeque<Sighting>,
    groups: Vec<Group>,
    /// The last visit, which the robot may return to.
    last: Option<Found>,
    /// How many visits were given away.
    certain: usize,
    /// Those of them that it left no longer ago than it remembers walls.
    remembered: VecDeque<Visit>,
    /// Whether the log has ended.
    over: bool,
}

/// Sightings that agree on a middle.
#[derive(Clone, Debug)]
struct Group {
    seen: Vec<Seen>,
    center: Point,
    /// The first and the last moment at which it was seen from nearby.
    near: Option<[Moment; 2]>,
    last: f64,
}

/// A visit, and how well it was seen.
#[derive(Clone, Debug)]
struct Found {
    stage: Stage,
    inside: [Moment; 2],
    sightings: usize,
}

/// A place is left when the robot has driven so many metres on without being near.
const GONE: f64 = 3.0;
/// A robot that leaves more than 60 degrees beside a gateway does not leave by it.
const SIDEWAYS: f64 = FRAC_PI_3;

impl VisitDetector {
    /// A robot that has seen nothing yet; refuses a grid that is too large to be made.
    pub fn new(parameters: VisitParameters) -> Result<Self, GridError> {
        Ok(VisitDetector {
            parameters,
            follower: Follower::new(&parameters)?,
            awaiting: VecDeque::new(),
            next: 0.0,
            sightings: VecDeque::new(),
            groups: Vec::new(),
            last: None,
            certain: 0,
            remembered: VecDeque::new(),
            over: false,
        })
    }

    /// Takes the next scan; gives the visits that are certain now.
    pub fn add(&mut self, scan: &LaserScan) -> Vec<Stage> {
        let moment = self.follower.add(scan);
        self.go_on(moment)
    }

    /// As [`VisitDetector::add`], with the pose that a [`ScanMatcher`](crate::sensor::ScanMatcher) gave to each scan,
    /// which may run ahead elsewhere.
    pub fn add_placed(&mut self, scan: &LaserScan, pose: &LocalPose) -> Vec<Stage> {
        let moment = self.follower.add_placed(scan, pose);
        self.go_on(moment)
    }

    fn go_on(&mut self, moment: Moment) -> Vec<Stage> {
        if moment.driven >= self.next {
            self.awaiting.push_back(moment);
            self.next = moment.driven + self.parameters.spacing;
        }
        let mut certain = Vec::new();
        while let Some(due) =
            self.awaiting.pop_front_if(|due| due.driven + self.parameters.lag <= moment.driven)
        {
            certain.extend(self.judge(due));
        }
        certain
    }

    /// Where the robot was at the scan taken last.
    pub fn now(&self) -> Option<&Moment> {
        self.follower.moments().last()
    }

    /// The visits that were still open when the log ended.
    pub fn finish(mut self) -> Vec<Stage> {
        self.over = true;
        let mut certain = Vec::new();
        while let Some(due) = self.awaiting.pop_front() {
            certain.extend(self.judge(due));
        }
        for group in std::mem::take(&mut self.groups) {
            certain.extend(self.close(group));
        }
        certain.extend(self.last.take().map(|found| found.stage));
        certain
    }

    fn judge(&mut self, moment: Moment) -> Vec<Stage> {
        let sighting = look(moment, &self.follower, &self.parameters.perception);
        self.sightings.push_back(sighting);
        while self.sightings.front().is_some_and(|old| old.moment.driven + LOOKS_AROUND < moment.driven) {
            self.sightings.pop_front();
        }
        if let Some(seen) = sighting.place {
            self.join(seen, moment);
        }
        let (open, closed) = std::mem::take(&mut self.groups)
            .into_iter()
            .partition(|group| group.last + GONE >= moment.driven);
        self.groups = open;
        closed.into_iter().filter_map(|group| self.close(group)).collect()
    }

    fn join(&mut self, seen: Seen, moment: Moment) {
        let agreement = self.parameters.agreement;
        let agrees = |group: &&mut Group| (group.center - seen.center).norm() <= agreement;
        let near = (moment.local_from_robot.position() - seen.center).norm()
            <= seen.clearance + self.parameters.presence;
        match self.groups.iter_mut().find(agrees) {
            Some(group) => group.add(seen, moment, near),
            None => self.groups.push(Group::new(seen, moment, near)),
        }
    }

    /// Decides whether a group was a visit; gives the visit before it, which is certain then.
    fn close(&mut self, group: Group) -> Option<Stage> {
        let found = self.settle(&group)?;
        let Some(last) = self.last.take() else {
            self.keep(found);
            return None;
        };
        let apart = found.inside[0].driven - last.inside[1].driven;
        let same =
            (found.stage.visit.center - last.stage.visit.center).norm() <= 2.0 * self.parameters.agreement;
        let overlaps = found.stage.visit.arrival.driven < last.inside[1].driven
            || found.is_within(&last)
            || last.is_within(&found);
        if same && apart <= LOOKS_AROUND {
            self.keep(self.joined(last, found));
            None
        } else if overlaps {
            // Two middles of one place: the one that was seen more often stays.
            self.keep(if found.sightings > last.sightings { found.instead_of(last) } else { last });
            None
        } else {
            self.keep(found);
            self.certain += 1;
            self.remember(&last.stage.visit);
            Some(last.stage)
        }
    }

    /// One stay of two at the same place: as seen last, or else as seen first, whichever the robot passed through.
    fn joined(&self, last: Found, found: Found) -> Found {
        let first = self.certain == 0;
        let latest = last.clone().prolonged(&found, &found.stage.visit);
        let earliest = last.clone().prolonged(&found, &last.stage.visit);
        let understood = |found: &Found| self.is_passed_through(&found.stage.visit, first);
        [latest, earliest].into_iter().find(understood).unwrap_or_else(|| found.instead_of(last))
    }

    fn keep(&mut self, found: Found) {
        self.follower.forget_before(&found.stage.visit.arrival);
        self.last = Some(found);
    }

    fn remember(&mut self, left: &Visit) {
        let memory = self.parameters.matching.memory;
        let since = left.departure.driven - memory;
        while self.remembered.pop_front_if(|known| known.departure.driven < since).is_some() {}
        self.remembered.push_back(left.clone());
    }

    /// The visit that a group of sightings shows, if it is one: the robot was near, most of what it saw there agrees,
    /// and the place is one that the robot came into and left by its gateways.
    fn settle(&self, group: &Group) -> Option<Found> {
        let inside = group.near?;
        let sightings = self.agreeing(group, inside)?;
        let visit = self.seen_again(group, inside).or_else(|| self.seen(group, inside))?;
        let arrival = visit.arrival;
        let from = self.last.as_ref().map_or(0, |last| last.stage.visit.arrival.scan);
        let way = self.follower.between(from, arrival.scan).to_vec();
        Some(Found { stage: Stage { way, visit }, inside, sightings })
    }

    /// A visit to a place that the robot remembers, as it was seen on the visit before: scans are matched with walls that
    /// were seen there, so that this is one place, and its star has been told. Where the robot did not pass through gateways
    /// that it had then, it is read anew.
    fn seen_again(&self, group: &Group, inside: [Moment; 2]) -> Option<Visit> {
        let VisitParameters { matching, agreement, .. } = self.parameters;
        let recent = |known: &&Visit| known.departure.driven + matching.memory >= inside[0].driven;
        let same = |known: &&Visit| (known.center - group.center).norm() <= agreement;
        let mut known = self.remembered.iter().rev().filter(recent).filter(same);
        known.find_map(|known| self.passed(known.center, &known.lpm, inside))
    }

    /// A visit to a place as it was seen over the whole of it.
    fn seen(&self, group: &Group, inside: [Moment; 2]) -> Option<Visit> {
        let at = |middle: &Point| Pose { x: middle.x, y: middle.y, ..inside[0].local_from_robot };
        let center = group.center + self.read(&group.center, &at(&group.center))?.1.center.coords;
        let (lpm, _) = self.read(&center, &at(&center))?;
        self.passed(center, &lpm, inside)
    }

    /// The visit on which the robot came into a place seen so, and left it, by its gateways, if it did.
    fn passed(&self, center: Point, seen: &Lpm, inside: [Moment; 2]) -> Option<Visit> {
        let place = describe(seen, &self.parameters.perception).ok()?;
        let scans = inside.map(|moment| moment.scan);
        let [arrival, departure] = passages(self.follower.moments(), scans, &center, &place.gateways)?;
        let at = arrival.local_from_robot;
        let lpm = Lpm { robot_pose: Pose { x: at.x - center.x, y: at.y - center.y, ..at }, ..seen.clone() };
        let visit = Visit { center, lpm, arrival, departure };
        self.is_passed_through(&visit, self.last.is_none()).then_some(visit)
    }

    /// How many sightings agree with a group while the robot was near, if these are enough.
    fn agreeing(&self, group: &Group, inside: [Moment; 2]) -> Option<usize> {
        let VisitParameters { agreement, spacing, hysteresis, .. } = self.parameters;
        let during = |s: &&Sighting| (inside[0].driven..=inside[1].driven).contains(&s.moment.driven);
        let agrees = |s: &Sighting| s.place.is_some_and(|p| (p.center - group.center).norm() <= agreement);
        let all = self.sightings.iter().filter(during).count();
        let agreeing = self.sightings.iter().filter(during).filter(|s| agrees(s)).count();
        let long = agreeing as f64 * spacing >= hysteresis;
        (long && 2 * agreeing >= all).then_some(agreeing)
    }

    /// Whether the trace can tell of a visit: by which gateway the robot came in, unless the log began there, and by
    /// which it left, unless the log ended there. Where a robot passes and no gateway is, the place was not understood.
    fn is_passed_through(&self, visit: &Visit, first: bool) -> bool {
        let Ok(place) = describe(&visit.lpm, &self.parameters.perception) else { return false };
        let now = self.follower.moments().last();
        let ended = self.over && now.is_none_or(|last| last.scan == visit.departure.scan);
        let out = visit.way_out();
        let gateway = place.outward_slot_toward(out).and_then(|slot| place.star.slot(slot)?.bearing);
        let left = gateway.is_some_and(|bearing| wrap_angle(bearing - out).abs() <= SIDEWAYS);
        // A robot that starts off does not see what is behind it.
        let closed_behind = first && place.gateways.len() == 1 && place.arrival.is_none();
        // Nor does one that stops see, in time, what is far ahead.
        let closed_ahead = ended && !left && place.gateways.len() == 1;
        let closed = closed_behind || closed_ahead;
        (first || place.arrival.is_some()) && (ended || left) && !is_passage(&place) && !closed
    }

    /// The LPM around a point of the local frame as seen over the whole visit, from a pose in it, and its place, if it is
    /// one and has its middle there.
    fn read(&self, middle: &Point, robot: &Pose) -> Option<(Lpm, PlaceDescription)> {
        let lpm = self.follower.lpm(middle, robot)?;
        let place = describe(&lpm, &self.parameters.perception).ok()?;
        let there = place.center.coords.norm() <= self.parameters.agreement;
        (there && !is_passage(&place)).then_some((lpm, place))
    }
}

impl Group {
    fn new(seen: Seen, moment: Moment, near: bool) -> Self {
        let mut group = Group { seen: Vec::new(), center: seen.center, near: None, last: moment.driven };
        group.add(seen, moment, near);
        group
    }

    fn add(&mut self, seen: Seen, moment: Moment, near: bool) {
        self.seen.push(seen);
        self.center = median(&self.seen);
        if near {
            let first = self.near.map_or(moment, |[first, _]| first);
            self.near = Some([first, moment]);
        }
        self.last = moment.driven;
    }
}

impl Found {
    /// Whether the robot came to this place and left it without having left another that it was at.
    fn is_within(&self, other: &Found) -> bool {
        let [stay, around] = [self, other].map(|found| {
            let Visit { arrival, departure, .. } = &found.stage.visit;
            arrival.driven..=departure.driven
        });
        around.contains(stay.start()) && around.contains(stay.end())
    }

    /// A stay that goes on until the end of the next, at the place as it is in one of them.
    fn prolonged(mut self, next: &Found, seen: &Visit) -> Found {
        let Visit { arrival, .. } = self.stage.visit;
        let (center, at) = (seen.center, arrival.local_from_robot);
        let mut lpm = seen.lpm.clone();
        lpm.robot_pose = Pose { x: at.x - center.x, y: at.y - center.y, ..at };
        self.stage.visit = Visit { center, lpm, arrival, departure: next.stage.visit.departure };
        self.inside[1] = next.inside[1];
        self.sightings += next.sightings;
        self
    }

    /// A visit in place of one that was seen less well; its way goes on from the same visit before.
    fn instead_of(mut self, other: Found) -> Found {
        let arrival = self.stage.visit.arrival.scan;
        let last = other.stage.way.last().map_or(0, |moment| moment.scan);
        let mut way: Vec<Moment> =
            other.stage.way.into_iter().filter(|moment| moment.scan <= arrival).collect();
        way.extend(self.stage.way.iter().filter(|moment| moment.scan > last));
        self.stage.way = way;
        self
    }
}

/// The median of the middles, each coordinate by itself: single views that went wrong do not move it.
fn median(seen: &[Seen]) -> Point {
    let middle = |coordinate: fn(&Seen) -> f64| {
        let mut all: Vec<f64> = seen.iter().map(coordinate).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    Point::new(middle(|seen| seen.center.x), middle(|seen| seen.center.y))
}
