//! The grammar of a trace, and the step from grids and headings to stars and slots.
//!
//! An [`Experience`] is a state machine without I/O: it takes the events of a trace one by one, refuses what may
//! not come next without changing, and gives for every observation what the logic needs: the star, the slot the
//! robot came in on, and the slot it had left the previous place by.

use crate::geometry::{Point, Pose, wrap_angle};
use crate::lpm::Lpm;
use crate::star::{SlotIndex, SmallScaleStar};
use crate::trace::event::{Assert, Event, EventKind, Observation, Percept, Travel, Turn, TurnTarget};
use crate::trace::experience_error::ExperienceError;
use crate::trace::sighting::{Described, Motion, Sighting};
use crate::trace::views::ViewExperience;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_3;

/// How far a heading may be from the outward direction of the gateway it means, radians.
pub const HEADING_TOLERANCE: f64 = FRAC_PI_3;

/// Reads star and arrival slot off an LPM; the flag says that it is the first observation.
pub type Describe<'a> = &'a dyn Fn(&Lpm, bool) -> Result<Described, ExperienceError>;

/// Where a trace stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Experience {
    next_seq: u64,
    phase: Phase,
    observations: usize,
    /// The `seq` of each assert in force.
    asserts: BTreeSet<u64>,
}

#[derive(Clone, Debug, Default, PartialEq)]
enum Phase {
    #[default]
    Start,
    Place(Here),
    /// Left by a slot, `None` where grids are not looked into, and on the way.
    Travelling(Option<SlotIndex>, Box<Travel>, Option<Motion>),
    /// In a trace of views, which only [`Experience::check`] takes.
    Views(ViewExperience),
}

#[derive(Clone, Debug, PartialEq)]
struct Here {
    /// The star and the slot faced; `None` where grids are not looked into.
    facing: Option<(SmallScaleStar, SlotIndex)>,
    /// Direction in the frame of the observation, where it has one.
    heading: Option<f64>,
    /// Where the robot was on arrival in that frame.
    position: Point,
}

impl Experience {
    /// An experience before its first event.
    pub fn new() -> Self {
        Experience::default()
    }

    /// The `seq` that the next event must carry.
    pub fn next_seq(&self) -> u64 {
        self.next_seq
    }

    /// Takes an event; on an error nothing has changed. Gives what the logic needs for an observation, nothing
    /// for a turn or a travel.
    pub fn accept(&mut self, event: &Event, describe: Describe) -> Result<Option<Sighting>, ExperienceError> {
        self.advance(event, Some(describe))
    }

    /// Takes an event without looking into grids: order, numbers and the slots of bare stars are checked.
    pub fn check(&mut self, event: &Event) -> Result<(), ExperienceError> {
        self.advance(event, None).map(|_| ())
    }

    fn advance(
        &mut self,
        event: &Event,
        describe: Option<Describe>,
    ) -> Result<Option<Sighting>, ExperienceError> {
        if event.seq != self.next_seq {
            return Err(ExperienceError::Sequence { expected: self.next_seq, found: event.seq });
        }
        if let Some(views) = self.views(event, describe.is_some())? {
            self.phase = Phase::Views(views);
            self.next_seq += 1;
            return Ok(None);
        }
        match &event.kind {
            EventKind::Assert(assert) => {
                self.check_assert(assert)?;
                self.asserts.insert(event.seq);
            }
            EventKind::Retract { assert } => self.retract(*assert)?,
            acted => {
                let (phase, sighting) = self.next_phase(acted, describe)?;
                self.phase = phase;
                self.observations += usize::from(matches!(acted, EventKind::Observation(_)));
                self.next_seq += 1;
                return Ok(sighting);
            }
        }
        self.next_seq += 1;
        Ok(None)
    }

    /// Where a trace of views leads, if this is one or becomes one by its first event; `explained` says that views
    /// are of no use.
    fn views(&self, event: &Event, explained: bool) -> Result<Option<ViewExperience>, ExperienceError> {
        match (&self.phase, &event.kind) {
            (Phase::Views(views), _) => views.after(event).map(Some),
            (Phase::Start, EventKind::Observation(seen)) if matches!(seen.percept, Percept::View(_)) => {
                if explained {
                    Err(ExperienceError::ViewRefused)
                } else {
                    ViewExperience::new().after(event).map(Some)
                }
            }
            _ => Ok(None),
        }
    }

