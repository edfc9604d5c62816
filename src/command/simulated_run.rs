//! A simulated flight as a recording: a run file in text or a log, by the name of the file; whole or not at all.

use super::output_file::{OutputFile, write_whole};
use sideslip::error::Failure;
use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::{RunFileWriter, RunInfo};
use sideslip::outputs::mcap_log::McapLog;
use sideslip::telemetry::record::Sample;
use std::path::Path;

/// The kind of recording that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// A run file in text.
    Csv,
    /// A log, of samples only.
    Mcap,
}

impl Format {
    /// The format that the ending of the name asks for.
    pub(crate) fn by_name(path: &Path) -> Result<Self, Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "csv" => Ok(Format::Csv),
            "mcap" => Ok(Format::Mcap),
            "tlog" => Err(Failure::file(path, "simulate writes .csv and .mcap; .tlog is not written yet")),
            _ => Err(Failure::file(path, "expected a name that ends in .csv or .mcap")),
        }
    }
}

/// Writes the channels that any sample carries.
pub(crate) fn write_run(path: &Path, format: Format, info: &RunInfo, samples: &[Sample]) -> Result<(), Failure> {
    let present = samples.iter().fold(0, |present, sample| present | sample.present);
    let channels: Vec<Channel> = Channel::ALL.into_iter().filter(|channel| present & (1 << channel.index()) != 0).collect();
    match format {
        Format::Csv => write_whole(path, |file| {
            let mut writer = RunFileWriter::new(file, info, &channels)?;
            samples.iter().try_for_each(|sample| writer.write_row(sample.time_s, |channel| sample.get(channel)))?;
            writer.finish().map(|_| ())
        }),
        Format::Mcap => write_log(path, info, &channels, samples),
    }
}

fn write_log(path: &Path, info: &RunInfo, channels: &[Channel], samples: &[Sample]) -> Result<(), Failure> {
    let controls = info.geometry().controls;
    let named = channels.iter().map(|channel| (channel.name(controls).to_owned(), channel.si_unit().to_owned()));
    let head = LogHead { run_toml: info.to_toml(), channels: named.collect(), controls };
    let output = OutputFile::beside(path)?;
    let mut log = McapLog::create(output.place(), head, Box::new(|_| ())).map_err(|error| Failure::Running(error.to_string()))?;
    for sample in samples {
        log.sample(sample, &[]);
    }
    let summary = log.close();
    if let Some(fault) = summary.faults.first() {
        for further in summary.files.iter().skip(1) {
            let _ = std::fs::remove_file(further);
        }
        return Err(Failure::Running(fault.clone()));
    }
    output.keep()
}

const _: () = assert!(CHANNELS <= 32, "a sample's presence has 32 bits");
