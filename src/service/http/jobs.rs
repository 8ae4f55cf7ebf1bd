//! Jobs: work that a client does not wait for.

use crate::export::{GridDocument, MapGraph};
use crate::service::http::grid::Picture;
use crate::service::jobs::{Job, JobKind, Jobs, Progress};
use crate::service::problem::{Problem, ProblemDocument, ProblemKind};
use crate::service::representation::Representation;
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequestParts, Path, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use humantime::format_rfc3339_millis;
use serde::Serialize;
use std::time::{SystemTime, UNIX_EPOCH};
use utoipa::ToSchema;

/// Seconds after which it is worth while to look at a job again.
const RETRY_AFTER: &str = "1";
/// Seconds after which it is worth while to ask for a job again, where there were too many.
pub(super) const RETRY_AFTER_FULL: &str = "10";

/// A job. Fields that do not apply are left out.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = Job)]
pub(super) struct JobDocument {
    /// Its number.
    id: u64,
    /// What it makes of a candidate.
    kind: JobKind,
    /// The address at which that is had without a job, of the map as it is then.
    of: String,
    /// The job is of the map before the event of this number.
    next_seq: u64,
    /// How far it is.
    status: JobStatus,
    /// When it had its turn, RFC 3339 in UTC.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    began: Option<String>,
    /// When it came to an end, RFC 3339 in UTC.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    ended: Option<String>,
    /// The address of what it made.
    #[serde(skip_serializing_if = "Option::is_none")]
    result: Option<String>,
    /// Why it could not make it.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<ProblemDocument>,
}

/// How far a job is.
#[derive(Clone, Copy, Debug, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
enum JobStatus {
    /// Others come first.
    Queued,
    /// It has its turn.
    Running,
    /// `result` is the address of what it made.
    Done,
    /// `problem` says why it could not.
    Failed,
    /// A client ended it.
    Cancelled,
}

/// The jobs of the service.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Jobs)]
pub(super) struct JobList {
    /// In the order in which they were asked for.
    jobs: Vec<JobDocument>,
}

/// What jobs make that is JSON.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is used; jobs keep bytes")]
enum Made {
    Graph(Box<MapGraph>),
    Grid(Box<GridDocument>),
}

impl JobDocument {
    fn of(job: &Job) -> JobDocument {
        let (status, result, problem) = match &job.progress {
            Progress::Queued => (JobStatus::Queued, None, None),
            Progress::Running => (JobStatus::Running, None, None),
            Progress::Done(_) => (JobStatus::Done, Some(format!("{}/result", address(job))), None),
            Progress::Failed(problem) => {
                (JobStatus::Failed, None, Some(problem.of_instance(path(&job.order.of))))
            }
            Progress::Cancelled => (JobStatus::Cancelled, None, None),
        };
        let Job { id, order, began, ended, .. } = job;
        // Times before 1970 cannot be written so.
        let text = |time: &SystemTime| format_rfc3339_millis(*time.max(&UNIX_EPOCH)).to_string();
        let [began, ended] = [began, ended].map(|time| time.as_ref().map(text));
        JobDocument {
            id: *id,
            kind: order.kind,
            of: order.of.clone(),
            next_seq: order.next_seq,
            status,
            began,
            ended,
            result,
            problem,
        }
    }
}

/// List the jobs, in the order in which they were asked for.
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs",
    params(("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has")),
    responses(
        (status = 200, description = "The jobs", body = JobList,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
    )
)]
pub(super) async fn list_jobs(State(jobs): State<Jobs>, headers: HeaderMap) -> Result<Response, Problem> {
    let jobs = jobs.list().iter().map(JobDocument::of).collect();
    Ok(Representation::of(&JobList { jobs })?.answer(&headers))
}

/// Read a job: how far it is.
#[utoipa::path(
    get, path = "/v1/jobs/{job}", tag = "jobs", operation_id = "get_job",
    params(
        ("job" = u64, Path, description = "Number of the job"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "The job", body = JobDocument,
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 304, description = "The answer has not changed"),
        (status = 404, description = "There is no such job, or it was forgotten"),
    )
)]
pub(super) async fn get_job(
    State(jobs): State<Jobs>,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = jobs.get(id).ok_or_else(|| unknown(&id.to_string()))?;
    Ok(Representation::of(&JobDocument::of(&job))?.answer(&headers))
}

