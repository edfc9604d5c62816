//! A stream out of values: the inverse of frame synchroniser and decommutator, for the same formats.
//!
//! Consumes the value of each parameter in engineering units at the time of its word; produces the bytes of the line, minor
//! frame by minor frame, randomised where the format's line code asks for it and inverted where it expects that polarity. The
//! time of a word is that of the leading edge of its first bit, as in the [decommutator](super::decommutator). Words that no
//! parameter stands in are zero. Where two parameters share bits, that of the later place in the minor frame, and there the
//! later parameter, is sent. A value beyond what its word can hold is sent as the nearest that it can, and counted. What is no
//! number is sent where the encoding has bits for it (IEEE 754), and refused elsewhere.

use super::bits::{LineCode, Randomizer, read_bits, write_bits};
use super::calibration::CalibrationError;
use super::decommutator::BitClock;
use super::encoding::RawWord;
use super::format::{Parity, ParityPlace};
use super::layout::PcmFormat;
use super::sync_pattern::PolarityRule;

/// Why nothing can be sent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum PcmEncoderError {
    #[error("parameter {}: its calibration has no inverse: {error}", parameter + 1)]
    NoInverse { parameter: usize, error: CalibrationError },
    #[error("parameter {} at {time_s} s: expected a number, found {value}", parameter + 1)]
    NoNumber { parameter: usize, time_s: f64, value: f64 },
}

/// Makes a stream.
#[derive(Clone, Debug)]
pub struct PcmEncoder {
    format: PcmFormat,
    /// Least and greatest raw number of each place.
    ranges: Vec<(f64, f64)>,
    clock: BitClock,
    frame: Box<[u8]>,
    /// Number of the next minor frame, and its first bit.
    number: u32,
    bit: u64,
    line: LineWriter,
    saturated: u64,
}

impl PcmEncoder {
    /// Begins with minor frame 1 at that time, s.
    ///
    /// # Errors
    /// [`PcmEncoderError::NoInverse`] where the values of a parameter are not those of one raw number each.
    pub fn new(format: &PcmFormat, start_s: f64) -> Result<Self, PcmEncoderError> {
        let mut ranges = Vec::with_capacity(format.places().len());
        for place in format.places() {
            let Some(parameter) = format.parameters().get(place.parameter) else { continue };
            let range = parameter.encoding.range(place.bits).unwrap_or_default();
            let wrong = |error| PcmEncoderError::NoInverse { parameter: place.parameter, error };
            parameter.calibration.check_inverse(range.0, range.1).map_err(wrong)?;
            ranges.push(range);
        }
        let spec = format.spec();
        Ok(PcmEncoder {
            ranges,
            clock: BitClock { start_s, bit_rate: spec.bit_rate },
            frame: vec![0; format.minor_frame_bits().div_ceil(8)].into(),
            number: 1,
            bit: 0,
            line: LineWriter::new(spec.line_code, spec.polarity == PolarityRule::Inverted),
            saturated: 0,
            format: format.clone(),
        })
    }

    /// The same with every bit of the line inverted, whatever polarity the format expects.
    #[must_use]
    pub fn inverted(mut self) -> Self {
        self.line.flip = !self.line.flip;
        self
    }

