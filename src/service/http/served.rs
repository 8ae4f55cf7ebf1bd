//! What handlers are given: the maps, and the jobs that are made of them.

use crate::service::Maps;
use crate::service::jobs::Jobs;
use axum::extract::FromRef;

/// The state of the service.
#[derive(Clone)]
pub(super) struct Served {
    /// Its maps.
    pub(super) maps: Maps,
    /// Its jobs.
    pub(super) jobs: Jobs,
}

impl Served {
    /// A service of these maps, without jobs yet.
    pub(super) fn new(maps: Maps) -> Served {
        // Half of the threads, so that whoever waits for an answer finds the others free.
        let jobs = Jobs::new(*maps.limits(), maps.patchwork_threads() / 2);
        Served { maps, jobs }
    }
}

impl FromRef<Served> for Maps {
    fn from_ref(served: &Served) -> Maps {
        served.maps.clone()
    }
}

impl FromRef<Served> for Jobs {
    fn from_ref(served: &Served) -> Jobs {
        served.jobs.clone()
    }
}
