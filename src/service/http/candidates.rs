//! Candidates: the maps that are still possible, and the simplest of them.

use crate::abduction::Candidate;
use crate::explanation::{Verdict, verdict};
use crate::export::{Count, MapGraph, Preferred};
use crate::service::http::answer::{read, read_candidates};
use crate::service::http::cursor::Cursor;
use crate::service::http::extract::{CandidateName, CandidatePath, GraphQuery, MapPath, PageQuery};
use crate::service::http::jobs::JobDocument;
use crate::service::http::patchwork::{Asked, lay_out};
use crate::service::http::served::Served;
use crate::service::jobs::JobKind;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::view::Ranked;
use crate::service::{Maps, View};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;

/// Some candidates of a map.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct CandidatePage {
    /// How many there are.
    total: Count,
    /// Those on this page, in the order of their visits.
    candidates: Vec<CandidateSummary>,
    /// The cursor of the next page; null on the last.
    next: Option<String>,
}

/// A candidate: an assignment of every observation to a place and a rotation of its star.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = Candidate)]
pub(super) struct CandidateSummary {
    /// Its position among the candidates, from 0; another event may change it.
    id: usize,
    /// Number of paths, travelled or not.
    paths: usize,
    /// Number of places.
    places: usize,
    /// Number of path segments.
    segments: usize,
    /// The number of the place of each observation; places are numbered by first visit.
    visits: Vec<usize>,
    /// How many slots further on the star of the place each slot of each observation is.
    rotations: Vec<u8>,
}

impl CandidatePage {
    fn of(view: &View, start: usize, limit: usize) -> CandidatePage {
        let end = view.abduction.len().min(start.saturating_add(limit));
        let candidate = |id| Some(CandidateSummary::of(id, &view.abduction.candidate(id)?));
        CandidatePage {
            total: view.report.candidates.into(),
            candidates: (start..end).filter_map(candidate).collect(),
            next: (end < view.abduction.len()).then(|| Cursor::at(view, end).to_string()),
        }
    }
}

impl CandidateSummary {
    fn of(id: usize, candidate: &Candidate) -> CandidateSummary {
        CandidateSummary {
            id,
            paths: candidate.map.path_count(),
            places: candidate.map.place_count(),
            segments: candidate.map.segment_count(),
            visits: candidate.places(),
            rotations: candidate.visits.iter().map(|visit| visit.rotation).collect(),
        }
    }
}

/// List the candidates, page by page.
///
/// A cursor holds until the next observation.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates", tag = "maps", operation_id = "list_candidates",
    params(
        ("map" = String, Path, description = "Name of the map"),
        PageQuery,
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "A page of candidates", body = CandidatePage,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 400, description = "The query is wrong"),
        (status = 404, description = "There is no such map"),
        (status = 410, description = "The candidates have changed since the cursor was given"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn list_candidates(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    page: PageQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let some = move |view: &View| {
        let start = page.cursor.map_or(Ok(0), |cursor| Cursor::start(&cursor, view))?;
        Ok(CandidatePage::of(view, start, page.limit))
    };
    read(&maps, &name, &headers, some).await
}

/// Read the preferred candidate: the simplest map.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates/preferred", tag = "maps", operation_id = "get_preferred",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "The preferred candidate", body = Preferred,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 404, description = "No such map, no observation in it, or nothing explains its events"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_preferred(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let preferred =
        |view: &View, ranked: &Ranked| Preferred::of(&ranked.report).ok_or_else(|| none_left(view));
    read_candidates(&maps, &name, &[CandidateName::Preferred], &headers, preferred).await
}

/// Read the map of a candidate as a graph.
///
/// Where travels were measured, its places and visits have poses, relaxed so that what was measured is strained least, and
/// it is told what strains them. That may be left out. Where it takes long, or a client would rather not wait, a job is made
/// of it.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates/{candidate}/graph", tag = "maps",
    operation_id = "get_graph",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("candidate" = String, Path, description = "Position of the candidate, or `preferred`"),
        GraphQuery,
        ("Prefer" = Option<String>, Header,
            description = "`respond-async`, with `wait=SECONDS` or without: make poses as a job at once, or after so long"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "Places, paths, path segments and frontier", body = MapGraph,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 202, body = JobDocument,
            description = "It takes long, or is not to be waited for: a job makes it, unless someone cancels it",
            headers(
                ("Location" = String, description = "The address of the job"),
                ("Retry-After" = u64, description = "Seconds after which to look at it; not if it was cancelled"),
                ("Preference-Applied" = String, description = "The preference that made it a job, if one did"),
            )),
        (status = 304, description = "The answer has not changed"),
        (status = 400, description = "The query is wrong"),
        (status = 404, description = "No such map or candidate, no observation, or nothing explains the events"),
        (status = 422, description = "The name is not one"),
        (status = 503, description = "It took too long even as a job, or there are too many jobs",
            headers(("Retry-After" = u64, description = "Too many jobs: seconds after which to ask again"))),
    )
)]
pub(super) async fn get_graph(
    State(served): State<Served>,
    CandidatePath(name, candidate): CandidatePath,
    GraphQuery { poses }: GraphQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let maps = &served.maps;
    let view = maps.view(&name).await?;
    if !(poses && view.survey.is_measured()) {
        let graph = move |view: &View, ranked: &Ranked| Ok(MapGraph::of(&candidate.find(view, ranked)?));
        return read_candidates(maps, &name, &[candidate], &headers, graph).await;
    }
    let graph = move |view: &View, ranked: &Ranked, interrupted: &dyn Fn() -> bool| {
        let candidate = candidate.find(view, ranked)?;
        let frames = view.relax(&candidate.visits, interrupted)?;
        Representation::of(&MapGraph::of(&candidate).with_frames(&candidate, &frames))
    };
    let of = format!("/v1/maps/{name}/candidates/{candidate}/graph");
    lay_out(&served, Asked { view, candidate, kind: JobKind::Graph, of }, &headers, graph).await
}

impl CandidateName {
    /// The candidate in a view.
    pub(super) fn find(self, view: &View, ranked: &Ranked) -> Result<Candidate, Problem> {
        view.abduction.candidate(self.position(view, ranked)?).ok_or_else(|| none_left(view))
    }

    /// The position of the candidate in a view.
    pub(super) fn position(self, view: &View, ranked: &Ranked) -> Result<usize, Problem> {
        match self {
            _ if ranked.report.minimal.is_empty() => Err(none_left(view)),
            CandidateName::Preferred => preferred(view, ranked),
            CandidateName::At(position) if position < view.abduction.len() => Ok(position),
            CandidateName::At(position) => Err(Problem::new(
                ProblemKind::UnknownCandidate,
                format!(
                    "there is no candidate {position}, expected 0 to {} or preferred",
                    view.abduction.len() - 1
                ),
            )),
        }
    }
}

/// The position of the preferred candidate in a view.
fn preferred(view: &View, ranked: &Ranked) -> Result<usize, Problem> {
    let visits = ranked.report.minimal.first().map(|candidate| &candidate.visits);
    match visits.and_then(|visits| verdict(&view.abduction, visits)) {
        Some(Verdict::Kept(position)) => Ok(position),
        _ => Err(none_left(view)),
    }
}

/// Why there is no preferred candidate.
pub(super) fn none_left(view: &View) -> Problem {
    match &view.report.extinction {
        Some(extinction) => Problem::extinct(extinction),
        None => Problem::new(ProblemKind::NoObservation, "post the first observation, the event with seq 0"),
    }
}
