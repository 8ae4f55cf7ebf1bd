//! Every error as a problem document (RFC 9457). The only file that decides statuses.

use crate::abduction::Extinction;
use crate::patchwork::local_frames::LocalFramesError;
use crate::patchwork::merged::MergeError;
use crate::service::{
    Fault, IntakeError, Limits, MapNameError, MapsError, Position, SessionError, StoreError,
};
use crate::trace::EventError;
use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

/// The media type of problem documents.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// What went wrong and how to mend it. Boxed, as results carry it.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem(Box<ProblemDocument>);

/// What went wrong and how to mend it. Fields that do not apply are left out.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemDocument {
    /// Names the kind of problem: `/problems/` and the code.
    #[serde(rename = "type")]
    pub kind: String,
    /// The kind of problem in words.
    pub title: &'static str,
    /// The HTTP status.
    pub status: u16,
    /// The kind of problem, for programs.
    pub code: &'static str,
    /// What was found, what was expected, how to mend it.
    pub detail: String,
    /// The path of the request.
    pub instance: String,
    /// JSON pointer to the value at fault in the configuration or event; empty for the whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// The line of the NDJSON body, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// The position in the array of events, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<u64>,
    /// The number of the event at fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seq: Option<u64>,
    /// The number of the event that comes next.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<u64>,
    /// The number of the last event taken: all up to it are kept. Null if the map has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<u64>)]
    pub accepted_through: Option<Option<u64>>,
    /// The observation that nothing explains, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observation: Option<usize>,
    /// The axioms that refuted the last candidates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axioms: Option<Vec<&'static str>>,
    /// The columns and rows that the grid would have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[usize; 2]>,
    /// A resolution at which the grid would not be too large, metres; left out if there is none that may be asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fitting: Option<f64>,
}

/// The kinds of problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemKind {
    /// The body is not JSON.
    MalformedJson,
    /// The body ended or broke before its end.
    IncompleteBody,
    /// The query is wrong.
    InvalidQuery,
    /// No such resource.
    UnknownResource,
    /// No such map.
    UnknownMap,
    /// No such candidate.
    UnknownCandidate,
    /// The map has seen nothing.
    NoObservation,
    /// No map is consistent with the events.
    NoConsistentMap,
    /// The trace has not what a patchwork is made of.
    NotMeasured,
    /// No such job.
    UnknownJob,
    /// The job was cancelled.
    JobCancelled,
    /// As many jobs as there may be.
    TooManyJobs,
    /// None of the media types that the client takes.
    NotAcceptable,
    /// The grid asked for is too large.
    GridTooLarge,
    /// The work was ended after the time it may take.
    OutOfTime,
    /// The resource does not have the method.
    MethodNotAllowed,
    /// Events are missing.
    SequenceGap,
    /// Another event has the number.
    EventConflict,
    /// The map has another configuration.
    ConfigConflict,
    /// The candidates have changed since the cursor was given.
    StaleCursor,
    /// The body or a line of it is too long.
    BodyTooLarge,
    /// The media type or encoding of the body is not taken.
    UnsupportedMediaType,
    /// The name of the map is not one.
    InvalidMapName,
    /// The configuration is wrong.
    MalformedConfig,
    /// The event is wrong.
    MalformedEvent,
    /// A fault of the service.
    Internal,
    /// As many maps as there may be.
    TooManyMaps,
    /// A map as big as it may be.
    MapFull,
}

