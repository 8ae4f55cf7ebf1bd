//! The grid of a candidate: the LPMs of its visits, laid over each other as the relaxed map has them.

use crate::export::{GridDocument, map_pgm, map_png};
use crate::grid::OccupancyGrid;
use crate::patchwork::merged::Canvas;
use crate::service::View;
use crate::service::http::accept::GridFormat;
use crate::service::http::extract::{CandidateName, CandidatePath, GridQuery};
use crate::service::http::jobs::JobDocument;
use crate::service::http::patchwork::{Asked, lay_out};
use crate::service::http::served::Served;
use crate::service::jobs::JobKind;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::view::Ranked;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use utoipa::ToSchema;

/// The bytes of a picture.
#[derive(ToSchema)]
#[schema(value_type = String, format = Binary)]
#[expect(dead_code, reason = "only its schema is used")]
pub(super) struct Picture(Vec<u8>);

/// Read all that was seen as one occupancy grid.
///
/// The grids of all observations that hang together with the first, laid over each other where relaxation puts them. JSON is
/// in the form in which a trace has an LPM; pictures are in the greys of `map_server`, and JSON of the same resolution says
/// where they lie. Whoever does not wait for the answer ends the work. Where it takes long, or a client would rather not wait, a job is
/// made of it.
#[utoipa::path(
    get, path = "/v1/maps/{map}/candidates/{candidate}/grid", tag = "maps", operation_id = "get_grid",
    params(
        ("map" = String, Path, description = "Name of the map"),
        ("candidate" = String, Path, description = "Position of the candidate, or `preferred`"),
        GridQuery,
        ("Accept" = Option<String>, Header, description = "The form of the answer; JSON unless it says otherwise"),
        ("Prefer" = Option<String>, Header,
            description = "`respond-async`, with `wait=SECONDS` or without: make it as a job at once, or after so long"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "The grid",
            content(
                (GridDocument = "application/json"),
                (Picture = "image/png"),
                (Picture = "image/x-portable-graymap"),
            ),
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
        (status = 404, description = "No such map or candidate, no observation, nothing explains the events, or they \
                                      have not what a patchwork is made of"),
        (status = 406, description = "The header Accept names no form that there is"),
        (status = 422, description = "The name is not one, or the grid would be too large"),
        (status = 503, description = "It took too long even as a job, or there are too many jobs",
            headers(("Retry-After" = u64, description = "Too many jobs: seconds after which to ask again"))),
    )
)]
pub(super) async fn get_grid(
    State(served): State<Served>,
    CandidatePath(name, candidate): CandidatePath,
    GridQuery { resolution, format }: GridQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = format.map_or_else(|| GridFormat::accepted(&headers), Ok)?;
    let view = served.maps.view(&name).await?;
    let canvas = Canvas { resolution, most_cells: served.maps.limits().cells_per_answer };
    let query = format!("resolution={resolution}&format={format}");
    let of = format!("/v1/maps/{name}/candidates/{candidate}/grid?{query}");
    let asked = Asked { view, candidate, kind: JobKind::Grid, of };
    let work = move |view: &View, ranked: &Ranked, interrupted: &dyn Fn() -> bool| {
        encoded(&grid((view, ranked), candidate, &canvas, interrupted)?, format)
    };
    let mut response = lay_out(&served, asked, &headers, work).await?;
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

fn grid(
    (view, ranked): (&View, &Ranked),
    candidate: CandidateName,
    canvas: &Canvas,
    interrupted: &dyn Fn() -> bool,
) -> Result<OccupancyGrid, Problem> {
    let (candidate, survey) = (candidate.find(view, ranked)?, &view.survey);
    if !survey.has_grids() {
        return Err(missing("no observation of the map is a grid, expected some with `lpm`"));
    }
    if survey.len() > 1 && !survey.is_measured() {
        return Err(missing("no travel of the map was measured, expected `odometry` with `covariance`"));
    }
    let frames = view.relax(&candidate.visits, interrupted)?;
    let grid = survey.grid(&frames, canvas, interrupted)?;
    grid.ok_or_else(|| missing("nothing is known in the grids that hang together with the first observation"))
}

fn missing(detail: &str) -> Problem {
    Problem::new(ProblemKind::NotMeasured, detail)
}

fn encoded(grid: &OccupancyGrid, format: GridFormat) -> Result<Representation, Problem> {
    let bytes = match format {
        GridFormat::Json => return Representation::of(&GridDocument::of(grid)),
        GridFormat::Pgm => map_pgm(grid),
        GridFormat::Png => map_png(grid).map_err(|error| {
            Problem::new(ProblemKind::Internal, format!("the grid cannot be drawn: {error}"))
        })?,
    };
    Ok(Representation::of_bytes(format.media_type(), bytes))
}