    /// Where what the robot saw or did leads.
    fn next_phase(
        &self,
        kind: &EventKind,
        describe: Option<Describe>,
    ) -> Result<(Phase, Option<Sighting>), ExperienceError> {
        Ok(match (kind, &self.phase) {
            (EventKind::Observation(seen), Phase::Start) => observe(seen, None, None, None, describe)?,
            (EventKind::Observation(seen), Phase::Travelling(departure, travel, motion)) => {
                observe(seen, *departure, Some(travel), motion.clone(), describe)?
            }
            (EventKind::Turn(turn), Phase::Place(here)) => (Phase::Place(here.turned(turn)?), None),
            (EventKind::Travel(travel), Phase::Place(here)) => {
                (Phase::Travelling(here.departure()?, travel.clone(), here.motion(travel)), None)
            }
            (found, phase) => return Err(out_of_order(found, phase)),
        })
    }

    fn check_assert(&self, assert: &Assert) -> Result<(), ExperienceError> {
        let observations = self.observations;
        let unseen = assert.visits.iter().position(|&visit| visit >= observations);
        if let Some(position) = unseen {
            let found = assert.visits[position];
            return Err(ExperienceError::NotSeen { position, found, observations });
        }
        match assert.visits {
            [a, b] if a == b => Err(ExperienceError::OneVisit(a)),
            _ => Ok(()),
        }
    }

    fn retract(&mut self, assert: u64) -> Result<(), ExperienceError> {
        if self.asserts.remove(&assert) {
            return Ok(());
        }
        let in_force: Vec<String> = self.asserts.iter().map(u64::to_string).collect();
        let in_force = if in_force.is_empty() { "there is none".into() } else { in_force.join(", ") };
        Err(ExperienceError::NotInForce { found: assert, in_force })
    }
}

impl Here {
    fn turned(&self, turn: &Turn) -> Result<Here, ExperienceError> {
        let Some((star, _)) = &self.facing else {
            return match turn.target {
                TurnTarget::Described(_) => Err(views_in_stars("/turn")),
                _ => Ok(self.clone()),
            };
        };
        let (slot, heading) = match turn.target {
            TurnTarget::Slot(slot) => {
                let Some(target) = star.slot(slot) else {
                    let last = star.slots().len() as u8 - 1;
                    return Err(ExperienceError::TurnOutOfRange { found: slot.0, last });
                };
                let turned = self.heading.zip(turn.angle).map(|(heading, angle)| wrap_angle(heading + angle));
                (slot, turned.or(target.bearing))
            }
            TurnTarget::Heading(heading) => (slot_towards(star, heading)?, Some(heading)),
            TurnTarget::Angle(angle) => {
                let heading = self.heading.ok_or(ExperienceError::NoBearings)? + angle;
                (slot_towards(star, heading)?, Some(wrap_angle(heading)))
            }
            TurnTarget::Described(_) => return Err(views_in_stars("/turn")),
        };
        Ok(Here { facing: Some((star.clone(), slot)), heading, position: self.position })
    }

    /// What was measured of a travel from here.
    fn motion(&self, travel: &Travel) -> Option<Motion> {
        let (odometry, covariance) = travel.odometry.zip(travel.covariance)?;
        let given = travel.from_pose;
        Some(Motion {
            start: given.map_or(self.position, |pose| pose.position()),
            heading: given.map(|pose| pose.theta).or(self.heading),
            start_given: given.is_some(),
            odometry,
            covariance,
            shape: way(travel, &odometry),
        })
    }

    fn departure(&self) -> Result<Option<SlotIndex>, ExperienceError> {
        let Some((star, slot)) = &self.facing else {
            return Ok(None);
        };
        let outward = star.slot(*slot).is_some_and(|s| s.outward.is_some());
        if outward { Ok(Some(*slot)) } else { Err(ExperienceError::TravelNotOutward(slot.0)) }
    }
}

/// The way that a travel went, in the frame of its odometry, from its beginning to its end; empty where it was not told.
fn way(travel: &Travel, odometry: &Pose) -> Vec<Point> {
    let told = travel.trail(odometry);
    if told.is_empty() { told } else { [Point::origin()].into_iter().chain(told).collect() }
}

