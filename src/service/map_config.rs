//! How a map is to be built: chosen once, when it is made.

use crate::abduction::{AxiomError, AxiomSet, Profile};
use crate::export::Strategy;
use crate::service::Limits;
use crate::trace::EventError;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The choices of a map, with defaults filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapConfig {
    /// The axioms that candidates obey.
    pub axioms: AxiomSet,
    /// The most candidates kept after an observation.
    pub max_candidates: usize,
}

/// How a map is to be built. Every field may be left out.
#[derive(Clone, Debug, Default, Serialize, Deserialize, ToSchema)]
#[schema(as = MapConfig)]
#[serde(deny_unknown_fields, default)]
pub struct WireMapConfig {
    /// A choice of axioms by name; `default` if neither this nor `axioms` is given.
    pub profile: Option<WireProfile>,
    /// How candidates are searched.
    pub strategy: Strategy,
    /// Exactly these axioms, in place of a profile.
    pub axioms: Option<Vec<String>>,
    /// The most candidates kept after an observation, the simplest ones.
    #[schema(minimum = 1)]
    pub max_candidates: Option<u64>,
}

/// A choice of axioms with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Profile)]
#[serde(rename_all = "lowercase")]
pub enum WireProfile {
    /// The axioms of Beeson et al. 2003.
    Paper,
    /// With planarity.
    Default,
}

impl WireMapConfig {
    /// The choices, or what is wrong with them.
    pub fn config(&self, limits: &Limits) -> Result<MapConfig, EventError> {
        let axioms = match (self.profile, &self.axioms) {
            (Some(_), Some(_)) => {
                return Err(EventError::new("/axioms", "stands beside profile, expected one of the two"));
            }
            (profile, None) => AxiomSet::of(profile.unwrap_or(WireProfile::Default).into()),
            (None, Some(names)) => names
                .join(",")
                .parse()
                .map_err(|error: AxiomError| EventError::new("/axioms", error.to_string()))?,
        };
        let bound = limits.candidates_per_map;
        let asked = self.max_candidates.map_or(Some(bound), |asked| usize::try_from(asked).ok());
        match asked.filter(|asked| (1..=bound).contains(asked)) {
            Some(max_candidates) => Ok(MapConfig { axioms, max_candidates }),
            None => {
                Err(EventError::new("/max_candidates", format!("is out of range, expected 1 to {bound}")))
            }
        }
    }
}

impl From<WireProfile> for Profile {
    fn from(profile: WireProfile) -> Profile {
        match profile {
            WireProfile::Paper => Profile::Paper,
            WireProfile::Default => Profile::Default,
        }
    }
}
