//! The recorded traces in `worlds/` as visits.

use std::fs::File;
use std::io::BufReader;
use topostar::abduction::Visit;
use topostar::star::PerceptionParameters;
use topostar::trace::perceive::perceive;
use topostar::trace::{Experience, read_trace};

/// The visits of a trace file of `worlds/`, by its name without ending.
pub(crate) fn visits(name: &str) -> Vec<Visit> {
    let path = format!("{}/worlds/{name}.ndjson", env!("CARGO_MANIFEST_DIR"));
    let file = File::open(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let (events, fault) = read_trace(BufReader::new(file));
    assert!(fault.is_none(), "{path}: {fault:?}");
    let mut experience = Experience::new();
    let parameters = PerceptionParameters::default();
    let look = |event| experience.accept(event, &|lpm, first| perceive(lpm, first, &parameters)).unwrap();
    events.iter().filter_map(look).map(|sighting| Visit::from(&sighting)).collect()
}
