//! Visits whose arrivals somebody has marked in the log.

use crate::geometry::Point;
use crate::grid::GridError;
use crate::sensor::{LaserScan, LocalPose};
use crate::visit::follower::Follower;
use crate::visit::{Moment, Stage, Visit, VisitParameters};
use thiserror::Error;

/// The marks are put where the robot is this far from the middle of a place, metres, heading there.
const PLACE_RADIUS: f64 = 3.0;

/// Why marks could not be followed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ArrivalsError {
    /// An arrival not after the one before.
    #[error("arrival {arrival} is at scan {scan}, expected a later scan than the arrival before it")]
    Order {
        /// Arrival, counted from 0.
        arrival: usize,
        /// Its scan.
        scan: usize,
    },
    /// An arrival beyond the log.
    #[error("arrival {arrival} is at scan {scan}, expected one of the {scans} scans of the log, from 0")]
    Beyond {
        /// Arrival, counted from 0.
        arrival: usize,
        /// Its scan.
        scan: usize,
        /// Scans in the log.
        scans: usize,
    },
    /// The grid that the parameters ask for cannot be made.
    #[error(transparent)]
    Grid(#[from] GridError),
}

/// Takes scans one by one and gives a visit for each mark. The first mark is at a place; all others are ahead of one.
#[derive(Clone, Debug)]
pub struct AnnotatedVisits {
    follower: Follower,
    lag: f64,
    arrivals: Vec<usize>,
    /// Marks that have been passed.
    passed: usize,
    scans: usize,
    last_arrival: usize,
    stay: Option<Stay>,
}

/// The visit to the last mark passed.
#[derive(Clone, Debug)]
struct Stay {
    center: Point,
    way: Vec<Moment>,
    arrival: Moment,
    /// The first moment after it at which the robot was gone, if it has not come back since, and the visit as it was
    /// when the robot had driven on.
    departure: Option<Moment>,
    visit: Option<Visit>,
}

impl AnnotatedVisits {
    /// Marks as indices of scans, counted from 0.
    pub fn new(arrivals: Vec<usize>, parameters: &VisitParameters) -> Result<Self, ArrivalsError> {
        if let Some(late) = (1..arrivals.len()).find(|&k| arrivals[k - 1] >= arrivals[k]) {
            return Err(ArrivalsError::Order { arrival: late, scan: arrivals[late] });
        }
        Ok(AnnotatedVisits {
            follower: Follower::new(parameters)?,
            lag: parameters.lag,
            arrivals,
            passed: 0,
            scans: 0,
            last_arrival: 0,
            stay: None,
        })
    }

    /// Takes the next scan; gives the visit before, if the robot has come to the next mark.
    pub fn add(&mut self, scan: &LaserScan) -> Option<Stage> {
        let moment = self.follower.add(scan);
        self.go_on(moment)
    }

    /// As [`AnnotatedVisits::add`], with the pose that a [`ScanMatcher`](crate::sensor::ScanMatcher) gave to each scan.
    pub fn add_placed(&mut self, scan: &LaserScan, pose: &LocalPose) -> Option<Stage> {
        let moment = self.follower.add_placed(scan, pose);
        self.go_on(moment)
    }

    fn go_on(&mut self, moment: Moment) -> Option<Stage> {
        self.scans += 1;
        if self.arrivals.get(self.passed) != Some(&moment.scan) {
            self.stay_on(moment);
            return None;
        }
        let before = self.stay.take().and_then(|stay| self.end(stay, moment));
        let ahead = if self.passed == 0 { 0.0 } else { PLACE_RADIUS };
        let center = moment.local_from_robot.transform_point(&Point::new(ahead, 0.0));
        let way = Moment::between(self.follower.moments(), self.last_arrival, moment.scan).to_vec();
        self.follower.forget_before(&moment);
        self.stay = Some(Stay { center, way, arrival: moment, departure: None, visit: None });
        self.last_arrival = moment.scan;
        self.passed += 1;
        before
    }

    /// Where the robot was at the scan taken last.
    pub fn now(&self) -> Option<&Moment> {
        self.follower.moments().last()
    }

    /// The visit to the last mark passed, and what is wrong with the next one, if there is one.
    pub fn finish(mut self) -> (Option<Stage>, Option<ArrivalsError>) {
        let (arrival, scans) = (self.passed, self.scans);
        let beyond = |&scan: &usize| ArrivalsError::Beyond { arrival, scan, scans };
        let end = self.follower.moments().last().copied();
        let last = self.stay.take().zip(end).and_then(|(stay, end)| self.end(stay, end));
        (last, self.arrivals.get(arrival).map(beyond))
    }

    fn stay_on(&mut self, moment: Moment) {
        let Some(stay) = &mut self.stay else { return };
        let here = (moment.local_from_robot.position() - stay.center).norm() <= PLACE_RADIUS;
        // Until the next mark a robot that comes back has only looked around; after the last mark nothing tells.
        let returns = here && (stay.visit.is_none() || self.passed < self.arrivals.len());
        match stay.departure {
            _ if returns => (stay.departure, stay.visit) = (None, None),
            None => stay.departure = Some(moment),
            Some(departure) if stay.visit.is_none() && moment.driven >= departure.driven + self.lag => {
                stay.visit = visit(&self.follower, stay, departure);
            }
            Some(_) => {}
        }
    }

    fn end(&self, stay: Stay, now: Moment) -> Option<Stage> {
        let visit =
            stay.visit.clone().or_else(|| visit(&self.follower, &stay, stay.departure.unwrap_or(now)));
        visit.map(|visit| Stage { way: stay.way, visit })
    }
}

fn visit(follower: &Follower, stay: &Stay, departure: Moment) -> Option<Visit> {
    let Stay { center, arrival, .. } = *stay;
    let lpm = follower.lpm(&center, &arrival.local_from_robot)?;
    Some(Visit { center, lpm, arrival, departure })
}
