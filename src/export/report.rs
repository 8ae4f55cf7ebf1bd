//! The report of an abduction: the one stable object of `map --json`.

use crate::abduction::{self, AxiomSet, Candidate, OPERATOR, Profile};
use crate::export::{Explanation, MapStrain, Mending, PoseErrors, Standstill, Ties, Truth};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// What an abduction has found. Fields are added, never renamed or removed, within one `version`.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Report {
    /// Version of this format: 1.
    pub version: u32,
    /// How many candidates explain all observations.
    pub candidates: Count,
    /// How many candidates explained the observations up to each; where `complete` is false, at least as many.
    pub candidates_per_observation: Vec<u64>,
    /// How many maps were made in the search; where `complete` is false, at least as many.
    pub maps_created: u64,
    /// How many candidates each axiom refuted, by the name of the axiom; all axioms held are named. Under
    /// `operator`, how many the operator's word in force did.
    pub refuted: BTreeMap<String, u64>,
    /// How the candidates were searched.
    pub strategy: Strategy,
    /// Partial explanations looked at, under the strategy `best-first`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<u64>,
    /// No map is simpler than this, under the strategy `best-first`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<Bound>,
    /// The profile that holds exactly these axioms, or `custom`.
    pub profile: String,
    /// The axioms held; all of them refute but `boundary=soft`, which ranks.
    pub axioms: Vec<String>,
    /// Whether every candidate there is was kept.
    pub complete: bool,
    /// The simplest map; null before the first observation and when no map is left.
    pub preferred: Option<Preferred>,
    /// The `visits` of each candidate as simple as the preferred one, that one first.
    pub minimal: Vec<Vec<usize>>,
    /// How many different maps these are: where a robot came to a place by more than one story, two candidates
    /// can be one map with its places numbered differently. Null where there are too many to compare.
    pub minimal_maps: Option<usize>,
    /// How these are told apart by what was measured; left out where there is one, or nothing was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ties: Option<Ties>,
    /// Why the search ended early; null if every candidate was followed to the last observation.
    pub stop_reason: Option<StopReason>,
    /// What refuted the last candidates; null unless no candidate is left.
    pub extinction: Option<Extinction>,
    /// The operator's word in force, in the order in which it was said.
    pub asserts: Vec<Assertion>,
    /// Why the preferred map is as it is; the command line fills it in where `--explain` asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explain: Option<Box<Explanation>>,
    /// How the map of a log compares with marked arrivals; the command line fills it in where `--truth` asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<Box<Truth>>,
    /// How far the poses of a log are off; the command line fills it in where `--relations` asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<Box<PoseErrors>>,
    /// What strains the preferred map once its local frames are relaxed; the command line fills it in where travels
    /// were measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<Box<MapStrain>>,
    /// Why no map explains the whole trace, and the map of what was before; the command line fills it in where the
    /// last candidate was refuted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standstill: Option<Box<Standstill>>,
    /// The readings that were taken otherwise than they were read; the command line fills it in where no map explains the
    /// trace as it was read, and changing doubtful readings leads further.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mending: Option<Box<Mending>>,
    /// Wall time of the search; the command line fills it in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// A count that says whether it is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Count {
    /// The number counted.
    pub value: u64,
    /// How the true number compares with it.
    pub relation: Relation,
}

/// How a true number compares with the number counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Relation {
    /// It is equal.
    Eq,
    /// It is equal or greater: a limit cut the search.
    Gte,
}

/// How candidates are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// All candidates, one observation after the other: exhaustive.
    #[default]
    BreadthFirst,
    /// The simplest candidates alone, and the proof that none is simpler.
    BestFirst,
}

/// How simple any map is at best that a search has not ruled out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Bound {
    /// The number of paths.
    pub paths: usize,
    /// The number of places of a map of so many paths.
    pub places: usize,
}

impl From<abduction::Strategy> for Strategy {
    fn from(strategy: abduction::Strategy) -> Strategy {
        match strategy {
            abduction::Strategy::BreadthFirst => Strategy::BreadthFirst,
            abduction::Strategy::BestFirst => Strategy::BestFirst,
        }
    }
}

impl From<Strategy> for abduction::Strategy {
    fn from(strategy: Strategy) -> abduction::Strategy {
        match strategy {
            Strategy::BreadthFirst => abduction::Strategy::BreadthFirst,
            Strategy::BestFirst => abduction::Strategy::BestFirst,
        }
    }
}

/// The simplest map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Preferred {
    /// Whether it is the only one this simple.
    pub unique: bool,
    /// Whether no consistent map is known to be simpler.
    pub proven: bool,
    /// Number of pairs of paths of which one is no boundary for the other, the fewest possible; only where boundaries
    /// are held soft.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub abnormalities: Option<usize>,
    /// Number of paths, travelled or not.
    pub paths: usize,
    /// Number of places.
    pub places: usize,
    /// Number of path segments.
    pub segments: usize,
    /// Number of distinctive states.
    pub dstates: usize,
    /// The number of the place of each observation; places are numbered by first visit.
    pub visits: Vec<usize>,
}

/// Why a search ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// The limit on candidates cut the search.
    CandidateLimit,
    /// The simplest candidates are proven to be that; no others were followed.
    MinimumProven,
    /// The limit on memory cut or ended the search.
    MemoryLimit,
    /// The limit on steps ended the search for the simplest candidates.
    StepLimit,
    /// The time was up.
    Interrupted,
    /// No candidate is left: the axioms do not allow the trace.
    Inconsistent,
}

