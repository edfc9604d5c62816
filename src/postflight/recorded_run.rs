//! A run as it was recorded: samples and where its instruments stand.

use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;

/// A recorded run.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// What it is called.
    pub name: String,
    /// Its samples in order of time.
    pub samples: Vec<Sample>,
    /// Where its instruments are said to stand.
    pub geometry: RunGeometry,
    /// Whether `reconstruction::screening` has taken damaged samples out already.
    pub screened: bool,
}
