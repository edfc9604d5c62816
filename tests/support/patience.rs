//! Waits for other processes. A limit here tells a hang from a slow machine, and measures nothing.

use std::time::{Duration, Instant};

/// Long enough for a machine whose cores are all busy with something else.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Tries until it holds; panics when patience is at its end.
pub(crate) fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "not within {PATIENCE:?}: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
