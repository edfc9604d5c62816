//! A recording through the real-time pipeline, as fast as it goes.

use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::recording_losses::recording_notes;
use crate::command::recordings::run_head::{HeadedRecording, head_of};
use crate::command::recordings::run_result::RunResult;
use crate::command::terminal::progress_line::ProgressLine;
use sideslip::error::Failure;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::live::wiring::WiredRun;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::sync::atomic::{AtomicBool, Ordering};

/// Estimates a run to its end, or until `stop`.
pub(super) fn through_pipeline(
    source: &RecordingSource,
    config: &PipelineConfig,
    mapping: &Mapping,
    stop: &AtomicBool,
) -> Result<RunResult, Failure> {
    let HeadedRecording { mut recording, info, .. } = head_of(source, source.open(mapping)?)?;
    let pipeline = Pipeline::new(config, *info.geometry()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
    let mut wired = WiredRun::new(pipeline, info.geometry().controls, None, None);
    let name = info.run().unwrap_or_default().to_owned();
    let mut progress = ProgressLine::new();
    let mut interrupted = false;
    while let Some(row) = recording.next_row()? {
        if stop.load(Ordering::Relaxed) {
            interrupted = true;
            break;
        }
        let time_s = row.sample.time_s;
        wired.step(row, &mut ()).unwrap_or_else(|never| match never {});
        progress.show(|| wired.sink.progress(&name, time_s));
    }
    drop(progress);
    let finished = wired.finish(&mut ()).unwrap_or_else(|never| match never {});
    let (notes, losses) = recording_notes(&recording, finished.rows, interrupted);
    Ok(RunResult::new(name, info.geometry().controls, finished.range_s, finished, None).of_recording(notes, losses))
}
