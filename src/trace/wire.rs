//! The JSON form of an event: one flat object, unknown fields refused.
//!
//! The types here are the wire contract of the trace format and of `POST /v1/maps/{map}/events`; what an object
//! may hold depends on its `kind`, and [`WireEvent::into_event`] says what is missing or out of place by JSON
//! pointer.

use crate::geometry::Pose;
use crate::grid::occupancy::FARTHEST;
use crate::star::SlotIndex;
use crate::trace::event::{
    Assert, Event, EventKind, Observation, Percept, Stamp, Travel, Turn, TurnDescription, TurnTarget,
};
use crate::trace::event_error::EventError;
use crate::trace::object;
use crate::trace::wire_grid::{WireLpm, check_points};
use crate::trace::wire_star::WireStar;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// One event of a trace. `kind` says which of the other fields apply.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Event)]
#[serde(deny_unknown_fields)]
pub struct WireEvent {
    /// Position in the trace, counted from 0 without gaps; the idempotency key.
    pub seq: u64,
    /// What happened.
    pub kind: WireKind,
    /// When it happened.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub stamp: Option<WireStamp>,
    /// observation: the star description, with `dstate`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub star: Option<WireStar>,
    /// observation: the slot of `star` the robot is at after the event.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dstate: Option<u64>,
    /// observation: the name of a view in place of `star` and `dstate`; a trace holds views throughout or nowhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// observation: a local perceptual model in place of `star` and `dstate`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub lpm: Option<WireLpm>,
    /// observation: the robot's pose in the frame of the observation on arrival.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub robot_pose: Option<WirePose>,
    /// turn: the slot of the latest star that the robot faces now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<u64>,
    /// turn: the description of the turn, in a trace of views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<WireTurn>,
    /// turn: the direction the robot faces now, radians, in the frame of the latest LPM.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading: Option<f64>,
    /// turn: how far the robot turned, radians, counter-clockwise positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// travel: the displacement over the travel in the robot's frame at its start.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub odometry: Option<WirePose>,
    /// travel: covariance of the displacement, 9 numbers, row-major x, y, theta.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<f64>>,
    /// travel: pose in the frame of the last observation when the travel started.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub from_pose: Option<WirePose>,
    /// travel: the way it went, points in the frame of `odometry`, straight in between. Where it is told, and odometry has a
    /// covariance, `apart` takes it that path segments meet at places alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Vec<[f64; 2]>>,
    /// assert: two observations, counted from 0, already made and different.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visits: Option<[usize; 2]>,
    /// assert: whether they are to one place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same: Option<bool>,
    /// retract: the `seq` of the assert that is taken back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assert: Option<u64>,
}

/// The kinds of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = EventKind)]
#[serde(rename_all = "lowercase")]
pub enum WireKind {
    /// What was seen at a place.
    Observation,
    /// A turn within a place.
    Turn,
    /// A travel along a path.
    Travel,
    /// An operator's word: two visits are, or are not, to one place.
    Assert,
    /// An operator's word taken back.
    Retract,
}

/// How a turn is described in a trace of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = TurnDescription)]
#[serde(rename_all = "lowercase")]
pub enum WireTurn {
    /// To the left, onto another path.
    Left,
    /// To the right, onto another path.
    Right,
    /// To the other direction of the same path.
    Around,
}

/// A time as ROS spells it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Stamp)]
#[serde(deny_unknown_fields)]
pub struct WireStamp {
    /// Whole seconds.
    pub sec: i64,
    /// Nanoseconds within the second.
    #[serde(alias = "nsec")]
    #[schema(maximum = 999_999_999)]
    pub nanosec: u32,
}

/// A pose or displacement: metres and radians.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = Pose)]
#[serde(deny_unknown_fields)]
pub struct WirePose {
    /// Metres along the first axis.
    pub x: f64,
    /// Metres along the second axis.
    pub y: f64,
    /// Radians, counter-clockwise positive.
    pub theta: f64,
}

