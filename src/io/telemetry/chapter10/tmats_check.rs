//! Compares what the setup says of a PCM channel with what its data show, and says every contradiction in words.
//!
//! Consumes the packets of one channel; produces a list of [`Contradiction`]s. Measured are: the mode, the distance at which
//! a sync pattern recurs (that of the setup, those that the standard recommends for 24 and 32 bits, and any that are given),
//! its polarity, and the bit rate. A pattern that is not found is told only where another one is: data without any frames
//! (noise, an idle link) contradict nothing. In unpacked and packed mode, the recorded frame is compared with its filler. The
//! bit rate is that of packets that follow each other without a gap (throughput mode), or of minor frames.
//! Source: IRIG 106-09 Chapter 9 (P group), Chapter 10, 10.6.2; sync patterns: Chapter 4, appendix C.

use super::header::{RTC_MODULUS, TICKS_PER_SECOND};
use super::packet::{Chapter10Packet, Integrity};
use super::pcm_data::{BitTime, PcmAlignment, PcmMode, PcmPacket};
use super::pcm_layout::{CellSize, UnpackedForm};
use super::sequence::SequenceStep;
use super::sync_search::{Recurrence, SyncSearch};
use super::tmats_pcm::TmatsPcmFormat;
use std::fmt;

/// Patterns that the standard recommends: value, bits.
pub const RECOMMENDED: [(u64, u8); 2] = [(0xFA_F320, 24), (0xFE6B_2840, 32)];
/// Patterns that are looked for at most.
pub const PATTERNS: usize = 16;
/// How far the bit rate may be off before that is told.
pub const BIT_RATE_SHARE: f64 = 0.01;

/// A difference between setup and data, or within the setup.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the sentence of each says what its fields are")]
pub enum Contradiction {
    OwnLength { group: u32, written: u32, computed: u64 },
    OwnPattern { group: u32, written: u32, digits_need: u32 },
    Mode { written: PcmMode, found: PcmMode },
    FrameLength { group: u32, written: u64, found: u64, frames: u64 },
    RecordedFrame { group: u32, written: u64, found: u64, frames: u64 },
    Pattern { group: u32, written: u64, found: Recurrence },
    Polarity { group: u32, written_inverted: bool, frames: u64 },
    BitRate { group: u32, written: u64, found: f64 },
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Contradiction::OwnLength { group, written, computed } => {
                write!(
                    f,
                    "TMATS says {written} bits in a minor frame (P-{group}\\MF2), but its words and its sync pattern \
                     make {computed}"
                )
            }
            Contradiction::OwnPattern { group, written, digits_need } => {
                write!(f, "TMATS says a sync pattern of {written} bits (P-{group}\\MF4), but writes one that needs {digits_need}")
            }
            Contradiction::Mode { written, found } => {
                write!(f, "TMATS says {written:?} mode, the packets are in {found:?} mode")
            }
            Contradiction::FrameLength { group, written, found, frames } => {
                write!(f, "TMATS says {written} bits in a minor frame (P-{group}\\MF2), the data say {found} ({frames} frames)")
            }
            Contradiction::RecordedFrame { group, written, found, frames } => write!(
                f,
                "the minor frame of TMATS (P-{group}) is recorded with {written} bits and its filler, the data say {found} \
                 ({frames} frames)"
            ),
            Contradiction::Pattern { group, written, found } => {
                let (pattern, period, frames) = (found.pattern, found.period, found.frames);
                write!(
                    f,
                    "TMATS says the sync pattern {written:X} (P-{group}\\MF5), which does not recur in the data; \
                     {pattern:X} recurs every {period} bits ({frames} frames)"
                )
            }
            Contradiction::Polarity { group, written_inverted, frames } => {
                let [says, is] = if *written_inverted { ["inverted", "normal"] } else { ["normal", "inverted"] };
                write!(f, "TMATS says {says} polarity (P-{group}\\D4), the data have the {is} sync pattern ({frames} frames)")
            }
            Contradiction::BitRate { group, written, found } => {
                write!(f, "TMATS says {written} bits a second (P-{group}\\D2), the data have {found:.0}")
            }
        }
    }
}

/// What the data of one channel show.
#[derive(Clone, Debug)]
pub struct PcmEvidence {
    searches: Vec<SyncSearch>,
    mode: Option<(PcmMode, PcmAlignment)>,
    /// Time of the last packet's first bit, and its bits.
    last: Option<(u64, u64)>,
    ticks: u64,
    bits: u64,
    scratch: Vec<u8>,
}

