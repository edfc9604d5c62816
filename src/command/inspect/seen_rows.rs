//! The rows of a recording, surveyed to the end, as text and as JSON, and what of it was lost.

use super::estimable::EstimableQuantities;
use super::survey::Survey;
use super::{json, table};
use crate::command::message;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::run_head::override_keys;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::record::RecordingError;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

/// The rows of a recording, surveyed to the end.
pub(super) struct SeenRows {
    pub(super) recording: Recording,
    /// Of the run, keys overridden.
    pub(super) info: RunInfo,
    rows: u64,
    pub(super) text: String,
    pub(super) document: serde_json::Value,
}

impl SeenRows {
    /// Reads it.
    pub(super) fn read(source: &RecordingSource, mut recording: Recording) -> Result<Self, Failure> {
        let file = source.file.as_path();
        let mut info = recording.info().clone();
        override_keys(&mut info, &source.set)?;
        let mut survey = Survey::new(recording.columns());
        let latencies = info.latencies().copied().unwrap_or_default();
        let order = RowAlignment::of_recording(&recording, &latencies);
        let mut order = order.map_err(|wrong| RecordingError::Whole { path: file.into(), what: wrong.to_string() })?;
        let (mut seen_s, mut begin_s): (Option<[f64; 2]>, Option<f64>) = (None, None);
        while let Some(row) = recording.next_row()? {
            let time_s = row.sample.time_s;
            seen_s = Some(seen_s.map_or([time_s; 2], |[first_s, last_s]| [first_s.min(time_s), last_s.max(time_s)]));
            if !source.span.has(time_s) {
                continue;
            }
            begin_s.get_or_insert(time_s);
            survey.add(row);
            order.push(row.number, &row.sample, &row.others, &mut |_| ());
        }
        order.finish(&mut |_| ());
        if survey.rows == 0 && !source.span.is_whole() {
            return Err(Failure::file(file, source.span.refusal(seen_s)));
        }
        if let (Some([first_s, _]), Some(begin_s)) = (seen_s, begin_s.filter(|_| !source.span.is_whole())) {
            info.begin_later(begin_s - first_s);
        }
        let estimable = EstimableQuantities::of(&survey, recording.info().geometry().controls);
        let text = table::text(file, &recording, &info, &survey, &order, &estimable);
        let document = json::document(file, &recording, &info, &survey, &order, &estimable);
        Ok(SeenRows { recording, info, rows: survey.rows, text, document })
    }

    /// Says what was lost.
    pub(super) fn outcome(&self, file: &Path) -> Outcome {
        let skipped = self.recording.skipped().rows();
        let mut outcome = Outcome::Done;
        if skipped > 0 {
            message(format_args!("sideslip: {}: {skipped} of {} rows skipped", file.display(), skipped + self.rows));
            outcome = Outcome::DataLost;
        }
        if let Some(shortfall) = self.recording.shortfall() {
            message(format_args!("sideslip: {}: {shortfall}", file.display()));
            outcome = Outcome::DataLost;
        }
        outcome
    }
}
