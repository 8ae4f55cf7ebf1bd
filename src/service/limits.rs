//! What the service lets one client, and all of them, use.

use crate::trace::ndjson::MAX_LINE;
use std::ops::RangeInclusive;
use std::time::Duration;

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
    /// The most partial explanations that a search for the simplest candidates alone looks at, on a walk of
    /// [`Limits::SHORT`] observations or fewer; see [`Limits::steps`].
    pub steps_per_map: u64,
    /// How long that search may take for one request; the next request to the map goes on with it.
    pub settling: Duration,
    /// Cells of a grid that is answered with.
    pub cells_per_answer: usize,
    /// How long one waits for the relaxation of a candidate and the making of its grid, before a job is made of it; and how
    /// long ties may be relaxed to be put in order.
    pub patchwork_time: Duration,
    /// How long any of these may take as a job.
    pub job_time: Duration,
    /// Jobs in all, those that have ended and are kept among them.
    pub jobs: usize,
    /// How long a job is kept that has ended.
    pub job_kept: Duration,
    /// Bytes of what kept jobs made; what was made last is kept, however large.
    pub job_bytes: usize,
    /// Bytes of a configuration.
    pub config_bytes: usize,
    /// Bytes of a JSON body of events. An NDJSON body is bounded by its lines only.
    pub json_bytes: usize,
    /// Bytes of a line of NDJSON.
    pub line_bytes: usize,
}

impl Limits {
    /// Sides of the cells of a grid that may be asked for, metres.
    pub const RESOLUTIONS: RangeInclusive<f64> = 0.01..=1.0;
    /// The observations of a walk that is short.
    pub const SHORT: usize = 64;

    /// The most partial explanations looked at on a walk of so many observations. One of them costs about the square of
    /// these, so that long walks have fewer, but never fewer than it takes to find some candidate.
    pub fn steps(&self, observations: usize) -> u64 {
        let short = Limits::SHORT.pow(2) as u128;
        let square = (observations as u128).pow(2).max(short);
        let fewer = u128::from(self.steps_per_map) * short / square;
        let least = self.steps_per_map.min(2 * observations as u64);
        u64::try_from(fewer).unwrap_or(u64::MAX).max(least)
    }
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
            settling: Duration::from_secs(10),
            cells_per_answer: 8 * 1024 * 1024,
            patchwork_time: Duration::from_secs(20),
            job_time: Duration::from_secs(600),
            jobs: 64,
            job_kept: Duration::from_secs(3600),
            job_bytes: 256 * 1024 * 1024,
            config_bytes: 64 * 1024,
            json_bytes: 64 * 1024 * 1024,
            line_bytes: MAX_LINE as usize,
        }
    }
}
