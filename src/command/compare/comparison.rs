//! Flight against simulation: each run beside the free runs of one model or two, and the errors of all.

use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::sample::Sample;
use sideslip::postflight::validation::free_run::FreeRunPrediction;
use sideslip::postflight::validation::improvement::{Improvement, improvement};

/// One run with the free runs of the model and of the other beside it.
pub(super) struct ComparedRun {
    pub(super) name: String,
    pub(super) info: RunInfo,
    pub(super) samples: Vec<Sample>,
    pub(super) model: FreeRunPrediction,
    pub(super) beside: Option<FreeRunPrediction>,
    /// Whether the free runs are long enough for a score: beyond the trim window, whose mean error is taken out.
    pub(super) scored: bool,
}

/// Whether a motion goes on beyond the trim window.
pub(super) fn outlasts_trim(prediction: &FreeRunPrediction, trim_window_s: f64) -> bool {
    let [start_s, _] = prediction.range_s;
    prediction.diverged_at_s.is_none_or(|at_s| at_s > start_s + trim_window_s)
}

/// The prediction without any value: figures of it are none.
pub(super) fn emptied(prediction: &FreeRunPrediction) -> FreeRunPrediction {
    let mut empty = prediction.clone();
    for channel in &mut empty.channels {
        channel.times_s.clear();
        channel.measured.clear();
        channel.predicted.clear();
    }
    empty
}

impl ComparedRun {
    /// The figures of this run alone.
    pub(super) fn figures(&self) -> Improvement {
        let (model, beside) = self.pair();
        if self.scored { improvement(&[(model, beside)]) } else { improvement(&[(&emptied(model), &emptied(beside))]) }
    }

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
