//! Samples out of minor frames.
//!
//! Consumes minor frames, from the frame synchroniser or from a recorder, with the time of their first bit; produces a sample
//! for each place of a parameter in them, in the order of their places.
//!
//! A sample's time is that of the leading edge of the first bit of its word (of the first sent of its words), its parity bit
//! included: `t = t0 + (bits from the stream's first bit to it) / bit rate`. A word's value exists when its first bit goes
//! out and not before its turn, so of all instants that the stream tells this is the nearest to the measurement; the last bit
//! comes later by the length of the word and tells nothing more. It is also the instant that IRIG 106 Chapter 10 takes for
//! the time of a minor frame, there for the first bit of the pattern. Delays of filters and encoders before that are not
//! known here.
//!
//! Nothing is repaired and no sample is dropped for its value; flags say what is wrong with it. Subcommutated samples of a
//! minor frame whose number is in doubt are left out, because their parameter is not known, and such minor frames are
//! counted. Nothing is allocated after the start.

use super::bits::read_bits;
use super::format::ParameterSpec;
use super::frame_sync::MinorFrame;
use super::layout::{PartLayout, PcmFormat};
use super::parity_check::ParityCheck;
use super::step_check::StepCheck;
use super::subframe::{SubframeCounters, SubframeTracker};

/// What is wrong with a sample: any of these at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleFlags(u8);

impl SampleFlags {
    /// Nothing.
    pub const NONE: Self = SampleFlags(0);
    /// One of its words has wrong parity, or one that is in doubt ([`ParityCheck`]).
    pub const PARITY: Self = SampleFlags(1);
    /// Below its low limit.
    pub const LOW: Self = SampleFlags(2);
    /// Above its high limit.
    pub const HIGH: Self = SampleFlags(4);
    /// Its raw number is outside of the calibration's range.
    pub const EXTRAPOLATED: Self = SampleFlags(8);
    /// Its bits are no number, or one without an engineering value.
    pub const NO_VALUE: Self = SampleFlags(16);
    /// Its minor frame has no pattern at one of its ends: the bits may not be those of the parameter.
    pub const DOUBTFUL_FRAME: Self = SampleFlags(32);
    /// Further from the samples of its parameter beside it than their largest step.
    pub const STEP: Self = SampleFlags(64);

    /// Whether all of the others are among them.
    #[must_use]
    pub const fn contains(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// Both.
    #[must_use]
    pub const fn with(self, others: Self) -> Self {
        SampleFlags(self.0 | others.0)
    }

    const fn when(self, is: bool) -> Self {
        if is { self } else { Self::NONE }
    }
}

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PcmSample {
    /// Which parameter of the format, from 0.
    pub parameter: usize,
    /// Its time, s.
    pub time_s: f64,
    /// Its bits, the last in the lowest place.
    pub raw: u64,
    /// Its value in engineering units, where it has one.
    pub value: Option<f64>,
    /// What is wrong with it.
    pub flags: SampleFlags,
}

/// The time of each bit of a stream without gaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BitClock {
    /// Time of the leading edge of bit 0, s.
    pub start_s: f64,
    /// Bits a second.
    pub bit_rate: f64,
}

impl BitClock {
    /// The time of the leading edge of a bit, s.
    #[must_use]
    pub fn time_s(&self, bit: u64) -> f64 {
        self.start_s + bit as f64 / self.bit_rate
    }
}

/// What was found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecommutationCounters {
    /// Minor frames.
    pub minor_frames: u64,
    /// Minor frames of another length than the format's: not read.
    pub wrong_length: u64,
    /// Samples.
    pub samples: u64,
    /// Words with wrong parity, measured or not.
    pub parity_errors: u64,
    /// Words whose parity was checked.
    pub parity_checks: u64,
    /// Words with right parity that is in doubt.
    pub parity_doubted: u64,
    /// Samples beyond their limits.
    pub out_of_limits: u64,
    /// Samples too far from those beside them.
    pub beyond_step: u64,
    /// Samples with extrapolated values.
    pub extrapolated: u64,
    /// Samples without a value.
    pub no_value: u64,
    /// Minor frames whose subcommutated samples were left out.
    pub withheld_frames: u64,
    /// Subframe identifiers.
    pub subframe_id: SubframeCounters,
}

/// A place to be read.
#[derive(Clone, Copy, Debug)]
struct Take {
    parameter: usize,
    offset: u32,
    bits: u32,
    /// Among all of the parts.
    parts: (usize, usize),
}

/// Reads minor frames.
#[derive(Clone, Debug)]
pub struct Decommutator {
    parameters: Vec<ParameterSpec>,
    minor_frame_bits: usize,
    parts: Vec<PartLayout>,
    /// Places of every minor frame, then of minor frame 1, 2, ... with these among them.
    takes: Vec<Vec<Take>>,
    parity: ParityCheck,
    subframe: Option<(PartLayout, SubframeTracker)>,
    subcommutated: bool,
    /// By parameter.
    steps: Vec<StepCheck>,
    counters: DecommutationCounters,
}

