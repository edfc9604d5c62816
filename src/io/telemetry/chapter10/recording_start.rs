//! What stands at the start of a recording: the setup, and the time of day of the first data.
//!
//! Consumes a file from its first byte; produces the text of the setup records before the first PCM packet, and the time where
//! a time packet is among the first [`SEARCHED`] bytes. A setup in XML is told.

use super::error::Chapter10Error;
use super::header::data_type;
use super::packet::{Chapter10Packet, Chapter10Reader};
use super::summary::moment;
use super::time_relation::TimeRelation;
use super::tmats::SetupRecord;
use crate::io::telemetry::byte_window::read_block;
use std::io::{Read, Result as IoResult};

/// How far a recording is searched for its first time and PCM packet, bytes: the longest setup, and a second of data.
pub(super) const SEARCHED: usize = 16 << 20;

/// The start of a recording.
#[derive(Debug, Default)]
pub(super) struct RecordingStart {
    /// The texts of the setup records in order.
    pub(super) setup: Vec<u8>,
    /// Whether a setup record is XML.
    pub(super) is_xml: bool,
    /// Day and time of day of the first packet of data.
    pub(super) moment: Option<String>,
    /// Packets that were found.
    pub(super) packets: u64,
    relation: TimeRelation,
    first_rtc: Option<u64>,
    has_pcm: bool,
}

impl RecordingStart {
    /// Reads it.
    pub(super) fn read(file: &mut impl Read, block: &mut [u8]) -> IoResult<Self> {
        let (mut start, mut reader, mut searched) = (RecordingStart::default(), Chapter10Reader::default(), 0);
        while searched < SEARCHED && !start.is_whole() {
            let count = read_block(file, block)?;
            searched += count;
            let mut rest = block.get(..count).unwrap_or_default();
            while !rest.is_empty() {
                rest = rest.get(reader.take(rest)..).unwrap_or_default();
                while let Some(packet) = reader.next_packet() {
                    start.packet(&packet);
                }
            }
            if count == 0 {
                while let Some(packet) = reader.finish() {
                    start.packet(&packet);
                }
                break;
            }
        }
        start.moment = start.first_rtc.filter(|rtc| start.relation.at(*rtc).is_some()).map(|rtc| moment(&start.relation, rtc));
        Ok(start)
    }

    fn is_whole(&self) -> bool {
        self.has_pcm && self.relation.channel().is_some()
    }

    fn packet(&mut self, packet: &Chapter10Packet<'_>) {
        self.packets += 1;
        if packet.header.data_type > 0x07 {
            self.first_rtc.get_or_insert(packet.header.rtc);
        }
        self.has_pcm |= packet.header.data_type == data_type::PCM_1;
        if !self.has_pcm {
            match SetupRecord::parse(packet) {
                Ok(setup) => self.setup.extend_from_slice(setup.text),
                Err(error) => self.is_xml |= error == Chapter10Error::SetupXml,
            }
        }
        if self.relation.channel().is_none() {
            // What it lacks is counted when the recording is read.
            let _ = self.relation.packet(packet);
        }
    }
}
