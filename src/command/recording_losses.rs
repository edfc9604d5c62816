//! What of a recording was lost on the way in, a sentence each, for commands that read it whole.

use sideslip::telemetry::recording::Recording;
use std::path::Path;

/// Rows skipped beside those that were read, and what of the file could not be read; complete after the last row.
pub(crate) fn losses(file: &Path, recording: &Recording, read: usize) -> Vec<String> {
    let (file, skipped) = (file.display(), recording.skipped().rows());
    let rows = (skipped > 0).then(|| format!("{file}: {skipped} of {} rows skipped", skipped + read as u64));
    rows.into_iter().chain(recording.shortfall().map(|shortfall| format!("{file}: {shortfall}"))).collect()
}
