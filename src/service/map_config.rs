//! How a map is to be built: chosen once, when it is made.

use crate::abduction::{AxiomError, AxiomSet, Boundary, Profile, Strategy};
use crate::export;
use crate::service::Limits;
use crate::trace::EventError;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The choices of a map, with defaults filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapConfig {
    /// The axioms that candidates obey.
    pub axioms: AxiomSet,
    /// How candidates are searched.
    pub strategy: Strategy,
    /// The most candidates kept after an observation.
    pub max_candidates: usize,
    /// The most partial explanations looked at for the simplest candidates.
    pub max_steps: Option<u64>,
}

/// How a map is to be built. Every field may be left out.
#[derive(Clone, Debug, Default, Serialize, Deserialize, ToSchema)]
#[schema(as = MapConfig)]
#[serde(deny_unknown_fields, default)]
pub struct WireMapConfig {
    /// A choice of axioms by name; `default` if neither this nor `axioms` is given.
    pub profile: Option<WireProfile>,
    /// How the axioms of the profile are joined by `boundary`; not at all if left out.
    pub boundary: Option<WireBoundary>,
    /// How candidates are searched.
    pub strategy: export::Strategy,
    /// Exactly these axioms, in place of `profile` and `boundary`.
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

/// How the axiom `boundary` is held: a path divides what is right of it from what is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Boundary)]
#[serde(rename_all = "lowercase")]
pub enum WireBoundary {
    /// Maps with fewer exceptions are preferred to others.
    Soft,
    /// Maps with an exception are refuted.
    Hard,
}

impl WireMapConfig {
    /// The choices, or what is wrong with them.
    pub fn config(&self, limits: &Limits) -> Result<MapConfig, EventError> {
        let axioms = self.axiom_set()?;
        let bound = limits.candidates_per_map;
        let asked = self.max_candidates.map_or(Some(bound), |asked| usize::try_from(asked).ok());
        match asked.filter(|asked| (1..=bound).contains(asked)) {
            Some(max_candidates) => {
                let (strategy, max_steps) = (self.strategy.into(), Some(limits.steps_per_map));
                Ok(MapConfig { axioms, strategy, max_candidates, max_steps })
            }
            None => {
                Err(EventError::new("/max_candidates", format!("is out of range, expected 1 to {bound}")))
            }
        }
    }

    fn axiom_set(&self) -> Result<AxiomSet, EventError> {
        let Some(names) = &self.axioms else {
            let profile = AxiomSet::of(self.profile.unwrap_or(WireProfile::Default).into());
            return Ok(profile.with_boundary(self.boundary.map(Boundary::from)));
        };
        if self.profile.is_some() {
            return Err(EventError::new("/axioms", "stands beside profile, expected one of the two"));
        }
        if self.boundary.is_some() {
            let message =
                "stands beside axioms, expected boundary=soft or boundary=hard in that list instead";
            return Err(EventError::new("/boundary", message));
        }
        let parsed: Result<AxiomSet, AxiomError> = names.join(",").parse();
        parsed.map_err(|error| EventError::new("/axioms", error.to_string()))
    }
}

impl From<WireBoundary> for Boundary {
    fn from(boundary: WireBoundary) -> Boundary {
        match boundary {
            WireBoundary::Soft => Boundary::Soft,
            WireBoundary::Hard => Boundary::Hard,
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