impl PcmEvidence {
    /// Nothing seen; looks for the setup's pattern, the recommended ones, and those given.
    pub fn new(format: Option<&TmatsPcmFormat>, others: &[(u64, u8)]) -> Self {
        let of_setup = format.and_then(|format| Some((format.sync_pattern?, u8::try_from(format.sync_bits?).ok()?)));
        let mut patterns: Vec<(u64, u8)> = Vec::new();
        for pattern in of_setup.iter().chain(&RECOMMENDED).chain(others) {
            if !patterns.contains(pattern) && patterns.len() < PATTERNS {
                patterns.push(*pattern);
            }
        }
        let searches = patterns.into_iter().filter_map(|(pattern, bits)| SyncSearch::new(pattern, bits)).collect();
        PcmEvidence { searches, mode: None, last: None, ticks: 0, bits: 0, scratch: Vec::new() }
    }

    /// Takes in a packet of the channel; damaged ones and those that are no PCM packets are left out.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>) {
        let Ok(pcm) = PcmPacket::parse(packet) else { return };
        if packet.integrity == Integrity::Damaged {
            self.last = None;
            return;
        }
        self.mode = Some((pcm.word.mode, pcm.word.alignment));
        self.scratch.clear();
        let run = pcm.bits(&mut self.scratch);
        let throughput = pcm.word.mode == PcmMode::Throughput;
        let next = matches!(packet.sequence, SequenceStep::Next) && throughput && !packet.header.overflow();
        if !next {
            self.last = None;
            self.searches.iter_mut().for_each(SyncSearch::gap);
        }
        if let (BitTime::Rtc(rtc), true) = (run.time, throughput) {
            if let Some((before, bits)) = self.last {
                self.ticks += rtc.wrapping_sub(before) % RTC_MODULUS;
                self.bits += bits;
            }
            self.last = Some((rtc, run.bits));
        }
        for search in &mut self.searches {
            search.push(&self.scratch);
        }
    }

    /// The pattern that recurs in most frames.
    pub fn recurrence(&self) -> Option<Recurrence> {
        self.searches.iter().filter_map(SyncSearch::found).max_by_key(|found| (found.frames, found.pattern_bits))
    }

    /// The measured bit rate, 1/s (throughput mode, two packets that follow each other).
    #[expect(clippy::cast_precision_loss, reason = "a rate, not a count")]
    pub fn bit_rate(&self) -> Option<f64> {
        (self.ticks > 0).then(|| self.bits as f64 * TICKS_PER_SECOND as f64 / self.ticks as f64)
    }

    /// The minor frame that the data show, bits: as transmitted in throughput mode, as recorded with its filler otherwise.
    pub fn frame_bits(&self) -> Option<u64> {
        let headers = match self.mode? {
            (PcmMode::Throughput, _) => 0,
            (_, PcmAlignment::Bits16) => 80,
            (_, PcmAlignment::Bits32) => 96,
        };
        self.recurrence()?.period.checked_sub(headers)
    }

    /// Everything in which the setup contradicts itself or the data.
    pub fn contradictions(&self, format: &TmatsPcmFormat) -> Vec<Contradiction> {
        let mut all = own_contradictions(format);
        let group = format.group;
        if let (Some(written), Some((found, _))) = (format.mode, self.mode)
            && written != found
        {
            all.push(Contradiction::Mode { written, found });
        }
        if let (Some(written), Some(found)) = (format.bit_rate, self.bit_rate()) {
            #[expect(clippy::cast_precision_loss, reason = "a rate, not a count")]
            let apart = (found - written as f64).abs();
            if !(apart <= BIT_RATE_SHARE * found) {
                all.push(Contradiction::BitRate { group, written, found });
            }
        }
        if let Some(found) = self.recurrence() {
            self.compare_frame(format, found, &mut all);
        }
        all
    }

    fn compare_frame(&self, format: &TmatsPcmFormat, found: Recurrence, all: &mut Vec<Contradiction>) {
        let (group, frames) = (format.group, found.frames);
        if let Some(written) = format.sync_pattern {
            let same_length = format.sync_bits == Some(u32::from(found.pattern_bits));
            if written != found.pattern || !same_length {
                all.push(Contradiction::Pattern { group, written, found });
            } else if let Some(written_inverted) = format.inverted
                && written_inverted != found.inverted
            {
                all.push(Contradiction::Polarity { group, written_inverted, frames });
            }
        }
        let (Some((mode, alignment)), Some(bits)) = (self.mode, self.frame_bits()) else { return };
        if mode == PcmMode::Throughput {
            if let Some(written) = format.frame_bits.map(u64::from)
                && written != bits
            {
                all.push(Contradiction::FrameLength { group, written, found: bits, frames });
            }
        } else if let Some(layout) = format.layout() {
            let recorded = [CellSize::Bits16, CellSize::Alignment].map(|cell| {
                let map = layout.map(mode, alignment, UnpackedForm { cell, ..UnpackedForm::default() });
                map.map_or(0, |map| 8 * map.bytes() as u64)
            });
            if !recorded.contains(&bits) {
                let [written, _] = recorded;
                all.push(Contradiction::RecordedFrame { group, written, found: bits, frames });
            }
        }
    }
}

