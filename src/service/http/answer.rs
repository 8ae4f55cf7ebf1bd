//! Answers to reads: with a strong ETag, mostly JSON.

use crate::service::http::extract::CandidateName;
use crate::service::problem::Problem;
use crate::service::representation::Representation;
use crate::service::view::Ranked;
use crate::service::{MapName, Maps, View};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::sync::Arc;
use std::time::Duration;

/// Reads something of a map as it is now, on a worker.
pub(super) async fn read<T: Serialize>(
    maps: &Maps,
    name: &MapName,
    request: &HeaderMap,
    something: impl FnOnce(&View) -> Result<T, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let view = maps.view(name).await?;
    let read = move || Representation::of(&something(&view)?);
    Ok(maps.read(read).await??.answer(request))
}

/// Reads something of candidates of a map as it is now, on a worker.
pub(super) async fn read_candidates<T: Serialize>(
    maps: &Maps,
    name: &MapName,
    candidates: &[CandidateName],
    request: &HeaderMap,
    something: impl FnOnce(&View, &Ranked) -> Result<T, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let view = maps.view(name).await?;
    let ranked = ranked_for(maps, &view, candidates, maps.limits().patchwork_time).await?;
    let read = move || Representation::of(&something(&view, &ranked)?);
    Ok(maps.read(read).await??.answer(request))
}

/// What a view found, in an order in which these candidates can be looked up: only the preferred one depends on it. It may
/// have to wait, at most so long, which must not be on a worker.
pub(super) async fn ranked_for(
    maps: &Maps,
    view: &Arc<View>,
    candidates: &[CandidateName],
    longest: Duration,
) -> Result<Arc<Ranked>, Problem> {
    match candidates.contains(&CandidateName::Preferred) {
        true => Ok(maps.ranked_within(longest, view).await?),
        false => Ok(view.unranked()),
    }
}

impl Representation {
    /// The answer: not modified, if the client has these bytes.
    pub(super) fn answer(&self, request: &HeaderMap) -> Response {
        if is_known(&self.tag, request) {
            return not_modified(self.tag.clone());
        }
        let headers = [(header::ETAG, self.tag.as_str()), (header::CONTENT_TYPE, self.kind)];
        (headers, self.bytes.clone()).into_response()
    }
}

/// The answer to a client that has what this tag names.
pub(super) fn not_modified(tag: String) -> Response {
    (StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response()
}

/// Whether the client has what this tag names.
pub(super) fn is_known(tag: &str, request: &HeaderMap) -> bool {
    let known = request.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    known.flat_map(|list| list.split(',')).map(str::trim).any(|known| {
        // If-None-Match compares weakly.
        known == "*" || known.trim_start_matches("W/") == tag
    })
}
