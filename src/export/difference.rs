//! What differs between two candidates, as JSON.

use crate::abduction::Simplicity;
use crate::explanation;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What differs between two candidates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Difference {
    /// The first candidate.
    pub first: Side,
    /// The second.
    pub second: Side,
    /// The first observation that they take for different things; null if they are the same candidate.
    pub parting: Option<usize>,
    /// The visits to the place of the same first visit in both, but turned otherwise.
    pub rotations: Vec<usize>,
}

/// One of two candidates, and what holds in it and not in the other.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Side {
    /// Its position among the candidates.
    pub candidate: usize,
    /// Its abnormalities; left out unless the axiom `boundary` is held soft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub abnormalities: Option<usize>,
    /// The number of its paths.
    pub paths: usize,
    /// The number of its places.
    pub places: usize,
    /// The visits that are one place here only.
    pub same_place: Pairs,
    /// The travels that lie on one path here only, each by the observation at its end.
    pub same_path: Pairs,
}

/// Pairs of observations, ascending.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Pairs {
    /// How many there are.
    pub count: usize,
    /// The first of them, 1000 at most.
    pub pairs: Vec<[usize; 2]>,
}

/// The most pairs that are listed; they are quadratic in the observations.
const LISTED: usize = 1000;

impl Difference {
    /// The wire form, for the candidates at two positions.
    pub fn of(difference: &explanation::Difference, candidates: [usize; 2]) -> Difference {
        let side = |side: usize| {
            let Simplicity { abnormalities, paths, places } = difference.simplicity[side];
            Side {
                candidate: candidates[side],
                abnormalities,
                paths,
                places,
                same_place: Pairs::of(&difference.places[side]),
                same_path: Pairs::of(&difference.paths[side]),
            }
        };
        Difference {
            first: side(0),
            second: side(1),
            parting: difference.parting,
            rotations: difference.rotations.clone(),
        }
    }
}

impl Pairs {
    fn of(pairs: &[[usize; 2]]) -> Pairs {
        Pairs { count: pairs.len(), pairs: pairs.iter().take(LISTED).copied().collect() }
    }
}
