//! Rows of channels out of packets, from a recording or live.
//!
//! Consumes every packet in order and the [`ChosenChannel`]; produces rows as of any recording, in order of time, and sentences
//! on what was lost or contradicts the setup. Packets of other channels are passed over; PCM channels that nobody chose are
//! counted where none was named.

use super::channel_choice::ChosenChannel;
use super::channel_decoder::ChannelDecoder;
use super::header::data_type;
use super::packet::Chapter10Packet;
use super::tmats_check::PcmEvidence;
use super::tmats_pcm::TmatsPcmFormat;
use crate::flight::channel::ControlNames;
use crate::flight::file::run_file::RecordingColumn;
use crate::io::telemetry::pcm::recording::losses_in_words;
use crate::io::telemetry::pcm::rows::PcmRows;
use crate::io::telemetry::record::RecordingRow;

/// Rows of one PCM channel.
#[derive(Debug)]
pub struct ChannelRows {
    channel: Option<u16>,
    /// Whether the channel was named.
    named: bool,
    decoder: ChannelDecoder,
    rows: PcmRows,
    /// What the setup says, and what the data show.
    evidence: Option<(TmatsPcmFormat, PcmEvidence)>,
    others: u64,
    begun: bool,
}

impl ChannelRows {
    /// Nothing seen; the first packet of data has that time, s.
    ///
    /// # Errors
    /// A sentence where no recorder can hold such frames, or their parameters cannot be channels.
    pub fn new(chosen: &ChosenChannel) -> Result<Self, String> {
        Ok(ChannelRows {
            channel: chosen.channel,
            named: chosen.channel.is_some(),
            decoder: ChannelDecoder::new(&chosen.format)?,
            rows: PcmRows::new(&chosen.format)?,
            evidence: chosen.written.clone().map(|written| {
                let evidence = PcmEvidence::new(Some(&written), &[]);
                (written, evidence)
            }),
            others: 0,
            begun: false,
        })
    }

    /// The same without holding the data against the setup.
    #[must_use]
    pub fn unquestioned(self) -> Self {
        ChannelRows { evidence: None, ..self }
    }

    /// The time, then the parameters in the order of the format.
    pub fn columns(&self) -> &[RecordingColumn] {
        self.rows.columns()
    }

    /// How the controls are called.
    pub fn controls(&self) -> ControlNames {
        self.rows.controls()
    }

    /// The channel that is read; `None` before the first packet where none was named.
    pub fn channel(&self) -> Option<u16> {
        self.channel
    }

    /// What reads its packets.
    pub fn decoder(&self) -> &ChannelDecoder {
        &self.decoder
    }

    /// The time that a packet of now should have, s, where the receiver's clock tells it.
    pub fn expect(&mut self, time_s: f64) {
        self.decoder.expect(time_s);
    }

    /// Goes on with a time whose zero has that count.
    pub fn resume(&mut self, zero: i64) {
        self.begun = true;
        self.decoder.resume(zero);
    }

    /// Takes in a packet and gives the rows that it completes. The first packet of data has the time `start_s`.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>, start_s: f64, each: &mut impl FnMut(&RecordingRow)) {
        // Computer generated data, such as the setup, may have any count.
        if !self.begun && packet.header.data_type > 0x07 {
            self.begun = true;
            self.decoder.begin(packet.header.rtc, start_s);
        }
        if packet.header.data_type != data_type::PCM_1 {
            return;
        }
        if *self.channel.get_or_insert(packet.header.channel) != packet.header.channel {
            self.others += u64::from(!self.named);
            return;
        }
        if let Some((_, evidence)) = &mut self.evidence {
            evidence.packet(packet);
        }
        let ChannelRows { decoder, rows, .. } = self;
        decoder.packet(packet, |sample| rows.put(&sample, each));
    }

    /// Gives the rows that wait: no packets follow.
    pub fn finish(&mut self, each: &mut impl FnMut(&RecordingRow)) {
        let ChannelRows { decoder, rows, .. } = self;
        decoder.finish(|sample| rows.put(&sample, each));
        rows.finish(each);
    }

    /// What was lost of the channel, and where the data contradict the setup, each in a sentence.
    pub fn shortfalls(&self) -> Vec<String> {
        let tally = self.decoder.tally();
        let counted = [
            (tally.damaged, "packets with a wrong checksum skipped"),
            (tally.missing, "packets missing"),
            (tally.repeated, "packets that came twice skipped"),
            (tally.overflows, "packets where the recorder lost data"),
            (tally.time_errors, "packets with an error of the relative time counter"),
            (tally.restarts, "restarts of the recorder's time"),
            (tally.doubtful, "minor frames without pattern, or of which the recorder was unsure"),
        ];
        let counted = counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
        let mut all: Vec<String> = counted.collect();
        if let Some(first) = tally.first_unreadable {
            all.push(format!("{} packets skipped that cannot be read with this format, the first: {first}", tally.unreadable));
        }
        if self.others > 0 {
            all.push(format!("{} packets of other PCM channels not read: `channel = N` chooses one", self.others));
        }
        let (sync, data) = self.decoder.counters();
        all.extend(losses_in_words(&sync, &data));
        if let Some(rate) = self.decoder.contradicting_rate() {
            all.push(format!(
                "bits come at {rate:.0} a second by the recorder's times, not at the bit rate that is written (D2, or `bit_rate` of the \
                 format): words are dated by the former, except those of the first packets"
            ));
        }
        all.extend(self.rows.shortfall());
        if let Some((written, evidence)) = &self.evidence {
            all.extend(evidence.contradictions(written).iter().map(ToString::to_string));
        }
        all
    }
}
