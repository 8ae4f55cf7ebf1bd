//! Threads for work that computes: never more at once than there are processors.

use std::sync::Arc;
use std::thread::available_parallelism;
use thiserror::Error;
use tokio::sync::Semaphore;

/// A bound on the computations that run at once. Others wait for their turn, first come, first served.
#[derive(Clone, Debug)]
pub struct Workers {
    free: Arc<Semaphore>,
}

/// The work ended in a panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the work ended before its result")]
pub struct Interrupted;

impl Default for Workers {
    fn default() -> Self {
        let processors = available_parallelism().map_or(1, |n| n.get());
        Workers { free: Arc::new(Semaphore::new(processors)) }
    }
}

impl Workers {
    /// Runs work away from the async workers. Once begun it runs to its end, also if nobody waits any more.
    pub async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Interrupted> {
        let permit = Arc::clone(&self.free).acquire_owned().await.map_err(|_| Interrupted)?;
        let run = move || {
            let result = work();
            drop(permit);
            result
        };
        tokio::task::spawn_blocking(run).await.map_err(|_| Interrupted)
    }
}
