//! How large a cause is: what it changes in the predicted motion, as a share of that motion and of the model's error.
//!
//! Consumes the problem and the point where the search ended; produces for each hypothesis, with y the predictions over a
//! horizon (`horizon_prediction`) from the states of the filter, y' those without it, and sigma the standard deviation of a
//! reading's noise,
//!     motion share = max over channels of (max over runs of rms(y - y'))/(max over runs of rms(z - mean z))    (1)
//!     error        = mean over channels of mean (y - y')^2/sigma^2                                             (2)
//! and, of what all of them leave, mean over channels of mean (z - y)^2/sigma^2 - 1; channels whose axes the model does not
//! cover leave nothing. A channel that moves less than its noise counts as moving by its noise. An instrument that is late by d
//! changes its channel by d times the rate of what it measures; a control that is recorded late changes the motion. Many samples
//! make a cause of any size significant; whether it matters is (1).

use crate::flight::channel::Channel;
use crate::flight::effect::{Effect, Family};
use crate::postflight::diagnosis::data::run_data::{OUTPUT_CHANNELS, OUTPUTS};
use crate::postflight::diagnosis::holdout::horizon_prediction::{PredictedReading, Predictions, is_covered, predict_windows};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::{Hypothesis, ParameterSet};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::likelihood::state::FilterResult;

/// Of one hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CauseSize {
    /// (1).
    pub(crate) motion_share: f64,
    /// (2).
    pub(crate) error: f64,
    /// Whether it is an instrument's.
    pub(crate) of_instrument: bool,
}

/// Of all hypotheses, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CauseSizes {
    pub(crate) of: Vec<CauseSize>,
    /// Error that they leave beyond that of the noise, not below nought.
    pub(crate) left: f64,
}

/// Sums over the readings of one output.
#[derive(Clone, Copy, Debug, Default)]
struct Whitened {
    sum: f64,
    count: f64,
}

impl Whitened {
    fn add(&mut self, square: f64) {
        if square.is_finite() {
            (self.sum, self.count) = (self.sum + square, self.count + 1.0);
        }
    }

    /// Mean over the outputs of the mean of each.
    fn pooled(outputs: &[Whitened; OUTPUTS]) -> f64 {
        let means = outputs.iter().filter(|one| one.count > 0.0).map(|one| one.sum / one.count);
        let (sum, count) = means.fold((0.0, 0.0), |(sum, count), mean| (sum + mean, count + 1.0));
        sum / f64::max(count, 1.0)
    }
}

/// What one hypothesis changes.
#[derive(Clone, Copy, Default)]
struct Changed {
    /// Largest rms of any run, by output.
    most: [f64; OUTPUTS],
    whitened: [Whitened; OUTPUTS],
}

/// (1) and (2) of every hypothesis, by predictions over each of these times; nothing where the model cannot be followed along the
/// runs.
pub(crate) fn cause_sizes<const N: usize>(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    horizons_s: [f64; N],
) -> [CauseSizes; N] {
    match linearise(problem, point, &[], Detail::Traces) {
        Some(local) => horizons_s.map(|horizon_s| sizes_over(problem, point, &local.runs, horizon_s)),
        None => core::array::from_fn(|_| CauseSizes::default()),
    }
}

