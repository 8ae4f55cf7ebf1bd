//! Request bodies: media types, and reading within bounds.

use crate::service::problem::{Problem, ProblemKind};
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, header};
use http_body_util::{BodyExt, LengthLimitError, Limited};

/// The media types of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MediaType {
    /// `application/json`
    Json,
    /// `application/x-ndjson`
    Ndjson,
}

impl MediaType {
    /// The media type of a request, if the service reads it.
    pub(super) fn of(headers: &HeaderMap) -> Result<MediaType, Problem> {
        let unsupported = |detail: String| Problem::new(ProblemKind::UnsupportedMediaType, detail);
        let encoding = text(headers, header::CONTENT_ENCODING);
        if !matches!(encoding.as_str(), "" | "identity") {
            return Err(unsupported(format!("Content-Encoding is `{encoding}`, expected none")));
        }
        let given = text(headers, header::CONTENT_TYPE);
        let essence = given.split(';').next().unwrap_or_default().trim();
        match essence {
            "application/json" => Ok(MediaType::Json),
            "application/x-ndjson" | "application/jsonl" => Ok(MediaType::Ndjson),
            _ => Err(unsupported(format!(
                "Content-Type is `{given}`, expected application/json or application/x-ndjson"
            ))),
        }
    }
}

fn text(headers: &HeaderMap, name: HeaderName) -> String {
    let value = headers.get(name).map(|value| String::from_utf8_lossy(value.as_bytes()).to_ascii_lowercase());
    value.unwrap_or_default()
}

/// The whole body, if it has no more bytes than the bound.
pub(super) async fn whole(body: &mut Body, bound: usize) -> Result<Bytes, Problem> {
    match Limited::new(body, bound).collect().await {
        Ok(collected) => Ok(collected.to_bytes()),
        Err(error) if error.is::<LengthLimitError>() => {
            let detail = format!(
                "the body has more than {bound} bytes; send events as NDJSON, which has no such bound, in \
                 several requests, or grids as png_b64"
            );
            Err(Problem::new(ProblemKind::BodyTooLarge, detail))
        }
        Err(error) => Err(incomplete(error)),
    }
}

/// The next piece of the body, none at its end.
pub(super) async fn piece(body: &mut Body) -> Result<Option<Bytes>, Problem> {
    loop {
        match body.frame().await {
            None => return Ok(None),
            Some(Err(error)) => return Err(incomplete(error)),
            // Frames without data are trailers.
            Some(Ok(frame)) => {
                if let Ok(bytes) = frame.into_data() {
                    return Ok(Some(bytes));
                }
            }
        }
    }
}

/// Reads on to the end or the bound: a client that still sends when the connection ends may lose the answer.
pub(super) async fn drain(body: &mut Body, bound: usize) {
    let mut read = 0;
    while read < bound
        && let Ok(Some(bytes)) = piece(body).await
    {
        read += bytes.len();
    }
}

fn incomplete(error: impl std::fmt::Display) -> Problem {
    Problem::new(
        ProblemKind::IncompleteBody,
        format!("the body cannot be read to its end: {error}; send it again"),
    )
}
