//! The gain of causes on hold-out runs, all together and each of them.
//!
//! Consumes a model, causes and runs that these were not found in; produces the errors of predictions over a horizon
//! (`horizon_prediction`) with the causes over those without, and of each cause the error with all over that with all but it.

use super::horizon_prediction::predict_over_horizon;
use crate::flight::control::Control;
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::data::run_data::RunData;
use crate::postflight::diagnosis::data::usable_runs::record_of;
use crate::postflight::diagnosis::record::DiagnosisError;
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::validation::free_run::FreeRunPrediction;
use crate::postflight::validation::improvement::{Improvement, IntervalEstimate, improvement};
use crate::simulation::flight_model::FlightModel;

/// The gain, and each run's predictions before and after.
pub type HoldoutImprovement = (Improvement, Vec<(FreeRunPrediction, FreeRunPrediction)>);

/// Whether any of the runs moves a control.
pub(crate) fn moves(holdout: &[RecordedRun], control: Control) -> bool {
    let records = holdout.iter().filter_map(|run| RunData::of(&run.name, &run.samples, run.geometry).ok());
    records.into_iter().any(|run| run.moves(control.index()))
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
) -> Result<(Vec<Option<IntervalEstimate>>, HoldoutImprovement), DiagnosisError> {
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
        ratios.push(gain_of(&without, &after).pooled.map(|pooled| pooled.ratio));
    }
    let gain = gain_of(&before, &after);
    Ok((ratios, (gain, before.into_iter().zip(after).collect())))
}
