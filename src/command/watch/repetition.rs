//! How often and how many times something is shown.

use std::time::Duration;

#[derive(Clone, Copy)]
pub(super) struct Repetition {
    /// Interval; `None` for the usual one.
    pub(super) every: Option<Duration>,
    /// How many times; `None` without an end.
    pub(super) count: Option<u64>,
}

impl Repetition {
    /// Whether there is more to show after so many.
    pub(super) fn more_after(self, outputs: u64) -> bool {
        self.count.is_none_or(|count| outputs < count)
    }
}
