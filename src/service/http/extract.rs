//! What handlers take from paths and queries; refusals are problems.

use crate::service::MapName;
use crate::service::problem::{Problem, ProblemKind};
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use serde::Deserialize;
use utoipa::IntoParams;

/// The name of a map from the path.
pub(super) struct MapPath(pub(super) MapName);

impl<S: Send + Sync> FromRequestParts<S> for MapPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let refused = |error: PathRejection| Problem::new(ProblemKind::InvalidMapName, error.body_text());
        let Path(name) = Path::<String>::from_request_parts(parts, state).await.map_err(refused)?;
        Ok(MapPath(name.parse()?))
    }
}

/// The most candidates on a page.
const MAX_PAGE: usize = 1000;

/// Which page of candidates.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct PageQuery {
    /// The most candidates on the page.
    #[serde(default = "default_limit")]
    #[param(default = 20, minimum = 1, maximum = 1000)]
    pub(super) limit: usize,
    /// `next` of the page before; left out for the first page.
    pub(super) cursor: Option<String>,
}

fn default_limit() -> usize {
    20
}

impl<S: Send + Sync> FromRequestParts<S> for PageQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let invalid = |detail: String| Problem::new(ProblemKind::InvalidQuery, detail);
        let refused = |error: QueryRejection| invalid(error.body_text());
        let Query(query) = Query::<PageQuery>::from_request_parts(parts, state).await.map_err(refused)?;
        if !(1..=MAX_PAGE).contains(&query.limit) {
            return Err(invalid(format!("limit is {}, expected 1 to {MAX_PAGE}", query.limit)));
        }
        Ok(query)
    }
}
