//! An answer as bytes.

use crate::service::problem::{Problem, ProblemKind};
use axum::body::Bytes;
use serde::Serialize;
use std::hash::{DefaultHasher, Hasher};

/// Bytes of some media type and their tag. A clone shares the bytes.
#[derive(Clone, Debug)]
pub(super) struct Representation {
    /// Their media type.
    pub(super) kind: &'static str,
    /// What is sent.
    pub(super) bytes: Bytes,
    /// A strong entity tag: other bytes have another.
    pub(super) tag: String,
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
        Representation { kind, bytes: bytes.into(), tag }
    }
}
