//! The samples of a recording, of whatever format.

use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

/// Every sample that is left of it.
pub(crate) fn remaining_samples(recording: &mut Recording) -> Vec<Sample> {
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        samples.push(row.sample);
    }
    samples
}

/// Every sample of the file.
pub(crate) fn samples_of(file: &Path) -> Vec<Sample> {
    remaining_samples(&mut Recording::open(file).unwrap())
}
