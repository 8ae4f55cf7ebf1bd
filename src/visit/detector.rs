//! Finds visits in a stream of scans.

use crate::geometry::{Point, Pose};
use crate::grid::GridError;
use crate::lpm::Lpm;
use crate::sensor::{LaserScan, LocalPose};
use crate::star::{PlaceDescription, describe};
use crate::visit::follower::Follower;
use crate::visit::recollection::Recollection;
use crate::visit::sighting::{Seen, Sighting, is_passage, look};
use crate::visit::stay::Stay;
use crate::visit::{Moment, Stage, VisitParameters};
use std::collections::VecDeque;

/// A robot that comes back to the place it left last, within so many metres and without another place on the way, has
/// not left it: it has looked around.
const LOOKS_AROUND: f64 = 60.0;

/// Takes scans one by one and gives visits, each when the robot has come to another place and no longer remembers the walls of
/// that one: until then it may learn that it passed a place on the way. Memory is bounded by the window, the visits on as much of the
/// way, and the way between two visits.
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
    /// Those before it, as far as they are not given away.
    recollection: Recollection,
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
    stay: Stay,
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
            recollection: Recollection::new(parameters),
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
            self.close(&group);
        }
        if let Some(last) = self.last.take() {
            self.recollection.add(last.stay, self.follower.moments());
        }
        certain.extend(self.recollection.finish(self.follower.moments()));
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
        closed.iter().for_each(|group| self.close(group));
        self.due()
    }

    /// The visits that are certain.
    fn due(&mut self) -> Vec<Stage> {
        let Some(last) = &self.last else { return Vec::new() };
        let due = self.recollection.due(&last.stay.visit.arrival, self.follower.moments());
        if let Some(told) = self.recollection.told() {
            self.follower.forget_before(&told.arrival);
        }
        due
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

    /// Decides whether a group was a visit.
    fn close(&mut self, group: &Group) {
        let Some(found) = self.settle(group) else { return };
        let Some(last) = self.last.take() else { return self.last = Some(found) };
        self.last = Some(if self.goes_on(&last.stay, &found.stay) {
            self.joined(last, found)
        } else if last.stay.is_over_before(&found.stay) {
            self.recollection.add(last.stay, self.follower.moments());
            found
        } else {
            // Two middles of one place: the one that was seen more often stays.
            let better = found.sightings > last.sightings && self.is_next(&found.stay);
            if better { found } else { last }
        });
    }

    /// Whether a stay is the one before, which goes on: the robot had only looked around.
    fn goes_on(&self, before: &Stay, stay: &Stay) -> bool {
        let apart = stay.inside[0].driven - before.inside[1].driven;
        self.parameters.is_one_place(&stay.visit.center, &before.visit.center) && apart <= LOOKS_AROUND
    }

    /// Whether a stay may come after all before the last one: they are over before it, and it is not the last of them.
    fn is_next(&self, stay: &Stay) -> bool {
        let may_follow = |before: &Stay| before.is_over_before(stay) && !self.goes_on(before, stay);
        self.recollection.before().is_none_or(may_follow)
    }

    /// One stay of two at the same place: as seen last, or else as seen first, whichever the robot passed through; or
    /// else one of the two alone. None if it may not come next.
    fn joined(&self, last: Found, found: Found) -> Found {
        let first = self.recollection.before().is_none();
        let sightings = last.sightings + found.sightings;
        let whole = [&found, &last].map(|seen| last.stay.prolonged(&found.stay, &seen.stay));
        let understood = |stay: &Stay| self.is_passed_through(stay, first) && self.is_next(stay);
        let joined = whole.into_iter().find(understood).map(|stay| Found { stay, sightings });
        joined.unwrap_or_else(|| if self.is_next(&found.stay) { found } else { last })
    }

    /// The visit that a group of sightings shows, if it is one: the robot was near, most of what it saw there agrees,
    /// and the place is one that the robot came into and left by its gateways.
    fn settle(&self, group: &Group) -> Option<Found> {
        let inside = group.near?;
        let sightings = self.agreeing(group, inside)?;
        let stay = self.seen_again(group, inside).or_else(|| self.seen(group, inside))?;
        Some(Found { stay, sightings })
    }

    /// A stay at a place as it was read before, as long as the walls are remembered that it was read by: scans are matched with
    /// them, so that this is one place. Where the robot did not pass through gateways that it had then, it is read anew.
    fn seen_again(&self, group: &Group, inside: [Moment; 2]) -> Option<Stay> {
        let VisitParameters { matching, agreement, perception, .. } = &self.parameters;
        let same = |known: &&Stay| (known.visit.center - group.center).norm() <= *agreement;
        let known = self.recollection.latest().filter(same);
        let mut known = known.filter(|known| known.is_remembered(&inside[0], matching.memory));
        known.find_map(|known| {
            let again = known.again(self.follower.moments(), inside, perception)?;
            self.is_passed_through(&again, self.last.is_none()).then_some(again)
        })
    }

    /// A stay at a place as it was seen over the whole of it.
    fn seen(&self, group: &Group, inside: [Moment; 2]) -> Option<Stay> {
        let at = |middle: &Point| Pose { x: middle.x, y: middle.y, ..inside[0].local_from_robot };
        let center = group.center + self.read(&group.center, &at(&group.center))?.1.center.coords;
        let (lpm, _) = self.read(&center, &at(&center))?;
        let stay = Stay::new(&center, &lpm, self.follower.moments(), inside, &self.parameters.perception)?;
        self.is_passed_through(&stay, self.last.is_none()).then_some(stay)
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
    fn is_passed_through(&self, stay: &Stay, first: bool) -> bool {
        let visit = &stay.visit;
        let Ok(place) = describe(&visit.lpm, &self.parameters.perception) else { return false };
        let now = self.follower.moments().last();
        let ended = self.over && now.is_none_or(|last| last.scan == visit.departure.scan);
        let left = stay.is_left(&place);
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

/// The median of the middles, each coordinate by itself: single views that went wrong do not move it.
fn median(seen: &[Seen]) -> Point {
    let middle = |coordinate: fn(&Seen) -> f64| {
        let mut all: Vec<f64> = seen.iter().map(coordinate).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    Point::new(middle(|seen| seen.center.x), middle(|seen| seen.center.y))
}
