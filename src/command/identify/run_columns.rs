//! A recording as columns.

use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::recording_losses::losses;
use crate::command::recordings::run_head::{HeadedRecording, head_of};
use sideslip::error::Failure;
use sideslip::flight::file::log_head::ColumnTarget;
use sideslip::io::outputs::words::control_scale::assumed_names;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::postflight::identification::columns::Columns;

/// Reads a run: its columns, and what of it was lost, a sentence each.
pub(super) fn read_columns(
    source: &RecordingSource,
    mapping: &Mapping,
    trim_window_s: f64,
) -> Result<(Columns, Vec<String>), Failure> {
    let HeadedRecording { mut recording, info, head } = head_of(source, source.open_with_note(mapping)?)?;
    let targets = head.targets();
    let mut columns: Vec<(String, Vec<f64>)> = head.channels.iter().map(|(name, _)| (name.clone(), Vec::new())).collect();
    let mut times_s = Vec::new();
    while let Some(row) = recording.next_row()? {
        times_s.push(row.sample.time_s);
        for ((_, values), target) in columns.iter_mut().zip(&targets) {
            let value = match target {
                ColumnTarget::Known(channel) => row.sample.get(*channel),
                ColumnTarget::Unknown(place) => row.others.get(*place).copied().flatten(),
            };
            values.push(value.unwrap_or(f64::NAN));
        }
    }
    let losses = losses(&source.file, &recording, times_s.len());
    let name = info.run().unwrap_or_default().to_owned();
    let columns = Columns::new(name, *info.geometry(), times_s, columns, trim_window_s);
    let mut columns = columns.map_err(|wrong| Failure::file(&source.file, wrong))?;
    columns.properties = *info.properties();
    columns.recorded_at = info.recorded_at().map(str::to_owned);
    columns.assumed_scale = assumed_names(&info);
    Ok((columns, losses))
}
