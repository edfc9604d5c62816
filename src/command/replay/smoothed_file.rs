//! The smoothed states of a run in a file: every sample's, from the whole record.

use super::output_per_recording::OutputPerRecording;
use crate::command::recordings::simulated_run::close_whole;
use crate::command::terminal::output_file::{OutputFile, write_whole};
use sideslip::error::Failure;
use sideslip::flight::file::log_head::{ColumnTarget, LogHead};
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::log::mcap_log::{LogError, McapLog};
use sideslip::io::outputs::log::state_file;
use sideslip::io::outputs::record::Message;
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::fixed_interval::smooth_watched;
use sideslip::realtime::estimation::record::{LaggedRecord, StateRecord};
use std::path::{Path, PathBuf};

/// The files of `--smoothed`.
pub(super) const STATES: OutputPerRecording = OutputPerRecording { option: "--smoothed", endings: &["csv", "mcap"] };

/// Messages between two flushes of an MCAP file.
const FLUSH_EVERY: usize = 4096;

pub(super) struct RunToSmooth<'a> {
    pub(super) file: &'a Path,
    pub(super) info: &'a RunInfo,
    pub(super) head: &'a LogHead,
    /// Every row, in order.
    pub(super) rows: &'a [RecordingRow],
}

#[derive(Debug)]
pub(super) struct SmoothedFile {
    path: PathBuf,
    states: usize,
    rows: usize,
}

impl SmoothedFile {
    pub(super) fn line(&self) -> String {
        let SmoothedFile { path, states, rows } = self;
        let without = match rows - states {
            0 => String::new(),
            count => format!("; {count} of {rows} samples without one, for the filter did not run there"),
        };
        format!("smoothed: {}, {states} states{without}", path.display())
    }
}

impl RunToSmooth<'_> {
    /// Smooths and writes, as text or MCAP by the name; `None`, and nothing written, where `watch` said no to going on.
    pub(super) fn write(
        &self,
        path: &Path,
        config: &EstimationConfig,
        watch: impl FnMut(f64) -> bool,
    ) -> Result<Option<SmoothedFile>, Failure> {
        let samples: Vec<Sample> = self.rows.iter().map(|row| row.sample).collect();
        let smoothed = smooth_watched(&samples, config, *self.info.geometry(), watch);
        let Some(smoothed) = smoothed.map_err(|wrong| Failure::Input(wrong.to_string()))? else { return Ok(None) };
        if smoothed.states.is_empty() {
            let expected = "`p`, `q` and `r` together, `tas`, and `phi` and `theta` or accelerometers";
            let what = format!("--smoothed: expected {expected} to start the filter with, found no sample where it could start");
            return Err(Failure::file(self.file, what));
        }
        if path.extension().is_some_and(|ending| ending == "mcap") {
            self.write_log(path, &smoothed.states)?;
        } else {
            self.write_text(path, &smoothed.states)?;
        }
        Ok(Some(SmoothedFile { path: path.into(), states: smoothed.states.len(), rows: self.rows.len() }))
    }

    fn write_text(&self, path: &Path, states: &[StateRecord]) -> Result<(), Failure> {
        if let Some([before, after]) = states.array_windows().find(|[before, after]| !(after.time_s > before.time_s)) {
            let (before, after) = (before.time_s, after.time_s);
            let what =
                format!("--smoothed: expected time that increases for a text file (MCAP takes any), found {before} s, {after} s");
            return Err(Failure::file(self.file, what));
        }
        let known = self.head.targets().into_iter().filter_map(|target| match target {
            ColumnTarget::Known(channel) => Some(channel),
            ColumnTarget::Unknown(_) => None,
        });
        let channels: Vec<_> = known.filter(|&channel| self.rows.iter().any(|row| row.sample.get(channel).is_some())).collect();
        write_whole(path, |file| {
            let rows = self.with_states(states).filter_map(|(row, state)| Some((state?, &row.sample)));
            state_file::write(file, self.info, &channels, rows)
        })
    }

    /// The recording as it was, with its states beside it.
    fn write_log(&self, path: &Path, states: &[StateRecord]) -> Result<(), Failure> {
        let output = OutputFile::beside(path)?;
        let created = McapLog::create(output.place(), self.head.clone(), Box::new(|_| ())).map_err(|error| match error {
            LogError::File { source, .. } => Failure::io(path, &source),
            ambiguous @ LogError::AmbiguousColumn { .. } => Failure::file(path, ambiguous),
        });
        let mut log = created?.one_file();
        let end_s = states.last().map_or(0.0, |last| last.time_s);
        for (place, (row, state)) in self.with_states(states).enumerate() {
            let others: Vec<f64> = row.others.iter().map(|other| other.unwrap_or(f64::NAN)).collect();
            log.sample(&row.sample, &others);
            if let Some(state) = state {
                log.message(&Message::Smoothed(LaggedRecord { state: *state, lag_s: end_s - state.time_s }));
            }
            if place % FLUSH_EVERY == FLUSH_EVERY - 1 {
                log.flush();
            }
        }
        close_whole(log, &output)?;
        output.keep()
    }

    /// Every row with its state, where it has one; both are in the same order.
    fn with_states<'s>(&'s self, states: &'s [StateRecord]) -> impl Iterator<Item = (&'s RecordingRow, Option<&'s StateRecord>)> {
        let mut ahead = states.iter().peekable();
        self.rows.iter().map(move |row| (row, ahead.next_if(|state| state.time_s.to_bits() == row.sample.time_s.to_bits())))
    }
}
