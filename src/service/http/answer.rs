//! Answers to reads: with a strong ETag, mostly JSON.

use crate::service::http::extract::CandidateName;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::tags::Question;
use crate::service::view::Ranked;
use crate::service::{MapName, Maps, View};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;

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
    let ranked = ranked_for(maps, &view, candidates).await?;
    let read = move || Representation::of(&something(&view, &ranked)?);
    Ok(maps.read(read).await??.answer(request))
}

/// Relaxes a candidate of a map as it is now and answers what follows from that, unless the client has the answer. `form` is
/// what is answered of the candidate, and in which form.
pub(super) async fn lay_out(
    maps: &Maps,
    view: Arc<View>,
    candidate: CandidateName,
    form: String,
    request: &HeaderMap,
    make: impl FnOnce(&View, &Ranked, &dyn Fn() -> bool) -> Result<Representation, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let ranked = ranked_for(maps, &view, &[candidate]).await?;
    let ordered_by = ranked.ties.as_ref().map(|ties| ties.ordered_by);
    let question = Question { candidate: format!("{candidate:?}"), ordered_by, form };
    if let Some(tag) = view.tags.get(&question).filter(|tag| is_known(tag, request)) {
        return Ok(not_modified(tag));
    }
    let tags = Arc::clone(&view.tags);
    let make = move |interrupted: &dyn Fn() -> bool| make(&view, &ranked, interrupted);
    let made = maps.lay_out(make).await??;
    tags.insert(question, made.tag.clone());
    Ok(made.answer(request))
}

/// What a view found, in an order in which these candidates can be looked up: only the preferred one depends on it. It may
/// have to wait, which must not be on a worker.
async fn ranked_for(
    maps: &Maps,
    view: &Arc<View>,
    candidates: &[CandidateName],
) -> Result<Arc<Ranked>, Problem> {
    match candidates.contains(&CandidateName::Preferred) {
        true => Ok(maps.ranked(view).await?),
        false => Ok(view.unranked()),
    }
}

/// Bytes of some media type and their tag.
pub(super) struct Representation {
    kind: &'static str,
    bytes: Vec<u8>,
    tag: String,
}

impl Representation {
    /// The JSON form of a value. Linear in its size: belongs to a worker.
    pub(super) fn of(value: &impl Serialize) -> Result<Representation, Problem> {
        let bytes = serde_json::to_vec(value).map_err(|error| {
            Problem::new(ProblemKind::Internal, format!("the answer is not JSON: {error}"))
        })?;
        Ok(Representation::of_bytes("application/json", bytes))
    }

    /// Bytes of a media type.
    pub(super) fn of_bytes(kind: &'static str, bytes: Vec<u8>) -> Representation {
        let mut hasher = DefaultHasher::new();
        hasher.write(&bytes);
        let tag = format!("\"{:016x}\"", hasher.finish());
        Representation { kind, bytes, tag }
    }

    /// The answer: not modified, if the client has these bytes.
    pub(super) fn answer(self, request: &HeaderMap) -> Response {
        if is_known(&self.tag, request) {
            return not_modified(self.tag);
        }
        ([(header::ETAG, self.tag)], [(header::CONTENT_TYPE, self.kind)], self.bytes).into_response()
    }
}

fn not_modified(tag: String) -> Response {
    (StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response()
}

/// Whether the client has what this tag names.
fn is_known(tag: &str, request: &HeaderMap) -> bool {
    let known = request.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    known.flat_map(|list| list.split(',')).map(str::trim).any(|known| {
        // If-None-Match compares weakly.
        known == "*" || known.trim_start_matches("W/") == tag
    })
}
