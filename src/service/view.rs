//! What readers see of a map: a snapshot that no running search holds up.

use crate::abduction::{Abduction, Report};
use crate::service::{MapConfig, Session};
use std::sync::Arc;

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
            return View::with_report(session, Arc::clone(&self.report));
        }
        View::of(session)
    }

    fn with_report(session: &Session, report: Arc<Report>) -> View {
        let (config, next_seq) = (session.config(), session.next_seq());
        View { config, next_seq, abduction: session.abduction().for_readers(), report }
    }
}
