//! What the hold-out runs say, in a word.

use sideslip::postflight::validation::improvement::{ImprovementVerdict, IntervalEstimate};

pub(super) fn judged(judged: ImprovementVerdict) -> &'static str {
    match judged {
        ImprovementVerdict::Gain => "gain",
        ImprovementVerdict::NoGain => "no gain",
        ImprovementVerdict::Loss => "loss",
    }
}

/// The hold-out verdict on one cause: the error with it over that without it.
pub(super) fn borne_out(ratio: &IntervalEstimate) -> &'static str {
    match ratio.verdict() {
        _ if ratio.is_negligible() => "hardly seen there",
        ImprovementVerdict::Gain => "borne out",
        ImprovementVerdict::NoGain => "neither borne out nor refuted",
        ImprovementVerdict::Loss => "refuted",
    }
}
