//! `inspect` of an IRIG 106 Chapter 10 recording: its channels, where its setup contradicts its data, and the rows of one of
//! its PCM channels, or why it gives none.

use super::seen_rows::SeenRows;
use crate::command::message_text;
use crate::command::options::telemetry_source::{RecordingKind, RecordingSource};
use crate::command::recordings::provenance::Provenance;
use crate::command::terminal::console::print;
use serde_json::json;
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::words::printable::printable;
use sideslip::io::telemetry::chapter10::header::type_name;
use sideslip::io::telemetry::chapter10::packet::{Chapter10Reader, PacketTally};
use sideslip::io::telemetry::chapter10::survey::RecordingSurvey;
use sideslip::io::telemetry::record::RecordingError;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use std::fs::File;
use std::io::Read;
use std::path::Path;

const BLOCK: usize = 64 << 10;

/// Measurements that are named at most.
const NAMED: usize = 12;

/// Reads the whole recording and shows its channels, then the rows of one.
pub(super) fn run(source: &RecordingSource, config: &RecordingConfig, json: Option<&Path>) -> Result<Outcome, Failure> {
    let file = source.file.as_path();
    let io = |error: std::io::Error| Failure::io(file, &error);
    let mut bytes = File::open(file).map_err(io)?;
    let (mut reader, mut survey, mut block) = (Chapter10Reader::default(), RecordingSurvey::default(), vec![0; BLOCK]);
    loop {
        let count = bytes.read(&mut block).map_err(io)?;
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
    let mut text = format!("{}: IRIG 106 Chapter 10, {} packets\n", printable(&file.display().to_string()), tally.packets);
    text.push_str(&format!("{}\n", survey.summary.table(&tally, &survey.relation)));
    for (channel, sentence) in &contradictions {
        text.push_str(&format!("channel {channel}: {sentence}\n"));
    }
    if survey.unmeasured() > 0 {
        let packets = survey.unmeasured();
        text.push_str(&format!("{packets} PCM packets of further channels were not held against the setup\n"));
    }
    // Where the user says how its frames are read, they must be read.
    let asked = matches!(source.kind, RecordingKind::Chapter10(Some(_))) || config.chapter10 != Default::default();
    let seen = match source.open(config).map_err(Failure::from).and_then(|recording| SeenRows::read(source, recording)) {
        Err(why) if asked => return Err(why),
        seen => seen,
    };
    match &seen {
        Ok(seen) => {
            text.push_str(&format!("\n{}", seen.text));
            text.push_str(&listed("measurements of the setup are not read", seen.recording.left_out()));
            text.push_str(&listed("channels are read on an assumption", seen.recording.assumed()));
        }
        Err(why) => text.push_str(&format!("Nothing can be estimated from it: {why}\n")),
    }
    match json {
        None => print(&text)?,
        Some(target) => {
            message_text(text.trim_end());
            let mut document = document(file, &survey, &tally, &contradictions);
            if let Some(document) = document.as_object_mut() {
                document.insert("recording".into(), seen.as_ref().map_or(serde_json::Value::Null, |seen| seen.document.clone()));
                document.insert("no_rows".into(), json!(seen.as_ref().err().map(ToString::to_string)));
            }
            let at = seen.as_ref().ok().and_then(|seen| seen.info.recorded_at());
            Provenance::of(source.files()).dated(file, at).write_json(
                target,
                DocumentSchema::Chapter10,
                &format!("{document:#}\n"),
            )?;
        }
    }
    let lost =
        tally.skipped_bytes + tally.damaged + tally.missing_packets + survey.unreadable_times + contradictions.len() as u64;
    match seen.map(|seen| seen.outcome(file)) {
        Ok(Outcome::Done) | Err(_) if lost == 0 => Ok(Outcome::Done),
        _ => Ok(Outcome::DataLost),
    }
}

/// Sentences on measurements under a line that says how many.
fn listed(what: &str, all: &[String]) -> String {
    let mut text = String::new();
    if !all.is_empty() {
        text.push_str(&format!("\n{} {what}:\n", all.len()));
    }
    all.iter().take(NAMED).for_each(|why| text.push_str(&format!("  {why}\n")));
    if all.len() > NAMED {
        text.push_str(&format!("  and {} more\n", all.len() - NAMED));
    }
    text
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
