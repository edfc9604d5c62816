//! What a recording holds, channel by channel.
//!
//! Consumes packets in order; produces for each channel and data type the packets, bytes, losses and the range of times. The
//! range is that of the relative time counters in the headers: the first packet's and the last packet's, with the time of the
//! year where the relation is known. Data of which this module does not read the body (video, buses, indices) are counted all
//! the same. Memory: one line for each channel and data type, at most [`LINES`].
//! Source: IRIG 106-09 Chapter 10, 10.6.1.1 (header) and table 10-6 (data types).

use super::header::{data_type, type_name};
use super::packet::{Chapter10Packet, Integrity, PacketTally};
use super::pcm_data::{PcmMode, PcmPacket};
use super::sequence::SequenceStep;
use super::time_relation::TimeRelation;
use std::collections::BTreeMap;
use std::fmt;

/// Channels and data types that are told apart at most.
pub const LINES: usize = 4096;

/// One channel with one data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelSummary {
    /// Packets.
    pub packets: u64,
    /// Their length, bytes.
    pub bytes: u64,
    /// Packets with a wrong data checksum.
    pub damaged: u64,
    /// Gaps in the sequence numbers.
    pub gaps: u64,
    /// Packets that are missing in them.
    pub missing: u64,
    /// Packets with the sequence number of the one before.
    pub repeated: u64,
    /// Packets before or in which the recorder lost data.
    pub overflows: u64,
    /// Packets with an error of the relative time counter.
    pub time_errors: u64,
    /// Packets whose counter is below that of the one before.
    pub backwards: u64,
    /// Relative time counter of the first packet.
    pub first_rtc: u64,
    /// Relative time counter of the last packet.
    pub last_rtc: u64,
    /// Version of the data type in the first packet.
    pub data_version: u8,
    /// Mode of PCM data in the first packet that can be read.
    pub pcm_mode: Option<PcmMode>,
    /// PCM packets whose channel specific word cannot be read.
    pub unreadable: u64,
}

/// What a recording holds.
#[derive(Clone, Debug, Default)]
pub struct RecordingSummary {
    lines: BTreeMap<(u16, u8), ChannelSummary>,
    /// Packets that have no line.
    beyond: u64,
}

impl RecordingSummary {
    /// Takes in a packet.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>) {
        let header = &packet.header;
        let key = (header.channel, header.data_type);
        if self.lines.len() >= LINES && !self.lines.contains_key(&key) {
            self.beyond += 1;
            return;
        }
        let line = self.lines.entry(key).or_insert(ChannelSummary {
            packets: 0,
            bytes: 0,
            damaged: 0,
            gaps: 0,
            missing: 0,
            repeated: 0,
            overflows: 0,
            time_errors: 0,
            backwards: 0,
            first_rtc: header.rtc,
            last_rtc: header.rtc,
            data_version: header.data_version,
            pcm_mode: None,
            unreadable: 0,
        });
        line.packets += 1;
        line.bytes += u64::from(header.packet_length);
        line.damaged += u64::from(packet.integrity == Integrity::Damaged);
        line.overflows += u64::from(header.overflow());
        line.time_errors += u64::from(header.time_error());
        line.backwards += u64::from(header.rtc < line.last_rtc);
        line.last_rtc = header.rtc;
        match packet.sequence {
            SequenceStep::Gap(missing) => {
                line.gaps += 1;
                line.missing += u64::from(missing);
            }
            SequenceStep::Repeated => line.repeated += 1,
            SequenceStep::First | SequenceStep::Next => {}
        }
        if header.data_type == data_type::PCM_1 {
            match PcmPacket::parse(packet) {
                Ok(pcm) => line.pcm_mode = line.pcm_mode.or(Some(pcm.word.mode)),
                Err(_) => line.unreadable += 1,
            }
        }
    }

    /// Channel, data type and what there is, in the order of the channels.
    pub fn lines(&self) -> impl Iterator<Item = (u16, u8, &ChannelSummary)> {
        self.lines.iter().map(|((channel, data_type), line)| (*channel, *data_type, line))
    }

    /// One channel with one data type.
    pub fn line(&self, channel: u16, data_type: u8) -> Option<&ChannelSummary> {
        self.lines.get(&(channel, data_type))
    }

    /// Packets that have no line, because there are too many channels.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// The table as text, with the losses of the reader.
    pub fn table<'a>(&'a self, tally: &'a PacketTally, relation: &'a TimeRelation) -> impl fmt::Display + 'a {
        SummaryTable { summary: self, tally, relation }
    }
}

