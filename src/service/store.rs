//! Where maps are kept: configurations and events, in order. All else follows from them by replay.

use crate::service::{MapConfig, MapName};
use crate::trace::Event;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use thiserror::Error;

/// Keeps maps. Calls may block; the service makes none of them on an async worker, and none for one map at the
/// same time as another for that map.
pub trait Store: Send + Sync {
    /// Keeps a new map; if the name is taken, gives the configuration kept under it and changes nothing.
    fn create(&self, map: &MapName, config: MapConfig) -> Result<Created, StoreError>;

    /// Keeps further events of a map, all or none. They are safe once this returns.
    fn append(&self, map: &MapName, events: &[Arc<Event>]) -> Result<(), StoreError>;

    /// A map as it is kept, if it is.
    fn load(&self, map: &MapName) -> Result<Option<StoredMap>, StoreError>;
}

/// What came of creating a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Created {
    /// It is new.
    New,
    /// It exists with this configuration.
    Existing(MapConfig),
}

/// A map as it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredMap {
    /// How it is built.
    pub config: MapConfig,
    /// All its events.
    pub events: Vec<Arc<Event>>,
}

/// Why something is not kept.
#[derive(Debug, Error)]
pub enum StoreError {
    /// There are as many maps as there may be.
    #[error("the service holds {0} maps, which is the most it may hold; go on in one of them")]
    TooManyMaps(usize),
    /// There is no such map.
    #[error("the store has no map `{0}`")]
    UnknownMap(MapName),
    /// The medium failed.
    #[error("the store failed: {0}")]
    Failed(String),
}

/// Keeps maps in memory, until the process ends.
#[derive(Debug)]
pub struct MemoryStore {
    most_maps: usize,
    maps: Mutex<BTreeMap<MapName, StoredMap>>,
}

impl MemoryStore {
    /// A store without maps, for so many at most.
    pub fn new(most_maps: usize) -> Self {
        MemoryStore { most_maps, maps: Mutex::default() }
    }

    /// Every change is one insertion, so a panic elsewhere cannot leave the maps half changed.
    fn maps(&self) -> MutexGuard<'_, BTreeMap<MapName, StoredMap>> {
        self.maps.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for MemoryStore {
    fn create(&self, map: &MapName, config: MapConfig) -> Result<Created, StoreError> {
        let mut maps = self.maps();
        let full = maps.len() >= self.most_maps;
        match maps.entry(map.clone()) {
            Entry::Occupied(kept) => Ok(Created::Existing(kept.get().config)),
            Entry::Vacant(_) if full => Err(StoreError::TooManyMaps(self.most_maps)),
            Entry::Vacant(free) => {
                free.insert(StoredMap { config, events: Vec::new() });
                Ok(Created::New)
            }
        }
    }

    fn append(&self, map: &MapName, events: &[Arc<Event>]) -> Result<(), StoreError> {
        let mut maps = self.maps();
        let kept = maps.get_mut(map).ok_or_else(|| StoreError::UnknownMap(map.clone()))?;
        kept.events.extend_from_slice(events);
        Ok(())
    }

    fn load(&self, map: &MapName) -> Result<Option<StoredMap>, StoreError> {
        Ok(self.maps().get(map).cloned())
    }
}