/// Read what a job made.
///
/// Of the map as it was when the job was asked for; where the job failed, the problem.
#[utoipa::path(
    get, path = "/v1/jobs/{job}/result", tag = "jobs", operation_id = "get_job_result",
    params(
        ("job" = u64, Path, description = "Number of the job"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the answer the client has"),
    ),
    responses(
        (status = 200, description = "What it made, in the form in which it was asked for",
            content(
                (Made = "application/json"),
                (Picture = "image/png"),
                (Picture = "image/x-portable-graymap"),
            ),
            headers(("ETag" = String, description = "Changes with the answer"))),
        (status = 202, description = "The job has not ended", body = JobDocument,
            headers(
                ("Location" = String, description = "The address of the job"),
                ("Retry-After" = u64, description = "Seconds after which to look again"),
            )),
        (status = 304, description = "The answer has not changed"),
        (status = 404, description = "There is no such job, or it was forgotten; or it failed for want of something"),
        (status = 410, description = "The job was cancelled"),
        (status = 422, description = "It failed as the grid would be too large"),
        (status = 503, description = "It failed as it took too long"),
    )
)]
pub(super) async fn get_job_result(
    State(jobs): State<Jobs>,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = jobs.get(id).ok_or_else(|| unknown(&id.to_string()))?;
    if let Progress::Cancelled = job.progress {
        let detail = format!("job {id} was cancelled; ask again for {}", job.order.of);
        return Err(Problem::new(ProblemKind::JobCancelled, detail));
    }
    answer(&job, &headers)
}

/// Cancel a job.
///
/// Its work ends at once, for all who asked for it. Of a job that has ended nothing changes.
#[utoipa::path(
    delete, path = "/v1/jobs/{job}", tag = "jobs", operation_id = "cancel_job",
    params(("job" = u64, Path, description = "Number of the job")),
    responses(
        (status = 204, description = "The job has ended"),
        (status = 404, description = "There is no such job, or it was forgotten"),
    )
)]
pub(super) async fn cancel_job(
    State(jobs): State<Jobs>,
    JobPath(id): JobPath,
) -> Result<StatusCode, Problem> {
    jobs.cancel(id).then_some(StatusCode::NO_CONTENT).ok_or_else(|| unknown(&id.to_string()))
}

/// What a job made, or why it could not, or the job itself.
pub(super) fn answer(job: &Job, request: &HeaderMap) -> Result<Response, Problem> {
    match &job.progress {
        Progress::Done(made) => Ok(made.answer(request)),
        Progress::Failed(problem) => Err(problem.clone()),
        Progress::Queued | Progress::Running | Progress::Cancelled => {
            let (location, body) = ([(header::LOCATION, address(job))], Json(JobDocument::of(job)));
            let mut response = (StatusCode::ACCEPTED, location, body).into_response();
            // What was cancelled stays so.
            if !matches!(job.progress, Progress::Cancelled) {
                response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from_static(RETRY_AFTER));
            }
            Ok(response)
        }
    }
}

/// The number of a job from the path.
pub(super) struct JobPath(u64);

impl<S: Send + Sync> FromRequestParts<S> for JobPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let refused = |error: PathRejection| unknown(&error.body_text());
        let Path(id) = Path::<String>::from_request_parts(parts, state).await.map_err(refused)?;
        id.parse().map(JobPath).map_err(|_| unknown(&id))
    }
}

fn unknown(id: &str) -> Problem {
    let detail =
        format!("there is no job `{id}`, or it ended and was forgotten; /v1/jobs lists those there are");
    Problem::new(ProblemKind::UnknownJob, detail)
}

fn address(job: &Job) -> String {
    format!("/v1/jobs/{}", job.id)
}

fn path(address: &str) -> &str {
    address.split('?').next().unwrap_or_default()
}