/// Where the setup contradicts itself.
pub fn own_contradictions(format: &TmatsPcmFormat) -> Vec<Contradiction> {
    let mut all = Vec::new();
    let group = format.group;
    if let (Some(written), Some(layout)) = (format.frame_bits, format.layout())
        && u64::from(written) != layout.frame_bits()
    {
        all.push(Contradiction::OwnLength { group, written, computed: layout.frame_bits() });
    }
    if let (Some(written), Some(pattern)) = (format.sync_bits, format.sync_pattern) {
        let digits_need = 64 - pattern.leading_zeros();
        if digits_need > written {
            all.push(Contradiction::OwnPattern { group, written, digits_need });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::packet::Chapter10Reader;
    use super::super::packet_test::{Noise, packet};
    use super::super::tmats::Tmats;
    use super::*;

    fn format(text: &str) -> TmatsPcmFormat {
        TmatsPcmFormat::of_group(&Tmats::parse(text.as_bytes()), 1)
    }

    const SETUP: &str =
        "P-1\\D2:1000000;P-1\\D4:N;P-1\\F1:16;P-1\\MF1:15;P-1\\MF2:256;P-1\\MF4:32;P-1\\MF5:11111110011010110010100001000000;";

    /// Packets of frames of 256 bits in throughput mode, 1,000,000 bits a second, the complement if `inverted`.
    fn evidence(format: &TmatsPcmFormat, inverted: bool) -> PcmEvidence {
        let mut noise = Noise(21);
        let (mut reader, mut evidence) = (Chapter10Reader::default(), PcmEvidence::new(Some(format), &[]));
        for sequence in 0..5_u8 {
            let mut body = vec![0, 0, 0x10, 0];
            for _ in 0..10 {
                let mut frame = vec![0x6B, 0xFE, 0x40, 0x28];
                frame.extend((0..28).map(|_| noise.next() as u8));
                body.extend(frame.iter().map(|byte| if inverted { !byte } else { *byte }));
            }
            reader.take(&packet(1, 9, sequence, 25_600 * u64::from(sequence), &body, 3));
            evidence.packet(&reader.next_packet().unwrap());
        }
        evidence
    }

    fn words(format: &TmatsPcmFormat, inverted: bool) -> Vec<String> {
        evidence(format, inverted).contradictions(format).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_setup_that_is_right_has_no_contradictions() {
        let right = format(SETUP);
        assert_eq!(words(&right, false), Vec::<String>::new());
        let evidence = evidence(&right, false);
        assert_eq!((evidence.frame_bits(), evidence.recurrence().map(|found| found.frames)), (Some(256), Some(49)));
        assert!((evidence.bit_rate().unwrap() - 1e6).abs() < 1e-6);
    }

    #[test]
    fn every_wrong_statement_is_told_in_words() {
        let other = format(&SETUP.replace("MF5:1", "MF5:0").replace("MF1:15", "MF1:13").replace("MF2:256", "MF2:512"));
        assert_eq!(
            words(&other, false),
            [
                "TMATS says 512 bits in a minor frame (P-1\\MF2), but its words and its sync pattern make 224",
                "TMATS says the sync pattern 7E6B2840 (P-1\\MF5), which does not recur in the data; \
                 FE6B2840 recurs every 256 bits (49 frames)",
                "TMATS says 512 bits in a minor frame (P-1\\MF2), the data say 256 (49 frames)",
            ]
        );
        let other = format(&SETUP.replace("D2:1000000", "D2:1020000").replace("MF4:32", "MF4:30"));
        let told = words(&other, true);
        assert_eq!(told[1], "TMATS says a sync pattern of 30 bits (P-1\\MF4), but writes one that needs 32");
        assert_eq!(told[2], "TMATS says 1020000 bits a second (P-1\\D2), the data have 1000000");
        let polarity = "TMATS says normal polarity (P-1\\D4), the data have the inverted sync pattern (49 frames)";
        assert_eq!(words(&format(SETUP), true), [polarity]);
        let unpacked = TmatsPcmFormat { mode: Some(PcmMode::Unpacked), ..format(SETUP) };
        assert_eq!(words(&unpacked, false), ["TMATS says Unpacked mode, the packets are in Throughput mode"]);
    }
}
