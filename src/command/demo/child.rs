//! A process of this program's own that ends with whoever started it.

use std::process::Child;

/// It is ended when this goes, however that comes.
pub(super) struct EndsWithUs(pub(super) Child);

impl Drop for EndsWithUs {
    fn drop(&mut self) {
        if !matches!(self.0.try_wait(), Ok(Some(_))) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }
}
