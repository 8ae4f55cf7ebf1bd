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
    /// The most bytes that the search may hold, beside the observations.
    pub max_memory: Option<usize>,
    /// The most partial explanations looked at for the simplest candidates, where the limits allow as many.
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
    /// The most bytes that the search may hold: candidates, counted as if their maps shared no memory, and what searches
    /// for room and for the simplest ones remember. What does not fit cuts the search as the limit on candidates does.
    #[schema(minimum = 1)]
    pub max_memory: Option<u64>,
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
        let max_candidates = within(self.max_candidates, limits.candidates_per_map, "/max_candidates")?;
        let max_memory = Some(within(self.max_memory, limits.memory_per_map, "/max_memory")?);
        let strategy = self.strategy.into();
        Ok(MapConfig { axioms, strategy, max_candidates, max_memory, max_steps: None })
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

/// What is asked for, or else all there may be.
fn within(asked: Option<u64>, bound: usize, pointer: &str) -> Result<usize, EventError> {
    let asked = asked.map_or(Some(bound), |asked| usize::try_from(asked).ok());
    let message = || format!("is out of range, expected 1 to {bound}");
    asked.filter(|asked| (1..=bound).contains(asked)).ok_or_else(|| EventError::new(pointer, message()))
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
