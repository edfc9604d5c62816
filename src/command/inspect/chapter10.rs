//! `inspect` of an IRIG 106 Chapter 10 recording: its channels, and where its setup contradicts its data.

use crate::command::message;
use crate::command::terminal::output_file::{print, write_json};
use serde_json::json;
use sideslip::error::{Failure, Outcome};
use sideslip::io::telemetry::chapter10::header::type_name;
use sideslip::io::telemetry::chapter10::packet::{Chapter10Reader, PacketTally};
use sideslip::io::telemetry::chapter10::survey::RecordingSurvey;
use sideslip::io::telemetry::record::RecordingError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

const BLOCK: usize = 64 << 10;

/// Reads the whole recording once and shows its channels.
pub(super) fn run(file: &Path, json: Option<&Path>) -> Result<Outcome, Failure> {
    let io = |error: std::io::Error| Failure::io(file, &error);
    let mut source = File::open(file).map_err(io)?;
    let (mut reader, mut survey, mut block) = (Chapter10Reader::default(), RecordingSurvey::default(), vec![0; BLOCK]);
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
    if survey.unmeasured() > 0 {
        let packets = survey.unmeasured();
        text.push_str(&format!("{packets} PCM packets of further channels were not held against the setup\n"));
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

fn document(file: &Path, survey: &RecordingSurvey, tally: &PacketTally, contradictions: &[(u16, String)]) -> serde_json::Value {
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
