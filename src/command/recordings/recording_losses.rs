//! What of a recording was lost on the way in, a sentence each, for commands that read it whole.

use sideslip::io::outputs::words::control_scale::assumed_scale;
use sideslip::io::telemetry::alignment::aligned_recording::AlignedRecording;
use std::fmt::Write;
use std::path::Path;

/// Rows skipped beside those that were read, and what of the file could not be read; complete after the last row.
pub(crate) fn losses(file: &Path, aligned: &AlignedRecording, read: usize) -> Vec<String> {
    let recording = &aligned.recording;
    let (file, skipped) = (file.display(), recording.skipped().rows());
    let rows = (skipped > 0).then(|| format!("{file}: {skipped} of {} rows skipped", skipped + read as u64));
    rows.into_iter().chain(aligned.losses().iter().map(|what| format!("{file}: {what}"))).collect()
}

/// The same in detail, and then what else a reader should know of the file: sentences, of which so many first ones are losses.
pub(crate) fn recording_notes(aligned: &AlignedRecording, read: u64, interrupted: bool) -> (Vec<String>, usize) {
    let mut notes = detailed_losses(aligned, read);
    let losses = notes.len();
    notes.extend(aligned.tally().unwrap_or_default().notes());
    notes.extend(assumed_scale(aligned.recording.info()));
    notes.extend(aligned.longest_gap().map(|[from_s, to_s]| format!("no samples from {from_s:.2} to {to_s:.2} s")));
    if aligned.recording.ends_abruptly() && losses == 0 && !interrupted {
        let note = "the last line has no end: the file may have been cut short, and the last value with it";
        notes.push(note.into());
    }
    (notes, losses)
}

fn detailed_losses(aligned: &AlignedRecording, rows: u64) -> Vec<String> {
    let recording = &aligned.recording;
    let skipped = recording.skipped();
    let mut losses = Vec::new();
    if skipped.rows() > 0 {
        let mut sentence = format!("{} of {} rows skipped", skipped.rows(), skipped.rows() + rows);
        for reason in skipped.reasons() {
            let place = format_args!("first at {} {}: {}", recording.counted_in(), reason.first, reason.example);
            let _ = write!(sentence, "; {} for: {}, {place}", reason.rows, reason.reason.words());
        }
        losses.push(sentence);
    }
    losses.extend(aligned.losses());
    losses
}
