//! The gain of causes on hold-out runs, all together and each of them.
//!
//! Consumes a model, causes and runs that these were not found in; produces the errors of predictions over a horizon
//! (`horizon_prediction`) with the causes over those without, and of each cause the error with all over that with all but it.

use super::horizon_prediction::predict_over_horizon;
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::data::run_data::RunData;
use crate::postflight::diagnosis::data::usable_runs::record_of;
use crate::postflight::diagnosis::record::DiagnosisError;
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::validation::free_run::FreeRunPrediction;
use crate::postflight::validation::improvement::{
    ChannelImprovement, Improvement, ImprovementVerdict, IntervalEstimate, improvement,
};
use crate::simulation::flight_model::FlightModel;

/// The gain, and each run's predictions before and after.
pub type HoldoutImprovement = (Improvement, Vec<(FreeRunPrediction, FreeRunPrediction)>);

/// Whether any of the runs moves a control.
pub(crate) fn moves(holdout: &[RecordedRun], control: Control) -> bool {
    let records = holdout.iter().filter_map(|run| RunData::of(&run.name, &run.samples, run.geometry).ok());
    records.into_iter().any(|run| run.moves(control.index()))
}

/// What hold-out runs say of one cause: errors with all causes over those with all but this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldoutEvidence {
    /// Pooled over the channels.
    pub ratio: IntervalEstimate,
    /// What that ratio would be if the cause were right and all that it changes were error before.
    pub expected: f64,
    /// The channel whose error the cause is expected to reduce most.
    pub channel: Channel,
    /// Ratio of the errors of that channel.
    pub channel_ratio: IntervalEstimate,
    /// What that would be.
    pub channel_expected: f64,
}

/// What hold-out runs say of a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldoutVerdict {
    /// The error is smaller with it, pooled or of the channel that it should improve most.
    BorneOut,
    /// The runs do not tell.
    NotSeen,
    /// The pooled error is larger with it: much, or by more than it was predicted to fall.
    Refuted,
    /// Of the channel that it should improve most, the 95 % interval excludes even a quarter of the gain that it predicts.
    GainNotSeen,
}

/// Part of the predicted gain below which a cause is contradicted.
const LEAST_PART: f64 = 0.25;
/// Predicted ratio of errors above which the gain is too small to contradict a cause.
const EXPECTED_AT_MOST: f64 = 0.98;
/// Predicted ratio of errors above which no hold-out run can show a gain.
const TELLING_AT_MOST: f64 = 0.995;

impl HoldoutEvidence {
    /// Verdict on the cause.
    pub fn verdict(&self) -> HoldoutVerdict {
        let least = 1.0 - LEAST_PART * (1.0 - self.channel_expected);
        let gains = |ratio: &IntervalEstimate| ratio.verdict() == ImprovementVerdict::Gain && !ratio.is_negligible();
        let loss = self.ratio.verdict() == ImprovementVerdict::Loss;
        if self.ratio.is_refuted() || loss && self.ratio.value - 1.0 > 1.0 - self.expected {
            HoldoutVerdict::Refuted
        } else if gains(&self.ratio) {
            HoldoutVerdict::BorneOut
        } else if self.channel_expected < EXPECTED_AT_MOST && self.channel_ratio.interval[0] > least {
            HoldoutVerdict::GainNotSeen
        } else if gains(&self.channel_ratio) {
            HoldoutVerdict::BorneOut
        } else {
            HoldoutVerdict::NotSeen
        }
    }

    /// Whether the cause, if it is right, should be seen on the channel that it improves most.
    pub fn is_telling(&self) -> bool {
        self.channel_expected < TELLING_AT_MOST
    }

    fn of(gain: &Improvement) -> Option<Self> {
        let pooled = gain.pooled.as_ref()?;
        let expected_of = ChannelImprovement::expected_ratio;
        let finite = gain.channels.iter().filter(|one| expected_of(one).is_finite());
        let most = finite.min_by(|a, b| expected_of(a).total_cmp(&expected_of(b)))?;
        Some(HoldoutEvidence {
            ratio: pooled.ratio,
            expected: pooled.expected_ratio(),
            channel: most.channel,
            channel_ratio: most.ratio,
            channel_expected: expected_of(most),
        })
    }
}

