//! Jobs: work with a number, begun by one request, looked at and ended by others.
//!
//! Some run at a time, first come, first served, on the threads that such work has anyway. A job is of the map as it was when
//! it was asked for. What has ended is kept for a while, within bounds of number and size; nothing runs to forget it, as
//! whoever looks next does.

use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::{Limits, MapsError, Panicked};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::available_parallelism;
use std::time::{Duration, Instant, SystemTime};
use tokio::sync::{Semaphore, watch};
use tokio::task::AbortHandle;
use tokio::time::timeout;
use utoipa::ToSchema;

/// The jobs of a service. A clone is another handle to the same jobs.
#[derive(Clone)]
pub(super) struct Jobs {
    limits: Limits,
    /// Half of the threads, so that whoever waits for an answer finds the others free.
    turns: Arc<Semaphore>,
    kept: Arc<Mutex<Kept>>,
}

/// A job as it is now.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// Its number; jobs count up from 1.
    pub(super) id: u64,
    /// What it makes.
    pub(super) order: Arc<Order>,
    /// How far it is.
    pub(super) progress: Progress,
    /// When it had its turn.
    pub(super) began: Option<SystemTime>,
    /// When it came to an end, whichever.
    pub(super) ended: Option<SystemTime>,
}

/// What a job makes.
#[derive(Debug)]
pub(super) struct Order {
    /// What kind of thing.
    pub(super) kind: JobKind,
    /// The address at which it could be had without a job.
    pub(super) of: String,
    /// The number of the first event that it does not know.
    pub(super) next_seq: u64,
}

/// What kind of thing a job makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum JobKind {
    /// The relaxed graph of a candidate.
    Graph,
    /// The grid of a candidate.
    Grid,
}

/// How far a job is.
#[derive(Clone, Debug)]
pub(super) enum Progress {
    /// Others come first.
    Queued,
    /// It has its turn.
    Running,
    /// This is what it made.
    Done(Arc<Representation>),
    /// This is why it could not.
    Failed(Problem),
    /// Someone ended it before.
    Cancelled,
}

/// In the order of their numbers.
#[derive(Default)]
struct Kept {
    last: u64,
    jobs: BTreeMap<u64, Entry>,
}

struct Entry {
    job: watch::Sender<Job>,
    task: AbortHandle,
    ended: Option<Instant>,
}

impl Progress {
    fn is_end(&self) -> bool {
        !matches!(self, Progress::Queued | Progress::Running)
    }

    fn is_done(&self) -> bool {
        matches!(self, Progress::Done(_))
    }

    fn bytes(&self) -> usize {
        match self {
            Progress::Done(made) => made.bytes.len(),
            _ => 0,
        }
    }
}

impl Jobs {
    /// No jobs yet.
    pub(super) fn new(limits: Limits) -> Jobs {
        let threads = available_parallelism().map_or(1, |n| n.get());
        Jobs { limits, turns: Arc::new(Semaphore::new((threads / 2).max(1))), kept: Arc::default() }
    }

    /// Begins a job as soon as it has its turn. Refused where as many as there may be have not ended; else the one that ended
    /// first makes room.
    pub(super) fn begin(
        &self,
        order: Order,
        work: impl Future<Output = Result<Arc<Representation>, Problem>> + Send + 'static,
    ) -> Result<Job, Problem> {
        let mut kept = self.kept();
        while kept.jobs.len() >= self.limits.jobs {
            if !kept.forget_first(Progress::is_end) {
                let detail = format!(
                    "{} jobs have not ended, the most there may be; cancel one or wait",
                    self.limits.jobs
                );
                return Err(Problem::new(ProblemKind::TooManyJobs, detail));
            }
        }
        kept.last += 1;
        let id = kept.last;
        let job = Job { id, order: Arc::new(order), progress: Progress::Queued, began: None, ended: None };
        let task = tokio::spawn(self.clone().run(id, work)).abort_handle();
        kept.jobs.insert(id, Entry { job: watch::Sender::new(job.clone()), task, ended: None });
        Ok(job)
    }

    /// The job of a number.
    pub(super) fn get(&self, id: u64) -> Option<Job> {
        self.kept().jobs.get(&id).map(|entry| entry.job.borrow().clone())
    }

    /// All jobs, in the order of their numbers.
    pub(super) fn list(&self) -> Vec<Job> {
        self.kept().jobs.values().map(|entry| entry.job.borrow().clone()).collect()
    }

    /// A job once it has ended, or as it is after that long.
    pub(super) async fn ended_within(&self, job: Job, longest: Duration) -> Job {
        let told = self.kept().jobs.get(&job.id).map(|entry| entry.job.subscribe());
        let Some(mut told) = told else { return job };
        // Whatever came of waiting, what was told last is what there is.
        let _ = timeout(longest, told.wait_for(|job| job.progress.is_end())).await;
        told.borrow().clone()
    }

    /// Ends a job, unless it has ended. Whether there is such a job.
    pub(super) fn cancel(&self, id: u64) -> bool {
        let task = self.kept().jobs.get(&id).map(|entry| entry.task.clone());
        let Some(task) = task else { return false };
        self.end(id, Progress::Cancelled);
        // The work is told to stop as its future is dropped. Not while the lock is held, which that takes as well.
        task.abort();
        true
    }

