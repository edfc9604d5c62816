//! `inspect` of an IRIG 106 Chapter 10 recording: its channels, and where its setup contradicts its data.

use crate::command::message;
use crate::command::terminal::output_file::{print, write_json};
use serde_json::json;
use sideslip::error::{Failure, Outcome};
use sideslip::io::telemetry::chapter10::header::{data_type, type_name};
use sideslip::io::telemetry::chapter10::packet::{Chapter10Packet, Chapter10Reader, PacketTally};
use sideslip::io::telemetry::chapter10::summary::RecordingSummary;
use sideslip::io::telemetry::chapter10::time_relation::TimeRelation;
use sideslip::io::telemetry::chapter10::tmats::{SetupRecord, Tmats};
use sideslip::io::telemetry::chapter10::tmats_check::PcmEvidence;
use sideslip::io::telemetry::chapter10::tmats_pcm::TmatsPcmFormat;
use sideslip::io::telemetry::record::RecordingError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

const BLOCK: usize = 64 << 10;

/// What the recording shows.
#[derive(Default)]
struct Chapter10Survey {
    summary: RecordingSummary,
    relation: TimeRelation,
    setup: Vec<u8>,
    /// What is measured of each PCM channel.
    evidence: BTreeMap<u16, PcmEvidence>,
    unreadable_times: u64,
}

impl Chapter10Survey {
    fn packet(&mut self, packet: &Chapter10Packet<'_>) {
        self.summary.packet(packet);
        self.unreadable_times += u64::from(self.relation.packet(packet).is_err());
        if let Ok(setup) = SetupRecord::parse(packet) {
            self.setup.extend_from_slice(setup.text);
        }
        if packet.header.data_type == data_type::PCM_1 {
            let (channel, setup) = (packet.header.channel, &self.setup);
            let evidence = self.evidence.entry(channel).or_insert_with(|| {
                // The setup record is the first packet of a recording.
                PcmEvidence::new(TmatsPcmFormat::of_channel(&Tmats::parse(setup), channel).ok().as_ref(), &[])
            });
            evidence.packet(packet);
        }
    }

    /// By channel, each contradiction between setup and data in a sentence.
    fn contradictions(&self) -> Vec<(u16, String)> {
        let tmats = Tmats::parse(&self.setup);
        let of_channel = |(&channel, evidence): (&u16, &PcmEvidence)| -> Vec<(u16, String)> {
            match TmatsPcmFormat::of_channel(&tmats, channel) {
                Ok(format) => evidence.contradictions(&format).iter().map(|one| (channel, one.to_string())).collect(),
                Err(wrong) => vec![(channel, wrong.to_string())],
            }
        };
        self.evidence.iter().flat_map(of_channel).collect()
    }
}

/// Reads the whole recording once and shows its channels.
pub(super) fn run(file: &Path, json: Option<&Path>) -> Result<Outcome, Failure> {
    let io = |error: std::io::Error| Failure::io(file, &error);
    let mut source = File::open(file).map_err(io)?;
    let (mut reader, mut survey, mut block) = (Chapter10Reader::default(), Chapter10Survey::default(), vec![0; BLOCK]);
    loop {
        let count = source.read(&mut block).map_err(io)?;
        if count == 0 {
            break;
        }
        let mut rest = block.get(..count).unwrap_or_default();
        while !rest.is_empty() {
            rest = rest.get(reader.take(rest)..).unwrap_or_default();
            while let Some(packet) = reader.next_packet() {
                survey.packet(&packet);
            }
        }
    }
    while let Some(packet) = reader.finish() {
        survey.packet(&packet);
    }
    let (tally, contradictions) = (reader.tally(), survey.contradictions());
    if tally.packets == 0 {
        let what = format!("expected packets of IRIG 106 Chapter 10, found none in {} bytes", tally.skipped_bytes);
        return Err(RecordingError::Whole { path: file.into(), what }.into());
    }
    let mut text = format!("{}: IRIG 106 Chapter 10, {} packets\n", file.display(), tally.packets);
    text.push_str(&format!("{}\n", survey.summary.table(&tally, &survey.relation)));
    for (channel, sentence) in &contradictions {
        text.push_str(&format!("channel {channel}: {sentence}\n"));
    }
    text.push_str("Nothing can be estimated from it without a format of its frames that names the channels of the aircraft.\n");
    match json {
        None => print(&text)?,
        Some(target) => {
            message(format_args!("{}", text.trim_end()));
            write_json(target, &format!("{:#}\n", document(file, &survey, &tally, &contradictions)))?;
        }
    }
    let lost = tally.skipped_bytes + tally.damaged + tally.missing_packets + survey.unreadable_times;
    Ok(if lost > 0 { Outcome::DataLost } else { Outcome::Done })
}

fn document(file: &Path, survey: &Chapter10Survey, tally: &PacketTally, contradictions: &[(u16, String)]) -> serde_json::Value {
    let channels: Vec<serde_json::Value> = survey
        .summary
        .lines()
        .map(|(channel, data_type, line)| {
            json!({
                "channel": channel,
                "data": type_name(data_type),
                "packets": line.packets,
                "bytes": line.bytes,
                "missing": line.missing,
                "damaged": line.damaged,
            })
        })
        .collect();
    let contradictions: Vec<serde_json::Value> =
        contradictions.iter().map(|(channel, sentence)| json!({ "channel": channel, "sentence": sentence })).collect();
    json!({
        "file": file.display().to_string(),
        "format": "IRIG 106 Chapter 10",
        "packets": tally.packets,
        "skipped_bytes": tally.skipped_bytes,
        "damaged": tally.damaged,
        "missing": tally.missing_packets,
        "channels": channels,
        "contradictions": contradictions,
    })
}