/// What causes gain on runs that they were not found in: for each, the pooled error with all of them over that with all but this
/// one; and the gain of all.
///
/// # Errors
/// [`DiagnosisError::Holdout`] where a run cannot be predicted.
pub fn held_out(
    model: &FlightModel,
    causes: &[Effect],
    holdout: &[RecordedRun],
) -> Result<(Vec<Option<HoldoutEvidence>>, HoldoutImprovement), DiagnosisError> {
    let own = model.file.own_effects();
    let record = |run: &RecordedRun| record_of(model, run).map_err(|unfit| DiagnosisError::Holdout(run.name.clone(), unfit));
    let records: Vec<RunData> = holdout.iter().map(record).collect::<Result<_, _>>()?;
    let predict = |causes: &[Effect]| -> Vec<FreeRunPrediction> {
        let effects: Vec<Effect> = own.iter().chain(causes).copied().collect();
        records.iter().map(|run| predict_over_horizon(model, &effects, run)).collect()
    };
    let gain_of =
        |before: &[FreeRunPrediction], after: &[FreeRunPrediction]| improvement(&before.iter().zip(after).collect::<Vec<_>>());
    let (before, after) = (predict(&[]), predict(causes));
    let mut ratios = Vec::new();
    for place in 0..causes.len() {
        let others: Vec<Effect> =
            causes.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, effect)| *effect).collect();
        let without = if others.is_empty() { before.clone() } else { predict(&others) };
        ratios.push(HoldoutEvidence::of(&gain_of(&without, &after)));
    }
    let gain = gain_of(&before, &after);
    Ok((ratios, (gain, before.into_iter().zip(after).collect())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(pooled: [f64; 3], channel: [f64; 3], channel_expected: f64) -> HoldoutEvidence {
        let ratio = |[low, value, high]: [f64; 3]| IntervalEstimate { value, interval: [low, high] };
        HoldoutEvidence {
            ratio: ratio(pooled),
            expected: 0.99,
            channel: Channel::Alpha,
            channel_ratio: ratio(channel),
            channel_expected,
        }
    }

    /// What counts is the interval: beside a pooled error that tells nothing, a channel's own decides.
    #[test]
    fn a_cause_is_contradicted_where_its_own_channel_shows_no_gain() {
        let untold = [0.99, 1.0, 1.01];
        for (pooled, channel, expected, wanted) in [
            (untold, [0.978, 1.000, 1.017], 0.685, HoldoutVerdict::GainNotSeen),
            (untold, [0.60, 0.75, 1.01], 0.685, HoldoutVerdict::NotSeen),
            (untold, [0.60, 0.72, 0.85], 0.685, HoldoutVerdict::BorneOut),
            // What it predicts is too little to contradict it, or to bear it out.
            (untold, [0.997, 1.0, 1.003], 0.985, HoldoutVerdict::NotSeen),
            (untold, [0.985, 0.988, 0.992], 0.985, HoldoutVerdict::NotSeen),
            ([0.93, 0.95, 0.97], [0.9, 1.0, 1.1], 0.9, HoldoutVerdict::BorneOut),
            ([0.93, 0.95, 0.97], [1.03, 1.07, 1.12], 0.95, HoldoutVerdict::BorneOut),
            ([1.03, 1.06, 1.10], [0.60, 0.72, 0.85], 0.685, HoldoutVerdict::Refuted),
            // It was predicted to fall to 0.99.
            ([1.005, 1.018, 1.03], [0.98, 1.0, 1.04], 0.98, HoldoutVerdict::Refuted),
            ([1.001, 1.005, 1.01], [0.98, 1.0, 1.04], 0.98, HoldoutVerdict::NotSeen),
        ] {
            assert_eq!(evidence(pooled, channel, expected).verdict(), wanted, "{channel:?} of {expected}");
        }
    }
}
