//! Run files in text: preamble, header, rows; written again where a row was read.

use super::{Steps, bits, pieces};
use sideslip::flight::channel::Channel;
use sideslip::flight::file::run_file::{RecordingTarget, RunFileWriter, RunInfo};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::csv::CsvRecording;
use sideslip::io::telemetry::format::RecordingFormat;
use std::io::{Cursor, Read, Result};
use std::path::Path;

pub(super) fn run_file(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let whole = read(Box::new(Cursor::new(bytes.to_vec())), bytes);
    let lengths: Vec<usize> = pieces(bytes).map(<[u8]>::len).collect();
    let cut = read(Box::new(Pieces { source: Cursor::new(bytes.to_vec()), lengths, next: 0 }), bytes);
    assert!(whole.rows == cut.rows && whole.error == cut.error, "pieces change what is read: {:?} {:?}", whole.error, cut.error);
    if let Some(info) = whole.info.filter(|_| !whole.samples.is_empty()) {
        written_again(&info, &whole.channels, &whole.samples);
    }
    whole.samples.len()
}

struct Found {
    info: Option<RunInfo>,
    channels: Vec<Channel>,
    samples: Vec<Sample>,
    /// Line, time and values as bits, of every row.
    rows: Vec<Vec<u64>>,
    error: Option<String>,
}

fn read(source: Box<dyn Read + Send>, bytes: &[u8]) -> Found {
    let mut found = Found { info: None, channels: Vec::new(), samples: Vec::new(), rows: Vec::new(), error: None };
    let mut recording = match CsvRecording::new(Path::new("fuzz"), source) {
        Ok(recording) => recording,
        Err(error) => {
            found.error = Some(error.to_string());
            return found;
        }
    };
    found.info = Some(recording.info().clone());
    found.channels.extend(recording.columns().iter().filter_map(|column| match column.target {
        RecordingTarget::Known { channel, .. } => Some(channel),
        RecordingTarget::Time { .. } | RecordingTarget::Other => None,
    }));
    let mut steps = Steps::of(bytes, 1);
    loop {
        match recording.next_row() {
            Ok(Some(row)) => {
                steps.one();
                let others = row.others.iter().map(|other| other.unwrap_or(f64::NAN));
                let numbers = std::iter::once(row.sample.time_s).chain(row.sample.values).chain(others);
                found.rows.push([vec![row.number, u64::from(row.sample.present)], bits(numbers)].concat());
                found.samples.push(row.sample);
            }
            Ok(None) => break,
            Err(error) => {
                found.error = Some(error.to_string());
                break;
            }
        }
    }
    let lines = bytes.iter().filter(|byte| **byte == b'\n').count() as u64 + 1;
    assert!(found.rows.len() as u64 + recording.skipped().rows() <= lines, "more rows than lines");
    let _ = recording.ends_abruptly();
    found
}

fn written_again(info: &RunInfo, channels: &[Channel], samples: &[Sample]) {
    let mut writer = RunFileWriter::new(Vec::new(), info, channels).unwrap();
    for sample in samples {
        writer.write_row(sample.time_s, |channel| sample.get(channel)).unwrap();
    }
    let text = writer.finish().unwrap();
    let again = read(Box::new(Cursor::new(text.clone())), &text);
    let shown = String::from_utf8_lossy(&text[..text.len().min(500)]).into_owned();
    assert_eq!((again.error, again.info.as_ref()), (None, Some(info)), "written again:\n{shown}");
    let numbers = |sample: &Sample| bits(std::iter::once(sample.time_s).chain(sample.values));
    let same = |(one, other): (&Sample, &Sample)| one.present == other.present && numbers(one) == numbers(other);
    assert!(samples.len() == again.samples.len() && samples.iter().zip(&again.samples).all(same), "rows change:\n{shown}");
}

/// A source that gives so much at a time.
struct Pieces {
    source: Cursor<Vec<u8>>,
    lengths: Vec<usize>,
    next: usize,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let most = self.lengths.get(self.next).copied().unwrap_or(usize::MAX).min(buffer.len());
        self.next += 1;
        self.source.read(&mut buffer[..most])
    }
}
