//! What readers see of a map: a snapshot that no running search holds up.

use crate::abduction::{Abduction, Assignment, Report};
use crate::export::{TieOrder, Ties};
use crate::patchwork::closures::{Agreements, Known};
use crate::patchwork::local_frames::{LocalFrames, LocalFramesError};
use crate::patchwork::survey::Survey;
use crate::patchwork::ties;
use crate::service::tags::Tags;
use crate::service::{MapConfig, Session};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::OnceCell;

/// A map after some of its events.
#[derive(Clone, Debug)]
pub struct View {
    /// How it is built.
    pub config: MapConfig,
    /// The number of the event that comes next.
    pub next_seq: u64,
    /// What explains the events; it shares all candidates with the session's.
    pub abduction: Abduction,
    /// What it has found.
    pub report: Arc<Report>,
    /// What the events tell the patchwork.
    pub survey: Arc<Survey>,
    /// The same report once the simplest maps are in order. Empty as long as nobody asked, or nobody waited for it.
    pub(super) ranked: Arc<OnceCell<Arc<Ranked>>>,
    /// The tags of answers that follow from what was found.
    pub(super) tags: Arc<Tags>,
    /// What visits show of each other, as far as it was asked of this view or another of the map: most of the work, and the
    /// same however the map grows.
    known: Arc<Mutex<Known>>,
}

/// What was found, the simplest maps in the order of their strain where that can be told.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// What was found. Its first simplest map is the preferred one.
    pub report: Arc<Report>,
    /// What told the simplest maps apart, where there are several and travels were measured.
    pub ties: Option<Ties>,
}

impl View {
    /// What a session shows now.
    pub fn of(session: &Session) -> View {
        View::with_report(session, Arc::new(session.abduction().report()))
    }

    /// What the session of this view shows now. Only an observation, an operator's word, or a search that went on where
    /// it was interrupted changes what is found.
    pub fn next(&self, session: &Session) -> View {
        let known = Arc::clone(&self.known);
        match self.finds_what(session) {
            true => {
                let (report, ranked) = (Arc::clone(&self.report), Arc::clone(&self.ranked));
                let tags = Arc::clone(&self.tags);
                View { ranked, tags, known, ..View::with_report(session, report) }
            }
            false => View { known, ..View::of(session) },
        }
    }

    /// Whether the session of this view still shows the same.
    pub fn shows(&self, session: &Session) -> bool {
        self.next_seq == session.next_seq() && self.finds_what(session)
    }

    fn finds_what(&self, session: &Session) -> bool {
        let (now, shown) = (session.abduction(), &self.abduction);
        now.observations() == shown.observations()
            && now.word() == shown.word()
            && now.settlement() == shown.settlement()
    }

    /// Relaxes a candidate of the map. Stops where `interrupted` says so, and the next to ask finds what was done by then.
    pub fn relax(
        &self,
        candidate: &[Assignment],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<LocalFrames, LocalFramesError> {
        self.agreeing(|agreements| self.survey.relax(candidate, agreements, interrupted))
    }

    /// Does something that asks what visits show of each other, and remembers what they do.
    fn agreeing<T>(&self, something: impl FnOnce(&mut Agreements<'_>) -> T) -> T {
        let known = self.known().clone();
        let mut agreements = self.survey.agreements().knowing(known);
        let done = something(&mut agreements);
        self.known().extend(agreements.into_known());
        done
    }

    /// What is remembered is added pair by pair, each of which is right whatever became of the others.
    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether what was measured may tell several simplest maps apart.
    pub(super) fn has_ties(&self) -> bool {
        self.report.minimal.len() > 1 && self.survey.is_measured()
    }

    /// What was found, with the simplest maps in the order of their assignments.
    pub(super) fn unranked(&self) -> Arc<Ranked> {
        let ties = self.has_ties().then(|| Ties {
            ordered_by: TieOrder::Assignment,
            strains: vec![None; self.report.minimal.len()],
        });
        Arc::new(Ranked { report: Arc::clone(&self.report), ties })
    }

    /// What was found, with the simplest maps in order; `None` where `interrupted` says to stop. Relaxes those that tie, a
    /// bounded number ([`crate::patchwork::ties`]): belongs to a worker.
    pub(super) fn rank(&self, interrupted: &dyn Fn() -> bool) -> Option<Arc<Ranked>> {
        if !self.has_ties() {
            return Some(self.unranked());
        }
        let mut report = Report::clone(&self.report);
        let rank = |agreements: &mut Agreements<'_>| {
            ties::Ties::rank(&mut report, &self.survey, agreements, interrupted)
        };
        let ties = match self.agreeing(rank) {
            Ok(ties) => ties.as_ref().map(Ties::of),
            Err(LocalFramesError::Interrupted) => return None,
            // Measurements that cannot be relaxed do not tell the maps apart.
            Err(LocalFramesError::Graph(_) | LocalFramesError::Relax(_)) => None,
        };
        Some(Arc::new(Ranked { report: Arc::new(report), ties }))
    }

    fn with_report(session: &Session, report: Arc<Report>) -> View {
        View {
            config: session.config(),
            next_seq: session.next_seq(),
            abduction: session.abduction().for_readers(),
            report,
            survey: Arc::clone(session.survey()),
            ranked: Arc::default(),
            tags: Arc::default(),
            known: Arc::default(),
        }
    }
}
