//! HTTP: resources, methods and media types. Handlers are thin; what they call knows nothing of HTTP.

mod accept;
mod answer;
mod body;
mod candidates;
mod cursor;
mod document;
mod edge;
mod events;
mod extract;
mod grid;
mod jobs;
mod maps;
mod patchwork;
mod prefer;
mod process;
mod reasons;
mod served;

use crate::service::Maps;
use crate::service::http::served::Served;
use axum::Router;
use std::io;
use std::time::Duration;
use tokio::net::TcpListener;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// The service as a router, to be served or called in-process.
pub fn app(maps: Maps) -> Router {
    let (router, _) = api().split_for_parts();
    edge::guard(router).with_state(Served::new(maps))
}

/// The OpenAPI 3.1 document of the service.
pub fn openapi() -> utoipa::openapi::OpenApi {
    document::with_problems(api().into_openapi())
}

/// How long requests under way may take to finish once the process is asked to end.
const GRACE: Duration = Duration::from_secs(5);

/// Serves until the process is asked to end, and finishes the requests under way; one that takes longer than a few
/// seconds, as its client has gone silent, is cut.
pub async fn serve(listener: TcpListener, maps: Maps) -> io::Result<()> {
    serve_until(listener, maps, interrupted()).await
}

/// Serves until `end` is there.
pub async fn serve_until(
    listener: TcpListener,
    maps: Maps,
    end: impl Future<Output = ()> + Send + 'static,
) -> io::Result<()> {
    let (ended, cut) = tokio::sync::oneshot::channel();
    let end = async move {
        end.await;
        // Fails if the server has ended already, and then there is nothing to cut.
        let _ = ended.send(());
    };
    let late = async move {
        if cut.await.is_err() {
            std::future::pending::<()>().await;
        }
        tokio::time::sleep(GRACE).await;
    };
    tokio::select! {
        outcome = axum::serve(listener, app(maps)).with_graceful_shutdown(end) => outcome,
        () = late => Ok(()),
    }
}

/// Ctrl-c, or what a supervisor sends. Where signals cannot be listened for, the service runs until it is killed.
async fn interrupted() {
    let terminated = async {
        #[cfg(unix)]
        if let Ok(mut signal) = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            signal.recv().await;
            return;
        }
        std::future::pending::<()>().await;
    };
    let interrupted = async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    tokio::select! {
        () = terminated => {}
        () = interrupted => {}
    }
}

fn api() -> OpenApiRouter<Served> {
    OpenApiRouter::with_openapi(document::head())
        .routes(routes!(maps::put_map, maps::get_map))
        .routes(routes!(events::post_events))
        .routes(routes!(candidates::list_candidates))
        .routes(routes!(candidates::get_preferred))
        .routes(routes!(candidates::get_graph))
        .routes(routes!(grid::get_grid))
        .routes(routes!(reasons::get_explanation))
        .routes(routes!(reasons::get_difference))
        .routes(routes!(reasons::get_tree))
        .routes(routes!(reasons::get_next))
        .routes(routes!(jobs::list_jobs))
        .routes(routes!(jobs::get_job, jobs::cancel_job))
        .routes(routes!(jobs::get_job_result))
        .routes(routes!(process::livez))
        .routes(routes!(process::openapi_json))
}