impl ProblemKind {
    /// Status, code and title.
    fn row(self) -> (StatusCode, &'static str, &'static str) {
        use ProblemKind::*;
        match self {
            MalformedJson => (StatusCode::BAD_REQUEST, "malformed-json", "The body is not JSON"),
            IncompleteBody => (StatusCode::BAD_REQUEST, "incomplete-body", "The body broke off"),
            InvalidQuery => (StatusCode::BAD_REQUEST, "invalid-query", "The query is wrong"),
            UnknownResource => (StatusCode::NOT_FOUND, "unknown-resource", "There is nothing here"),
            UnknownMap => (StatusCode::NOT_FOUND, "unknown-map", "There is no such map"),
            UnknownCandidate => (StatusCode::NOT_FOUND, "unknown-candidate", "There is no such candidate"),
            NoObservation => (StatusCode::NOT_FOUND, "no-observation", "The map has no observation yet"),
            NoConsistentMap => (StatusCode::NOT_FOUND, "no-consistent-map", "No map explains the events"),
            NotMeasured => (StatusCode::NOT_FOUND, "not-measured", "There is nothing to make a patchwork of"),
            UnknownJob => (StatusCode::NOT_FOUND, "unknown-job", "There is no such job"),
            JobCancelled => (StatusCode::GONE, "job-cancelled", "The job was cancelled"),
            TooManyJobs => (StatusCode::SERVICE_UNAVAILABLE, "too-many-jobs", "There are too many jobs"),
            NotAcceptable => (StatusCode::NOT_ACCEPTABLE, "not-acceptable", "No form of it is acceptable"),
            GridTooLarge => {
                (StatusCode::UNPROCESSABLE_ENTITY, "grid-too-large", "The grid would be too large")
            }
            OutOfTime => (StatusCode::SERVICE_UNAVAILABLE, "out-of-time", "It takes too long"),
            MethodNotAllowed => (
                StatusCode::METHOD_NOT_ALLOWED,
                "method-not-allowed",
                "The resource does not have the method",
            ),
            SequenceGap => (StatusCode::CONFLICT, "sequence-gap", "Events are missing"),
            EventConflict => (StatusCode::CONFLICT, "event-conflict", "Another event has the number"),
            ConfigConflict => (StatusCode::CONFLICT, "config-conflict", "The map has another configuration"),
            StaleCursor => (StatusCode::GONE, "stale-cursor", "The candidates have changed"),
            BodyTooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "body-too-large", "The body is too large"),
            UnsupportedMediaType => (
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                "unsupported-media-type",
                "The media type of the body is not taken",
            ),
            InvalidMapName => {
                (StatusCode::UNPROCESSABLE_ENTITY, "invalid-map-name", "The name of the map is not one")
            }
            MalformedConfig => {
                (StatusCode::UNPROCESSABLE_ENTITY, "malformed-config", "The configuration is wrong")
            }
            MalformedEvent => (StatusCode::UNPROCESSABLE_ENTITY, "malformed-event", "The event is wrong"),
            Internal => (StatusCode::INTERNAL_SERVER_ERROR, "internal-error", "The service is at fault"),
            TooManyMaps => (StatusCode::INSUFFICIENT_STORAGE, "too-many-maps", "There are too many maps"),
            MapFull => (StatusCode::INSUFFICIENT_STORAGE, "map-full", "The map is full"),
        }
    }
}

impl Problem {
    /// A problem of a kind.
    pub fn new(kind: ProblemKind, detail: impl Into<String>) -> Problem {
        let (status, code, title) = kind.row();
        Problem(Box::new(ProblemDocument {
            kind: format!("/problems/{code}"),
            title,
            status: status.as_u16(),
            code,
            detail: detail.into(),
            instance: String::new(),
            pointer: None,
            line: None,
            index: None,
            seq: None,
            expected: None,
            accepted_through: None,
            observation: None,
            axioms: None,
            size: None,
            fitting: None,
        }))
    }

    /// The problem with more said of it.
    #[must_use]
    pub fn with(mut self, say: impl FnOnce(&mut ProblemDocument)) -> Problem {
        say(&mut self.0);
        self
    }

    /// The problem of a value at fault in a configuration or event.
    pub fn at(kind: ProblemKind, error: EventError) -> Problem {
        let detail = error.to_string();
        Problem::new(kind, detail).with(|document| document.pointer = Some(error.pointer))
    }

    /// The problem of a map that no candidate is left of.
    pub fn extinct(extinction: &Extinction) -> Problem {
        let axioms = extinction.names();
        let detail = format!("nothing explains {extinction}");
        Problem::new(ProblemKind::NoConsistentMap, detail).with(|document| {
            document.observation = Some(extinction.observation);
            document.axioms = Some(axioms);
        })
    }

    /// The problem of a patchwork that took too long.
    pub fn out_of_time() -> Problem {
        let detail = "the patchwork was not finished in the time it may take; a grid in coarser cells is made faster, and a \
                      graph without poses is made at once";
        Problem::new(ProblemKind::OutOfTime, detail)
    }

    /// Whether it is of this kind.
    pub fn is(&self, kind: ProblemKind) -> bool {
        self.0.code == kind.row().1
    }

    /// The document of the problem, met on the path of a request.
    pub(super) fn of_instance(&self, path: &str) -> ProblemDocument {
        ProblemDocument { instance: path.to_owned(), ..(*self.0).clone() }
    }

    /// The problem of an event that was not taken by a map which expects `next_seq`.
    pub fn fault(fault: Fault, next_seq: u64) -> Problem {
        Problem::from(fault.error).with(|document| {
            match fault.position {
                Position::Whole => {}
                Position::Line(line) => document.line = Some(line),
                Position::Index(index) => document.index = Some(index),
            }
            document.seq = fault.seq;
            document.accepted_through = Some(next_seq.checked_sub(1));
        })
    }
}

