//! Maps that are equally simple, and what strains them.

use crate::patchwork::ties::{self, Doubt};
use serde::{Deserialize, Serialize};
use std::f64::consts::LN_10;
use utoipa::ToSchema;

/// How the maps in `minimal` are told apart by what was measured. It ranks nothing that the axioms and simplicity have not
/// left equal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Ties {
    /// What orders `minimal`, whose first is the preferred one.
    pub ordered_by: TieOrder,
    /// The strain of each map in `minimal`, in its order; null for those that were not relaxed, as only the first 16 are, or
    /// fewer on walks of more than 32 observations, and where relaxing came to no rest.
    pub strains: Vec<Option<TieStrain>>,
}

/// What orders maps that are equally simple.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TieOrder {
    /// The probability of their strain and of walls that differ, the greatest first.
    Strain,
    /// Their assignments, as not all strains are known, or as nothing is compared in one.
    Assignment,
}

/// What strains one of the maps that are equally simple.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TieStrain {
    /// Chi-square of all travels and closures.
    pub chi_square: f64,
    /// Numbers measured less numbers sought.
    pub degrees_of_freedom: usize,
    /// On how many visits to known places the walls are others than on the first visit.
    pub walls_differ: usize,
    /// The decimal logarithm of the probability that chance strains as much or more, if covariances are honest, and
    /// that walls differ, which they do once in ten visits to one place.
    pub log10_probability: f64,
}

impl Ties {
    /// The wire form of ties in order.
    pub fn of(ties: &ties::Ties) -> Ties {
        Ties {
            ordered_by: if ties.by_strain { TieOrder::Strain } else { TieOrder::Assignment },
            strains: ties.doubts.iter().map(|doubt| doubt.as_ref().map(TieStrain::of)).collect(),
        }
    }
}

impl TieStrain {
    fn of(doubt: &Doubt) -> TieStrain {
        let Doubt { strain, walls_differ } = doubt;
        TieStrain {
            chi_square: strain.chi_square,
            degrees_of_freedom: strain.degrees_of_freedom,
            walls_differ: *walls_differ,
            log10_probability: doubt.log_probability() / LN_10,
        }
    }
}
