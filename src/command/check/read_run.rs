//! A recording as the check of its instruments takes it.

use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::run_input::{RunInput, read_run};
use sideslip::error::Failure;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::postflight::recorded_run::RecordedRun;

/// A recording as it was read.
pub(super) struct ReadRun {
    pub(super) candidate: RecordedRun,
    pub(super) info: RunInfo,
    pub(super) losses: Vec<String>,
}

/// Reads a recording; where time does not increase is a loss.
pub(super) fn read(source: &RecordingSource, mapping: &Mapping) -> Result<ReadRun, Failure> {
    let RunInput { name, info, samples, mut losses } = read_run(source, mapping)?;
    let backwards = samples.array_windows().filter(|[before, after]| !(after.time_s > before.time_s)).count();
    if backwards > 0 {
        losses.push(format!("{}: time does not increase at {backwards} of {} rows", source.file.display(), samples.len()));
    }
    Ok(ReadRun { candidate: RecordedRun { name, samples, geometry: *info.geometry(), screened: false }, info, losses })
}
