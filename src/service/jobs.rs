//! Jobs: work with a number, begun by one request, looked at and ended by others.
//!
//! Some run at a time, first come, first served, on the threads that such work has anyway. A job is of the map as it was when
//! it was first asked for; whoever asks for the same as a job, before it has ended and while the map finds the same, has the same job. What has ended is kept for a while,
//! within bounds of number and size; nothing runs to forget it, as whoever looks next does.

use crate::abduction::Report;
use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::{Limits, MapsError, Panicked};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::watch;
use tokio::task::AbortHandle;
use tokio::time::timeout;
use utoipa::ToSchema;

/// The jobs of a service. A clone is another handle to the same jobs.
#[derive(Clone)]
pub(super) struct Jobs(Arc<Mutex<Kept>>);

/// A job as it is now.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// Its number; jobs count up.
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
    /// What the map had found, all that the answer at an address depends on.
    pub(super) found: Weak<Report>,
    /// Whether it is known not to be made soon.
    pub(super) large: bool,
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
struct Kept {
    limits: Limits,
    /// How many run at once.
    turns: usize,
    last: u64,
    jobs: BTreeMap<u64, Entry>,
}

struct Entry {
    job: watch::Sender<Job>,
    task: AbortHandle,
    ended: Option<Instant>,
    /// How many asked for it, without those who gave up waiting.
    clients: usize,
    /// Whether it is known not to be made soon.
    large: bool,
}

impl Order {
    fn is(&self, other: &Order) -> bool {
        self.of == other.of && Weak::ptr_eq(&self.found, &other.found)
    }
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
    /// No jobs yet, and turns for so many at once. Numbers go on from the clock, milliseconds since 1970, so that none is that
    /// of a job before the service was started again, as long as the clock is not set back.
    pub(super) fn new(limits: Limits, turns: usize) -> Jobs {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let last = u64::try_from(since.as_millis()).unwrap_or_default();
        Jobs(Arc::new(Mutex::new(Kept { limits, turns, last, jobs: BTreeMap::new() })))
    }

    /// The job under way for the same, or a new one, which begins as soon as it has its turn. Refused where as many as there
    /// may be have not ended; else the one that ended first makes room.
    pub(super) fn begin(
        &self,
        order: Order,
        work: impl Future<Output = Result<Arc<Representation>, Problem>> + Send + 'static,
    ) -> Result<watch::Receiver<Job>, Problem> {
        let mut kept = self.kept();
        if let Some(same) = kept.under_way(&order) {
            same.clients += 1;
            same.large |= order.large;
            return Ok(same.job.subscribe());
        }
        let most = kept.limits.jobs;
        while kept.jobs.len() >= most {
            if !kept.forget_first(Progress::is_end) {
                let detail = format!("{most} jobs have not ended, the most there may be; cancel one or wait");
                return Err(Problem::new(ProblemKind::TooManyJobs, detail));
            }
        }
        kept.last += 1;
        let (id, large) = (kept.last, order.large);
        let (job, told) = watch::channel(Job {
            id,
            order: Arc::new(order),
            progress: Progress::Queued,
            began: None,
            ended: None,
        });
        let task = tokio::spawn(self.clone().run(told.clone(), work)).abort_handle();
        kept.jobs.insert(id, Entry { job, task, ended: None, clients: 1, large });
        kept.give_turns();
        Ok(told)
    }

    /// The job under way for the same, which one more then waits for; none where making it again may be faster, as it has no
    /// turn yet and may be small.
    pub(super) fn join(&self, order: &Order) -> Option<watch::Receiver<Job>> {
        let mut kept = self.kept();
        let same = kept.under_way(order)?;
        let running = matches!(same.job.borrow().progress, Progress::Running);
        (running || same.large).then(|| {
            same.clients += 1;
            same.job.subscribe()
        })
    }

    /// The job of a number.
    pub(super) fn get(&self, id: u64) -> Option<Job> {
        self.kept().jobs.get(&id).map(|entry| entry.job.borrow().clone())
    }

    /// All jobs, in the order of their numbers.
    pub(super) fn list(&self) -> Vec<Job> {
        self.kept().jobs.values().map(|entry| entry.job.borrow().clone()).collect()
    }

    /// A job once it has ended, or as it is after that long. It is cancelled if all who asked for it go away before: nobody
    /// else waits for it, as they were never told its number.
    pub(super) async fn ended_within(&self, mut told: watch::Receiver<Job>, longest: Duration) -> Job {
        let mut waiting = Waiting { jobs: self, id: Some(told.borrow().id) };
        // Whatever came of waiting, what was told last is what there is.
        let _ = timeout(longest, told.wait_for(|job| job.progress.is_end())).await;
        waiting.id = None;
        told.borrow().clone()
    }

    /// Ends a job, unless it has ended. Whether there is such a job.
    pub(super) fn cancel(&self, id: u64) -> bool {
        self.cancel_if(id, |_| true)
    }

