//! `topostar serve`: the HTTP service.

use crate::cli::failure::Failure;
use crate::service::{Limits, Maps, MemoryStore, http};
use clap::Args;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;

/// Run the HTTP service.
#[derive(Debug, Args)]
#[command(after_help = "\
The service holds its maps in memory: they are gone when it ends. GET /openapi.json describes it.

Example:
  topostar serve &
  curl -X PUT http://127.0.0.1:7878/v1/maps/office
  curl -H 'content-type: application/x-ndjson' --data-binary @trace.ndjson http://127.0.0.1:7878/v1/maps/office/events
  curl http://127.0.0.1:7878/v1/maps/office")]
pub(super) struct Serve {
    /// Address and port. Only loopback addresses: there is no authentication yet.
    #[arg(long, default_value = "127.0.0.1:7878")]
    listen: SocketAddr,
}

impl Serve {
    pub(super) fn run(self) -> Result<(), Failure> {
        if !self.listen.ip().is_loopback() {
            return Err(Failure::Usage(format!(
                "{} is not a loopback address; the service has no authentication yet and listens on loopback only",
                self.listen
            )));
        }
        runtime()?.block_on(async {
            let listener = TcpListener::bind(self.listen)
                .await
                .map_err(|error| Failure::Broken(format!("cannot listen on {}: {error}", self.listen)))?;
            let address = listener.local_addr().map_err(|error| Failure::Broken(error.to_string()))?;
            eprintln!("listening on http://{address}, ctrl-c ends");
            http::serve(listener, maps()).await.map_err(|error| Failure::Broken(error.to_string()))
        })
    }
}

/// The runtime that the service runs on.
pub(super) fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    tokio::runtime::Runtime::new().map_err(|error| Failure::Broken(format!("no async runtime: {error}")))
}

/// Maps kept in memory, with the default limits.
pub(super) fn maps() -> Maps {
    let limits = Limits::default();
    Maps::new(Arc::new(MemoryStore::new(limits.maps)), limits)
}
