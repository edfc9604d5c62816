//! Process noise of filter error: gusts on forces and moments, noise of the inputs.
//!
//! Consumes a run as recorded and the record that output error fits; produces for every chosen input the density of its noise in
//! every interval [(unit of u)^2 s],
//!     s = sigma^2 T + (u_1 - u_0)^2 T/12     between two samples T apart                               (1)
//! sigma from the second differences of the samples (`resting_controls`). The second term, the variance of a step at a uniformly
//! distributed time under the interpolating line, applies only to gaps. A control held for a time L has one error, of variance
//! sigma^2 T/L: for motions slower than L the full noise, for faster ones none, hence
//!     s = sigma^2 T min(1, [`SETTLED_S`]/L)^2     where it is held                                     (2)
//! Source: ours. Returns [`ColumnError`] where a run lacks an input.

use super::columns::{ColumnError, Columns};
use super::identification_model::IdentificationModel;
use super::model_variables::axis;
use crate::flight::signal::white_noise::white_noise_std_between_gaps;
use crate::postflight::output_error::InputOutputRecord;
use crate::postflight::output_error::filter_error::Disturbances;

/// A control held for longer than this, s, has the noise of its mean only.
pub(crate) const SETTLED_S: f64 = 2.0;

/// Length of a gap in median intervals.
const MISSING: f64 = 2.5;

/// Gusts on every equation with derivatives; (1) and (2) of the inputs of every run.
///
/// # Errors
/// [`ColumnError`] where a run lacks an input.
pub(crate) fn disturbances(
    linear: &IdentificationModel,
    runs: &[Columns],
    records: &[InputOutputRecord],
) -> Result<Disturbances, ColumnError> {
    let states = linear.choice.states.iter().enumerate();
    let gusts = states.filter(|(_, state)| axis(state).is_some()).map(|(place, _)| place).collect();
    let of_run = |(run, record): (&Columns, &InputOutputRecord)| {
        let of = |(name, used): (&String, &Vec<f64>)| Ok(densities(&record.times_s, &run.deviations(name)?, used));
        linear.choice.inputs.iter().zip(&record.inputs).map(of).collect::<Result<Vec<_>, ColumnError>>()
    };
    Ok(Disturbances { gusts, inputs: runs.iter().zip(records).map(of_run).collect::<Result<_, _>>()? })
}

/// (1) and (2) of one input, by interval; `used` is the input of the model.
fn densities(times_s: &[f64], recorded: &[f64], used: &[f64]) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        times_s.iter().copied().zip(recorded.iter().copied()).filter(|(_, value)| value.is_finite()).collect();
    let sigma = white_noise_std_between_gaps(&known);
    let mut lengths: Vec<f64> =
        known.windows(2).filter_map(|two| if let [a, b] = two { Some(b.0 - a.0) } else { None }).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
    let held = held(times_s, used);
    let mut at = 0;
    let intervals = times_s.iter().zip(&held).map(|(from, held_s)| {
        while known.get(at + 1).is_some_and(|next| next.0 <= *from) {
            at += 1;
        }
        let (Some(before), Some(after)) = (known.get(at), known.get(at + 1)) else { return 0.0 };
        let length = after.0 - before.0;
        if *held_s > 0.0 {
            let part = (SETTLED_S / held_s).min(1.0);
            return usual * sigma * sigma * part * part;
        }
        let step = if length > MISSING * usual { after.1 - before.1 } else { 0.0 };
        length * (sigma * sigma + step * step / 12.0)
    });
    intervals.collect()
}

/// By interval, how long the control is held there, s; 0 where it moves.
fn held(times_s: &[f64], used: &[f64]) -> Vec<f64> {
    let count = times_s.len().min(used.len()).saturating_sub(1);
    let mut lengths = vec![0.0; count];
    let same = |k: usize| used.get(k).zip(used.get(k + 1)).is_some_and(|(a, b)| a.to_bits() == b.to_bits());
    let mut from = 0;
    while from < count {
        let to = from + (from..count).take_while(|&k| same(k)).count();
        if let (Some(first), Some(last)) = (times_s.get(from), times_s.get(to)) {
            lengths.iter_mut().take(to).skip(from).for_each(|length| *length = last - first);
        }
        from = to.max(from + 1);
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::densities;

    #[test]
    fn a_gap_over_a_step_is_uncertain_by_where_the_step_is() {
        let nan = f64::NAN;
        let times: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k)).collect();
        let recorded = [0.0, 1.0, 2.0, 3.0, nan, nan, nan, 9.0, 10.0];
        let used = [0.0, 1.0, 2.0, 3.0, 4.5, 6.0, 7.5, 9.0, 9.0];
        let found = densities(&times, &recorded, &used);
        // The samples are a line but for the gap, so second differences have no noise.
        for (k, expected) in [0.0, 0.0, 0.0, 1.2, 1.2, 1.2, 1.2, 0.0].into_iter().enumerate() {
            assert!((found[k] - expected).abs() < 1e-9, "{found:?}");
        }
    }
}
