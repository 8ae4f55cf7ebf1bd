//! The events of a trace as plain values.

use crate::geometry::{Point, Pose};
use crate::lpm::Lpm;
use crate::star::{SlotIndex, SmallScaleStar};

/// One line of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Position in the trace, counted from 0 without gaps; the idempotency key.
    pub seq: u64,
    /// When it happened, if the robot said so. Order is `seq`, never the stamp.
    pub stamp: Option<Stamp>,
    /// What happened.
    pub kind: EventKind,
}

/// A time as ROS spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i64,
    /// Nanoseconds within the second, below 1,000,000,000.
    pub nanosec: u32,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// The robot is at a place and has seen its neighbourhood.
    Observation(Box<Observation>),
    /// The robot turned within the place.
    Turn(Turn),
    /// The robot left through a gateway and followed a path to the next place.
    Travel(Box<Travel>),
    /// An operator said of two visits that they are, or are not, to one place. Comes anywhere after them.
    Assert(Assert),
    /// An operator took back what was said. Comes anywhere after that.
    Retract {
        /// The `seq` of the assertion.
        assert: u64,
    },
}

/// What an operator says of two visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Assert {
    /// The two observations, counted from 0: already made, and different.
    pub visits: [usize; 2],
    /// Whether their places are one.
    pub same: bool,
}

impl EventKind {
    /// Its name in a trace.
    pub fn name(&self) -> &'static str {
        match self {
            EventKind::Observation(_) => "observation",
            EventKind::Turn(_) => "turn",
            EventKind::Travel(_) => "travel",
            EventKind::Assert(_) => "assert",
            EventKind::Retract { .. } => "retract",
        }
    }
}

/// What was seen at a place.
#[derive(Clone, Debug, PartialEq)]
pub enum Percept {
    /// A star description and the slot the robot is at: on arrival the directed fragment it came in on, at the
    /// first observation the slot it faces.
    Star {
        /// The star.
        star: SmallScaleStar,
        /// The slot, in range.
        dstate: SlotIndex,
        /// The robot's pose in the frame of the observation, if given.
        robot_pose: Option<Pose>,
    },
    /// A local perceptual model, from which star and slot follow.
    Lpm(Lpm),
    /// The name of the view at the dstate the robot is at; not empty.
    View(String),
}

/// An observation at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Star, grid or view.
    pub percept: Percept,
}

/// Where a turn ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TurnTarget {
    /// Facing a slot of the latest star.
    Slot(SlotIndex),
    /// Facing a direction of the latest LPM's frame, radians.
    Heading(f64),
    /// Turned by an angle, radians, counter-clockwise positive.
    Angle(f64),
    /// Facing what the next view shows: in traces of views.
    Described(TurnDescription),
}

/// A turn as traces of views describe it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnDescription {
    /// To the left, onto another path.
    Left,
    /// To the right, onto another path.
    Right,
    /// To the other direction of the same path.
    Around,
}

/// A turn within a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Where it ended.
    pub target: TurnTarget,
    /// The measured angle beside a slot target or a description, radians.
    pub angle: Option<f64>,
}

/// A travel along a path; all metric parts are optional and ignored by the symbolic axioms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Travel {
    /// Displacement of the robot over the travel, in its frame at the start.
    pub odometry: Option<Pose>,
    /// Covariance of the displacement, row-major x, y, theta; symmetric and positive semi-definite.
    pub covariance: Option<[f64; 9]>,
    /// Pose in the frame of the last observation when the travel started.
    pub from_pose: Option<Pose>,
    /// The way it went, points in the frame of `odometry`, straight in between, metres.
    pub shape: Vec<[f64; 2]>,
}

impl Travel {
    /// The way it went in a frame in which the robot's pose at its end is `arrival`; empty without odometry or
    /// shape.
    pub fn trail(&self, arrival: &Pose) -> Vec<Point> {
        let Some(odometry) = self.odometry.filter(|_| !self.shape.is_empty()) else { return Vec::new() };
        let frame_from_start = arrival.compose(&odometry.inverse());
        let way = self.shape.iter().map(|&[x, y]| frame_from_start.transform_point(&Point::new(x, y)));
        way.chain([arrival.position()]).collect()
    }
}
