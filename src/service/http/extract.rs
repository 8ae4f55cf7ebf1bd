//! What handlers take from paths and queries; refusals are problems.

use crate::service::http::accept::GridFormat;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::{Limits, MapName};
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::fmt;
use std::str::FromStr;
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

/// The name of a map and a candidate of it from the path.
pub(super) struct CandidatePath(pub(super) MapName, pub(super) CandidateName);

/// The name of a map and two candidates of it from the path.
pub(super) struct CandidatePair(pub(super) MapName, pub(super) CandidateName, pub(super) CandidateName);

/// A candidate as paths name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CandidateName {
    /// `preferred`
    Preferred,
    /// By its position.
    At(usize),
}

impl FromStr for CandidateName {
    type Err = Problem;

    fn from_str(text: &str) -> Result<Self, Problem> {
        let unknown = || {
            let detail = format!("`{text}` is no candidate, expected its position from 0 on, or preferred");
            Problem::new(ProblemKind::UnknownCandidate, detail)
        };
        match text {
            "preferred" => Ok(CandidateName::Preferred),
            _ => text.parse().map(CandidateName::At).map_err(|_| unknown()),
        }
    }
}

impl fmt::Display for CandidateName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CandidateName::Preferred => f.write_str("preferred"),
            CandidateName::At(position) => write!(f, "{position}"),
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for CandidatePath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let refused = |error: PathRejection| Problem::new(ProblemKind::InvalidMapName, error.body_text());
        let Path((name, candidate)) =
            Path::<(String, String)>::from_request_parts(parts, state).await.map_err(refused)?;
        Ok(CandidatePath(name.parse()?, candidate.parse()?))
    }
}

impl<S: Send + Sync> FromRequestParts<S> for CandidatePair {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let refused = |error: PathRejection| Problem::new(ProblemKind::InvalidMapName, error.body_text());
        let Path((name, first, second)) =
            Path::<(String, String, String)>::from_request_parts(parts, state).await.map_err(refused)?;
        Ok(CandidatePair(name.parse()?, first.parse()?, second.parse()?))
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
        let query: PageQuery = query(parts, state).await?;
        within("limit", query.limit, 1, MAX_PAGE)?;
        Ok(query)
    }
}

/// How many gateways.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct NextQuery {
    /// The most gateways, the best ones.
    #[serde(default = "default_limit")]
    #[param(default = 20, minimum = 1, maximum = 1000)]
    pub(super) limit: usize,
}

impl<S: Send + Sync> FromRequestParts<S> for NextQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let query: NextQuery = query(parts, state).await?;
        within("limit", query.limit, 1, MAX_PAGE)?;
        Ok(query)
    }
}

/// The most observations below a node of the tree, and the most children of a node.
const MAX_DEPTH: usize = 16;
const MAX_WIDTH: usize = 100;

/// Which part of the tree of candidates.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct TreeQuery {
    /// The observation of the node, from 0.
    #[serde(default)]
    #[param(default = 0)]
    pub(super) observation: usize,
    /// A candidate that begins so.
    #[serde(default)]
    #[param(default = 0)]
    pub(super) candidate: usize,
    /// How many observations below the node.
    #[serde(default = "default_depth")]
    #[param(default = 3, minimum = 1, maximum = 16)]
    pub(super) depth: usize,
    /// The most children, and ended branches, of each node.
    #[serde(default = "default_limit")]
    #[param(default = 20, minimum = 1, maximum = 100)]
    pub(super) limit: usize,
    /// Whether to find the branches that ended, and why.
    #[serde(default)]
    #[param(default = false)]
    pub(super) ended: bool,
    /// `next` of the answer before, for further children of the node.
    pub(super) cursor: Option<String>,
}

fn default_depth() -> usize {
    3
}

impl<S: Send + Sync> FromRequestParts<S> for TreeQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let query: TreeQuery = query(parts, state).await?;
        within("depth", query.depth, 1, MAX_DEPTH)?;
        within("limit", query.limit, 1, MAX_WIDTH)?;
        Ok(query)
    }
}

/// Which two visits.
#[derive(Clone, Copy, Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct VisitsQuery {
    /// Two observations, counted from 0, with a comma between: `0,8`.
    #[param(value_type = Option<String>)]
    pub(super) visits: Option<[usize; 2]>,
}

impl<S: Send + Sync> FromRequestParts<S> for VisitsQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Given {
            visits: Option<String>,
        }
        let Some(text) = query::<Given, S>(parts, state).await?.visits else {
            return Ok(VisitsQuery { visits: None });
        };
        let pair = text.split_once(',').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
        let expected = || {
            let detail = format!("visits is `{text}`, expected two observations, counted from 0, as 0,8");
            Problem::new(ProblemKind::InvalidQuery, detail)
        };
        Ok(VisitsQuery { visits: Some(pair.ok_or_else(expected)?) })
    }
}

/// What a graph holds.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct GraphQuery {
    /// Whether with poses and strain, where travels were measured.
    #[serde(default = "with_poses")]
    #[param(default = true)]
    pub(super) poses: bool,
}

fn with_poses() -> bool {
    true
}

impl<S: Send + Sync> FromRequestParts<S> for GraphQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        query(parts, state).await
    }
}

/// Which grid.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(super) struct GridQuery {
    /// Side of a cell, metres.
    #[serde(default = "default_resolution")]
    #[param(default = 0.05, minimum = 0.01, maximum = 1.0)]
    pub(super) resolution: f64,
    /// The form of the answer, in place of the header Accept.
    #[param(inline)]
    pub(super) format: Option<GridFormat>,
}

fn default_resolution() -> f64 {
    0.05
}

impl<S: Send + Sync> FromRequestParts<S> for GridQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let query: GridQuery = query(parts, state).await?;
        if Limits::RESOLUTIONS.contains(&query.resolution) {
            return Ok(query);
        }
        let (least, most) = Limits::RESOLUTIONS.into_inner();
        let detail = format!("resolution is {}, expected {least} to {most} metres a cell", query.resolution);
        Err(Problem::new(ProblemKind::InvalidQuery, detail))
    }
}

async fn query<T: DeserializeOwned, S: Send + Sync>(parts: &mut Parts, state: &S) -> Result<T, Problem> {
    let refused = |error: QueryRejection| Problem::new(ProblemKind::InvalidQuery, error.body_text());
    let Query(query) = Query::<T>::from_request_parts(parts, state).await.map_err(refused)?;
    Ok(query)
}

fn within(name: &str, given: usize, least: usize, most: usize) -> Result<(), Problem> {
    match (least..=most).contains(&given) {
        true => Ok(()),
        false => {
            let detail = format!("{name} is {given}, expected {least} to {most}");
            Err(Problem::new(ProblemKind::InvalidQuery, detail))
        }
    }
}