impl Decommutator {
    /// For that format.
    #[must_use]
    pub fn new(format: &PcmFormat) -> Self {
        let minor_frames = format.spec().minor_frames;
        let mut parts = Vec::new();
        let mut takes = vec![Vec::new(); minor_frames as usize + 1];
        for place in format.places() {
            let from = parts.len();
            parts.extend_from_slice(&place.parts);
            let take = Take { parameter: place.parameter, offset: place.offset, bits: place.bits, parts: (from, parts.len()) };
            for (number, takes) in (0..).zip(&mut takes) {
                if place.frames.is_none_or(|frames| frames.contains(number)) {
                    takes.push(take);
                }
            }
        }
        let tracker = |part| {
            let id = format.spec().subframe_id?;
            Some((part, SubframeTracker::new(id, minor_frames, format.minor_frame_bits())))
        };
        Decommutator {
            parameters: format.parameters().to_vec(),
            minor_frame_bits: format.minor_frame_bits(),
            parts,
            takes,
            parity: ParityCheck::new(format),
            subframe: format.subframe_part().and_then(tracker),
            subcommutated: format.places().iter().any(|place| place.frames.is_some()),
            steps: vec![StepCheck::default(); format.parameters().len()],
            counters: DecommutationCounters::default(),
        }
    }

    /// Gives each sample of a minor frame of a stream, and returns the frame's number in its major frame, where it is known.
    pub fn minor_frame(&mut self, frame: &MinorFrame<'_>, clock: &BitClock, each: impl FnMut(PcmSample)) -> Option<u32> {
        let in_frame = |offset: u32| clock.time_s(frame.first_bit.saturating_add(offset.into()));
        self.read(frame, in_frame, each)
    }

    /// The same for a minor frame that has a clock of its own: its first bit is the clock's bit 0. Its place in the stream serves
    /// the continuity of the subframe identifier alone.
    pub fn timed_minor_frame(&mut self, frame: &MinorFrame<'_>, clock: &BitClock, each: impl FnMut(PcmSample)) -> Option<u32> {
        self.read(frame, |offset| clock.time_s(offset.into()), each)
    }

    /// What was found so far.
    #[must_use]
    pub fn counters(&self) -> DecommutationCounters {
        let subframe_id = self.subframe.as_ref().map(|(_, tracker)| tracker.counters()).unwrap_or_default();
        let (parity_errors, parity_checks) = self.parity.errors();
        let parity_doubted = self.parity.doubted();
        DecommutationCounters { subframe_id, parity_errors, parity_checks, parity_doubted, ..self.counters }
    }

    fn read(&mut self, frame: &MinorFrame<'_>, time_s: impl Fn(u32) -> f64, mut each: impl FnMut(PcmSample)) -> Option<u32> {
        self.counters.minor_frames += 1;
        if frame.bits != self.minor_frame_bits || frame.bytes.len() * 8 < frame.bits {
            self.counters.wrong_length += 1;
            return None;
        }
        self.parity.check(frame.bytes);
        let number = self.subframe.as_mut().and_then(|(part, tracker)| {
            let value = read_bits(frame.bytes, part.offset as usize, part.bits)?;
            tracker.number(value, frame.first_bit)
        });
        self.counters.withheld_frames += u64::from(self.subcommutated && number.is_none());
        let frame_flags = SampleFlags::DOUBTFUL_FRAME.when(frame.is_doubtful());
        let takes = self.takes.get(number.unwrap_or(0) as usize).map_or(&[][..], Vec::as_slice);
        for take in takes {
            let Some(parameter) = self.parameters.get(take.parameter) else { continue };
            let (mut raw, mut flags) = (0_u64, frame_flags);
            for part in self.parts.get(take.parts.0..take.parts.1).unwrap_or_default() {
                let bits = read_bits(frame.bytes, part.offset as usize, part.bits).unwrap_or_default();
                raw = raw.checked_shl(part.bits).unwrap_or(0) | bits;
                flags = flags.with(SampleFlags::PARITY.when(self.parity.refuses(part.word)));
            }
            let calibrated = parameter.encoding.decode(raw, take.bits).and_then(|number| parameter.calibration.apply(number));
            let value = calibrated.map(|found| found.value);
            let limits = parameter.limits;
            let low = matches!((value, limits.low), (Some(value), Some(low)) if value < low);
            let high = matches!((value, limits.high), (Some(value), Some(high)) if value > high);
            let extrapolated = calibrated.is_some_and(|found| found.extrapolated);
            flags = flags
                .with(SampleFlags::LOW.when(low))
                .with(SampleFlags::HIGH.when(high))
                .with(SampleFlags::EXTRAPOLATED.when(extrapolated))
                .with(SampleFlags::NO_VALUE.when(value.is_none()));
            // What is wrong already is nothing to hold others against.
            let right = flags == SampleFlags::NONE || flags == SampleFlags::EXTRAPOLATED;
            if let (true, Some(step), Some(value), Some(check)) = (right, limits.step, value, self.steps.get_mut(take.parameter))
            {
                let beyond = !check.follows(value, step);
                self.counters.beyond_step += u64::from(beyond);
                flags = flags.with(SampleFlags::STEP.when(beyond));
            }
            self.counters.samples += 1;
            self.counters.out_of_limits += u64::from(low || high);
            self.counters.extrapolated += u64::from(extrapolated);
            self.counters.no_value += u64::from(value.is_none());
            each(PcmSample { parameter: take.parameter, time_s: time_s(take.offset), raw, value, flags });
        }
        number
    }
}

#[cfg(test)]
#[path = "decommutator_tests.rs"]
mod tests;