    fn cancel_if(&self, id: u64, so: impl FnOnce(&mut Entry) -> bool) -> bool {
        let mut kept = self.kept();
        let Some(entry) = kept.jobs.get_mut(&id) else { return false };
        let task = entry.task.clone();
        if so(entry) {
            kept.end(id, Progress::Cancelled);
            drop(kept);
            // The work is told to stop as its future is dropped. Not while the lock is held, which that takes as well.
            task.abort();
        }
        true
    }

    async fn run(
        self,
        mut told: watch::Receiver<Job>,
        work: impl Future<Output = Result<Arc<Representation>, Problem>>,
    ) {
        let id = told.borrow().id;
        let _end = EndOnDrop { jobs: &self, id };
        let turn = told.wait_for(|job| !matches!(job.progress, Progress::Queued)).await;
        if turn.is_ok_and(|job| !job.progress.is_end()) {
            let progress = work.await.map_or_else(Progress::Failed, Progress::Done);
            self.kept().end(id, progress);
        }
    }

    /// Those that did not end too long ago. Every change is one insertion or removal, so a panic elsewhere cannot leave the
    /// jobs half changed.
    fn kept(&self) -> MutexGuard<'_, Kept> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let longest = kept.limits.job_kept;
        kept.jobs.retain(|_, entry| entry.ended.is_none_or(|at| at.elapsed() < longest));
        kept
    }
}

impl Kept {
    fn under_way(&mut self, order: &Order) -> Option<&mut Entry> {
        let same = |entry: &&mut Entry| entry.ended.is_none() && entry.job.borrow().order.is(order);
        self.jobs.values_mut().find(same)
    }

    /// Those asked for first have their turns first.
    fn give_turns(&mut self) {
        let running = |entry: &&Entry| matches!(entry.job.borrow().progress, Progress::Running);
        let running = self.jobs.values().filter(running).count();
        let queued = |entry: &&Entry| matches!(entry.job.borrow().progress, Progress::Queued);
        let queued = self.jobs.values().filter(queued);
        for entry in queued.take(self.turns.saturating_sub(running)) {
            let began = Some(SystemTime::now());
            entry.job.send_modify(|job| (job.progress, job.began) = (Progress::Running, began));
        }
    }

    /// What has ended ends no more.
    fn end(&mut self, id: u64, progress: Progress) {
        let Some(entry) = self.jobs.get_mut(&id).filter(|entry| entry.ended.is_none()) else { return };
        entry.ended = Some(Instant::now());
        entry.job.send_modify(|job| (job.progress, job.ended) = (progress, Some(SystemTime::now())));
        // One answer is kept, however large.
        while self.answers() > 1 && self.bytes() > self.limits.job_bytes {
            self.forget_first(Progress::is_done);
        }
        self.give_turns();
    }

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
        self.jobs.kept().end(self.id, Progress::Failed(MapsError::Panicked(Panicked).into()));
    }
}