/// The outward slot whose bearing is nearest to a heading, within [`HEADING_TOLERANCE`].
fn slot_towards(star: &SmallScaleStar, heading: f64) -> Result<SlotIndex, ExperienceError> {
    let outward = star.indices().zip(star.slots()).filter(|(_, slot)| slot.outward.is_some());
    let off = outward.filter_map(|(index, slot)| Some((index, wrap_angle(slot.bearing? - heading).abs())));
    let nearest = off.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or(ExperienceError::NoBearings)?;
    if nearest.1 > HEADING_TOLERANCE {
        return Err(ExperienceError::NoGatewayThere(format!("{:.2}", wrap_angle(heading))));
    }
    Ok(nearest.0)
}

fn observe(
    seen: &Observation,
    departure: Option<SlotIndex>,
    travel: Option<&Travel>,
    motion: Option<Motion>,
    describe: Option<Describe>,
) -> Result<(Phase, Option<Sighting>), ExperienceError> {
    let (described, robot_pose) = match (&seen.percept, describe) {
        (Percept::Star { star, dstate, robot_pose }, _) => {
            // The frame of a bare star is the robot's pose on arrival.
            let described = Described { star: star.clone(), arrival: *dstate, middle: Point::origin() };
            (described, robot_pose.unwrap_or(Pose::IDENTITY))
        }
        (Percept::Lpm(lpm), Some(describe)) => {
            let lpm = lpm.clone().reached_by(travel.map(|travel| travel.trail(&lpm.robot_pose)));
            (describe(&lpm, travel.is_none())?, lpm.robot_pose)
        }
        (Percept::Lpm(lpm), None) => {
            let position = lpm.robot_pose.position();
            return Ok((Phase::Place(Here { facing: None, heading: None, position }), None));
        }
        (Percept::View(_), _) => return Err(views_in_stars("/view")),
    };
    let Described { star, arrival, middle } = described;
    if travel.is_some() && star.slot(arrival).is_none_or(|slot| slot.inward.is_none()) {
        return Err(ExperienceError::ArrivalNotInward(arrival.0));
    }
    let here = Here {
        facing: Some((star.clone(), arrival)),
        heading: Some(robot_pose.theta),
        position: robot_pose.position(),
    };
    let sighting = Sighting { star, arrival, departure, middle, robot_pose, motion };
    Ok((Phase::Place(here), Some(sighting)))
}

fn views_in_stars(pointer: &'static str) -> ExperienceError {
    ExperienceError::Mixed { pointer, found: "views", expected: "stars" }
}

