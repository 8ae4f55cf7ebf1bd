//! Seconds on the processor and by the clock, for the benchmarks that set rivals beside the product.

use std::fs;
use std::sync::OnceLock;
use std::time::Instant;

/// Seconds that this thread has been on a processor, as Linux counts them; elsewhere those of the clock.
pub(crate) fn processor() -> f64 {
    let counted = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = counted.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(wall, |nanoseconds| nanoseconds * 1e-9)
}

/// Seconds by the clock since this was first asked.
pub(crate) fn wall() -> f64 {
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    BEGUN.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// The mean seconds that some work takes by a clock, over so many by the wall's: a single run is counted too coarsely.
pub(crate) fn mean(clock: fn() -> f64, seconds: f64, mut work: impl FnMut()) -> f64 {
    let (begun, since, mut times) = (clock(), wall(), 0);
    while times == 0 || wall() - since < seconds {
        work();
        times += 1;
    }
    (clock() - begun) / f64::from(times)
}
