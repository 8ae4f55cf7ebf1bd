//! Maps: made once, then read.

use crate::export::Report;
use crate::service::http::body::{MediaType, whole};
use crate::service::http::extract::MapPath;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::view::Ranked;
use crate::service::{Created, MapConfig, MapName, Maps, View, WireMapConfig};
use crate::trace::EventError;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

/// A map and what explains it.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = Map)]
pub(super) struct MapState {
    /// Its name.
    map: String,
    /// The number that the next event must carry.
    next_seq: u64,
    /// The most candidates kept after an observation.
    max_candidates: usize,
    /// The most bytes that the search may hold, beside the observations; null without a limit.
    max_memory: Option<usize>,
    /// What explains its events.
    #[serde(flatten)]
    report: Report,
}

impl MapState {
    fn of(name: &MapName, view: &View, ranked: &Ranked) -> MapState {
        let MapConfig { max_candidates, max_memory, .. } = view.config;
        let report = Report { ties: ranked.ties.clone(), ..Report::new(&ranked.report) };
        MapState { map: name.to_string(), next_seq: view.next_seq, max_candidates, max_memory, report }
    }
}

/// Make a map.
///
/// An empty body means all defaults. Putting the same configuration again does no harm.
#[utoipa::path(
    put, path = "/v1/maps/{map}", tag = "maps", operation_id = "put_map",
    params(("map" = String, Path, description = "Name of the map: 1 to 64 characters of A-Z a-z 0-9 . _ -")),
    request_body(content = Option<WireMapConfig>, description = "How the map is to be built"),
    responses(
        (status = 201, description = "The map is made", body = MapState),
        (status = 200, description = "The map exists with this configuration", body = MapState),
        (status = 400, description = "The body is not JSON"),
        (status = 409, description = "The map exists with another configuration"),
        (status = 413, description = "The body is too large"),
        (status = 415, description = "The body is not application/json"),
        (status = 422, description = "The name or the configuration is wrong"),
        (status = 507, description = "There are as many maps as there may be"),
    )
)]
pub(super) async fn put_map(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    headers: HeaderMap,
    mut body: Body,
) -> Result<Response, Problem> {
    let config = read_config(&maps, &headers, &mut body).await?;
    let status = match maps.create(&name, config).await? {
        Created::New => StatusCode::CREATED,
        Created::Existing(_) => StatusCode::OK,
    };
    Ok((status, state(&maps, name).await?.answer(&HeaderMap::new())).into_response())
}

/// Read a map: the number of its next event, its candidates, the preferred one.
#[utoipa::path(
    get, path = "/v1/maps/{map}", tag = "maps", operation_id = "get_map",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "The map", body = MapState,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 404, description = "There is no such map"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_map(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    Ok(state(&maps, name).await?.answer(&headers))
}

async fn state(maps: &Maps, name: MapName) -> Result<Representation, Problem> {
    let view = maps.view(&name).await?;
    let ranked = maps.ranked(&view).await?;
    maps.read(move || Representation::of(&MapState::of(&name, &view, &ranked))).await?
}

async fn read_config(maps: &Maps, headers: &HeaderMap, body: &mut Body) -> Result<MapConfig, Problem> {
    let bytes = whole(body, maps.limits().config_bytes).await?;
    let wire = match bytes.trim_ascii().is_empty() {
        true => WireMapConfig::default(),
        false if MediaType::of(headers)? == MediaType::Json => parse_config(&bytes)?,
        false => {
            let detail = "a configuration is one JSON object, expected Content-Type application/json";
            return Err(Problem::new(ProblemKind::UnsupportedMediaType, detail));
        }
    };
    wire.config(maps.limits()).map_err(malformed)
}

fn parse_config(bytes: &[u8]) -> Result<WireMapConfig, Problem> {
    let not_json = |error: serde_json::Error| {
        Problem::new(ProblemKind::MalformedJson, format!("the configuration is not JSON: {error}"))
    };
    let value: serde_json::Value = serde_json::from_slice(bytes).map_err(not_json)?;
    if !value.is_object() {
        // Serde would read a list as the fields in their order.
        return Err(malformed(EventError::new("", "a configuration is one JSON object")));
    }
    // From the text: a value would have forgotten fields that are given twice.
    let mut json = serde_json::Deserializer::from_slice(bytes);
    serde_path_to_error::deserialize(&mut json).map_err(|error| malformed(EventError::from(&error)))
}

fn malformed(error: EventError) -> Problem {
    Problem::at(ProblemKind::MalformedConfig, error)
}
