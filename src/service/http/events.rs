//! Events: what robots saw and did, taken in order.

use crate::export::Count;
use crate::service::http::body::{MediaType, drain, piece, whole};
use crate::service::http::extract::MapPath;
use crate::service::problem::Problem;
use crate::service::{Batch, Lines, MapName, Maps, View};
use crate::trace::wire::WireEvent;
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::HeaderMap;
use serde::Serialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// What was taken.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct Receipt {
    /// Events of this request that the map holds now.
    accepted: u64,
    /// How many of them it held before.
    replayed: u64,
    /// The number of the last event the map holds; null if it has none.
    accepted_through: Option<u64>,
    /// The number that the next event must carry.
    next_seq: u64,
    /// How many candidates explain all observations.
    candidates: Count,
    /// Whether every candidate there is was kept.
    complete: bool,
}

/// One event or an array of them.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is used; bodies are parsed event by event")]
enum Events {
    One(Box<WireEvent>),
    Many(Vec<WireEvent>),
}

/// Post events.
///
/// One event, an array of them, or NDJSON, one event a line (the item schema is `Event`). Events are taken in
/// order of `seq`; posting one again with the same content does no harm. The taking ends at the first event
/// that cannot be taken: what came before it stays, nothing after it is taken.
#[utoipa::path(
    post, path = "/v1/maps/{map}/events", tag = "events", operation_id = "post_events",
    params(("map" = String, Path, description = "Name of the map")),
    request_body(
        description = "Events",
        content(
            (Events = "application/json"),
            (WireEvent = "application/x-ndjson"),
            (WireEvent = "application/jsonl"),
        )
    ),
    responses(
        (status = 200, description = "All events are kept", body = Receipt),
        (status = 400, description = "The body is not JSON or broke off"),
        (status = 404, description = "There is no such map"),
        (status = 409, description = "Events are missing, or another event has the number"),
        (status = 413, description = "The body or a line is too long"),
        (status = 415, description = "The body is neither JSON nor NDJSON"),
        (status = 422, description = "An event is wrong; those before it are kept"),
        (status = 507, description = "The map is as big as it may be"),
    )
)]
pub(super) async fn post_events(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    headers: HeaderMap,
    mut body: Body,
) -> Result<Json<Receipt>, Problem> {
    let mut posting = Posting { maps: &maps, name: &name, accepted: 0, replayed: 0 };
    let outcome = posting.run(&headers, &mut body).await;
    if outcome.is_err() {
        drain(&mut body, maps.limits().json_bytes).await;
    }
    outcome.map(Json)
}

/// The events of one request.
struct Posting<'a> {
    maps: &'a Maps,
    name: &'a MapName,
    accepted: u64,
    replayed: u64,
}

impl Posting<'_> {
    async fn run(&mut self, headers: &HeaderMap, body: &mut Body) -> Result<Receipt, Problem> {
        let view = self.maps.view(self.name).await?;
        let view = match MediaType::of(headers)? {
            MediaType::Json => {
                let body = whole(body, self.maps.limits().json_bytes).await?;
                self.take(Batch::Json(body.into())).await?
            }
            MediaType::Ndjson => self.stream(body).await?.unwrap_or(view),
        };
        Ok(self.receipt(&view))
    }

    /// Reads on only when all read so far is taken: a client that sends faster waits.
    async fn stream(&mut self, body: &mut Body) -> Result<Option<Arc<View>>, Problem> {
        let bound = self.maps.limits().line_bytes;
        let mut lines = Lines::new(bound);
        let mut view = None;
        while let Some(bytes) = piece(body).await? {
            let ended = lines.push(&bytes);
            if !ended.is_empty() {
                view = Some(self.take(Batch::Lines(ended, bound)).await?);
            }
        }
        match lines.finish() {
            Some(last) => self.take(Batch::Lines(vec![last], bound)).await.map(Some),
            None => Ok(view),
        }
    }

    async fn take(&mut self, batch: Batch) -> Result<Arc<View>, Problem> {
        let (taken, view) = self.maps.take(self.name, batch).await?;
        self.accepted += taken.new.len() as u64 + taken.replayed;
        self.replayed += taken.replayed;
        match taken.fault {
            Some(fault) => Err(Problem::fault(fault, view.next_seq)),
            None => Ok(view),
        }
    }

    fn receipt(&self, view: &View) -> Receipt {
        Receipt {
            accepted: self.accepted,
            replayed: self.replayed,
            accepted_through: view.next_seq.checked_sub(1),
            next_seq: view.next_seq,
            candidates: view.report.candidates.into(),
            complete: view.report.complete,
        }
    }
}
