//! Samples out of a stream of bytes: frame synchroniser and decommutator one behind the other.
//!
//! Consumes the bytes of one stream without gaps, in pieces of any size; gives each sample as soon as its minor frame is
//! whole and the pattern behind it was looked at.

use super::decommutator::{BitClock, Decommutator, PcmSample};
use super::frame_sync::FrameSynchronizer;
use super::layout::PcmFormat;

/// Frame synchroniser and decommutator of one stream.
#[derive(Clone, Debug)]
pub struct PcmDecoder {
    /// Finds minor frames.
    pub synchronizer: FrameSynchronizer,
    /// Reads them.
    pub decommutator: Decommutator,
    clock: BitClock,
}

impl FrameSynchronizer {
    /// For minor frames of that format.
    #[must_use]
    pub fn of_format(format: &PcmFormat) -> Self {
        let spec = format.spec();
        FrameSynchronizer::new(spec.sync, format.rules(), spec.polarity, spec.line_code, format.minor_frame_bits())
    }
}

impl PcmDecoder {
    /// For a stream of that format whose first bit has that time, s.
    #[must_use]
    pub fn new(format: &PcmFormat, start_s: f64) -> Self {
        PcmDecoder {
            synchronizer: FrameSynchronizer::of_format(format),
            decommutator: Decommutator::new(format),
            clock: BitClock { start_s, bit_rate: format.spec().bit_rate },
        }
    }

    /// The time of the next bit that is taken in, s.
    #[must_use]
    pub fn next_bit_s(&self) -> f64 {
        self.clock.time_s(self.synchronizer.counters().bits)
    }

    /// Bits that lasted so long, s, were lost somewhere before: what follows is later by that.
    pub fn go_on_later(&mut self, by_s: f64) {
        self.clock.start_s += by_s;
    }

    /// Takes in the bytes and gives every sample of the minor frames that they complete.
    pub fn feed(&mut self, mut bytes: &[u8], mut each: impl FnMut(PcmSample)) {
        loop {
            let taken = self.synchronizer.take(bytes);
            bytes = bytes.get(taken..).unwrap_or_default();
            while let Some(frame) = self.synchronizer.next_frame() {
                self.decommutator.minor_frame(&frame, &self.clock, &mut each);
            }
            if bytes.is_empty() {
                return;
            }
        }
    }

    /// Gives the samples that waited for more bytes: the stream is at its end.
    pub fn finish(&mut self, mut each: impl FnMut(PcmSample)) {
        while let Some(frame) = self.synchronizer.last_frame() {
            self.decommutator.minor_frame(&frame, &self.clock, &mut each);
        }
    }
}