fn out_of_order(found: &EventKind, phase: &Phase) -> ExperienceError {
    let found = found.name();
    let expected = match phase {
        Phase::Start => "an observation first",
        Phase::Place(_) => "a turn or a travel after an observation",
        Phase::Travelling(..) => "the observation at the end of the travel",
        Phase::Views(_) => "an event of a trace of views",
    };
    ExperienceError::Order { found, expected }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::ndjson::{parse_event, read_trace};

    const STAR: &str = r#""star":{"slots":[{"fragment":1,"direction":"+","out":null,"in":2,"control":"dead_end"},{"fragment":1,"direction":"-","out":2,"in":null,"control":"midline"}]}"#;

    fn fault(lines: &[&str]) -> (usize, String) {
        let (events, error) = read_trace(lines.join("\n").as_bytes());
        (events.len(), error.map_or_else(String::new, |e| e.to_string()))
    }

    #[test]
    fn the_first_fault_names_line_and_pointer_and_keeps_what_came_before() {
        let first = format!(r#"{{"seq":0,"kind":"observation",{STAR},"dstate":0}}"#);
        let cases: [(&str, &str); 22] = [
            (r#"{"seq":2,"kind":"travel"}"#, "line 2: /seq is 2, expected 1"),
            (r#"{"seq":1,"kind":"travel"}"#, "line 2: leaves by slot 0, which has no outward gateway"),
            (
                r#"{"seq":1,"kind":"turn","to":2}"#,
                "line 2: /to is 2, expected a slot of the latest star, 0 to 1",
            ),
            (r#"{"seq":1,"kind":"turn","angle":1.0}"#, "line 2: turns in radians, but the latest star"),
            (r#"{"seq":1,"kind":"turn","to":1,"speed":3}"#, "line 2: /speed unknown field `speed`"),
            (
                r#"{"seq":1,"kind":"turn","odometry":{"x":0,"y":0,"theta":0}}"#,
                "line 2: /odometry belongs to events of kind travel",
            ),
            (r#"{"seq":1,"kind":"turn"}"#, "line 2: a turn needs to"),
            (
                r#"{"seq":1,"kind":"travel","odometry":[1,2,3]}"#,
                "line 2: /odometry invalid type: sequence, expected an object",
            ),
            (
                r#"{"seq":1,"kind":"travel","odometry":{"x":0,"y":-1e300,"theta":0}}"#,
                "line 2: /odometry leads more than 10000 km off, expected metres",
            ),
            (
                r#"{"seq":1,"kind":"travel","odometry":{"x":1,"y":0,"theta":0},"covariance":[1,0,0,0,-1,0,0,0,1]}"#,
                "line 2: /covariance has a negative eigenvalue",
            ),
            (
                r#"{"seq":1,"kind":"travel","odometry":{"x":1,"y":0,"theta":0},"covariance":[1,1,0,0,1,0,0,0,1]}"#,
                "line 2: /covariance is not symmetric",
            ),
            (
                r#"{"seq":1,"kind":"travel","odometry":{"x":1,"y":0,"theta":0},"covariance":[1,1]}"#,
                "line 2: /covariance has 2 numbers, expected 9",
            ),
            (
                r#"{"seq":1,"kind":"assert","visits":[0,1],"same":true}"#,
                "line 2: /visits/1 is 1, but 1 observations have been made",
            ),
            (
                r#"{"seq":1,"kind":"assert","visits":[0,0],"same":true}"#,
                "line 2: /visits names observation 0 twice",
            ),
            (r#"{"seq":1,"kind":"assert","visits":[0,-1],"same":true}"#, "line 2: /visits"),
            (r#"{"seq":1,"kind":"assert","same":true}"#, "line 2: /visits is missing"),
            (r#"{"seq":1,"kind":"assert","visits":[0,1]}"#, "line 2: /same is missing"),
            (r#"{"seq":1,"kind":"retract"}"#, "line 2: /assert is missing"),
            (
                r#"{"seq":1,"kind":"retract","assert":0}"#,
                "line 2: /assert is 0, expected the seq of an assert in force: there is none",
            ),
            (r#"{"seq":1,"kind":"turn","same":true}"#, "line 2: /same belongs to events of kind assert"),
            (r#"[1,"travel"]"#, "line 2: is no JSON object"),
            (r#"{"seq":1,"#, "line 2: "),
        ];
        for (line, expected) in cases {
            let (kept, error) = fault(&[&first, line]);
            assert_eq!(kept, 1);
            assert!(error.starts_with(expected), "{error}");
        }
        let (_, error) = fault(&[&first.replace("\"in\":2", "\"in\":3")]);
        assert!(error.starts_with("line 1: /star/slots slot 0 has inward gateway 3, expected 2"), "{error}");
        let (_, error) = fault(&[&first.replace("\"dead_end\"", "\"stop\"")]);
        assert!(error.starts_with("line 1: /star/slots/0/control unknown variant `stop`"), "{error}");
    }

    #[test]
    fn the_arrival_slot_must_have_an_inward_gateway() {
        let line = |seq: u64, rest: &str| format!(r#"{{"seq":{seq},"kind":{rest}}}"#);
        let lines = [
            line(0, &format!(r#""observation",{STAR},"dstate":1"#)),
            line(1, r#""travel""#),
            line(2, &format!(r#""observation",{STAR},"dstate":1"#)),
        ];
        let (kept, error) = fault(&[&lines[0], &lines[1], &lines[2]]);
        assert_eq!(kept, 2);
        assert!(error.starts_with("line 3: /dstate is 1, a slot without an inward gateway"), "{error}");
    }

    #[test]
    fn a_refused_event_leaves_the_experience_as_it_was() {
        let mut experience = Experience::new();
        let travel = parse_event(r#"{"seq":0,"kind":"travel"}"#).unwrap();
        assert!(experience.check(&travel).is_err());
        assert_eq!(experience, Experience::new());
    }
}
