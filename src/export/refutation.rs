//! Why something was refuted, as JSON.

use crate::abduction::{self, OPERATOR};
use crate::explanation::{self, Ended, Ending};
use crate::export::{Assertion, GraphGateway};
use crate::map::PlaceId;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Why an assignment was refuted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Refutation {
    /// The axiom that does not hold.
    pub axiom: String,
    /// The observation at which it does not.
    pub observation: usize,
    /// The observations that cannot all be explained so.
    pub observations: Vec<usize>,
    /// The places that clash.
    pub places: Vec<usize>,
    /// The path segments that clash, by the gateways they join.
    pub segments: Vec<[GraphGateway; 2]>,
    /// The clash in one sentence.
    pub words: String,
}

/// What an observation could be taken for, and what refutes it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Alternative {
    /// The place; the next number for a new one.
    pub place: usize,
    /// How many slots further on the star of the place each slot seen is.
    pub rotation: u8,
    /// What refutes it, or the last of all that comes of it; null if nothing does.
    pub refuted: Option<Refutation>,
    /// The asserts in force that do not allow it; left out if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asserts: Vec<Assertion>,
}

/// A branch that ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct EndedBranch {
    /// What it takes the next observation for.
    #[serde(flatten)]
    pub taken: Alternative,
    /// How it ended: `refuted` here, `operator`, or `later`.
    pub ending: String,
}

impl Refutation {
    /// The wire form.
    pub fn of(refutation: &abduction::Refutation) -> Refutation {
        let clash = &refutation.clash;
        Refutation {
            axiom: refutation.axiom.name().into(),
            observation: refutation.observation,
            observations: clash.observations.clone(),
            places: clash.places.iter().copied().map(PlaceId::index).collect(),
            segments: clash.segments.iter().map(|ends| ends.map(GraphGateway::of)).collect(),
            words: clash.words.clone(),
        }
    }
}

impl Alternative {
    /// The wire form.
    pub fn of(alternative: &explanation::Alternative) -> Alternative {
        Alternative {
            place: alternative.assignment.place.index(),
            rotation: alternative.assignment.rotation,
            refuted: alternative.refutation.as_ref().map(Refutation::of),
            asserts: alternative.forbidden.iter().map(Assertion::of).collect(),
        }
    }
}

impl EndedBranch {
    /// The wire form.
    pub fn of(ended: &Ended) -> EndedBranch {
        let (refutation, ending, asserts) = match &ended.ending {
            Ending::Refuted(refutation) => (Some(Refutation::of(refutation)), "refuted", Vec::new()),
            Ending::Forbidden(said) => (None, OPERATOR, said.iter().map(Assertion::of).collect()),
            Ending::Later => (None, "later", Vec::new()),
        };
        let (place, rotation) = (ended.assignment.place.index(), ended.assignment.rotation);
        EndedBranch {
            taken: Alternative { place, rotation, refuted: refutation, asserts },
            ending: ending.into(),
        }
    }
}
