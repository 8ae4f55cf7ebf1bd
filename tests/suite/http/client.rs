//! A client of the router and the bodies it sends.

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, Method, Request, Response, StatusCode, header};
use http_body_util::BodyExt;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use topostar::service::{Limits, Maps, MemoryStore, Store, app};
use tower::ServiceExt;

pub(super) const JSON: &str = "application/json";
pub(super) const NDJSON: &str = "application/x-ndjson";
pub(super) const PROBLEM: &str = "application/problem+json";

#[derive(Clone)]
pub(super) struct Client {
    app: Router,
}

pub(super) struct Answer {
    pub(super) status: StatusCode,
    pub(super) headers: HeaderMap,
    pub(super) body: Bytes,
}

impl Client {
    pub(super) fn new() -> Client {
        Client::with_limits(Limits::default())
    }

    pub(super) fn with_limits(limits: Limits) -> Client {
        Client::with_store(Arc::new(MemoryStore::new(limits.maps)), limits)
    }

    pub(super) fn with_store(store: Arc<dyn Store>, limits: Limits) -> Client {
        Client::of(Maps::new(store, limits))
    }

    pub(super) fn of(maps: Maps) -> Client {
        Client { app: app(maps) }
    }

    pub(super) async fn send(&self, request: Request<Body>) -> Answer {
        let response: Response<Body> = self.app.clone().oneshot(request).await.unwrap();
        let (parts, body) = response.into_parts();
        let body = body.collect().await.unwrap().to_bytes();
        Answer { status: parts.status, headers: parts.headers, body }
    }

    pub(super) async fn call(&self, method: Method, path: &str, kind: &str, body: impl Into<Body>) -> Answer {
        let request = Request::builder().method(method).uri(path).header(header::CONTENT_TYPE, kind);
        self.send(request.body(body.into()).unwrap()).await
    }

    pub(super) async fn get(&self, path: &str) -> Answer {
        self.send(Request::get(path).body(Body::empty()).unwrap()).await
    }

    pub(super) async fn put(&self, map: &str, config: &str) -> Answer {
        self.call(Method::PUT, &format!("/v1/maps/{map}"), JSON, config.to_owned()).await
    }

    pub(super) async fn post(&self, map: &str, kind: &str, body: impl Into<Body>) -> Answer {
        self.call(Method::POST, &format!("/v1/maps/{map}/events"), kind, body).await
    }

    /// A map of this name and configuration that took the trace of the ACES building.
    pub(super) async fn with_aces(&self, map: &str, config: &str) -> Answer {
        assert_eq!(self.put(map, config).await.status, 201);
        self.post(map, NDJSON, aces()).await
    }
}

impl Answer {
    pub(super) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// The problem document, with what every problem has in common asserted.
    #[track_caller]
    pub(super) fn problem(&self, status: u16, code: &str) -> Value {
        assert_eq!(self.headers[header::CONTENT_TYPE], PROBLEM, "{}", String::from_utf8_lossy(&self.body));
        let problem = self.json();
        assert_eq!((self.status.as_u16(), problem["code"].as_str()), (status, Some(code)), "{problem}");
        assert_eq!(problem["status"], status);
        assert_eq!(problem["type"], format!("/problems/{code}"));
        for field in ["title", "detail", "instance"] {
            assert!(problem[field].as_str().is_some_and(|text| !text.is_empty()), "{problem}");
        }
        problem
    }
}

pub(super) fn root(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The trace of the ACES building, NDJSON.
pub(super) fn aces() -> String {
    root("worlds/aces-stars.ndjson")
}

/// Its events.
pub(super) fn aces_lines() -> Vec<String> {
    aces().lines().map(str::to_owned).collect()
}

/// Events as one JSON array.
pub(super) fn array(lines: &[String]) -> String {
    format!("[{}]", lines.join(","))
}
