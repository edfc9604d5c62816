//! Flight against simulation: each run beside the free runs of one model or two, and the errors of all.

use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::sample::Sample;
use sideslip::postflight::validation::free_run::FreeRunPrediction;
use sideslip::postflight::validation::improvement::Improvement;

/// One run with the free runs of the model and of the other beside it.
pub(super) struct ComparedRun {
    pub(super) name: String,
    pub(super) info: RunInfo,
    pub(super) samples: Vec<Sample>,
    pub(super) model: FreeRunPrediction,
    pub(super) beside: Option<FreeRunPrediction>,
}

impl ComparedRun {
    /// The model's, and what stands beside it: itself where nothing else does.
    pub(super) fn pair(&self) -> (&FreeRunPrediction, &FreeRunPrediction) {
        (&self.model, self.beside.as_ref().unwrap_or(&self.model))
    }
}

/// Every run, and all of them together.
pub(super) struct Comparison {
    pub(super) runs: Vec<(ComparedRun, Improvement)>,
    pub(super) all: Improvement,
    pub(super) beside: bool,
}
