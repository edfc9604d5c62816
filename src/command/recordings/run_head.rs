//! The head of a recording's run: its own keys, with those of `--set` in their place, and the recording aligned by them.

use crate::command::options::telemetry_source::RecordingSource;
use sideslip::error::Failure;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::{ChannelLatencies, RecordingColumn, RecordingTarget, RunInfo};
use sideslip::io::telemetry::alignment::aligned_recording::AlignedRecording;
use sideslip::io::telemetry::recording::Recording;

/// A recording with the head of its run.
pub(crate) struct HeadedRecording {
    /// Its rows are aligned by the latencies of the run; `info` says so.
    pub(crate) recording: AlignedRecording,
    pub(crate) info: RunInfo,
    pub(crate) head: LogHead,
}

/// The head of the run of an opened recording, keys overridden, named by its file where it has no name; its rows are those of the
/// part that is read, and its date that of the first of them.
pub(crate) fn head_of(source: &RecordingSource, recording: Recording) -> Result<HeadedRecording, Failure> {
    let file = source.file.as_path();
    let mut info = recording.info().clone();
    override_keys(&mut info, &source.set)?;
    let latencies = info.take_latencies();
    // A log has another name than the recording; the run keeps its own.
    let named = info.run().map_or_else(|| file.file_stem().unwrap_or_default().to_string_lossy().into_owned(), str::to_owned);
    let named = source.manoeuvre.map_or_else(|| named.clone(), |number| format!("{named} manoeuvre {number}"));
    if info.run() != Some(named.as_str()) {
        info.set(&format!("run={}", toml::Value::String(named))).map_err(|what| Failure::file(file, what))?;
    }
    let mut recording = aligned(source, recording, latencies.as_ref())?;
    if info.recorded_at_ns().is_some() {
        info.begin_later(recording.begins_after()?);
    }
    let head = head_with(&info, recording.recording.columns());
    Ok(HeadedRecording { recording, info, head })
}

/// A recording with its own keys, aligned by its own latencies.
pub(crate) fn aligned_by_its_own(source: &RecordingSource, recording: Recording) -> Result<AlignedRecording, Failure> {
    let latencies = recording.info().latencies().copied();
    aligned(source, recording, latencies.as_ref())
}

fn aligned(
    source: &RecordingSource,
    recording: Recording,
    latencies: Option<&ChannelLatencies>,
) -> Result<AlignedRecording, Failure> {
    let aligned = AlignedRecording::new(recording, latencies).map_err(|wrong| Failure::file(&source.file, wrong))?;
    Ok(aligned.within(source.span, source.file.clone()))
}

/// The head of a run with these columns.
pub(crate) fn head_with(info: &RunInfo, columns: &[RecordingColumn]) -> LogHead {
    let carried = columns.iter().filter(|column| !matches!(column.target, RecordingTarget::Time { .. }));
    LogHead {
        run_toml: info.to_toml(),
        channels: carried.map(|column| (column.name.clone(), column.inner_unit().to_owned())).collect(),
        controls: info.geometry().controls,
        ..LogHead::default()
    }
}

/// `--set` on what the run says of itself.
pub(crate) fn override_keys(info: &mut RunInfo, overrides: &[String]) -> Result<(), Failure> {
    overrides.iter().try_for_each(|set| info.set(set)).map_err(|what| Failure::Input(format!("--set: {what}")))
}
