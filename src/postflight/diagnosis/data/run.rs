//! A run as it was recorded: samples and where its instruments stand.

use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;

/// A run as it was recorded.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Its name.
    pub name: String,
    /// Its samples.
    pub samples: Vec<Sample>,
    /// Where its instruments stand.
    pub geometry: RunGeometry,
}
