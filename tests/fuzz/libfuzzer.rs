//! The fuzz targets under libFuzzer: one binary for each, which is told its target by its own name.
//!
//! With `SIDESLIP_FUZZ_STATISTICS` set, each new extreme of time and memory is printed.
#![no_main]

#[path = "../support/allocations.rs"]
#[allow(dead_code, reason = "the counts of calls are for other tests")]
mod allocations;
#[allow(dead_code, reason = "seeds are made elsewhere")]
mod targets;

/// Where the targets expect it.
mod support {
    pub(crate) use super::allocations;
}

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use targets::Target;

#[global_allocator]
static ALLOCATOR: allocations::Counted = allocations::Counted;

static TARGET: LazyLock<&Target> = LazyLock::new(|| Target::named(env!("CARGO_BIN_NAME")));
static TOLD: LazyLock<bool> = LazyLock::new(|| std::env::var_os("SIDESLIP_FUZZ_STATISTICS").is_some());
static SLOWEST_US: AtomicU64 = AtomicU64::new(1000);
static MOST_BYTES: AtomicU64 = AtomicU64::new(1 << 16);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let begun = Instant::now();
    let held = TARGET.run(bytes).held;
    if *TOLD {
        let us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        let (slowest, most) = (SLOWEST_US.fetch_max(us, Ordering::Relaxed), MOST_BYTES.fetch_max(held, Ordering::Relaxed));
        // A tenth more at least, so that the log stays short.
        if us > slowest + slowest / 10 || held > most + most / 10 {
            eprintln!("EXTREME: {us} us, {held} bytes held, for {} bytes", bytes.len());
        }
    }
});
