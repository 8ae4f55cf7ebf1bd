//! Where to look next, as JSON.

use crate::explanation;
use crate::export::{Count, GraphGateway};
use crate::star::{LargeScaleStar, LargeSlot};
use crate::trace::wire_star::WireControl;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What the gateways of a candidate's map promise to tell the candidates apart by, best first.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Outlook {
    /// The position of the candidate whose map it is.
    pub candidate: usize,
    /// The distinctive state the robot is at after the last observation.
    pub robot: GraphGateway,
    /// How many candidates there are to tell apart.
    pub candidates: Count,
    /// How many gateways can be reached.
    pub total: usize,
    /// What each of the best promises.
    pub gateways: Vec<Prospect>,
}

/// What travel through a gateway promises.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Prospect {
    /// The gateway, in the candidate's map.
    pub gateway: GraphGateway,
    /// Whether its far end is known there.
    pub explored: bool,
    /// The gateways to leave by, one travel after the other; the last is this one.
    pub route: Vec<GraphGateway>,
    /// How many slots clockwise from the slot come in on the robot finds each of them.
    pub turns: Vec<u8>,
    /// How many candidates fall at least, whichever is the true one.
    pub worst: u64,
    /// How many fall on average over the candidates, taking each for the true one in turn.
    pub expected: f64,
    /// What the candidates predict to be seen; each is in one group.
    pub predictions: Vec<Prediction>,
}

/// Candidates that predict the same.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Prediction {
    /// The travel of the route of which they predict it, from 0: the last, or the first at which they differ from the
    /// candidate whose map it is.
    pub travel: usize,
    /// The star to be seen, clockwise from the gateway come in by; null if they do not know.
    pub star: Option<Vec<PredictedSlot>>,
    /// How many candidates predict it.
    pub candidates: u64,
    /// How many candidates fall if it comes true.
    pub falls: u64,
}

/// A slot of a star that is predicted.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, ToSchema)]
pub struct PredictedSlot {
    /// How to travel away.
    pub control: WireControl,
    /// Whether there is a gateway.
    pub navigable: bool,
    /// The slot of the other direction of the same path.
    pub opposite: u8,
}

impl Outlook {
    /// The wire form, with so many gateways at most.
    pub fn of(outlook: &explanation::Outlook, limit: usize) -> Outlook {
        let candidates = outlook.candidates.value;
        Outlook {
            candidate: outlook.candidate,
            robot: GraphGateway::of(outlook.robot),
            candidates: outlook.candidates.into(),
            total: outlook.prospects.len(),
            gateways: outlook
                .prospects
                .iter()
                .take(limit)
                .map(|prospect| Prospect::of(prospect, candidates))
                .collect(),
        }
    }
}

impl Prospect {
    /// The wire form, of so many candidates.
    pub fn of(prospect: &explanation::Prospect, candidates: u64) -> Prospect {
        Prospect {
            gateway: GraphGateway::of(prospect.gateway),
            explored: prospect.explored,
            route: prospect.route.iter().map(|&gateway| GraphGateway::of(gateway)).collect(),
            turns: prospect.turns.clone(),
            worst: prospect.worst,
            expected: prospect.expected as f64 / candidates.max(1) as f64,
            predictions: prospect.predictions.iter().map(Prediction::of).collect(),
        }
    }
}

impl Prediction {
    fn of(prediction: &explanation::Prediction) -> Prediction {
        let slots = |star: &LargeScaleStar| star.slots().iter().map(PredictedSlot::of).collect();
        Prediction {
            travel: prediction.travel,
            star: prediction.star.as_ref().map(slots),
            candidates: prediction.candidates,
            falls: prediction.falls,
        }
    }
}

impl PredictedSlot {
    fn of(slot: &LargeSlot) -> PredictedSlot {
        PredictedSlot { control: slot.control.into(), navigable: slot.navigable, opposite: slot.opposite.0 }
    }
}
