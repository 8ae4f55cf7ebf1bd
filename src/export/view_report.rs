//! The report of a search over views: what `map --json` prints in profile `classic`.

use crate::classic::{self, AXIOMS, Candidate, DstateId};
use crate::export::{Count, Extinction};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a search over views has found. The fields are those of [`Report`](crate::export::Report), and mean the same,
/// but for those that tell of dstates. Fields are added, never renamed or removed, within one `version`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ViewReport {
    /// Version of this format: 1.
    pub version: u32,
    /// How many candidates explain all observations.
    pub candidates: Count,
    /// How many candidates explained the observations up to each; where `complete` is false, at least as many.
    pub candidates_per_observation: Vec<u64>,
    /// How many maps were made in the search; where `complete` is false, at least as many.
    pub maps_created: u64,
    /// How many of them were made to explain each observation.
    pub maps_created_per_observation: Vec<u64>,
    /// How many maps each axiom refuted, by the name of the axiom; all axioms are named.
    pub refuted: BTreeMap<String, u64>,
    /// How the candidates were searched.
    pub strategy: ViewStrategy,
    /// `classic`.
    pub profile: String,
    /// The axioms held.
    pub axioms: Vec<String>,
    /// Whether every candidate there is was followed.
    pub complete: bool,
    /// The simplest map found; null before the first observation and when there is none.
    pub preferred: Option<PreferredViews>,
    /// The `visits` of each candidate found that is as simple as the preferred one, that one first.
    pub minimal: Vec<Vec<usize>>,
    /// How many different maps these are. Null where there are too many to compare.
    pub minimal_maps: Option<usize>,
    /// Why the search ended early; null if every candidate was followed to the last observation.
    pub stop_reason: Option<ViewStopReason>,
    /// What refuted the last candidates; null unless no candidate is left.
    pub extinction: Option<Extinction>,
    /// Wall time of the search; the command line fills it in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// How candidates are searched in a trace of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewStrategy {
    /// All candidates, one observation after the other: exhaustive.
    BreadthFirst,
    /// The map that may become the simplest is followed first, until all simplest are known.
    BestFirst,
    /// The map that is the simplest now is followed first, until one explains everything.
    SimplestFirst,
}

/// The simplest map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PreferredViews {
    /// Whether it is known to be the only one this simple.
    pub unique: bool,
    /// Whether no consistent map is known to be simpler.
    pub proven: bool,
    /// Number of paths, travelled or not.
    pub paths: usize,
    /// Number of places.
    pub places: usize,
    /// Number of path segments: of pairs of places that a travel joined.
    pub segments: usize,
    /// Number of distinctive states.
    pub dstates: usize,
    /// The number of the place of each observation; places are numbered by first visit.
    pub visits: Vec<usize>,
    /// The number of the dstate of each observation; dstates are numbered by first visit.
    pub dstate_visits: Vec<usize>,
}

/// Why a search over views ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewStopReason {
    /// It found a map that explains everything; no others were followed.
    Found,
    /// The simplest candidates are proven to be that; no others were followed.
    MinimumProven,
    /// The limit on candidates cut the search.
    CandidateLimit,
    /// No candidate is left: the axioms do not allow the trace.
    Inconsistent,
}

impl ViewReport {
    /// The wire form of what a search has found.
    pub fn new(found: &classic::Report, strategy: ViewStrategy) -> ViewReport {
        let values =
            |counts: &[crate::abduction::Count]| counts.iter().map(|count| count.value).collect::<Vec<_>>();
        let none = AXIOMS.iter().map(|axiom| (axiom.name.to_owned(), 0));
        let refuted = found.refuted.iter().map(|(axiom, count)| (axiom.name().to_owned(), count));
        ViewReport {
            version: 1,
            candidates: found.candidates.into(),
            candidates_per_observation: values(&found.candidates_per_observation),
            maps_created: found.maps_created.value,
            maps_created_per_observation: values(&found.created_per_observation),
            refuted: none.chain(refuted).collect(),
            strategy,
            profile: "classic".into(),
            axioms: AXIOMS.iter().map(|axiom| axiom.name.into()).collect(),
            complete: found.complete,
            preferred: PreferredViews::of(found),
            minimal: found.minimal.iter().map(Candidate::places).collect(),
            minimal_maps: minimal_maps(found),
            stop_reason: ViewStopReason::of(found.stop_reason),
            extinction: found.extinction.as_ref().map(|end| Extinction {
                observation: end.observation,
                axioms: end.axioms.iter().map(|axiom| axiom.name().into()).collect(),
                asserts: Vec::new(),
            }),
            seconds: None,
        }
    }
}

impl PreferredViews {
    /// The first of the simplest candidates, if there is any.
    pub fn of(found: &classic::Report) -> Option<PreferredViews> {
        let candidate = found.minimal.first()?;
        let simplicity = candidate.map.simplicity();
        Some(PreferredViews {
            unique: found.unique,
            proven: found.proven,
            paths: simplicity.paths,
            places: simplicity.places,
            segments: candidate.map.paths().iter().map(|path| path.segments.len()).sum(),
            dstates: candidate.map.dstates().len(),
            visits: candidate.places(),
            dstate_visits: candidate.dstates.iter().copied().map(DstateId::index).collect(),
        })
    }
}

impl ViewStopReason {
    fn of(reason: classic::StopReason) -> Option<ViewStopReason> {
        match reason {
            classic::StopReason::Exhausted => None,
            classic::StopReason::Found => Some(ViewStopReason::Found),
            classic::StopReason::MinimumProven => Some(ViewStopReason::MinimumProven),
            classic::StopReason::Limit { .. } => Some(ViewStopReason::CandidateLimit),
            classic::StopReason::Inconsistent { .. } => Some(ViewStopReason::Inconsistent),
        }
    }
}

/// Steps that may be spent on comparing maps: a fraction of a second.
const COMPARISONS: usize = 5_000_000;

fn minimal_maps(found: &classic::Report) -> Option<usize> {
    let steps = |candidate: &Candidate| candidate.map.dstates().len().pow(2);
    let cost = found.minimal.iter().map(steps).fold(0, usize::saturating_add);
    (cost <= COMPARISONS).then(|| found.minimal_maps())
}