impl WireEvent {
    /// The event, or what is wrong with it.
    pub fn into_event(self) -> Result<Event, EventError> {
        let stamp = self.stamp.map(stamp).transpose()?;
        self.refuse_misplaced()?;
        let seq = self.seq;
        let kind = match self.kind {
            WireKind::Observation => EventKind::Observation(Box::new(self.observation()?)),
            WireKind::Turn => EventKind::Turn(self.turn()?),
            WireKind::Travel => EventKind::Travel(Box::new(self.travel()?)),
            WireKind::Assert => EventKind::Assert(self.assert()?),
            WireKind::Retract => EventKind::Retract { assert: self.retract()? },
        };
        Ok(Event { seq, stamp, kind })
    }

    /// The JSON form of an event. Grids are written as base64 bytes.
    pub fn from_event(event: &Event) -> WireEvent {
        let stamp = event.stamp.map(|s| WireStamp { sec: s.sec, nanosec: s.nanosec });
        let mut wire = WireEvent { stamp, ..WireEvent::empty(event.seq) };
        match &event.kind {
            EventKind::Observation(observation) => wire.put_observation(observation),
            EventKind::Turn(turn) => wire.put_turn(turn),
            EventKind::Travel(travel) => wire.put_travel(travel),
            EventKind::Assert(Assert { visits, same }) => {
                wire.kind = WireKind::Assert;
                (wire.visits, wire.same) = (Some(*visits), Some(*same));
            }
            EventKind::Retract { assert } => {
                wire.kind = WireKind::Retract;
                wire.assert = Some(*assert);
            }
        }
        wire
    }

    fn empty(seq: u64) -> WireEvent {
        WireEvent {
            seq,
            kind: WireKind::Observation,
            stamp: None,
            star: None,
            dstate: None,
            view: None,
            lpm: None,
            robot_pose: None,
            to: None,
            turn: None,
            heading: None,
            angle: None,
            odometry: None,
            covariance: None,
            from_pose: None,
            shape: None,
            visits: None,
            same: None,
            assert: None,
        }
    }

    fn refuse_misplaced(&self) -> Result<(), EventError> {
        use WireKind::{Assert, Observation, Retract, Travel, Turn};
        let fields = [
            ("star", self.star.is_some(), Observation),
            ("dstate", self.dstate.is_some(), Observation),
            ("view", self.view.is_some(), Observation),
            ("lpm", self.lpm.is_some(), Observation),
            ("robot_pose", self.robot_pose.is_some(), Observation),
            ("to", self.to.is_some(), Turn),
            ("turn", self.turn.is_some(), Turn),
            ("heading", self.heading.is_some(), Turn),
            ("angle", self.angle.is_some(), Turn),
            ("odometry", self.odometry.is_some(), Travel),
            ("covariance", self.covariance.is_some(), Travel),
            ("from_pose", self.from_pose.is_some(), Travel),
            ("shape", self.shape.is_some(), Travel),
            ("visits", self.visits.is_some(), Assert),
            ("same", self.same.is_some(), Assert),
            ("assert", self.assert.is_some(), Retract),
        ];
        let misplaced = fields.iter().find(|(_, given, kind)| *given && *kind != self.kind);
        misplaced.map_or(Ok(()), |(field, _, kind)| {
            let (kind, here) =
                (format!("{kind:?}").to_lowercase(), format!("{:?}", self.kind).to_lowercase());
            Err(EventError::new(
                format!("/{field}"),
                format!("belongs to events of kind {kind}, but this one is of kind {here}; leave it out"),
            ))
        })
    }

