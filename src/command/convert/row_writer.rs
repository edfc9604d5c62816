//! Rows of a recording written as a run file or as a log, whole or not at all.

use crate::command::recordings::simulated_run::close_whole;
use crate::command::terminal::output_file::OutputFile;
use sideslip::error::Failure;
use sideslip::flight::channel::Channel;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::{RecordingColumn, RecordingTarget, RunFileWriter, RunInfo};
use sideslip::io::outputs::log::mcap_log::McapLog;
use sideslip::io::telemetry::record::RecordingRow;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// The kind of output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowFormat {
    Csv,
    Mcap,
}

impl RowFormat {
    /// The format that the ending of the name asks for.
    pub(super) fn by_name(path: &Path) -> Result<Self, Failure> {
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("csv") => Ok(RowFormat::Csv),
            Some("mcap") => Ok(RowFormat::Mcap),
            _ => Err(Failure::file(path, "expected a name that ends in .csv or .mcap")),
        }
    }
}

enum Sink {
    Csv(Box<RunFileWriter<BufWriter<File>>>),
    Mcap(Box<McapLog>, Vec<f64>),
}

/// An output that is being written.
pub(super) struct RowWriter {
    output: OutputFile,
    sink: Sink,
}

impl RowWriter {
    /// Begins a file beside `path`.
    pub(super) fn begin(
        format: RowFormat,
        path: &Path,
        info: &RunInfo,
        head: LogHead,
        columns: &[RecordingColumn],
    ) -> Result<Self, Failure> {
        let output = OutputFile::beside(path)?;
        let sink = match format {
            RowFormat::Csv => {
                let file = File::create(output.place()).map_err(|error| Failure::io(path, &error))?;
                let known = |column: &RecordingColumn| match column.target {
                    RecordingTarget::Known { channel, .. } => Some(channel),
                    _ => None,
                };
                let channels: Vec<Channel> = columns.iter().filter_map(known).collect();
                let others: Vec<&RecordingColumn> = RecordingColumn::others(columns).collect();
                let writer = RunFileWriter::with_others(BufWriter::new(file), info, &channels, &others);
                Sink::Csv(Box::new(writer.map_err(|error| Failure::file(path, error))?))
            }
            RowFormat::Mcap => {
                let log = McapLog::create(output.place(), head, Box::new(|_| ()));
                Sink::Mcap(Box::new(log.map_err(|error| Failure::Running(error.to_string()))?.one_file()), Vec::new())
            }
        };
        Ok(RowWriter { output, sink })
    }

    /// Writes a row.
    pub(super) fn row(&mut self, row: &RecordingRow) -> Result<(), Failure> {
        match &mut self.sink {
            Sink::Csv(writer) => {
                let written = writer.write_row_with(row.sample.time_s, |channel| row.sample.get(channel), &row.others);
                written.map_err(|error| Failure::io(self.output.target(), &error))
            }
            Sink::Mcap(log, others) => {
                others.clear();
                others.extend(row.others.iter().map(|value| value.unwrap_or(f64::NAN)));
                log.sample(&row.sample, others);
                Ok(())
            }
        }
    }

    /// Ends the file and puts it in its place.
    pub(super) fn end(self) -> Result<(), Failure> {
        match self.sink {
            Sink::Csv(writer) => {
                writer.finish().map_err(|error| Failure::io(self.output.target(), &error))?;
            }
            Sink::Mcap(log, _) => close_whole(*log, &self.output)?,
        }
        self.output.keep()
    }
}