/// The end of all candidates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Extinction {
    /// The observation that nothing explains, counted from 0.
    pub observation: usize,
    /// The axioms that refuted the last candidates; `operator` if that was the operator's word.
    pub axioms: Vec<String>,
    /// The `seq` of each assert of which one must be retracted to bring candidates back; left out if there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asserts: Vec<u64>,
}

/// An operator's word on two visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Assertion {
    /// The number of the event that said it, by which it is retracted.
    pub seq: u64,
    /// Two observations, counted from 0.
    pub visits: [usize; 2],
    /// Whether they are to one place.
    pub same: bool,
}

impl Assertion {
    /// The wire form.
    pub fn of(assertion: &abduction::Assertion) -> Assertion {
        Assertion { seq: assertion.id, visits: assertion.visits, same: assertion.same }
    }
}

impl Report {
    /// The wire form of what an abduction has found.
    pub fn new(found: &abduction::Report) -> Report {
        let axioms = found.in_force;
        Report {
            version: 1,
            candidates: found.candidates.into(),
            candidates_per_observation: found
                .candidates_per_observation
                .iter()
                .map(|count| count.value)
                .collect(),
            maps_created: found.maps_created.value,
            refuted: refuted(found, axioms),
            strategy: found.strategy.into(),
            steps: found.settlement.map(|settlement| settlement.steps),
            bound: found.settlement.and_then(|settlement| settlement.bound).map(Bound::of),
            profile: profile_name(found.asked).into(),
            axioms: axioms.names().map(str::to_owned).collect(),
            complete: found.complete,
            preferred: Preferred::of(found),
            minimal: found.minimal.iter().map(Candidate::places).collect(),
            minimal_maps: minimal_maps(found),
            ties: None,
            stop_reason: StopReason::of(found.stop_reason),
            extinction: found.extinction.as_ref().map(Extinction::of),
            asserts: found.word.assertions().iter().map(Assertion::of).collect(),
            explain: None,
            truth: None,
            poses: None,
            strain: None,
            standstill: None,
            mending: None,
            seconds: None,
        }
    }
}

impl Preferred {
    /// The first of the simplest candidates, if any is left.
    pub fn of(found: &abduction::Report) -> Option<Preferred> {
        let candidate = found.minimal.first()?;
        Some(Preferred {
            unique: found.unique,
            proven: found.proven,
            abnormalities: found.simplicity.and_then(|simplicity| simplicity.abnormalities),
            paths: candidate.map.path_count(),
            places: candidate.map.place_count(),
            segments: candidate.map.segment_count(),
            dstates: candidate.map.dstate_count(),
            visits: candidate.places(),
        })
    }
}

impl Bound {
    fn of(bound: abduction::Simplicity) -> Bound {
        Bound { paths: bound.paths, places: bound.places }
    }
}

impl StopReason {
    /// Why it ended early, if it did.
    pub fn of(reason: abduction::StopReason) -> Option<StopReason> {
        match reason {
            abduction::StopReason::Exhausted => None,
            abduction::StopReason::MinimumProven => Some(StopReason::MinimumProven),
            abduction::StopReason::StepLimit => Some(StopReason::StepLimit),
            abduction::StopReason::Interrupted => Some(StopReason::Interrupted),
            abduction::StopReason::CandidateLimit { .. } => Some(StopReason::CandidateLimit),
            abduction::StopReason::MemoryLimit { .. } => Some(StopReason::MemoryLimit),
            abduction::StopReason::Inconsistent { .. } => Some(StopReason::Inconsistent),
        }
    }
}

impl Extinction {
    /// The wire form.
    pub fn of(extinction: &abduction::Extinction) -> Extinction {
        let axioms = extinction.names().into_iter().map(Into::into).collect();
        let asserts = extinction.assertions.iter().map(|assertion| assertion.id).collect();
        Extinction { observation: extinction.observation, axioms, asserts }
    }
}

impl From<abduction::Count> for Count {
    fn from(count: abduction::Count) -> Count {
        let relation = match count.relation {
            abduction::Relation::Equal => Relation::Eq,
            abduction::Relation::AtLeast => Relation::Gte,
        };
        Count { value: count.value, relation }
    }
}

/// Steps that may be spent on comparing maps: a fraction of a second.
const COMPARISONS: usize = 20_000_000;

fn minimal_maps(found: &abduction::Report) -> Option<usize> {
    let steps = |candidate: &Candidate| candidate.map.dstate_count().pow(2);
    let cost = found.minimal.iter().map(steps).fold(0, usize::saturating_add);
    (cost <= COMPARISONS).then(|| found.minimal_maps())
}

fn refuted(found: &abduction::Report, axioms: AxiomSet) -> BTreeMap<String, u64> {
    let none = axioms.iter().map(|axiom| (axiom.name.to_owned(), 0));
    let axioms = found.refuted.iter().map(|(axiom, count)| (axiom.name().to_owned(), count));
    let word = (!found.word.is_empty()).then(|| (OPERATOR.to_owned(), found.refuted.by_operator()));
    none.chain(axioms).chain(word).collect()
}

/// The name of the profile that holds exactly these axioms, or `custom`.
pub fn profile_name(axioms: AxiomSet) -> &'static str {
    let profile = Profile::ALL.into_iter().find(|&profile| AxiomSet::of(profile) == axioms);
    profile.map_or("custom", Profile::name)
}