    fn observation(self) -> Result<Observation, EventError> {
        if let Some(view) = self.view {
            let others = [
                ("star", self.star.is_some()),
                ("dstate", self.dstate.is_some()),
                ("lpm", self.lpm.is_some()),
                ("robot_pose", self.robot_pose.is_some()),
            ];
            return view_alone(view, &others);
        }
        let robot_pose = self.robot_pose.map(WirePose::pose);
        let percept = match (self.star, self.lpm) {
            (Some(star), None) => {
                let Some(dstate) = self.dstate else {
                    return Err(EventError::new(
                        "/dstate",
                        "is missing, expected the slot of the star that the robot is at, counted from 0",
                    ));
                };
                let star = star.star()?;
                let dstate = slot_index(dstate, star.slots().len(), "/dstate")?;
                Percept::Star { star, dstate, robot_pose }
            }
            (None, Some(_)) if self.dstate.is_some() => {
                return Err(EventError::new(
                    "/dstate",
                    "belongs to a star; for an lpm it follows from robot_pose, leave it out",
                ));
            }
            (None, Some(lpm)) => Percept::Lpm(lpm.lpm(robot_pose.unwrap_or(Pose::IDENTITY), "/lpm")?),
            (Some(_), Some(_)) => {
                return Err(EventError::new("/lpm", "stands beside a star, expected one of the two"));
            }
            (None, None) => {
                return Err(EventError::new(
                    "",
                    "an observation needs a star (with dstate), an lpm or a view",
                ));
            }
        };
        Ok(Observation { percept })
    }

    fn turn(self) -> Result<Turn, EventError> {
        if let Some(turn) = self.turn {
            let beside = [("/to", self.to.is_some()), ("/heading", self.heading.is_some())];
            return match beside.iter().find(|(_, given)| *given) {
                Some((field, _)) => {
                    Err(EventError::new(*field, "stands beside turn, expected one of the two"))
                }
                None => Ok(Turn { target: TurnTarget::Described(turn.into()), angle: self.angle }),
            };
        }
        match (self.to, self.heading, self.angle) {
            (Some(_), Some(_), _) => {
                Err(EventError::new("/heading", "stands beside to, expected one of the two"))
            }
            (None, Some(_), Some(_)) => {
                Err(EventError::new("/angle", "stands beside heading, expected one of the two"))
            }
            (Some(to), None, angle) => {
                let slot = slot_index(to, crate::star::MAX_SLOTS, "/to")?;
                Ok(Turn { target: TurnTarget::Slot(slot), angle })
            }
            (None, Some(heading), None) => Ok(Turn { target: TurnTarget::Heading(heading), angle: None }),
            (None, None, Some(angle)) => Ok(Turn { target: TurnTarget::Angle(angle), angle: Some(angle) }),
            (None, None, None) => {
                let message =
                    "a turn needs to (a slot), heading or angle (radians), in a trace of views turn";
                Err(EventError::new("", message))
            }
        }
    }

    fn travel(self) -> Result<Travel, EventError> {
        let covariance = self.covariance.map(|numbers| covariance(&numbers)).transpose()?;
        if covariance.is_some() && self.odometry.is_none() {
            return Err(EventError::new(
                "/covariance",
                "stands without the odometry it belongs to; add odometry or leave it out",
            ));
        }
        let odometry = self.odometry.map(WirePose::pose);
        if odometry.is_some_and(|pose| pose.x.abs().max(pose.y.abs()) > FARTHEST) {
            return Err(EventError::new("/odometry", "leads more than 10000 km off, expected metres"));
        }
        let shape = self.shape.unwrap_or_default();
        check_points(shape.len(), "/shape")?;
        Ok(Travel { odometry, covariance, from_pose: self.from_pose.map(WirePose::pose), shape })
    }

    fn assert(&self) -> Result<Assert, EventError> {
        let missing =
            |field: &str, expected: &str| EventError::new(field, format!("is missing, expected {expected}"));
        let visits =
            self.visits.ok_or_else(|| missing("/visits", "two observations, counted from 0: [0, 8]"))?;
        let same = self.same.ok_or_else(|| missing("/same", "true or false"))?;
        Ok(Assert { visits, same })
    }

    fn retract(&self) -> Result<u64, EventError> {
        let missing = "is missing, expected the seq of the assert to take back";
        self.assert.ok_or_else(|| EventError::new("/assert", missing))
    }

    fn put_observation(&mut self, observation: &Observation) {
        match &observation.percept {
            Percept::Star { star, dstate, robot_pose } => {
                self.star = Some(WireStar::from_star(star));
                self.dstate = Some(dstate.0.into());
                self.robot_pose = robot_pose.as_ref().map(WirePose::from_pose);
            }
            Percept::View(view) => self.view = Some(view.clone()),
            Percept::Lpm(lpm) => {
                self.lpm = Some(WireLpm::from_lpm(lpm));
                self.robot_pose = Some(WirePose::from_pose(&lpm.robot_pose));
            }
        }
    }

