//! Threads for work that computes: about as many at once as there are processors.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::available_parallelism;
use std::time::{Duration, Instant};
use thiserror::Error;
use tokio::sync::{Semaphore, oneshot};

/// A bound on the computations that run at once. Others wait for their turn, first come, first served.
#[derive(Clone, Debug)]
pub struct Workers {
    threads: usize,
    free: Arc<Semaphore>,
    count: Arc<Ended>,
}

/// The computations of some workers, counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workload {
    /// How many run now.
    pub running: usize,
    /// How many have come to an end, panics left out.
    pub ended: u64,
    /// How many of these were told to stop before.
    pub stopped: u64,
}

#[derive(Debug, Default)]
struct Ended {
    all: AtomicU64,
    stopped: AtomicU64,
}

/// The work ended in a panic: there is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the work ended before its result")]
pub struct Panicked;

impl Default for Workers {
    fn default() -> Self {
        Workers::at_least(1)
    }
}

impl Workers {
    /// As many threads as there are processors, but no fewer than that.
    pub fn at_least(threads: usize) -> Workers {
        Workers::of(available_parallelism().map_or(threads, |n| n.get().max(threads)))
    }

    fn of(threads: usize) -> Workers {
        Workers { threads, free: Arc::new(Semaphore::new(threads)), count: Arc::default() }
    }

    /// How many computations may run at once.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// What there is to do. What has ended is counted before its thread is free.
    pub fn workload(&self) -> Workload {
        let running = self.threads - self.free.available_permits().min(self.threads);
        let [ended, stopped] =
            [&self.count.all, &self.count.stopped].map(|count| count.load(Ordering::Acquire));
        Workload { running, ended, stopped }
    }

    /// Runs work away from the async workers. Once begun it runs to its end, also if nobody waits any more.
    pub async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Panicked> {
        // Nobody closes the semaphore, so that there is always a turn.
        let permit = Arc::clone(&self.free).acquire_owned().await.map_err(|_| Panicked)?;
        let count = Arc::clone(&self.count);
        let run = move || {
            let result = work();
            count.all.fetch_add(1, Ordering::Release);
            drop(permit);
            result
        };
        tokio::task::spawn_blocking(run).await.map_err(|_| Panicked)
    }

    /// Runs work that may be told to stop, by what it is given to ask: when nobody waits for it any more, as the client has
    /// gone, or when it has run for so long. Work that nobody waits for before its turn is not begun.
    pub async fn run_while_wanted<T: Send + 'static>(
        &self,
        longest: Duration,
        work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
    ) -> Result<T, Panicked> {
        // Nothing is sent: the one end notices when the other is dropped, with the future that waits here.
        let (wanted, _waiting) = oneshot::channel::<()>();
        let count = Arc::clone(&self.count);
        let work = move || {
            let (begun, stopped) = (Instant::now(), Cell::new(false));
            let result = work(&|| {
                let stop = wanted.is_closed() || begun.elapsed() >= longest;
                stopped.set(stopped.get() || stop);
                stop
            });
            count.stopped.fetch_add(u64::from(stopped.get()), Ordering::Release);
            result
        };
        self.run(work).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    const SOON: Duration = Duration::from_secs(60);

    fn one() -> Workers {
        Workers::of(1)
    }

    /// Work that runs until it is told to stop, and says that it has begun and ended.
    fn endless(said: &mpsc::Sender<&'static str>) -> impl FnOnce(&dyn Fn() -> bool) + Send + 'static {
        let said = said.clone();
        move |interrupted| {
            said.send("begun").unwrap();
            while !interrupted() {
                std::thread::yield_now();
            }
            said.send("ended").unwrap();
        }
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn work_that_nobody_waits_for_is_told_to_stop() {
        let (workers, (said, heard)) = (one(), mpsc::channel());
        let (busy, work) = (workers.clone(), endless(&said));
        let waiting = tokio::spawn(async move { busy.run_while_wanted(Duration::MAX, work).await });
        assert_eq!(heard.recv_timeout(SOON), Ok("begun"));
        // It has no turn yet, and is never begun.
        let (busy, work) = (workers.clone(), endless(&said));
        let queued = tokio::spawn(async move { busy.run_while_wanted(Duration::MAX, work).await });
        queued.abort();
        assert!(queued.await.is_err());
        waiting.abort();
        assert_eq!(heard.recv_timeout(SOON), Ok("ended"));
        assert_eq!(workers.run(|| 7).await, Ok(7));
        assert!(heard.try_recv().is_err());
        assert_eq!(workers.workload(), Workload { running: 0, ended: 2, stopped: 1 });
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn work_that_takes_too_long_is_told_to_stop() {
        let (said, heard) = mpsc::channel();
        one().run_while_wanted(Duration::from_millis(20), endless(&said)).await.unwrap();
        assert_eq!(heard.iter().take(2).collect::<Vec<_>>(), ["begun", "ended"]);
    }
}
