//! Samples out of the packets of one PCM channel, in whatever mode they were recorded.
//!
//! Consumes the packets of a channel in order, and the format of its frames; produces a sample for each place of a parameter.
//! | mode | minor frames | time of a minor frame's first bit |
//! | --- | --- | --- |
//! | packed, unpacked | as the recorder has synchronised them | that of its intra-packet header |
//! | throughput | by the frame synchroniser here | that of the packet that it begins in, and from there by the bit rate |
//!
//! The bit rate is the format's, unless the recorder's times contradict it ([`RecordedFrameRate`]): then theirs.
//!
//! A sample has the time of its word's first bit ([`Decommutator`]). Times are those of the relative time counter; intra-packet
//! times of another format count from the packet's own, and where their layout is not known minor frames follow at the bit
//! rate. In throughput mode a packet continues the bits of the one before unless packets are missing, the recorder lost data,
//! or its time differs from theirs by more than half of its length and a millisecond: then the search for frames begins anew.
//! Skipped, and counted: packets with a wrong checksum, and those that hold no whole number of such frames. A minor frame
//! without its pattern, or that the recorder was unsure of, gives samples that say so. Nothing is allocated in packets that
//! continue each other, once one was read.

use super::error::Chapter10Error;
use super::frame_rate::RecordedFrameRate;
use super::header::SecondaryTime;
use super::packet::{Chapter10Packet, Integrity};
use super::pcm_data::{BitTime, FrameLock, MinorFrames, PcmMode, PcmPacket, RecordedFrame};
use super::pcm_layout::{CellSize, PcmAlignment, PcmLayout, UnpackedForm, WordMap};
use super::rtc_clock::RtcClock;
use super::sequence::SequenceStep;
use crate::io::telemetry::pcm::bits::write_bits;
use crate::io::telemetry::pcm::decommutator::{BitClock, DecommutationCounters, Decommutator, PcmSample};
use crate::io::telemetry::pcm::frame_sync::{FrameSynchronizer, MinorFrame, SyncCounters};
use crate::io::telemetry::pcm::layout::PcmFormat;
use crate::io::telemetry::pcm::sync_pattern::PolarityRule;
use std::collections::VecDeque;

/// Packets in which minor frames that wait may begin, to start with.
const PACKETS: usize = 64;
/// A packet's time may differ from that of the bits before it by so much beside half of its length, s.
const JITTER_S: f64 = 1e-3;

/// What became of packets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelTally {
    /// Packets of the channel.
    pub packets: u64,
    /// Of these, skipped for a wrong checksum.
    pub damaged: u64,
    /// Of these, skipped because their body cannot be read with this format.
    pub unreadable: u64,
    /// The first of these.
    pub first_unreadable: Option<Chapter10Error>,
    /// Packets that came twice: the second is skipped.
    pub repeated: u64,
    /// Packets that are missing.
    pub missing: u64,
    /// Packets before or in which the recorder lost data.
    pub overflows: u64,
    /// Packets with an error of the relative time counter.
    pub time_errors: u64,
    /// Times that the recorder started again.
    pub restarts: u64,
    /// Minor frames, of all modes.
    pub minor_frames: u64,
    /// Of these, in packed or unpacked mode without their pattern, or of which the recorder was unsure.
    pub doubtful: u64,
}

/// A stream of bits in throughput mode.
#[derive(Debug)]
struct BitStream {
    synchronizer: FrameSynchronizer,
    /// First bit and time of each packet of which minor frames may begin later, s.
    packets: VecDeque<(u64, f64)>,
    bits: u64,
}

/// Reads the packets of a channel.
#[derive(Debug)]
pub struct ChannelDecoder {
    format: PcmFormat,
    layout: PcmLayout,
    /// Of the last packet's mode and alignment.
    map: Option<(PcmMode, PcmAlignment, WordMap)>,
    decommutator: Decommutator,
    stream: Option<BitStream>,
    /// Bits of the last packet in throughput mode.
    last_bits: Option<u64>,
    /// Of streams that ended.
    earlier: SyncCounters,
    clock: RtcClock,
    frame_rate: RecordedFrameRate,
    last_rtc: Option<u64>,
    scratch: Vec<u8>,
    frame: Vec<u8>,
    tally: ChannelTally,
}

