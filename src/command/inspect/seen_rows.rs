//! The rows of a recording, surveyed to the end, as text and as JSON, and what of it was lost.

use super::estimable::EstimableQuantities;
use super::survey::Survey;
use super::{json, table};
use crate::command::message;
use sideslip::error::Outcome;
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::record::RecordingError;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

/// The rows of a recording, surveyed to the end.
pub(super) struct SeenRows {
    pub(super) recording: Recording,
    rows: u64,
    pub(super) text: String,
    pub(super) document: serde_json::Value,
}

impl SeenRows {
    /// Reads it.
    pub(super) fn read(file: &Path, mut recording: Recording) -> Result<Self, RecordingError> {
        let mut survey = Survey::new(recording.columns());
        let latencies = recording.info().latencies().copied().unwrap_or_default();
        let order = RowAlignment::of_recording(&recording, &latencies);
        let mut order = order.map_err(|wrong| RecordingError::Whole { path: file.into(), what: wrong.to_string() })?;
        while let Some(row) = recording.next_row()? {
            survey.add(row);
            order.push(row.number, &row.sample, &row.others, &mut |_| ());
        }
        order.finish(&mut |_| ());
        let estimable = EstimableQuantities::of(&survey, recording.info().geometry().controls);
        let text = table::text(file, &recording, &survey, &order, &estimable);
        let document = json::document(file, &recording, &survey, &order, &estimable);
        Ok(SeenRows { recording, rows: survey.rows, text, document })
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