/// One who asked for a job, and gives it up unless told otherwise.
struct Waiting<'a> {
    jobs: &'a Jobs,
    id: Option<u64>,
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        let Some(id) = self.id else { return };
        self.jobs.cancel_if(id, |entry| {
            entry.clients -= 1;
            entry.clients == 0
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::{pending, ready};
    use tokio::task::yield_now;

    const SOON: Duration = Duration::from_secs(60);
    const NOT_LONG: Duration = Duration::from_millis(20);

    fn order(of: &str) -> Order {
        Order { kind: JobKind::Grid, of: of.into(), next_seq: 0, found: Weak::new(), large: false }
    }

    fn made(bytes: usize) -> Result<Arc<Representation>, Problem> {
        Ok(Arc::new(Representation::of_bytes("text/plain", vec![b'x'; bytes])))
    }

    fn ids(jobs: &Jobs) -> Vec<u64> {
        jobs.list().iter().map(|job| job.id).collect()
    }

    fn endless(jobs: &Jobs, of: &str) -> Option<u64> {
        jobs.begin(order(of), pending()).ok().map(|told| told.borrow().id)
    }

    fn progress(jobs: &Jobs, id: u64) -> Progress {
        jobs.get(id).unwrap().progress
    }

    async fn done(jobs: &Jobs, bytes: usize) -> u64 {
        let told = jobs.begin(order("done"), ready(made(bytes))).unwrap();
        let ended = jobs.ended_within(told, SOON).await;
        assert!(ended.progress.is_done() && ended.began <= ended.ended, "{ended:?}");
        ended.id
    }

    #[tokio::test]
    async fn what_ended_first_makes_room() {
        let jobs = Jobs::new(Limits { jobs: 3, ..Limits::default() }, 1);
        let [first, second, third] = ["a", "b", "c"].map(|of| endless(&jobs, of).unwrap());
        assert!(endless(&jobs, "d").is_none());
        assert!(jobs.cancel(third) && jobs.cancel(second));
        let fourth = endless(&jobs, "d").unwrap();
        assert_eq!(ids(&jobs), [first, second, fourth]);
    }

    #[tokio::test]
    async fn answers_are_kept_within_bounds_of_size_and_time() {
        let jobs = Jobs::new(Limits { job_bytes: 100, ..Limits::default() }, 1);
        let mut all = Vec::new();
        for bytes in [40, 50, 30] {
            all.push(done(&jobs, bytes).await);
        }
        assert_eq!(ids(&jobs), all[1..]);
        let large = done(&jobs, 1000).await;
        assert_eq!(ids(&jobs), [large]);
        let jobs = Jobs::new(Limits { job_kept: Duration::ZERO, ..Limits::default() }, 1);
        let id = done(&jobs, 1).await;
        assert!(jobs.list().is_empty() && jobs.get(id).is_none());
        // Whoever asked is told, even if it was forgotten before they came to wait.
        let told = jobs.begin(order("done"), ready(made(1))).unwrap();
        while !told.borrow().progress.is_end() {
            yield_now().await;
        }
        assert!(jobs.list().is_empty() && jobs.ended_within(told, SOON).await.progress.is_done());
    }

    /// A client that knows a number from before the service was started again is not told of another job.
    #[tokio::test]
    async fn numbers_go_on_when_the_service_starts_again() {
        let before = done(&Jobs::new(Limits::default(), 1), 1).await;
        tokio::time::sleep(NOT_LONG).await;
        assert!(done(&Jobs::new(Limits::default(), 1), 1).await > before);
    }

    /// A job that has its turn holds up others as long as it is not cancelled, and what breaks off has failed.
    #[tokio::test]
    async fn a_turn_ends_with_its_job() {
        let jobs = Jobs::new(Limits::default(), 1);
        let first = endless(&jobs, "a").unwrap();
        let second = jobs.begin(order("b"), async { panic!("broken") }).unwrap();
        let waiting = jobs.ended_within(second.clone(), NOT_LONG).await;
        assert!(matches!(waiting.progress, Progress::Queued) && waiting.began.is_none(), "{waiting:?}");
        assert!(matches!(progress(&jobs, first), Progress::Running));
        assert!(jobs.cancel(first) && jobs.cancel(first) && !jobs.cancel(7));
        assert!(matches!(jobs.ended_within(second, SOON).await.progress, Progress::Failed(_)));
        assert!(matches!(progress(&jobs, first), Progress::Cancelled));
    }

    /// Who joins a job and goes away ends it for nobody; one that waits for its turn is joined only if it is large.
    #[tokio::test]
    async fn a_job_is_joined_where_that_is_worth_it() {
        let jobs = Jobs::new(Limits::default(), 1);
        let running = endless(&jobs, "a").unwrap();
        let queued = endless(&jobs, "b").unwrap();
        assert!(jobs.join(&order("b")).is_none() && jobs.join(&order("c")).is_none());
        let large = jobs.begin(Order { large: true, ..order("b") }, pending()).unwrap();
        assert_eq!(large.borrow().id, queued);
        for (of, id) in [("a", running), ("b", queued)] {
            let joined = jobs.join(&order(of)).unwrap();
            assert_eq!(joined.borrow().id, id);
            let abandoned = timeout(NOT_LONG, jobs.ended_within(joined, SOON)).await;
            assert!(abandoned.is_err() && !progress(&jobs, id).is_end());
        }
        let joined = jobs.join(&order("a")).unwrap();
        assert!(jobs.cancel(running) && jobs.join(&order("a")).is_none());
        assert!(matches!(jobs.ended_within(joined, SOON).await.progress, Progress::Cancelled));
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn turns_are_in_the_order_of_asking() {
        let (jobs, order_of_turns) = (Jobs::new(Limits::default(), 1), Arc::new(Mutex::new(Vec::new())));
        let begin = |at: usize| {
            let turns = Arc::clone(&order_of_turns);
            let work = async move {
                turns.lock().unwrap().push(at);
                made(1)
            };
            jobs.begin(order(&at.to_string()), work).unwrap()
        };
        for told in (0..50).map(begin).collect::<Vec<_>>() {
            jobs.ended_within(told, SOON).await;
        }
        assert!(order_of_turns.lock().unwrap().is_sorted(), "{order_of_turns:?}");
    }

    #[tokio::test]
    async fn a_job_is_cancelled_when_the_last_gives_it_up() {
        let jobs = Jobs::new(Limits::default(), 1);
        let asking = || {
            let jobs = jobs.clone();
            let told = jobs.begin(order("a"), pending()).unwrap();
            let id = told.borrow().id;
            (id, tokio::spawn(async move { jobs.ended_within(told, SOON).await }))
        };
        let [(id, one), (same, other)] = [asking(), asking()];
        yield_now().await;
        assert_eq!((ids(&jobs), same), (vec![id], id));
        for (gone, is_end) in [(one, false), (other, true)] {
            gone.abort();
            assert!(gone.await.is_err());
            assert_eq!(progress(&jobs, id).is_end(), is_end);
        }
        // Whoever was told its number may come back.
        let (id, gone) = asking();
        assert_eq!(endless(&jobs, "a"), Some(id));
        yield_now().await;
        gone.abort();
        assert!(gone.await.is_err() && !progress(&jobs, id).is_end());
    }
}