    fn put_turn(&mut self, turn: &Turn) {
        self.kind = WireKind::Turn;
        match turn.target {
            TurnTarget::Slot(slot) => (self.to, self.angle) = (Some(slot.0.into()), turn.angle),
            TurnTarget::Heading(heading) => self.heading = Some(heading),
            TurnTarget::Angle(angle) => self.angle = Some(angle),
            TurnTarget::Described(described) => {
                (self.turn, self.angle) = (Some(described.into()), turn.angle);
            }
        }
    }

    fn put_travel(&mut self, travel: &Travel) {
        self.kind = WireKind::Travel;
        self.odometry = travel.odometry.as_ref().map(WirePose::from_pose);
        self.covariance = travel.covariance.map(|c| c.to_vec());
        self.from_pose = travel.from_pose.as_ref().map(WirePose::from_pose);
        self.shape = (!travel.shape.is_empty()).then(|| travel.shape.clone());
    }
}

impl WirePose {
    /// The pose.
    pub fn pose(self) -> Pose {
        Pose::new(self.x, self.y, self.theta)
    }

    /// The JSON form of a pose.
    pub fn from_pose(pose: &Pose) -> WirePose {
        WirePose { x: pose.x, y: pose.y, theta: pose.theta }
    }
}

impl From<WireTurn> for TurnDescription {
    fn from(wire: WireTurn) -> TurnDescription {
        match wire {
            WireTurn::Left => TurnDescription::Left,
            WireTurn::Right => TurnDescription::Right,
            WireTurn::Around => TurnDescription::Around,
        }
    }
}

impl From<TurnDescription> for WireTurn {
    fn from(turn: TurnDescription) -> WireTurn {
        match turn {
            TurnDescription::Left => WireTurn::Left,
            TurnDescription::Right => WireTurn::Right,
            TurnDescription::Around => WireTurn::Around,
        }
    }
}

/// A view, which stands beside none of the other fields of an observation.
fn view_alone(view: String, others: &[(&str, bool)]) -> Result<Observation, EventError> {
    if let Some((field, _)) = others.iter().find(|(_, given)| *given) {
        let message = "stands beside a view, which says all there is; leave one of the two out";
        return Err(EventError::new(format!("/{field}"), message));
    }
    if view.is_empty() {
        return Err(EventError::new("/view", "is empty, expected the name of what the robot sees"));
    }
    Ok(Observation { percept: Percept::View(view) })
}

fn stamp(wire: WireStamp) -> Result<Stamp, EventError> {
    if wire.nanosec >= 1_000_000_000 {
        return Err(EventError::new("/stamp/nanosec", "is a second or more, expected 0 to 999999999"));
    }
    Ok(Stamp { sec: wire.sec, nanosec: wire.nanosec })
}

fn slot_index(given: u64, slots: usize, pointer: &str) -> Result<SlotIndex, EventError> {
    if given < slots as u64 {
        // The star's own bound keeps `slots` within a byte.
        return Ok(SlotIndex(given as u8));
    }
    Err(EventError::new(pointer, format!("is {given}, expected a slot from 0 to {}", slots - 1)))
}

fn covariance(numbers: &[f64]) -> Result<[f64; 9], EventError> {
    let wrong = |message: &str| EventError::new("/covariance", message);
    let nine: [f64; 9] = numbers
        .try_into()
        .map_err(|_| wrong(&format!("has {} numbers, expected 9, row-major x, y, theta", numbers.len())))?;
    let matrix = nalgebra::Matrix3::from_row_slice(&nine);
    let scale = matrix.amax().max(f64::MIN_POSITIVE);
    if (matrix - matrix.transpose()).amax() > 1e-9 * scale {
        return Err(wrong("is not symmetric, expected entry (i, j) equal to entry (j, i)"));
    }
    if matrix.symmetric_eigenvalues().min() < -1e-9 * scale {
        return Err(wrong("has a negative eigenvalue, expected a positive semi-definite matrix"));
    }
    Ok(nine)
}