impl ChannelDecoder {
    /// For frames of that format.
    ///
    /// # Errors
    /// A sentence where no recorder can hold such frames.
    pub fn new(format: &PcmFormat) -> Result<Self, String> {
        let width = |bits: u32| u8::try_from(bits).unwrap_or(u8::MAX);
        let widths = format.words().iter().map(|word| width(word.bits)).collect();
        let layout = PcmLayout::new(width(format.spec().sync.bits), widths).map_err(|error| error.to_string())?;
        Ok(ChannelDecoder {
            layout,
            map: None,
            decommutator: Decommutator::new(format),
            stream: None,
            last_bits: None,
            earlier: SyncCounters::default(),
            clock: RtcClock::default(),
            frame_rate: RecordedFrameRate::default(),
            last_rtc: None,
            scratch: Vec::new(),
            frame: vec![0; format.minor_frame_bits().div_ceil(8)],
            tally: ChannelTally::default(),
            format: format.clone(),
        })
    }

    /// The count that has that time, s, where none was said before.
    pub fn begin(&mut self, rtc: u64, time_s: f64) {
        self.clock.begin(rtc, time_s);
    }

    /// Goes on with a time whose zero has that count.
    pub fn resume(&mut self, zero: i64) {
        self.clock.resume(zero);
    }

    /// The count at which the time is zero; `None` before the first packet.
    pub fn zero(&self) -> Option<i64> {
        self.clock.zero()
    }

    /// The time that a packet of now should have, s, where the receiver's clock tells it.
    pub fn expect(&mut self, time_s: f64) {
        self.clock.expect(time_s);
    }

    /// What became of packets.
    pub fn tally(&self) -> ChannelTally {
        ChannelTally { restarts: self.clock.restarts(), ..self.tally }
    }

    /// What the frame synchroniser (throughput mode) and the decommutator found.
    pub fn counters(&self) -> (SyncCounters, DecommutationCounters) {
        let sync = self.stream.as_ref().map(|stream| stream.synchronizer.counters()).unwrap_or_default();
        (sync.plus(&self.earlier), self.decommutator.counters())
    }

    /// The bit rate that the times of recorded minor frames show, 1/s, where the format has another one.
    pub fn contradicting_rate(&self) -> Option<f64> {
        self.frame_rate.contradicts(self.format.spec().bit_rate)
    }

    fn bit_rate(&self) -> f64 {
        self.contradicting_rate().unwrap_or(self.format.spec().bit_rate)
    }

