//! Seconds on the processor and by the clock, for the benchmarks that set rivals beside the product.

use rustix::time::{ClockId, Timespec, clock_gettime};
use std::sync::OnceLock;
use std::time::Instant;

/// Seconds that this thread has been on a processor, told in less than a microsecond.
pub(crate) fn processor() -> f64 {
    let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::ThreadCPUTime);
    tv_sec as f64 + tv_nsec as f64 * 1e-9
}

/// Seconds by the clock since this was first asked.
pub(crate) fn wall() -> f64 {
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    BEGUN.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// The mean seconds that some work takes by a clock, over so many by the wall's.
pub(crate) fn mean(clock: fn() -> f64, seconds: f64, mut work: impl FnMut()) -> f64 {
    let (begun, since, mut times) = (clock(), wall(), 0);
    while times == 0 || wall() - since < seconds {
        work();
        times += 1;
    }
    (clock() - begun) / f64::from(times)
}
