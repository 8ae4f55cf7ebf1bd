//! The edge of the service: whatever goes wrong leaves it as a problem document.

use crate::service::problem::{Problem, ProblemKind};
use axum::Router;
use axum::body::Body;
use axum::extract::Request;
use axum::http::header;
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use tower_http::catch_panic::CatchPanicLayer;

/// The router with answers for what it does not know and cannot do.
pub(super) fn guard<S: Clone + Send + Sync + 'static>(router: Router<S>) -> Router<S> {
    router
        .fallback(unknown_resource)
        .method_not_allowed_fallback(method_not_allowed)
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn(name_instance))
}

async fn unknown_resource() -> Problem {
    Problem::new(
        ProblemKind::UnknownResource,
        "no resource has this path; /openapi.json lists those there are",
    )
}

/// The router adds the header `Allow`.
async fn method_not_allowed(request: Request) -> Problem {
    let detail = format!("{} is not a method of this resource; see the header Allow", request.method());
    Problem::new(ProblemKind::MethodNotAllowed, detail)
}

/// The panic's message may hold what is not for clients.
fn panicked(_: Box<dyn Any + Send + 'static>) -> Response {
    Problem::new(ProblemKind::Internal, "the request met a fault of the service; nothing half done is kept")
        .into_response()
}

/// Fills in the path of the request as the problem's instance.
async fn name_instance(request: Request, next: Next) -> Response {
    let instance = request.uri().path().to_owned();
    let mut response = next.run(request).await;
    let Some(problem) = response.extensions_mut().remove::<Problem>() else { return response };
    let (_, body) = problem.with(|document| document.instance = instance).into_response().into_parts();
    // The length was that of the document without its instance.
    response.headers_mut().remove(header::CONTENT_LENGTH);
    response.map(|_: Body| body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::routing::get;
    use http_body_util::BodyExt;
    use tower::ServiceExt;

    #[tokio::test]
    async fn a_panic_in_a_handler_is_a_problem() {
        async fn fails() -> Response {
            panic!("secret")
        }
        let app: Router = guard(Router::new().route("/fails", get(fails)));
        let request = Request::get("/fails").body(Body::empty()).unwrap();
        let response = app.oneshot(request).await.unwrap();
        assert_eq!(response.status(), 500);
        let body = response.into_body().collect().await.unwrap().to_bytes();
        let text = std::str::from_utf8(&body).unwrap();
        assert!(text.contains(r#""instance":"/fails""#) && !text.contains("secret"), "{text}");
    }
}