impl From<IntakeError> for Problem {
    fn from(error: IntakeError) -> Problem {
        let detail = error.to_string();
        match error {
            IntakeError::NotJson(_) => Problem::new(ProblemKind::MalformedJson, detail),
            IntakeError::LineTooLong(_) => Problem::new(ProblemKind::BodyTooLarge, detail),
            IntakeError::Malformed(error) => Problem::at(ProblemKind::MalformedEvent, error),
            IntakeError::Session(error) => error.into(),
        }
    }
}

impl From<SessionError> for Problem {
    fn from(error: SessionError) -> Problem {
        let detail = error.to_string();
        match error {
            SessionError::Gap { expected, .. } => Problem::new(ProblemKind::SequenceGap, detail)
                .with(|document| document.expected = Some(expected)),
            SessionError::Conflict { .. } => Problem::new(ProblemKind::EventConflict, detail),
            SessionError::Full { .. } => Problem::new(ProblemKind::MapFull, detail),
            SessionError::Refused(error) => Problem::at(ProblemKind::MalformedEvent, error.at()),
            SessionError::Visit(_) | SessionError::Word(_) => {
                Problem::at(ProblemKind::MalformedEvent, EventError::new("", detail))
            }
        }
    }
}

impl From<MapsError> for Problem {
    fn from(error: MapsError) -> Problem {
        let kind = match &error {
            MapsError::Unknown(_) | MapsError::Store(StoreError::UnknownMap(_)) => ProblemKind::UnknownMap,
            MapsError::OtherConfig(_) => ProblemKind::ConfigConflict,
            MapsError::Store(StoreError::TooManyMaps(_)) => ProblemKind::TooManyMaps,
            MapsError::Store(StoreError::Failed(_)) | MapsError::Replay(_) | MapsError::Panicked(_) => {
                ProblemKind::Internal
            }
        };
        Problem::new(kind, error.to_string())
    }
}

impl From<LocalFramesError> for Problem {
    fn from(error: LocalFramesError) -> Problem {
        match error {
            LocalFramesError::Interrupted => Problem::out_of_time(),
            // Measurements are checked when they are taken.
            LocalFramesError::Graph(_) | LocalFramesError::Relax(_) => {
                Problem::new(ProblemKind::Internal, error.to_string())
            }
        }
    }
}

impl From<MergeError> for Problem {
    fn from(error: MergeError) -> Problem {
        let detail = error.to_string();
        match error {
            MergeError::TooLarge { width, height, fitting, .. } => {
                let fits = Limits::RESOLUTIONS.contains(&fitting).then_some(fitting);
                let detail = fits.map_or_else(|| far_off([width, height]), |_| detail);
                Problem::new(ProblemKind::GridTooLarge, detail).with(|document| {
                    document.size = Some([width, height]);
                    document.fitting = fits;
                })
            }
            MergeError::Interrupted => Problem::out_of_time(),
            MergeError::Grid(_) => Problem::new(ProblemKind::Internal, detail),
        }
    }
}

/// What is said of a grid too large at every resolution that may be asked for.
fn far_off([width, height]: [usize; 2]) -> String {
    let coarsest = Limits::RESOLUTIONS.end();
    format!(
        "the grid would be {width} x {height} cells, and too large in cells of {coarsest} m as well: the odometry of some travel \
         leads far off; `poses` of the graph show which"
    )
}

impl From<MapNameError> for Problem {
    fn from(error: MapNameError) -> Problem {
        Problem::new(ProblemKind::InvalidMapName, error.to_string())
    }
}

impl IntoResponse for Problem {
    /// The document without its `instance`, which the edge fills in from the copy in the extensions.
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, Json(&self.0)).into_response();
        response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(PROBLEM_JSON));
        response.extensions_mut().insert(self);
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_resolution_that_may_be_asked_for_is_named() {
        let too_large = |fitting| MergeError::TooLarge { width: 9, height: 8, most_cells: 7, fitting };
        for fitting in [1.1, 1e9, f64::INFINITY, f64::NAN] {
            let Problem(document) = too_large(fitting).into();
            assert_eq!(
                (document.code, document.size, document.fitting),
                ("grid-too-large", Some([9, 8]), None)
            );
            assert!(document.detail.contains("far off"), "{}", document.detail);
        }
        let Problem(document) = too_large(0.3).into();
        assert_eq!(document.fitting, Some(0.3));
        assert!(document.detail.contains("0.3 m would do"), "{}", document.detail);
    }
}
