//! What the hold-out runs say of the gain, in a word.

use sideslip::postflight::validation::improvement::{ImprovementVerdict, PooledImprovement};

pub(super) fn judged(pooled: &PooledImprovement) -> &'static str {
    match pooled.ratio.verdict() {
        ImprovementVerdict::Gain => "gain",
        ImprovementVerdict::NoGain if pooled.is_not_seen() => "not seen there",
        ImprovementVerdict::NoGain => "no gain",
        ImprovementVerdict::Loss => "loss",
    }
}
