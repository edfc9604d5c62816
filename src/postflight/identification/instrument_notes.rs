//! Evidence of errors of instruments in a fit that has assumed none.
//!
//! Consumes a fit; produces notes in words: outputs that the model does not follow although they move by far more than their
//! noise, and scales and delays of instruments (`instrument_parameters`) that are significant once they are free and move the
//! derivatives. An instrument's error biases the derivatives of a linear model, and their standard errors do not account for it.

use super::identification_model::IdentificationModel;
use super::instrument_parameters::relinearise_delays;
use super::resting_controls::noise;
use super::run_prediction::RunPrediction;
use crate::postflight::output_error::{FitResult, FitSettings, InputOutputRecord, fit};

/// Part of an output's variance that a model which is right leaves at most.
const LEFT: f64 = 0.1;
/// An output is not followed where the residual is so many times its noise.
const TIMES_NOISE: f64 = 3.0;
/// Standard errors by which a doubt stands out, and by which a derivative moves with it.
const STANDS_OUT: f64 = 4.0;
const MOVES: f64 = 2.0;

/// The outputs of a run that the model does not follow.
pub(crate) fn misfit_note(flown: &RunPrediction, outputs: &[String]) -> Option<String> {
    let off = outputs.iter().zip(&flown.scores).zip(&flown.record.outputs).filter_map(|((name, score), measured)| {
        let score = score.as_ref()?;
        let samples = flown.record.times_s.iter().copied().zip(measured.iter().copied());
        let known: Vec<(f64, f64)> = samples.filter(|(_, value)| value.is_finite()).collect();
        let times = score.rms / noise(&known);
        (score.vaf < 1.0 - LEFT && times > TIMES_NOISE)
            .then(|| format!("`{name}` (VAF {:.2}, {times:.0} times its noise)", score.vaf))
    });
    let off: Vec<String> = off.collect();
    (!off.is_empty()).then(|| {
        format!(
            "{}: the model does not follow {}: an instrument is in error (sign, unit, scale, lateness, place: see `check`), or something \
             acts that this model does not have; derivatives may be wrong by more than their standard errors",
            flown.run,
            off.join(", ")
        )
    })
}

/// Instruments that stand out once they are doubted, and the derivatives that move with them.
pub(crate) fn instrument_note(
    linear: &IdentificationModel,
    records: &[InputOutputRecord],
    fitted: &FitResult,
    settings: &FitSettings,
) -> Option<String> {
    let mut doubted = linear.clone();
    let mut records = records.to_vec();
    doubted.add_instrument_parameters();
    relinearise_delays(&doubted, &mut records, fitted).ok()?;
    let with = fit(&doubted.structure, &doubted.parameters_with_instruments(fitted), &[], &records, settings)
        .ok()
        .filter(|with| with.converged)?;
    let count = linear.derivatives.len();
    let numbers = with.theta.iter().zip(&with.std);
    let out: Vec<String> = doubted
        .instrument_parameters
        .iter()
        .zip(numbers.skip(count))
        .filter(|(doubt, (value, std))| **std < doubt.prior_std && (*value - doubt.prior_mean).abs() > STANDS_OUT * **std)
        .filter(|(doubt, _)| !doubt.name.starts_with("lag_part"))
        .map(|(doubt, (value, std))| format!("`{}` {value:.3} +- {std:.3} {}", doubt.name, doubt.unit).trim_end().to_owned())
        .collect();
    let told = fitted.theta.iter().zip(&fitted.std);
    let moved: Vec<String> = (0..count)
        .zip(told.zip(&with.theta))
        .filter(|(_, ((before, std), after))| (*after - *before).abs() > MOVES * **std)
        .map(|(place, ((before, std), after))| format!("{} by {:.1}", linear.name(place), (after - before).abs() / std))
        .collect();
    (!out.is_empty() && !moved.is_empty()).then(|| {
        format!(
            "the instruments are taken at their word, but once they are doubted {} stand out, and derivatives move, in standard errors: {}; \
             take the numbers of `--doubt-instruments`, and see `check`",
            out.join(", "),
            moved.join(", ")
        )
    })
}
