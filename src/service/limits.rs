//! What the service lets one client, and all of them, use.

use crate::trace::ndjson::MAX_LINE;

/// Bounds, so that nothing grows without one. Every refusal names its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maps in all.
    pub maps: usize,
    /// Events of one map.
    pub events_per_map: usize,
    /// Grid cells of the observations of one map.
    pub cells_per_map: usize,
    /// The most candidates a map may keep, and the number kept unless its configuration asks for fewer.
    pub candidates_per_map: usize,
    /// The most bytes that the search of a map may hold, and the number unless its configuration asks for fewer.
    pub memory_per_map: usize,
    /// The most partial explanations that a search for the simplest candidates alone looks at after a batch of
    /// events.
    pub steps_per_map: u64,
    /// Bytes of a configuration.
    pub config_bytes: usize,
    /// Bytes of a JSON body of events. An NDJSON body is bounded by its lines only.
    pub json_bytes: usize,
    /// Bytes of a line of NDJSON.
    pub line_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            maps: 1_000,
            events_per_map: 100_000,
            cells_per_map: 64 * 1024 * 1024,
            candidates_per_map: 20_000,
            memory_per_map: 256 * 1024 * 1024,
            steps_per_map: 100_000,
            config_bytes: 64 * 1024,
            json_bytes: 64 * 1024 * 1024,
            line_bytes: MAX_LINE as usize,
        }
    }
}
