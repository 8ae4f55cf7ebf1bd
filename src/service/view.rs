//! What readers see of a map: a snapshot that no running search holds up.

use crate::abduction::{Abduction, Report};
use crate::export::Ties;
use crate::patchwork::survey::Survey;
use crate::service::{MapConfig, Session};
use std::sync::{Arc, OnceLock};

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
    /// The same report once the simplest maps are in order.
    ranked: Arc<OnceLock<Ranked>>,
}

/// What was found, the simplest maps in the order of their strain where that can be told.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// What was found. Its first simplest map is the preferred one.
    pub report: Report,
    /// What told the simplest maps apart, where there are several and travels were measured.
    pub ties: Option<Ties>,
}

impl View {
    /// What a session shows now.
    pub fn of(session: &Session) -> View {
        View::with_report(session, Arc::new(session.abduction().report()))
    }

    /// What the session of this view shows now. Only an observation or an operator's word changes what is found.
    pub fn next(&self, session: &Session) -> View {
        let (now, shown) = (session.abduction(), &self.abduction);
        if now.observations() == shown.observations() && now.word() == shown.word() {
            let (report, ranked) = (Arc::clone(&self.report), Arc::clone(&self.ranked));
            return View { ranked, ..View::with_report(session, report) };
        }
        View::of(session)
    }

    /// What was found, with the simplest maps in order. The first to ask relaxes those that tie, a bounded number
    /// ([`crate::patchwork::ties`]): belongs to a worker.
    pub fn ranked(&self) -> &Ranked {
        self.ranked.get_or_init(|| {
            let mut report = Report::clone(&self.report);
            // Measurements that cannot be relaxed do not tell the maps apart.
            let ties = Ties::rank(&mut report, &self.survey, &|| false).ok().flatten();
            Ranked { report, ties }
        })
    }

    fn with_report(session: &Session, report: Arc<Report>) -> View {
        View {
            config: session.config(),
            next_seq: session.next_seq(),
            abduction: session.abduction().for_readers(),
            report,
            survey: Arc::clone(session.survey()),
            ranked: Arc::default(),
        }
    }
}