struct SummaryTable<'a> {
    summary: &'a RecordingSummary,
    tally: &'a PacketTally,
    relation: &'a TimeRelation,
}

impl fmt::Display for SummaryTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "channel  data                  packets      bytes  missing  damaged  from                     to")?;
        for (channel, data_type, line) in self.summary.lines() {
            let mode = match line.pcm_mode {
                Some(PcmMode::Unpacked) => ", unpacked",
                Some(PcmMode::Packed) => ", packed",
                Some(PcmMode::Throughput) => ", throughput",
                None => "",
            };
            let kind = format!("{}{mode}", type_name(data_type));
            let (packets, bytes, missing, damaged) = (line.packets, line.bytes, line.missing, line.damaged);
            let [from, to] = [line.first_rtc, line.last_rtc].map(|rtc| moment(self.relation, rtc));
            writeln!(f, "{channel:7}  {kind:20} {packets:8} {bytes:10} {missing:8} {damaged:8}  {from:24} {to}")?;
        }
        let tally = self.tally;
        write!(f, "{} packets, {} bytes skipped", tally.packets, tally.skipped_bytes)?;
        if let Some(at) = tally.first_skipped_at {
            write!(f, " (the first at byte {at})")?;
        }
        if let Some((at, error)) = tally.first_refusal {
            write!(f, "; {} headers refused, the first at byte {at}: {error}", tally.refused_headers)?;
        }
        if let Some((at, expected, found)) = tally.first_cut {
            write!(f, "; {} packets cut short, the first at byte {at}: {found} of {expected} bytes", tally.cut_short)?;
        }
        Ok(())
    }
}

/// Day of the year and time of day, or the count where that is not known.
pub(super) fn moment(relation: &TimeRelation, rtc: u64) -> String {
    use super::time::{DAY_NS, NS};
    use super::time_relation::TimeScale;
    let Some(time) = relation.at(rtc) else { return format!("count {rtc}") };
    let (day, of_day) = (time.ns.div_euclid(DAY_NS), time.ns.rem_euclid(DAY_NS));
    let (second, us) = (of_day / NS, of_day % NS / 1000);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    let day = match time.scale {
        TimeScale::YearStart => format!("day {:03}", day + 1),
        TimeScale::Since1970 => format!("1970 + {day} d"),
    };
    format!("{day} {hour:02}:{minute:02}:{second:02}.{us:06}")
}

#[cfg(test)]
mod tests {
    use super::super::packet::Chapter10Reader;
    use super::super::packet_test::packet;
    use super::*;

    #[test]
    fn every_channel_has_its_line() {
        let mut reader = Chapter10Reader::default();
        let mut damaged = packet(7, 0x09, 4, 900, &[0, 0, 0x10, 0, 1, 2], 2);
        damaged[28] ^= 1;
        let packets = [
            packet(1, 0x11, 0, 1000, &[1, 0, 0, 0, 0, 0x01, 0x02, 0x03, 0x04, 0], 2),
            packet(7, 0x09, 0, 1000, &[0, 0, 0x10, 0, 1, 2], 2),
            packet(7, 0x09, 1, 10_001_000, &[0, 0, 0x10, 0, 1, 2], 2),
            damaged,
            packet(7, 0x09, 4, 20_001_000, &[0, 0, 0, 0], 2),
            packet(9, 0xAB, 0, 5, &[], 2),
        ];
        reader.take(&packets.concat());
        let (mut summary, mut relation) = (RecordingSummary::default(), TimeRelation::default());
        while let Some(packet) = reader.next_packet() {
            relation.packet(&packet).unwrap();
            summary.packet(&packet);
        }
        let line = *summary.line(7, 0x09).unwrap();
        assert_eq!((line.packets, line.bytes, line.damaged, line.gaps, line.missing), (4, 32 * 4, 1, 1, 2));
        assert_eq!((line.repeated, line.backwards, line.unreadable), (1, 1, 1));
        assert_eq!((line.first_rtc, line.last_rtc, line.pcm_mode), (1000, 20_001_000, Some(PcmMode::Throughput)));
        let text = summary.table(&reader.tally(), &relation).to_string();
        let of_channel: Vec<&str> = text.lines().filter(|line| line.starts_with("      7")).collect();
        let counts = "      7  PCM data, throughput        4        128        2        1";
        assert_eq!(of_channel, [format!("{counts}  day 004 03:02:01.000000  day 004 03:02:03.000000")]);
        assert!(text.contains("unknown data type") && text.ends_with("6 packets, 0 bytes skipped"), "{text}");
    }
}
