//! One number for everything that a pipeline brought out: equal only where every bit of every record is.
//!
//! FNV-1a (64 bits) over the records' text, in which a float is written shortest that reads back as the same bits; so no
//! field can be forgotten and a NaN has no payload.

use core::fmt::Write;
use sideslip::realtime::pipeline::Tick;

/// The number so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(pub u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Fingerprint(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    /// Takes everything in that one sample brought.
    pub fn take(&mut self, tick: &Tick) {
        // Writing into a number cannot fail.
        let _ = write!(self, "{tick:?}");
    }
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Ok(())
    }
}
