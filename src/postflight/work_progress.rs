//! How far a long analysis is, and whether it was asked to end: told by the analysis, watched by whoever started it.
//!
//! In: steps that are planned and done, in whatever unit an analysis counts; more may be planned on the way. Out: both counts. An
//! analysis that was asked to stop ends at its next step with what it has.

use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Steps of one analysis; watched from another thread.
#[derive(Debug, Default)]
pub struct WorkProgress {
    planned: AtomicU64,
    done: AtomicU64,
    stop: AtomicBool,
}

/// Of settings: who watches, if anybody.
pub type Watch = Option<&'static WorkProgress>;

impl WorkProgress {
    /// Nothing planned, nothing done.
    pub const fn new() -> Self {
        WorkProgress { planned: AtomicU64::new(0), done: AtomicU64::new(0), stop: AtomicBool::new(false) }
    }

    /// So many steps more will be made, at most.
    pub fn plan(&self, steps: usize) {
        self.planned.fetch_add(steps as u64, Ordering::Relaxed);
    }

    /// So many of them were made, or turned out not to be needed.
    pub fn advance(&self, steps: usize) {
        self.done.fetch_add(steps as u64, Ordering::Relaxed);
    }

    /// Steps done and planned.
    pub fn counts(&self) -> (u64, u64) {
        (self.done.load(Ordering::Relaxed), self.planned.load(Ordering::Relaxed))
    }

    /// Asks the analysis to end at its next step.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl PartialEq for WorkProgress {
    /// Settings are the same where the same one watches.
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self, other)
    }
}

/// So many steps more will be made, at most; for who watches.
pub(crate) fn plan(watch: Watch, steps: usize) {
    if let Some(work) = watch {
        work.plan(steps);
    }
}

/// So many of them were made, or turned out not to be needed; for who watches.
pub(crate) fn advance(watch: Watch, steps: usize) {
    if let Some(work) = watch {
        work.advance(steps);
    }
}

/// Whether the analysis that is watched so was asked to end.
pub(crate) fn is_stopped(watch: Watch) -> bool {
    watch.is_some_and(WorkProgress::is_stopped)
}