fn sizes_over(problem: &DiagnosisProblem, point: &ParameterSet, runs: &[FilterResult], horizon_s: f64) -> CauseSizes {
    let mut moved = [0.0_f64; OUTPUTS];
    let mut left = [Whitened::default(); OUTPUTS];
    let mut changed = vec![Changed::default(); point.hypotheses.len()];
    for (number, (record, filtered)) in problem.runs.iter().zip(runs).enumerate() {
        let noise = |output: usize| record.recorded_noise.get(output).copied().filter(|noise| noise.is_finite()).unwrap_or(0.0);
        let with = predict_windows(problem, point, (number, &filtered.states), horizon_s);
        for (output, ((most, left), readings)) in moved.iter_mut().zip(&mut left).zip(&with.of_output).enumerate() {
            *most = most.max(deviation(readings.iter().map(|(_, reading, _)| reading.value))).max(noise(output));
            for (_, reading, predicted) in readings {
                let error = reading.value - predicted;
                let square = error * error * reading.count / (noise(output) * noise(output));
                // The noise alone is no error.
                left.add(if is_covered(problem, output) { square } else { 1.0 });
            }
        }
        for (place, changed) in changed.iter_mut().enumerate() {
            let Some(hypothesis) = point.hypotheses.get(place) else { continue };
            let differences = match hypothesis.effect {
                Effect::SensorDelay { channel, delay: late_s } | Effect::SensorLag { channel, tau: late_s }
                    if OUTPUT_CHANNELS.contains(&channel) =>
                {
                    late(&with, channel, late_s)
                }
                _ => {
                    let mut without = point.clone();
                    without.hypotheses.remove(place);
                    difference(&with, &predict_windows(problem, &without, (number, &filtered.states), horizon_s))
                }
            };
            let of_output = changed.most.iter_mut().zip(&mut changed.whitened).zip(differences).enumerate();
            for (output, ((most, whitened), differences)) in of_output {
                *most = most.max(rms(differences.iter().map(|(d, _)| *d)));
                let variance = noise(output) * noise(output);
                differences.iter().for_each(|(d, count)| whitened.add(d * d * count / variance));
            }
        }
    }
    let share = |changed: &[f64; OUTPUTS]| {
        let of_channel = changed.iter().zip(&moved).filter(|(_, moved)| **moved > 0.0).map(|(changed, moved)| changed / moved);
        of_channel.fold(0.0, f64::max)
    };
    let one = |(changed, hypothesis): (&Changed, &Hypothesis)| CauseSize {
        motion_share: share(&changed.most),
        error: Whitened::pooled(&changed.whitened),
        of_instrument: hypothesis.effect.kind().family() == Family::Instrument,
    };
    CauseSizes { of: changed.iter().zip(&point.hypotheses).map(one).collect(), left: (Whitened::pooled(&left) - 1.0).max(0.0) }
}

/// Differences between predictions of one output, each with the number of samples in its reading.
type Differences = Vec<(f64, f64)>;

/// By output, up to where one of the two diverges.
fn difference(with: &Predictions, without: &Predictions) -> [Differences; OUTPUTS] {
    core::array::from_fn(|output| {
        let of = |predictions: &Predictions| predictions.of_output.get(output).cloned().unwrap_or_default();
        of(with).iter().zip(&of(without)).map(|((_, reading, a), (.., b))| (a - b, reading.count)).collect()
    })
}

/// What being late changes in that channel.
fn late(with: &Predictions, late: Channel, late_s: f64) -> [Differences; OUTPUTS] {
    core::array::from_fn(|output| {
        let own = OUTPUT_CHANNELS.get(output).is_some_and(|&channel| channel == late);
        let readings: &[PredictedReading] = with.of_output.get(output).filter(|_| own).map_or(&[], Vec::as_slice);
        let pairs = readings.iter().zip(readings.iter().skip(1));
        let one = |((before_s, _, before), (after_s, reading, after)): (&PredictedReading, &PredictedReading)| {
            (late_s * (after - before) / (after_s - before_s), reading.count)
        };
        pairs.map(one).collect()
    })
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let squares = values.filter(|value| value.is_finite()).fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    libm::sqrt(squares.0 / f64::max(squares.1, 1.0))
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let (sum, count) = values.clone().fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    let mean = sum / f64::max(count, 1.0);
    rms(values.map(|x| x - mean))
}

#[cfg(test)]
mod tests {
    use super::super::super::likelihood::likelihood_tests::problem_with;
    use super::*;

    /// A control that is recorded late changes no channel of its own, and the motion all the same.
    #[test]
    fn a_late_instrument_and_a_late_control_are_large() {
        for channel in [Channel::R, Channel::Pedal] {
            let effect = Effect::SensorDelay { channel, delay: 0.2 };
            let problem = problem_with(vec![effect]);
            let mut point = problem.null_hypothesis();
            point.hypotheses = vec![Hypothesis::of(effect, 0.2)];
            let [sizes] = cause_sizes(&problem, &point, [2.0]);
            let CauseSize { motion_share, error, of_instrument } = sizes.of[0];
            assert!(motion_share > 0.05 && error > 1.0 && of_instrument, "{channel:?}: {motion_share} {error}");
        }
    }
}
