//! HTTP: resources, methods and media types. Handlers are thin; what they call knows nothing of HTTP.

mod answer;
mod body;
mod candidates;
mod cursor;
mod edge;
mod events;
mod extract;
mod maps;
mod process;

use crate::service::Maps;
use axum::Router;
use std::io;
use tokio::net::TcpListener;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// The service as a router, to be served or called in-process.
pub fn app(maps: Maps) -> Router {
    let (router, _) = api().split_for_parts();
    edge::guard(router).with_state(maps)
}

/// The OpenAPI 3.1 document of the service.
pub fn openapi() -> utoipa::openapi::OpenApi {
    api().into_openapi()
}

/// Serves until the process is asked to end by ctrl-c, and finishes the requests under way.
pub async fn serve(listener: TcpListener, maps: Maps) -> io::Result<()> {
    axum::serve(listener, app(maps)).with_graceful_shutdown(interrupted()).await
}

/// Where the signal cannot be listened for, the service runs until it is killed.
async fn interrupted() {
    if tokio::signal::ctrl_c().await.is_err() {
        std::future::pending::<()>().await;
    }
}

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Topostar",
        description = "Turns what a robot saw at places and did between them into the topological map that \
                       explains it best, and keeps every rival map that is still possible.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
        contact()
    ),
    tags(
        (name = "maps", description = "Maps and what explains them."),
        (name = "events", description = "What robots saw and did."),
        (name = "process", description = "The service itself.")
    )
)]
struct Document;

fn api() -> OpenApiRouter<Maps> {
    OpenApiRouter::with_openapi(Document::openapi())
        .routes(routes!(maps::put_map, maps::get_map))
        .routes(routes!(events::post_events))
        .routes(routes!(candidates::list_candidates))
        .routes(routes!(candidates::get_preferred))
        .routes(routes!(candidates::get_preferred_graph))
        .routes(routes!(process::livez))
        .routes(routes!(process::openapi_json))
}