    /// Appends the whole bytes of the next minor frame; `value` is asked for each parameter at the time of each of its words,
    /// s.
    ///
    /// # Errors
    /// [`PcmEncoderError::NoNumber`] where it gives none and the encoding has no bits for that; then nothing is sent.
    pub fn minor_frame(&mut self, mut value: impl FnMut(usize, f64) -> f64, out: &mut Vec<u8>) -> Result<(), PcmEncoderError> {
        let spec = self.format.spec();
        self.frame.fill(0);
        write_bits(&mut self.frame, 0, spec.sync.bits, spec.sync.pattern);
        for (place, (low, high)) in self.format.places().iter().zip(&self.ranges) {
            if place.frames.is_some_and(|frames| !frames.contains(self.number)) {
                continue;
            }
            let Some(parameter) = spec.parameters.get(place.parameter) else { continue };
            let time_s = self.clock.time_s(self.bit + u64::from(place.offset));
            let wanted = value(place.parameter, time_s);
            let word = match parameter.encoding.no_number() {
                Some(raw) if wanted.is_nan() => Some((false, RawWord { raw, saturated: false })),
                _ => {
                    let inverse = parameter.calibration.inverse(wanted, *low, *high);
                    inverse.and_then(|found| Some((found.beyond, parameter.encoding.encode(found.raw, place.bits)?)))
                }
            };
            let Some((beyond, word)) = word else {
                return Err(PcmEncoderError::NoNumber { parameter: place.parameter, time_s, value: wanted });
            };
            self.saturated += u64::from(beyond || word.saturated);
            let mut left = word.raw;
            for part in place.parts.iter().rev() {
                write_bits(&mut self.frame, part.offset as usize, part.bits, left);
                left = left.checked_shr(part.bits).unwrap_or(0);
            }
        }
        if let (Some(id), Some(part)) = (spec.subframe_id, self.format.subframe_part()) {
            write_bits(&mut self.frame, part.offset as usize, part.bits, id.value(self.number).into());
        }
        self.set_parity();
        self.line.write(&self.frame, self.format.minor_frame_bits(), out);
        self.number = self.number % self.format.spec().minor_frames + 1;
        self.bit += self.format.minor_frame_bits() as u64;
        Ok(())
    }

    /// Fills the last byte with zeros and appends it, where bits of it are left.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        self.line.finish(out);
    }

    /// First bit of the next minor frame in the stream.
    #[must_use]
    pub fn bit(&self) -> u64 {
        self.bit
    }

    /// Values beyond what their words can hold.
    #[must_use]
    pub fn saturated(&self) -> u64 {
        self.saturated
    }

    fn set_parity(&mut self) {
        for word in self.format.words() {
            let (odd, place) = match word.parity {
                Parity::None => continue,
                Parity::Odd(place) => (true, place),
                Parity::Even(place) => (false, place),
            };
            let (data, bits) = word.data();
            let ones = read_bits(&self.frame, data as usize, bits).map_or(0, u64::count_ones);
            let at = match place {
                ParityPlace::Leading => word.offset,
                ParityPlace::Trailing => word.offset + word.bits - 1,
            };
            write_bits(&mut self.frame, at as usize, 1, u64::from((ones % 2 == 1) != odd));
        }
    }
}

/// Bits to bytes of the line.
#[derive(Clone, Debug)]
struct LineWriter {
    randomizer: Option<Randomizer>,
    flip: bool,
    /// The last bits that make no byte yet, in the lowest places.
    left: u16,
    bits: u32,
}

impl LineWriter {
    fn new(code: LineCode, flip: bool) -> Self {
        let randomizer = match code {
            LineCode::NrzL => None,
            LineCode::RnrzL => Some(Randomizer::default()),
        };
        LineWriter { randomizer, flip, left: 0, bits: 0 }
    }

    fn write(&mut self, frame: &[u8], bits: usize, out: &mut Vec<u8>) {
        let whole = bits / 8;
        for byte in frame.iter().take(whole) {
            self.push(*byte, 8, out);
        }
        let rest = (bits % 8) as u32;
        if let Some(last) = frame.get(whole).filter(|_| rest > 0) {
            self.push(last >> (8 - rest), rest, out);
        }
    }

    fn push(&mut self, bits: u8, count: u32, out: &mut Vec<u8>) {
        self.left = self.left << count | u16::from(bits);
        self.bits += count;
        if self.bits < 8 {
            return;
        }
        self.bits -= 8;
        let data = (self.left >> self.bits) as u8;
        let sent = self.randomizer.as_mut().map_or(data, |randomizer| randomizer.byte(data));
        out.push(if self.flip { !sent } else { sent });
        self.left &= (1 << self.bits) - 1;
    }

    fn finish(&mut self, out: &mut Vec<u8>) {
        if self.bits > 0 {
            self.push(0, 8 - self.bits, out);
        }
    }
}

#[cfg(test)]
#[path = "encoder_tests.rs"]
mod tests;
