//! Answers that follow from a relaxed candidate: at once where they are kept, else when they are made, or as a job where that
//! takes long or nobody wants to wait.

use crate::service::http::answer::{is_known, not_modified, ranked_for};
use crate::service::http::extract::CandidateName;
use crate::service::http::jobs::{RETRY_AFTER_FULL, answer};
use crate::service::http::prefer::RespondAsync;
use crate::service::http::served::Served;
use crate::service::jobs::{JobKind, Order, Progress};
use crate::service::problem::{Problem, ProblemKind};
use crate::service::representation::Representation;
use crate::service::tags::Question;
use crate::service::view::Ranked;
use crate::service::{Maps, View};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::timeout;

/// The header that says which preferences were applied (RFC 7240).
const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// What is asked of a candidate of a map as it is now.
pub(super) struct Asked {
    /// The map.
    pub(super) view: Arc<View>,
    /// The candidate.
    pub(super) candidate: CandidateName,
    /// What of it.
    pub(super) kind: JobKind,
    /// The address of the answer in the form that was asked for.
    pub(super) of: String,
}

/// Relaxes a candidate and answers what follows from that, unless the client has the answer or it is kept. A job is made of it
/// where a client would rather not wait, or has waited as long as [`crate::service::Limits::patchwork_time`].
pub(super) async fn lay_out<M>(
    served: &Served,
    asked: Asked,
    request: &HeaderMap,
    make: M,
) -> Result<Response, Problem>
where
    M: FnOnce(&View, &Ranked, &dyn Fn() -> bool) -> Result<Representation, Problem> + Clone + Send + 'static,
{
    if let Some(answer) = asked.ranked_by_now().and_then(|ranked| asked.remembered(&ranked, request)) {
        return Ok(answer);
    }
    let preference = RespondAsync::of(request);
    if preference.is_none()
        && let Some(answer) = soon(served, &asked, request, make.clone()).await?
    {
        return Ok(answer);
    }
    as_job(served, asked, request, preference, make).await
}

/// The answer, if it is there soon; of a job for the same that is worth waiting for, how far it is by then.
async fn soon<M>(
    Served { maps, jobs }: &Served,
    asked: &Asked,
    request: &HeaderMap,
    make: M,
) -> Result<Option<Response>, Problem>
where
    M: FnOnce(&View, &Ranked, &dyn Fn() -> bool) -> Result<Representation, Problem> + Send + 'static,
{
    let longest = maps.limits().patchwork_time;
    if let Some(told) = jobs.join(&asked.order(false)) {
        let job = jobs.ended_within(told, longest).await;
        // Whoever cancelled it did so for those who asked for a job.
        if !matches!(job.progress, Progress::Cancelled) {
            return answer(&job, request).map(Some);
        }
    }
    let made = async {
        let ranked = ranked_for(maps, &asked.view, &[asked.candidate], longest).await?;
        if let Some(answer) = asked.remembered(&ranked, request) {
            return Ok(answer);
        }
        Ok::<_, Problem>(asked.made(maps, ranked, longest, make).await?.answer(request))
    };
    // What is not waited for any more is told to stop.
    match timeout(longest, made).await {
        Err(_) => Ok(None),
        Ok(Err(problem)) if problem.is(ProblemKind::OutOfTime) => Ok(None),
        Ok(made) => made.map(Some),
    }
}

async fn as_job<M>(
    served: &Served,
    asked: Asked,
    request: &HeaderMap,
    preference: Option<RespondAsync>,
    make: M,
) -> Result<Response, Problem>
where
    M: FnOnce(&View, &Ranked, &dyn Fn() -> bool) -> Result<Representation, Problem> + Send + 'static,
{
    let Served { maps, jobs } = served;
    let (view, candidate) = (Arc::clone(&asked.view), asked.candidate);
    maps.read(move || candidate.position(&view, &view.unranked())).await??;
    let order = asked.order(preference.is_none());
    let (maps, longest) = (maps.clone(), maps.limits().job_time);
    let work = async move {
        let ranked = ranked_for(&maps, &asked.view, &[asked.candidate], longest).await?;
        match asked.kept(&ranked) {
            Some(kept) => Ok(kept),
            None => asked.made(&maps, ranked, longest, make).await,
        }
    };
    let job = match jobs.begin(order, work) {
        Ok(told) => match preference.map_or(Duration::ZERO, RespondAsync::patience) {
            Duration::ZERO => told.borrow().clone(),
            patience => jobs.ended_within(told, patience).await,
        },
        Err(full) => return Ok(([(header::RETRY_AFTER, RETRY_AFTER_FULL)], full).into_response()),
    };
    let mut response = answer(&job, request)?;
    if response.status() == StatusCode::ACCEPTED
        && let Some(preference) = preference
        && let Ok(applied) = HeaderValue::from_str(&preference.applied())
    {
        response.headers_mut().insert(PREFERENCE_APPLIED, applied);
    }
    Ok(response)
}

impl Asked {
    /// The answer to a client that has it, or one that is kept.
    fn remembered(&self, ranked: &Ranked, request: &HeaderMap) -> Option<Response> {
        let given = self.view.tags.get(&self.question(ranked))?;
        match is_known(&given.tag, request) {
            true => Some(not_modified(given.tag)),
            false => given.kept().map(|kept| kept.answer(request)),
        }
    }

    fn kept(&self, ranked: &Ranked) -> Option<Arc<Representation>> {
        self.view.tags.get(&self.question(ranked))?.kept()
    }

    /// The answer made anew, on a worker, in at most so long.
    async fn made<M>(
        &self,
        maps: &Maps,
        ranked: Arc<Ranked>,
        longest: Duration,
        make: M,
    ) -> Result<Arc<Representation>, Problem>
    where
        M: FnOnce(&View, &Ranked, &dyn Fn() -> bool) -> Result<Representation, Problem> + Send + 'static,
    {
        let (view, question) = (Arc::clone(&self.view), self.question(&ranked));
        let work = move |interrupted: &dyn Fn() -> bool| make(&view, &ranked, interrupted);
        let made = Arc::new(maps.lay_out_within(longest, work).await??);
        self.view.tags.insert(question, &made);
        Ok(made)
    }

    /// What was found, in an order in which the candidate can be looked up, if nobody has to wait for that.
    fn ranked_by_now(&self) -> Option<Arc<Ranked>> {
        match self.candidate == CandidateName::Preferred && self.view.has_ties() {
            true => self.view.ranked.get().cloned(),
            false => Some(self.view.unranked()),
        }
    }

    /// What a job is to make, which may be known to be large.
    fn order(&self, large: bool) -> Order {
        let found = Arc::downgrade(&self.view.report);
        Order { kind: self.kind, of: self.of.clone(), next_seq: self.view.next_seq, found, large }
    }

    fn question(&self, ranked: &Ranked) -> Question {
        Question { of: self.of.clone(), ordered_by: ranked.ties.as_ref().map(|ties| ties.ordered_by) }
    }
}
