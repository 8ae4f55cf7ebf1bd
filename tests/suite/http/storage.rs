//! Sessions follow from what is stored; a store that fails takes nothing down.

use crate::http::client::{Client, JSON, NDJSON, aces, aces_lines};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use topostar::service::{
    Created, Limits, MapConfig, MapName, MemoryStore, Session, Store, StoreError, StoredMap,
};
use topostar::trace::{Event, read_trace};

#[tokio::test]
async fn another_process_over_the_same_store_answers_alike() {
    let store = Arc::new(MemoryStore::new(10));
    let first = Client::with_store(store.clone(), Limits::default());
    first.with_aces("aces", r#"{"profile":"paper"}"#).await;
    let second = Client::with_store(store, Limits::default());
    for path in ["", "/candidates", "/candidates/preferred/graph"] {
        let path = format!("/v1/maps/aces{path}");
        assert_eq!(first.get(&path).await.body, second.get(&path).await.body);
    }
}

#[test]
fn replay_of_a_prefix_is_the_session_at_that_time() {
    let (events, _) = read_trace(aces().as_bytes());
    let events: Vec<Arc<Event>> = events.into_iter().map(Arc::new).collect();
    let limits = Limits::default();
    let config = topostar::service::WireMapConfig::default().config(&limits).unwrap();
    let mut live = Session::new(config, limits);
    for (taken, event) in events.iter().enumerate() {
        let replayed = Session::replay(config, limits, &events[..taken]).unwrap();
        assert_eq!(replayed.next_seq(), live.next_seq());
        assert_eq!(replayed.abduction().report(), live.abduction().report());
        live.accept(event).unwrap();
    }
}

/// A store that fails, or panics, as often as it is told to.
struct Failing {
    kept: MemoryStore,
    failures: AtomicU8,
    panics: bool,
}

impl Store for Failing {
    fn create(&self, map: &MapName, config: MapConfig) -> Result<Created, StoreError> {
        self.kept.create(map, config)
    }

    fn append(&self, map: &MapName, events: &[Arc<Event>]) -> Result<(), StoreError> {
        let fails =
            self.failures.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).is_ok();
        match fails {
            true if self.panics => panic!("the store is told to"),
            true => Err(StoreError::Failed("the disk is full".into())),
            false => self.kept.append(map, events),
        }
    }

    fn load(&self, map: &MapName) -> Result<Option<StoredMap>, StoreError> {
        self.kept.load(map)
    }
}

#[tokio::test]
async fn events_that_are_not_kept_are_not_taken() {
    for panics in [false, true] {
        let store = Failing { kept: MemoryStore::new(1), failures: AtomicU8::new(2), panics };
        let client = Client::with_store(Arc::new(store), Limits::default());
        client.put("aces", "").await;
        for _ in 0..2 {
            client.post("aces", NDJSON, aces()).await.problem(500, "internal-error");
            assert_eq!(client.get("/v1/maps/aces").await.json()["next_seq"], 0);
        }
        let first = client.post("aces", JSON, aces_lines()[0].clone()).await;
        assert_eq!((first.status.as_u16(), &first.json()["replayed"]), (200, &serde_json::json!(0)));
        assert_eq!(client.post("aces", NDJSON, aces()).await.json()["candidates"]["value"], 23);
    }
}
