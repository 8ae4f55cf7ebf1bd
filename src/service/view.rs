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

    /// What the session of this view shows now. Only an observation, an operator's word, or a search that went on where
    /// it was interrupted changes what is found.
    pub fn next(&self, session: &Session) -> View {
        match self.finds_what(session) {
            true => View::with_report(session, Arc::clone(&self.report)),
            false => View::of(session),
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

    fn with_report(session: &Session, report: Arc<Report>) -> View {
        let (config, next_seq) = (session.config(), session.next_seq());
        View { config, next_seq, abduction: session.abduction().for_readers(), report }
    }
}
