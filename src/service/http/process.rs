//! The service itself: whether it lives, and what it offers.

use crate::service::http::openapi;
use axum::Json;

/// Whether the service answers.
#[utoipa::path(
    get, path = "/livez", tag = "process", operation_id = "livez",
    responses((status = 200, description = "The service answers", body = String, content_type = "text/plain"))
)]
pub(super) async fn livez() -> &'static str {
    "live\n"
}

/// This document.
#[utoipa::path(
    get, path = "/openapi.json", tag = "process", operation_id = "openapi",
    responses((status = 200, description = "The OpenAPI document of the service", body = Object, content_type = "application/json"))
)]
pub(super) async fn openapi_json() -> Json<utoipa::openapi::OpenApi> {
    Json(openapi())
}