    /// Gives the samples of a packet.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>, mut each: impl FnMut(PcmSample)) {
        let header = &packet.header;
        self.tally.packets += 1;
        self.tally.overflows += u64::from(header.overflow());
        self.tally.time_errors += u64::from(header.time_error());
        if let SequenceStep::Gap(missing) = packet.sequence {
            self.tally.missing += u64::from(missing);
        }
        if packet.sequence == SequenceStep::Repeated && self.last_rtc == Some(header.rtc) {
            self.tally.repeated += 1;
            return;
        }
        self.last_rtc = Some(header.rtc);
        if packet.integrity == Integrity::Damaged {
            self.tally.damaged += 1;
            return self.finish(each);
        }
        let (count, restarted) = self.clock.packet(header.rtc);
        let follows = matches!(packet.sequence, SequenceStep::First | SequenceStep::Next) && !header.overflow() && !restarted;
        let read = PcmPacket::parse(packet).and_then(|pcm| match pcm.word.mode {
            PcmMode::Throughput => {
                self.bits(&pcm, count, follows, &mut each);
                Ok(())
            }
            PcmMode::Packed | PcmMode::Unpacked => {
                self.finish(&mut each);
                self.frames(&pcm, count, &mut each)
            }
        });
        if let Err(error) = read {
            self.tally.unreadable += 1;
            self.tally.first_unreadable.get_or_insert(error);
        }
    }

    /// Gives the samples that wait for further bits: none follow.
    pub fn finish(&mut self, mut each: impl FnMut(PcmSample)) {
        let rate = self.bit_rate();
        let Some(mut stream) = self.stream.take() else { return };
        while let Some(frame) = stream.synchronizer.last_frame() {
            read_frame(&frame, &mut stream.packets, rate, &mut self.decommutator, &mut each);
            self.tally.minor_frames += 1;
        }
        self.earlier = stream.synchronizer.counters().plus(&self.earlier);
    }

    /// The bits of a packet in throughput mode, whose first has that count.
    fn bits(&mut self, pcm: &PcmPacket<'_>, count: i64, follows: bool, mut each: impl FnMut(PcmSample)) {
        self.scratch.clear();
        let run = pcm.bits(&mut self.scratch);
        let time_s = self.clock.time_s(count);
        self.frame_rate.packet_begins(time_s, self.last_bits.replace(run.bits).filter(|_| follows).map(|bits| bits as f64));
        let rate = self.bit_rate();
        let expected_s = self.stream.as_ref().and_then(|stream| {
            let (bit, time_s) = stream.packets.back()?;
            Some(time_s + (stream.bits - bit) as f64 / rate)
        });
        let near = |expected_s: f64| (time_s - expected_s).abs() <= 0.5 * run.bits as f64 / rate + JITTER_S;
        if !follows || !expected_s.is_none_or(near) {
            self.finish(&mut each);
        }
        let stream = self.stream.get_or_insert_with(|| BitStream {
            synchronizer: FrameSynchronizer::of_format(&self.format),
            packets: VecDeque::with_capacity(PACKETS),
            bits: 0,
        });
        if run.bits == 0 {
            return;
        }
        stream.packets.push_back((stream.bits, time_s));
        stream.bits += run.bits;
        let mut rest = self.scratch.as_slice();
        while !rest.is_empty() {
            let taken = stream.synchronizer.take(rest);
            rest = rest.get(taken..).unwrap_or_default();
            while let Some(frame) = stream.synchronizer.next_frame() {
                read_frame(&frame, &mut stream.packets, rate, &mut self.decommutator, &mut each);
                self.tally.minor_frames += 1;
            }
        }
    }

    /// The minor frames of a packet in packed or unpacked mode.
    fn frames(&mut self, pcm: &PcmPacket<'_>, count: i64, mut each: impl FnMut(PcmSample)) -> Result<(), Chapter10Error> {
        self.choose_map(pcm)?;
        let rate = self.bit_rate();
        let ChannelDecoder { map, decommutator, scratch, frame: buffer, tally, format, clock, frame_rate, .. } = self;
        let Some((mode, _, map)) = map else { return Ok(()) };
        let (mut first, mut index) = (None, 0.0);
        for recorded in pcm.frames(map, scratch)? {
            let start_s = match recorded.time {
                BitTime::Rtc(rtc) => clock.time_s(clock.near(rtc, count)),
                BitTime::Secondary(time) => {
                    clock.time_s(count)
                        + match nanoseconds(time) {
                            Some(ns) => ns.saturating_sub(*first.get_or_insert(ns)) as f64 * 1e-9,
                            None => index * format.minor_frame_bits() as f64 / rate,
                        }
                }
            };
            if matches!(recorded.time, BitTime::Rtc(_)) {
                frame_rate.frame(start_s);
            }
            index += 1.0;
            let (errors, inverted) = pattern_errors(&recorded, format);
            let bytes = match mode {
                PcmMode::Packed if !inverted => recorded.bits,
                _ => {
                    copy_frame(&recorded, map, inverted, buffer);
                    buffer.as_slice()
                }
            };
            let sync_errors = errors.filter(|_| recorded.lock.minor != FrameLock::Check);
            tally.minor_frames += 1;
            tally.doubtful += u64::from(sync_errors.is_none());
            let found = MinorFrame::synchronised(bytes, format.minor_frame_bits(), bit_at(start_s, rate));
            let frame = MinorFrame { sync_errors, inverted, ..found };
            decommutator.timed_minor_frame(&frame, &BitClock { start_s, bit_rate: rate }, &mut each);
        }
        frame_rate.packet_ends(format.minor_frame_bits() as f64);
        Ok(())
    }

    /// The places of words in packets of this mode. Recorders with 32-bit alignment have cells of 16 bits or of 32: those in
    /// which
    /// the patterns of this packet stand, or else those that fill it.
    fn choose_map(&mut self, pcm: &PcmPacket<'_>) -> Result<(), Chapter10Error> {
        let (mode, alignment) = (pcm.word.mode, pcm.word.alignment);
        if self
            .map
            .as_ref()
            .is_some_and(|(of, by, map)| (*of, *by) == (mode, alignment) && pcm.frames(map, &mut self.scratch).is_ok())
        {
            return Ok(());
        }
        let (mut chosen, mut refused) = (None, None);
        for cell in [CellSize::Bits16, CellSize::Alignment] {
            let Some(map) = self.layout.map(mode, alignment, UnpackedForm { cell, ..UnpackedForm::default() }) else { continue };
            match pcm.frames(&map, &mut self.scratch) {
                Ok(frames) => {
                    let patterns = with_pattern(frames, &self.format);
                    if chosen.as_ref().is_none_or(|(most, _)| patterns > *most) {
                        chosen = Some((patterns, map));
                    }
                }
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        match (chosen, refused) {
            (Some((_, map)), _) => {
                self.map = Some((mode, alignment, map));
                Ok(())
            }
            (None, Some(error)) => Err(error),
            (None, None) => Ok(()),
        }
    }
}

/// How many frames have their pattern.
fn with_pattern(frames: MinorFrames<'_>, format: &PcmFormat) -> usize {
    frames.filter(|frame| pattern_errors(frame, format).0.is_some()).count()
}

/// Wrong bits of a frame's pattern, `None` where it is none; whether it is inverted. A recorder may have put the polarity right.
fn pattern_errors(frame: &RecordedFrame<'_>, format: &PcmFormat) -> (Option<u32>, bool) {
    let (spec, rules) = (format.spec(), format.rules());
    let found = frame.sync();
    let within = |errors: u32| Some(errors).filter(|errors| *errors <= rules.lock_errors);
    if let Some(errors) = within(spec.sync.errors(found)) {
        return (Some(errors), false);
    }
    match spec.polarity {
        PolarityRule::Normal => (None, false),
        PolarityRule::Automatic | PolarityRule::Inverted => {
            let errors = within(spec.sync.errors(!found));
            (errors, errors.is_some())
        }
    }
}

/// The bits of a frame without the filler of its mode.
fn copy_frame(frame: &RecordedFrame<'_>, map: &WordMap, inverted: bool, buffer: &mut [u8]) {
    let mut at = 0;
    let values = std::iter::once((map.sync().width, frame.sync()));
    for (width, value) in values.chain(map.words().iter().map(|word| word.width).zip(frame.words())) {
        write_bits(buffer, at, width.into(), if inverted { !value } else { value });
        at += usize::from(width);
    }
}

/// Reads a minor frame of a stream; its time is that of the packet in which it begins and its bits from there.
fn read_frame(
    frame: &MinorFrame<'_>,
    packets: &mut VecDeque<(u64, f64)>,
    rate: f64,
    decommutator: &mut Decommutator,
    each: &mut impl FnMut(PcmSample),
) {
    while packets.get(1).is_some_and(|(bit, _)| *bit <= frame.first_bit) {
        packets.pop_front();
    }
    let Some((bit, time_s)) = packets.front() else { return };
    let start_s = time_s + frame.first_bit.saturating_sub(*bit) as f64 / rate;
    // Minor frames are counted by their time, which goes on where bits are lost.
    let frame = MinorFrame { first_bit: bit_at(start_s, rate), ..*frame };
    decommutator.timed_minor_frame(&frame, &BitClock { start_s, bit_rate: rate }, each);
}

fn bit_at(time_s: f64, rate: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast of a float saturates")]
    let bit = libm::round(time_s * rate) as u64;
    bit
}

/// A time of the secondary header on a scale of its own, ns; `None` of formats whose layout is not known.
fn nanoseconds(time: SecondaryTime) -> Option<i64> {
    let raw = match time {
        SecondaryTime::Ieee1588 { seconds, nanoseconds } => u64::from(seconds) * 1_000_000_000 + u64::from(nanoseconds),
        SecondaryTime::ExtendedRtc(raw) => raw,
        SecondaryTime::Chapter4(_) | SecondaryTime::Reserved(_) => return None,
    };
    Some(i64::try_from(raw).unwrap_or(i64::MAX))
}

#[cfg(test)]
#[path = "channel_decoder_tests.rs"]
mod tests;