    async fn run(self, id: u64, work: impl Future<Output = Result<Arc<Representation>, Problem>>) {
        let _end = EndOnDrop { jobs: &self, id };
        // Nobody closes the semaphore, so that there is always a turn.
        let Ok(_turn) = self.turns.acquire().await else { return };
        if let Some(entry) = self.kept().jobs.get(&id).filter(|entry| entry.ended.is_none()) {
            entry
                .job
                .send_modify(|job| (job.progress, job.began) = (Progress::Running, Some(SystemTime::now())));
        }
        self.end(id, work.await.map_or_else(Progress::Failed, Progress::Done));
    }

    /// What has ended ends no more.
    fn end(&self, id: u64, progress: Progress) {
        let mut kept = self.kept();
        let Some(entry) = kept.jobs.get_mut(&id).filter(|entry| entry.ended.is_none()) else { return };
        entry.ended = Some(Instant::now());
        entry.job.send_modify(|job| (job.progress, job.ended) = (progress, Some(SystemTime::now())));
        // One answer is kept, however large.
        while kept.answers() > 1 && kept.bytes() > self.limits.job_bytes {
            kept.forget_first(Progress::is_done);
        }
    }

    /// Those that did not end too long ago. Every change is one insertion or removal, so a panic elsewhere cannot leave the
    /// jobs half changed.
    fn kept(&self) -> MutexGuard<'_, Kept> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.jobs.retain(|_, entry| entry.ended.is_none_or(|at| at.elapsed() < self.limits.job_kept));
        kept
    }
}

impl Kept {
    fn answers(&self) -> usize {
        self.jobs.values().filter(|entry| entry.job.borrow().progress.is_done()).count()
    }

    fn bytes(&self) -> usize {
        self.jobs.values().map(|entry| entry.job.borrow().progress.bytes()).sum()
    }

    /// Forgets the one that ended first of those that have ended so. Whether there was one.
    fn forget_first(&mut self, so: impl Fn(&Progress) -> bool) -> bool {
        let ended = self.jobs.iter().filter_map(|(id, entry)| Some((entry.ended?, *id, entry)));
        let first =
            ended.filter(|(.., entry)| so(&entry.job.borrow().progress)).map(|(at, id, _)| (at, id)).min();
        first.is_some_and(|(_, id)| self.jobs.remove(&id).is_some())
    }
}

/// A job whose work broke off has failed; without this it would run for ever.
struct EndOnDrop<'a> {
    jobs: &'a Jobs,
    id: u64,
}

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.jobs.end(self.id, Progress::Failed(MapsError::Panicked(Panicked).into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::{pending, ready};

    const SOON: Duration = Duration::from_secs(60);

    fn order() -> Order {
        Order { kind: JobKind::Grid, of: "/grid".into(), next_seq: 0 }
    }

    fn made(bytes: usize) -> Result<Arc<Representation>, Problem> {
        Ok(Arc::new(Representation::of_bytes("text/plain", vec![b'x'; bytes])))
    }

    fn ids(jobs: &Jobs) -> Vec<u64> {
        jobs.list().iter().map(|job| job.id).collect()
    }

    async fn done(jobs: &Jobs, bytes: usize) -> u64 {
        let job = jobs.begin(order(), ready(made(bytes))).unwrap();
        let ended = jobs.ended_within(job, SOON).await;
        assert!(matches!(ended.progress, Progress::Done(_)) && ended.began <= ended.ended, "{ended:?}");
        ended.id
    }

    #[tokio::test]
    async fn what_ended_first_makes_room() {
        let jobs = Jobs::new(Limits { jobs: 3, ..Limits::default() });
        let endless = jobs.begin(order(), pending()).unwrap();
        let queued = jobs.begin(order(), pending()).unwrap();
        let third = jobs.begin(order(), pending()).unwrap();
        assert!(jobs.begin(order(), pending()).is_err());
        assert!(jobs.cancel(third.id) && jobs.cancel(queued.id));
        let fourth = jobs.begin(order(), pending()).unwrap();
        assert_eq!(ids(&jobs), [endless.id, queued.id, fourth.id]);
        assert_eq!((endless.id, fourth.id), (1, 4));
    }

    #[tokio::test]
    async fn answers_are_kept_within_bounds_of_size_and_time() {
        let jobs = Jobs::new(Limits { job_bytes: 100, ..Limits::default() });
        for bytes in [40, 50, 30] {
            done(&jobs, bytes).await;
        }
        assert_eq!(ids(&jobs), [2, 3]);
        done(&jobs, 1000).await;
        assert_eq!(ids(&jobs), [4]);
        let jobs = Jobs::new(Limits { job_kept: Duration::ZERO, ..Limits::default() });
        done(&jobs, 1).await;
        assert!(jobs.list().is_empty() && jobs.get(1).is_none());
    }

    /// A job that has its turn holds up others as long as it is not cancelled, and what breaks off has failed.
    #[tokio::test]
    async fn a_turn_ends_with_its_job() {
        let jobs = Jobs { turns: Arc::new(Semaphore::new(1)), ..Jobs::new(Limits::default()) };
        let first = jobs.begin(order(), pending()).unwrap();
        let second = jobs.begin(order(), async { panic!("broken") }).unwrap();
        let waiting = jobs.ended_within(second.clone(), Duration::from_millis(20)).await;
        assert!(matches!(waiting.progress, Progress::Queued) && waiting.began.is_none(), "{waiting:?}");
        assert!(matches!(jobs.get(first.id).unwrap().progress, Progress::Running));
        assert!(jobs.cancel(first.id) && jobs.cancel(first.id) && !jobs.cancel(7));
        assert!(matches!(jobs.ended_within(second, SOON).await.progress, Progress::Failed(_)));
        assert!(matches!(jobs.get(first.id).unwrap().progress, Progress::Cancelled));
    }
}
