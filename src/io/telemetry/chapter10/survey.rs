//! What a recording shows of itself in one pass: its channels, its time, its setup, and where setup and data disagree.
//!
//! Consumes packets in order; produces the [summary](super::summary), the [relation of times](super::time_relation) and a
//! sentence for every contradiction. Whatever the recording, the work for a packet is bounded: the setup is read at most
//! [`SETUP_READINGS`] times, and at most [`MEASURED`] PCM channels are held against it; others are counted.

use super::header::data_type;
use super::packet::Chapter10Packet;
use super::summary::RecordingSummary;
use super::time_relation::TimeRelation;
use super::tmats::{SetupRecord, Tmats};
use super::tmats_check::PcmEvidence;
use super::tmats_pcm::TmatsPcmFormat;
use std::collections::BTreeMap;

/// PCM channels that are held against the setup at most.
pub const MEASURED: usize = 256;
/// How often the setup is read anew at most, because more of it came.
pub const SETUP_READINGS: u32 = 64;

/// What the packets so far show.
#[derive(Debug, Default)]
pub struct RecordingSurvey {
    /// Its channels.
    pub summary: RecordingSummary,
    /// Its time.
    pub relation: TimeRelation,
    /// Time packets that cannot be read.
    pub unreadable_times: u64,
    setup: Vec<u8>,
    tmats: Tmats,
    /// Bytes of the setup that `tmats` was read from, and how often it was read.
    read_to: usize,
    readings: u32,
    /// What is measured of each PCM channel.
    evidence: BTreeMap<u16, PcmEvidence>,
    unmeasured: u64,
}

impl RecordingSurvey {
    /// Takes in a packet.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>) {
        self.summary.packet(packet);
        self.unreadable_times += u64::from(self.relation.packet(packet).is_err());
        if let Ok(setup) = SetupRecord::parse(packet) {
            self.setup.extend_from_slice(setup.text);
        }
        if packet.header.data_type != data_type::PCM_1 {
            return;
        }
        let channel = packet.header.channel;
        if !self.evidence.contains_key(&channel) {
            if self.evidence.len() >= MEASURED {
                self.unmeasured += 1;
                return;
            }
            // The setup record is the first packet of a recording, so that the setup is there.
            self.read_setup();
        }
        let tmats = &self.tmats;
        let new = || PcmEvidence::new(TmatsPcmFormat::of_channel(tmats, channel).ok().as_ref(), &[]);
        self.evidence.entry(channel).or_insert_with(new).packet(packet);
    }

    /// PCM packets of channels beyond those that are held against the setup.
    pub fn unmeasured(&self) -> u64 {
        self.unmeasured
    }

    /// By channel, each contradiction between setup and data in a sentence.
    pub fn contradictions(&self) -> Vec<(u16, String)> {
        let tmats = Tmats::parse(&self.setup);
        let of_channel = |(&channel, evidence): (&u16, &PcmEvidence)| -> Vec<(u16, String)> {
            match TmatsPcmFormat::of_channel(&tmats, channel) {
                Ok(format) => evidence.contradictions(&format).iter().map(|one| (channel, one.to_string())).collect(),
                Err(wrong) => vec![(channel, wrong.to_string())],
            }
        };
        self.evidence.iter().flat_map(of_channel).collect()
    }

    fn read_setup(&mut self) {
        if self.read_to < self.setup.len() && self.readings < SETUP_READINGS {
            self.tmats = Tmats::parse(&self.setup);
            self.read_to = self.setup.len();
            self.readings += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet::Chapter10Reader;
    use super::super::packet_test::packet;
    use super::*;

    #[test]
    fn channels_and_readings_of_the_setup_are_bounded_and_counted() {
        let mut survey = RecordingSurvey::default();
        let mut reader = Chapter10Reader::default();
        for channel in 0..300 {
            let setup = [&[8, 0, 0, 0][..], format!("R-1\\TK1-{channel}:{channel};").as_bytes()].concat();
            for bytes in [packet(0, 0x01, channel as u8, 0, &setup, 2), packet(channel, 0x09, 0, 0, &[0, 0, 0x10, 0, 1, 2], 2)] {
                assert_eq!(reader.take(&bytes), bytes.len());
                while let Some(packet) = reader.finish() {
                    survey.packet(&packet);
                }
            }
        }
        assert_eq!((survey.evidence.len(), survey.unmeasured(), survey.readings), (MEASURED, 44, SETUP_READINGS));
        let contradictions = survey.contradictions();
        assert_eq!(contradictions.len(), MEASURED, "the whole setup names every channel, and a format of none");
        assert!(contradictions.iter().all(|(_, sentence)| sentence.contains("format")), "{contradictions:?}");
    }
}
