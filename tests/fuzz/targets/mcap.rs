//! MCAP logs: head, samples, unknown columns, what a cut or damaged file did not give; written again by the program's log.

use super::{Steps, bits, temporary};
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::log::mcap_log::McapLog;
use sideslip::io::telemetry::format::RecordingFormat;
use sideslip::io::telemetry::log_recording::LogRecording;
use sideslip::io::telemetry::mcap::SampleReader;
use std::io::Cursor;
use std::path::Path;

/// An lz4 frame holds at most 255 bytes for one, and a message of no content is read as a sample of nothing.
const SAMPLES_PER_BYTE: u64 = 10;

pub(super) fn log(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let Some(found) = read(bytes) else { return 0 };
    if (1..200).contains(&found.samples.len()) {
        written_again(&found);
    }
    let Ok(mut recording) = LogRecording::new(Path::new("fuzz"), temporary::file(bytes)) else { return 0 };
    let mut rows = 0;
    while let Ok(Some(_)) = recording.next_row() {
        rows += 1;
    }
    assert_eq!(rows, found.samples.len(), "the recording has other rows than the log");
    let _ = (recording.shortfall(), recording.ends_abruptly());
    rows
}

struct Found {
    head: LogHead,
    samples: Vec<(Sample, Vec<Option<f64>>)>,
}

fn read(bytes: &[u8]) -> Option<Found> {
    let mut reader = SampleReader::open(Cursor::new(bytes)).ok()?;
    let mut found = Found { head: reader.head().clone(), samples: Vec::new() };
    let mut steps = Steps::of(bytes, SAMPLES_PER_BYTE);
    while let Ok(Some((sample, others))) = reader.next_sample() {
        steps.one();
        if found.samples.len() < 200 {
            found.samples.push((sample, others.to_vec()));
        } else {
            found.samples.push((sample, Vec::new()));
        }
    }
    assert_eq!(reader.losses().samples, found.samples.len() as u64);
    let _ = reader.losses().to_string();
    Some(found)
}

fn written_again(found: &Found) {
    let path = temporary::path("log.mcap");
    let Ok(mut log) = McapLog::create(&path, found.head.clone(), Box::new(|_| {})) else { return };
    for (sample, others) in &found.samples {
        let others: Vec<f64> = others.iter().map(|other| other.unwrap_or(f64::NAN)).collect();
        log.sample(sample, &others);
    }
    let summary = log.close();
    let written = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((summary.lost, summary.faults), (0, Vec::new()));
    let again = read(&written).expect("what was written is no log");
    assert_eq!(again.head, found.head, "the head changes");
    assert!(again.samples.iter().map(numbers).eq(found.samples.iter().map(numbers)), "the samples change");
}

/// Presence and values; an unknown column without a number is as one that was not sampled.
fn numbers((sample, others): &(Sample, Vec<Option<f64>>)) -> Vec<u64> {
    let others = others.iter().map(|other| other.unwrap_or(f64::NAN));
    let mut all = bits(std::iter::once(sample.time_s).chain(sample.values).chain(others));
    all.push(sample.present.into());
    all
}
