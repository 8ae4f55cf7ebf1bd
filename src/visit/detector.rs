//! Finds visits in a stream of scans.

use crate::geometry::{Point, Pose};
use crate::grid::GridError;
use crate::lpm::Lpm;
use crate::sensor::LaserScan;
use crate::star::{PlaceDescription, describe};
use crate::visit::follower::Follower;
use crate::visit::passage::passages;
use crate::visit::sighting::{Seen, Sighting, is_passage, look};
use crate::visit::{Moment, Stage, Visit, VisitParameters};
use std::collections::VecDeque;

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
        })
    }

    /// Takes the next scan; gives the visits that are certain now.
    pub fn add(&mut self, scan: &LaserScan) -> Vec<Stage> {
        let moment = self.follower.add(scan);
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

    /// The visits that were still open when the log ended.
    pub fn finish(mut self) -> Vec<Stage> {
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
        let overlaps = found.stage.visit.arrival.driven < last.inside[1].driven;
        if same && apart <= LOOKS_AROUND {
            self.keep(last.prolonged(found));
            None
        } else if overlaps {
            // Two middles of one place: the one that was seen more often stays.
            self.keep(if found.sightings > last.sightings { found.instead_of(last) } else { last });
            None
        } else {
            self.keep(found);
            Some(last.stage)
        }
    }

    fn keep(&mut self, found: Found) {
        self.follower.forget_before(&found.stage.visit.arrival);
        self.last = Some(found);
    }

    /// The visit that a group of sightings shows, if it is one: the robot was near, most of what it saw there agrees,
    /// and the place as seen over the whole visit is one.
    fn settle(&self, group: &Group) -> Option<Found> {
        let inside = group.near?;
        let during = |s: &&Sighting| (inside[0].driven..=inside[1].driven).contains(&s.moment.driven);
        let agrees = |s: &Sighting| {
            s.place.is_some_and(|p| (p.center - group.center).norm() <= self.parameters.agreement)
        };
        let all = self.sightings.iter().filter(during).count();
        let sightings = self.sightings.iter().filter(during).filter(|s| agrees(s)).count();
        let long = sightings as f64 * self.parameters.spacing >= self.parameters.hysteresis;
        if !long || 2 * sightings < all {
            return None;
        }
        let at = |middle: &Point| Pose { x: middle.x, y: middle.y, ..inside[0].local_from_robot };
        let center = group.center + self.read(&group.center, &at(&group.center))?.1.center.coords;
        let (_, place) = self.read(&center, &at(&center))?;
        let scans = inside.map(|moment| moment.scan);
        let [arrival, departure] = passages(self.follower.moments(), scans, &center, &place.gateways)?;
        // What the trace will show must be the place that was found, seen from the arrival.
        let (lpm, _) = self.read(&center, &arrival.local_from_robot)?;
        let from = self.last.as_ref().map_or(0, |last| last.stage.visit.arrival.scan);
        let way = self.follower.between(from, arrival.scan).to_vec();
        let visit = Visit { center, lpm, arrival, departure };
        Some(Found { stage: Stage { way, visit }, inside, sightings })
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
    /// A stay that goes on: it began with this one and ended with the next, and is what was seen last.
    fn prolonged(self, next: Found) -> Found {
        let arrival = self.stage.visit.arrival;
        let mut visit = next.stage.visit;
        let at = arrival.local_from_robot;
        visit.lpm.robot_pose = Pose { x: at.x - visit.center.x, y: at.y - visit.center.y, ..at };
        visit.arrival = arrival;
        let inside = [self.inside[0], next.inside[1]];
        Found {
            stage: Stage { way: self.stage.way, visit },
            inside,
            sightings: self.sightings + next.sightings,
        }
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
