//! A process of this program's own that ends with whoever started it.

use sideslip::error::Failure;
use std::process::Child;

/// It is ended when this goes, however that comes.
pub(super) struct ChildGuard(pub(super) Child);

impl Drop for ChildGuard {
    fn drop(&mut self) {
        if !matches!(self.0.try_wait(), Ok(Some(_))) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }
}

/// The failure of a demonstration that a signal stopped.
pub(super) fn stopped_early() -> Failure {
    Failure::Running("stopped by a signal before all was done; the log is closed".to_owned())
}
