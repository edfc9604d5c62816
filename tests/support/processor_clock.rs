//! Processor time of one thread, for benchmarks on a machine where others work too.

use std::time::Instant;

/// Processor time of this thread where the kernel tells it (Linux), else the clock on the wall.
pub(crate) struct Clock {
    begin: Instant,
}

impl Clock {
    /// The wall's zero is now.
    pub(crate) fn new() -> Self {
        Clock { begin: Instant::now() }
    }

    /// Seconds.
    pub(crate) fn seconds(&self) -> f64 {
        let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let on_processor_ns = told.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
        on_processor_ns.map_or_else(|| self.begin.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
    }
}
