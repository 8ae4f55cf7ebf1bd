//! All maps of the service: one session each, in order for one map and side by side for several.

use crate::service::{
    Batch, Created, Intake, Limits, MapConfig, MapName, Panicked, Session, SessionError, Store, StoreError,
    Taken, View, Workers, Workload, view::Ranked,
};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use thiserror::Error;
use tokio::sync::{Mutex as TurnMutex, watch};
use tokio::time::timeout;

/// The maps. A clone is another handle to the same maps.
#[derive(Clone)]
pub struct Maps {
    store: Arc<dyn Store>,
    limits: Limits,
    live: Arc<Mutex<BTreeMap<MapName, Arc<LiveMap>>>>,
    /// Apart, so that a read never waits for a search.
    searches: Workers,
    reads: Workers,
    /// Apart too: what may take long holds up neither. There are two at least, as jobs take half of them.
    patchworks: Workers,
}

/// Why the service cannot do what was asked of a map.
#[derive(Debug, Error)]
pub enum MapsError {
    /// There is no such map.
    #[error("there is no map `{0}`; make it first with PUT /v1/maps/{0}")]
    Unknown(MapName),
    /// It exists with another configuration.
    #[error("the map `{0}` exists with another configuration, which cannot change; choose another name")]
    OtherConfig(MapName),
    /// The store did not keep it.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// What was kept does not replay.
    #[error("the events kept do not replay: {0}")]
    Replay(#[from] SessionError),
    /// The work ended in a panic.
    #[error(transparent)]
    Panicked(#[from] Panicked),
}

struct LiveMap {
    /// None after work was cut short: the next one to take its turn replays what is kept.
    session: Arc<TurnMutex<Option<Session>>>,
    view: watch::Sender<Arc<View>>,
}

impl Maps {
    /// The maps of a store.
    pub fn new(store: Arc<dyn Store>, limits: Limits) -> Self {
        let (searches, reads, patchworks) = (Workers::default(), Workers::default(), Workers::at_least(2));
        Maps { store, limits, live: Arc::default(), searches, reads, patchworks }
    }

    /// The bounds they keep.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Makes a map, or finds that it exists with this configuration.
    pub async fn create(&self, name: &MapName, config: MapConfig) -> Result<Created, MapsError> {
        let (store, key) = (Arc::clone(&self.store), name.clone());
        match self.reads.run(move || store.create(&key, config)).await?? {
            Created::Existing(other) if other != config => Err(MapsError::OtherConfig(name.clone())),
            created => Ok(created),
        }
    }

    /// What a map shows now.
    pub async fn view(&self, name: &MapName) -> Result<Arc<View>, MapsError> {
        Ok(self.find(name).await?.view.borrow().clone())
    }

    /// Takes events into a map. Returns when they are kept, and not before the map's readers see them.
    pub async fn take(&self, name: &MapName, batch: Batch) -> Result<(Taken, Arc<View>), MapsError> {
        let live = self.find(name).await?;
        let mut turn = Arc::clone(&live.session).lock_owned().await;
        let (maps, name) = (self.clone(), name.clone());
        self.searches.run(move || maps.take_in_turn(&name, &live, &mut turn, &batch)).await?
    }

    /// Computes from a view, away from the async workers.
    pub async fn read<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, MapsError> {
        Ok(self.reads.run(work).await?)
    }

    /// Relaxes a candidate and what follows from that, away from the async workers. The work is told to stop when nobody
    /// waits for it any more, and after the time that the limits leave it.
    pub async fn lay_out<T: Send + 'static>(
        &self,
        work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
    ) -> Result<T, MapsError> {
        self.lay_out_within(self.limits.patchwork_time, work).await
    }

    /// The same for work that may take another time.
    pub(super) async fn lay_out_within<T: Send + 'static>(
        &self,
        longest: Duration,
        work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
    ) -> Result<T, MapsError> {
        Ok(self.patchworks.run_while_wanted(longest, work).await?)
    }

    /// The relaxations and grids in the making, and those that have ended.
    pub fn patchworks(&self) -> Workload {
        self.patchworks.workload()
    }

    /// How many relaxations and grids may be in the making at once.
    pub fn patchwork_threads(&self) -> usize {
        self.patchworks.threads()
    }

    /// What a view found, with the simplest maps in order. One of those who wait relaxes them, and all others wait without a
    /// thread; if that one goes away, the next begins anew with what visits were found to show of each other. Nobody waits
    /// longer than the limits leave a patchwork: then the order is that of the assignments, this once.
    pub async fn ranked(&self, view: &Arc<View>) -> Result<Arc<Ranked>, MapsError> {
        self.ranked_within(self.limits.patchwork_time, view).await
    }

    /// The same for those who may wait another time.
    pub(super) async fn ranked_within(
        &self,
        longest: Duration,
        view: &Arc<View>,
    ) -> Result<Arc<Ranked>, MapsError> {
        if !view.has_ties() {
            return Ok(view.unranked());
        }
        let rank = || async {
            let view = Arc::clone(view);
            self.lay_out_within(longest, move |interrupted| view.rank(interrupted))
                .await
                .map_err(Some)?
                .ok_or(None)
        };
        match timeout(longest, view.ranked.get_or_try_init(rank)).await {
            Ok(Ok(ranked)) => Ok(Arc::clone(ranked)),
            Ok(Err(Some(error))) => Err(error),
            Ok(Err(None)) | Err(_) => Ok(view.unranked()),
        }
    }

    /// While the work runs the session is out of its place: a panic leaves none rather than half of one.
    fn take_in_turn(
        &self,
        name: &MapName,
        live: &LiveMap,
        place: &mut Option<Session>,
        batch: &Batch,
    ) -> Result<(Taken, Arc<View>), MapsError> {
        let mut session = match place.take() {
            Some(session) => session,
            None => self.replay(name)?,
        };
        let taken = Intake::take(&mut session, batch);
        self.settle(&mut session);
        if !taken.new.is_empty() {
            self.store.append(name, &taken.new)?;
        }
        let shown = live.view.borrow().clone();
        if !shown.shows(&session) {
            live.view.send_replace(Arc::new(shown.next(&session)));
        }
        *place = Some(session);
        Ok((taken, live.view.borrow().clone()))
    }

    async fn find(&self, name: &MapName) -> Result<Arc<LiveMap>, MapsError> {
        if let Some(live) = self.live().get(name) {
            return Ok(Arc::clone(live));
        }
        let (maps, key) = (self.clone(), name.clone());
        let session = self.searches.run(move || maps.replay(&key)).await??;
        let live = || Arc::new(LiveMap::new(session));
        Ok(Arc::clone(self.live().entry(name.clone()).or_insert_with(live)))
    }

    fn replay(&self, name: &MapName) -> Result<Session, MapsError> {
        let stored = self.store.load(name)?.ok_or_else(|| MapsError::Unknown(name.clone()))?;
        let mut session = Session::replay(stored.config, self.limits, &stored.events)?;
        self.settle(&mut session);
        Ok(session)
    }

    /// No request holds a thread longer than that. What is not proven by then is said not to be.
    fn settle(&self, session: &mut Session) {
        let begun = Instant::now();
        session.settle(&|| begun.elapsed() >= self.limits.settling);
    }

    /// Every change is one insertion, so a panic elsewhere cannot leave the maps half changed.
    fn live(&self) -> MutexGuard<'_, BTreeMap<MapName, Arc<LiveMap>>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LiveMap {
    fn new(session: Session) -> Self {
        let view = watch::Sender::new(Arc::new(View::of(&session)));
        LiveMap { session: Arc::new(TurnMutex::new(Some(session))), view }
    }
}
