//! Reasons: why candidates are as they are, what sets them apart, how they branched, and where to look next.

use crate::explanation::{difference, node, outlook};
use crate::export::{Difference, Explanation, Outlook, TreeExtent, TreeNode};
use crate::service::http::answer::{read, read_candidates};
use crate::service::http::candidates::none_left;
use crate::service::http::cursor::Cursor;
use crate::service::http::extract::{
    CandidateName, CandidatePair, CandidatePath, MapPath, NextQuery, TreeQuery, VisitsQuery,
};
use crate::service::problem::{Problem, ProblemKind};
use crate::service::view::Ranked;
use crate::service::{Maps, View};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;

/// Some of the tree of candidates.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct TreePage {
    /// The node asked for, with what is below it.
    node: TreeNode,
    /// The cursor of further children of the node; null if there are none.
    next: Option<String>,
}

impl TreePage {
    fn of(view: &View, query: &TreeQuery) -> Result<TreePage, Problem> {
        let skip = query.cursor.as_ref().map_or(Ok(0), |cursor| Cursor::start(cursor, view))?;
        if view.report.minimal.is_empty() {
            return Err(none_left(view));
        }
        let abduction = &view.abduction;
        let Some(node) = node(abduction, query.observation, query.candidate) else {
            let [observation, candidate] = [abduction.observations() - 1, abduction.len() - 1];
            return Err(Problem::new(
                ProblemKind::InvalidQuery,
                format!(
                    "there is no such node, expected observation 0 to {observation} and candidate 0 to {candidate}"
                ),
            ));
        };
        let extent = TreeExtent { depth: query.depth, width: query.limit, skip, ended: query.ended };
        let node = TreeNode::of(abduction, &node, extent);
        let end = skip.saturating_add(query.limit);
        let next = (end < node.branches).then(|| Cursor::at(view, end).to_string());
        Ok(TreePage { node, next })
    }
}

/// Read how the candidates branched.
///
/// A node is a beginning that some candidates have in common; it is named by its observation and by a candidate that
/// begins so. With `ended`, the children that were proposed and refuted are found again, each with its reason.
#[utoipa::path(
    get, path = "/v1/maps/{map}/tree", tag = "reasons", operation_id = "get_tree",
    params(
        ("map" = String, Path, description = "Name of the map"),
        TreeQuery,
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "A node and what is below it", body = TreePage,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 400, description = "The query is wrong"),
        (status = 404, description = "No such map, no observation in it, or nothing explains its events"),
        (status = 410, description = "The candidates have changed since the cursor was given"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_tree(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    query: TreeQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    read(&maps, &name, &headers, move |view| TreePage::of(view, &query)).await
}

/// Read why a candidate is as it is.
///
/// Each coming back from the unknown with its reasons and what rivals say; with `visits` the same of any two
/// observations; an example of what each axiom refuted; the gateway that promises to tell most.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates/{candidate}/explain", tag = "reasons", operation_id = "get_explanation",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("candidate" = String, Path, description = "Position of the candidate, or `preferred`"),
        VisitsQuery,
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "The reasons", body = Explanation,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 400, description = "The query is wrong"),
        (status = 404, description = "No such map or candidate, no observation, or nothing explains the events"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_explanation(
    State(maps): State<Maps>,
    CandidatePath(name, candidate): CandidatePath,
    VisitsQuery { visits }: VisitsQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let reasons = move |view: &View, ranked: &Ranked| {
        let position = candidate.position(view, ranked)?;
        let last = view.abduction.observations().saturating_sub(1);
        Explanation::of(&view.abduction, position, visits).ok_or_else(|| {
            let detail = format!("visits: expected two different observations of 0 to {last}");
            Problem::new(ProblemKind::InvalidQuery, detail)
        })
    };
    read_candidates(&maps, &name, &[candidate], &headers, reasons).await
}

/// Read what differs between two candidates.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates/{candidate}/diff/{other}", tag = "reasons",
    operation_id = "get_difference",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("candidate" = String, Path, description = "Position of the first candidate, or `preferred`"),
        ("other" = String, Path, description = "Position of the second candidate, or `preferred`"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "What differs", body = Difference,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 404, description = "No such map or candidate, no observation, or nothing explains the events"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_difference(
    State(maps): State<Maps>,
    CandidatePair(name, first, second): CandidatePair,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let differs = move |view: &View, ranked: &Ranked| {
        let both = [first.position(view, ranked)?, second.position(view, ranked)?];
        let found = difference(&view.abduction, both).ok_or_else(|| none_left(view))?;
        Ok(Difference::of(&found, both))
    };
    read_candidates(&maps, &name, &[first, second], &headers, differs).await
}

/// Read where to look next.
///
/// What each gateway of the preferred map, the unexplored ones among them, promises to tell the candidates apart by,
/// best first.
#[utoipa::path(
    get, path = "/v1/maps/{map}/next", tag = "reasons", operation_id = "get_next",
    params(
        ("map" = String, Path, description = "Name of the map"),
        NextQuery,
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "Gateways, best first", body = Outlook,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 400, description = "The query is wrong"),
        (status = 404, description = "No such map, no observation in it, or nothing explains its events"),
        (status = 422, description = "The name is not one"),
    )
)]
pub(super) async fn get_next(
    State(maps): State<Maps>,
    MapPath(name): MapPath,
    NextQuery { limit }: NextQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let next = move |view: &View, ranked: &Ranked| {
        let found = outlook(&view.abduction, CandidateName::Preferred.position(view, ranked)?)
            .ok_or_else(|| none_left(view))?;
        Ok(Outlook::of(&found, limit))
    };
    read_candidates(&maps, &name, &[CandidateName::Preferred], &headers, next).await
}
