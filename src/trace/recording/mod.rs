//! From visits to a trace: an LPM at every arrival, and between them the turn and the travel that the poses show.

mod arrivals;

pub use arrivals::{Arrival, ArrivalsFileError};

use crate::geometry::Pose;
use crate::trace::event::{Event, EventKind, Observation, Percept, Travel, Turn, TurnTarget};
use crate::visit::{Moment, Stage, Visit, drift};

/// Points of the shape of a travel are this far apart, metres.
const SHAPE: f64 = 0.5;

/// Turns visits, as they become certain, into events.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    next: u64,
    last: Option<Visit>,
}

impl Recorder {
    /// The turn and the travel to a visit, and what was seen there.
    pub fn add(&mut self, stage: Stage) -> Vec<Event> {
        let mut kinds = Vec::new();
        if let Some(last) = &self.last {
            let target = TurnTarget::Heading(last.way_out());
            kinds.push(EventKind::Turn(Turn { target, angle: None }));
            kinds.push(EventKind::Travel(Box::new(travel(last, &stage.way))));
        }
        let percept = Percept::Lpm(stage.visit.lpm.clone());
        kinds.push(EventKind::Observation(Box::new(Observation { percept })));
        self.last = Some(stage.visit);
        let first = self.next;
        self.next += kinds.len() as u64;
        kinds.into_iter().zip(first..).map(|(kind, seq)| Event { seq, stamp: None, kind }).collect()
    }
}

/// The travel from a visit to the end of a way that began with its arrival. Where the robot was in the next place before it was
/// out of the last one, that is where it starts and ends. Its covariance is that of the whole way, as the place and the next
/// arrival are measured by the same poses.
fn travel(from: &Visit, way: &[Moment]) -> Travel {
    let left = way.last().filter(|arrival| arrival.scan < from.departure.scan).unwrap_or(&from.departure);
    let start = left.local_from_robot;
    let driven = &way[way.partition_point(|moment| moment.scan < left.scan)..];
    let seen = |moment: &Moment| start.inverse().compose(&moment.local_from_robot);
    let covariance = drift::covariance(way, &start);
    Travel {
        odometry: driven.last().map(seen),
        covariance: (!driven.is_empty()).then(|| std::array::from_fn(|k| covariance[(k / 3, k % 3)])),
        from_pose: Some(start.seen_from(&from.center)),
        shape: shape(driven.iter().map(seen)),
    }
}

/// Points of a trajectory, some way apart.
fn shape(poses: impl Iterator<Item = Pose>) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    for pose in poses {
        if points.last().is_none_or(|last| (pose.x - last[0]).hypot(pose.y - last[1]) >= SHAPE) {
            points.push([pose.x, pose.y]);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::sensor::LaserScan;
    use crate::sensor::log::LaserNumber;
    use crate::visit::{AnnotatedVisits, ArrivalsError, VisitParameters};
    use std::f64::consts::FRAC_PI_2;

    /// A drive of 20 m east and 20 m north in steps of 0.1 m that sees nothing but one post, so that odometry is all
    /// there is.
    fn drive() -> Vec<LaserScan> {
        let east = (0..=200).map(|k| Pose::new(0.1 * f64::from(k), 0.0, 0.0));
        let north = (0..=200).map(|k| Pose::new(20.0, 0.1 * f64::from(k), FRAC_PI_2));
        let scan = |(k, odom_from_robot)| LaserScan {
            stamp: k as f64,
            laser: LaserNumber::FRONT,
            odom_from_robot,
            robot_from_laser: Pose::IDENTITY,
            start_angle: 0.0,
            angle_increment: 0.1,
            ranges: vec![Some(2.0)],
        };
        east.chain(north).enumerate().map(scan).collect()
    }

    fn record(arrivals: &[usize]) -> Result<Vec<Event>, ArrivalsError> {
        let mut visits = AnnotatedVisits::new(arrivals.to_vec(), &VisitParameters::default())?;
        let mut stages: Vec<Stage> = drive().iter().filter_map(|scan| visits.add(scan)).collect();
        let (last, beyond) = visits.finish();
        stages.extend(last);
        beyond.map_or(Ok(()), Err)?;
        let mut recorder = Recorder::default();
        Ok(stages.into_iter().flat_map(|stage| recorder.add(stage)).collect())
    }

    #[test]
    fn a_bend_becomes_an_observation_a_turn_and_a_travel() {
        let events = record(&[0, 170, 371]).unwrap();
        assert!(events.iter().map(|event| event.seq).eq(0..7));
        let EventKind::Observation(seen) = &events[3].kind else { panic!("{:?}", events[3]) };
        let Percept::Lpm(lpm) = &seen.percept else { panic!("{seen:?}") };
        // The place is three metres ahead of the arrival: at the bend.
        assert!((lpm.robot_pose.x + 3.0).abs() < 1e-9 && lpm.robot_pose.y.abs() < 1e-9);
        let EventKind::Turn(Turn { target: TurnTarget::Heading(heading), .. }) = events[4].kind else {
            panic!()
        };
        assert!((heading - FRAC_PI_2).abs() < 1e-6, "{heading}");
        let EventKind::Travel(travel) = &events[5].kind else { panic!() };
        let way = travel.odometry.unwrap();
        // It left the place 3.1 m north of the bend, and arrived 17 m north of it.
        assert!((way.x - 13.9).abs() < 1e-6 && way.y.abs() < 1e-6 && way.theta.abs() < 1e-9, "{way:?}");
        assert!((travel.from_pose.unwrap().y - 3.1).abs() < 1e-6);
        let trail = travel.trail(&Pose::new(1.0, 2.0, 0.0));
        assert_eq!(trail.last().copied(), Some(Point::new(1.0, 2.0)));
        assert!(trail.iter().all(|point| (point.y - 2.0).abs() < 1e-6 && point.x <= 1.0 + 1e-6));
    }

    #[test]
    fn arrivals_must_come_in_order_and_lie_in_the_log() {
        let refused = |scans: &[usize]| record(scans).unwrap_err().to_string();
        assert!(refused(&[5, 5]).starts_with("arrival 1 is at scan 5"));
        assert!(refused(&[402]).starts_with("arrival 0 is at scan 402"));
        assert_eq!(record(&[]), Ok(Vec::new()));
    }
}
