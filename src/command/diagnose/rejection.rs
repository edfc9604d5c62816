//! Why a cause that fits is not relied upon, what hold-out runs say of one that is, and its share of the error, in words.

use sideslip::flight::channel::ControlNames;
use sideslip::postflight::diagnosis::diagnose::{Diagnosis, Finding, RejectedCause};
use sideslip::postflight::diagnosis::evidence::reliance::CauseRejection;
use sideslip::postflight::diagnosis::holdout::holdout_gain::{HoldoutEvidence, HoldoutVerdict};
use sideslip::postflight::validation::improvement::IntervalEstimate;

/// One clause.
pub(super) fn rejection(rejected: &RejectedCause, naming: ControlNames) -> String {
    let of_error = || percent_of_error(rejected.finding.error_share);
    let of_motion = rejected.finding.motion_share.map(|share| format!(" and changes the motion by {:.1} %", 100.0 * share));
    match (rejected.reason, &rejected.finding.held_out) {
        (CauseRejection::Small, _) => {
            // Of what is not small by itself it matters that hold-out runs do not show it.
            let not_seen = if rejected.finding.small { "" } else { ", and the hold-out runs do not show it" };
            format!("significant, but it explains {} of the model's error{}{not_seen}", of_error(), of_motion.unwrap_or_default())
        }
        (CauseRejection::Refuted, Some(own)) => {
            format!("refuted by the hold-out runs: error ratio {} with it", ratio_text(&own.ratio))
        }
        (CauseRejection::GainNotSeen, Some(own)) => format!(
            "refuted by the hold-out runs: error ratio {} of {}, for which it predicts {:.2}",
            ratio_text(&own.channel_ratio),
            own.channel.name(naming),
            own.channel_expected
        ),
        (_, None) => "refuted by the hold-out runs".to_owned(),
    }
}

/// Where no cause is found.
pub(super) fn explained(diagnosis: &Diagnosis) -> &'static str {
    if diagnosis.rejected.is_empty() {
        "The model explains these runs within their noise and its own tolerance"
    } else {
        "No cause is relied upon; beside those below the model explains these runs within their noise and its own tolerance"
    }
}

/// The verdict of the hold-out runs on one cause, in the words of the JSON.
pub(super) fn holdout_word(evidence: &HoldoutEvidence) -> &'static str {
    match evidence.verdict() {
        HoldoutVerdict::BorneOut => "borne out",
        HoldoutVerdict::NotSeen => "not seen there",
        HoldoutVerdict::Refuted | HoldoutVerdict::GainNotSeen => "refuted",
    }
}

/// `0.996 [0.975 1.018]`.
pub(super) fn ratio_text(ratio: &IntervalEstimate) -> String {
    let [low, high] = ratio.interval;
    format!("{:.3} [{low:.3} {high:.3}]", ratio.value)
}

/// `12 % of the error`: of that which faults of the recording leave, where there are any.
pub(super) fn share_of_error(finding: &Finding, all: &[Finding]) -> String {
    let is_fault = |one: &Finding| one.cause.effect.is_recording_fault();
    let remaining = if all.iter().any(is_fault) && !is_fault(finding) { "remaining " } else { "" };
    format!("{} of the {remaining}error", percent_of_error(finding.error_share))
}

/// `12 %`, of small shares two digits.
fn percent_of_error(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 2.0 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_shares_keep_a_digit() {
        assert_eq!([0.536, 0.0199, 0.0, 1.0].map(percent_of_error), ["54 %", "2.0 %", "0.0 %", "100 %"]);
        assert_eq!(ratio_text(&IntervalEstimate { value: 0.9959, interval: [0.9, 1.01] }), "0.996 [0.900 1.010]");
    }
}
