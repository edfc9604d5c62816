//! Evidence of errors of instruments in a fit that assumed none.
//!
//! Consumes a fit; produces notes: outputs whose residual is far above their noise (VAF below 1 - [`RESIDUAL_VARIANCE`], rms
//! above [`NOISE_RATIO`] times the noise), and instrument parameters (`instrument_parameters`) that are significant once they are
//! free while derivatives change with them, both in standard errors (Wald test). An instrument's error biases the derivatives of
//! a linear model, and their standard errors do not account for it.

use super::identification_model::IdentificationModel;
use super::instrument_parameters::relinearise_delays;
use super::run_prediction::RunPrediction;
use crate::flight::signal::white_noise::white_noise_std_between_gaps;
use crate::postflight::output_error::{FitResult, FitSettings, InputOutputRecord, fit};

/// Part of an output's variance above which its residual is a misfit.
const RESIDUAL_VARIANCE: f64 = 0.1;
/// Ratio of the rms residual to the noise above which it is a misfit.
const NOISE_RATIO: f64 = 3.0;
/// Standard errors that make an instrument parameter significant, and a change of a derivative.
const SIGNIFICANT: f64 = 4.0;
const CHANGED: f64 = 2.0;

/// A note on the outputs of a run with a misfit.
pub(crate) fn misfit_note(flown: &RunPrediction, outputs: &[String], counts: impl Fn(&str) -> bool) -> Option<String> {
    let misfits = outputs.iter().zip(&flown.scores).zip(&flown.record.outputs).filter_map(|((name, score), measured)| {
        let score = score.as_ref().filter(|_| counts(name))?;
        let samples = flown.record.times_s.iter().copied().zip(measured.iter().copied());
        let known: Vec<(f64, f64)> = samples.filter(|(_, value)| value.is_finite()).collect();
        let times = score.rms / white_noise_std_between_gaps(&known);
        (score.vaf < 1.0 - RESIDUAL_VARIANCE && times > NOISE_RATIO)
            .then(|| format!("`{name}` (VAF {:.2}, {times:.0} times its noise)", score.vaf))
    });
    let misfits: Vec<String> = misfits.collect();
    (!misfits.is_empty()).then(|| {
        format!(
            "{}: the model does not follow {}: an instrument is in error (sign, unit, scale, delay, position: see `check`), or the model \
             lacks an effect; derivatives may be wrong by more than their standard errors",
            flown.run,
            misfits.join(", ")
        )
    })
}

/// A note on the instrument parameters that are significant once they are free, and the derivatives that change with them.
pub(crate) fn instrument_note(
    linear: &IdentificationModel,
    records: &[InputOutputRecord],
    fitted: &FitResult,
    settings: &FitSettings,
) -> Option<String> {
    let mut extended = linear.clone();
    let mut records = records.to_vec();
    extended.add_instrument_parameters();
    relinearise_delays(&extended, &mut records, fitted).ok()?;
    let with = fit(&extended.structure, &extended.parameters_with_instruments(fitted), &[], &records, settings)
        .ok()
        .filter(|with| with.converged)?;
    let count = linear.derivatives.len();
    let numbers = with.theta.iter().zip(&with.std);
    let significant: Vec<String> = extended
        .instrument_parameters
        .iter()
        .zip(numbers.skip(count))
        .filter(|(parameter, (value, std))| {
            **std < parameter.prior_std && (*value - parameter.prior_mean).abs() > SIGNIFICANT * **std
        })
        .filter(|(parameter, _)| !parameter.name.starts_with("lag_part"))
        .map(|(parameter, (value, std))| {
            format!("`{}` {value:.3} +- {std:.3} {}", parameter.name, parameter.unit).trim_end().to_owned()
        })
        .collect();
    let trusted = fitted.theta.iter().zip(&fitted.std);
    let changed: Vec<String> = (0..count)
        .zip(trusted.zip(&with.theta))
        .filter(|(_, ((before, std), after))| (*after - *before).abs() > CHANGED * **std)
        .map(|(place, ((before, std), after))| format!("{} by {:.1}", linear.name(place), (after - before).abs() / std))
        .collect();
    (!significant.is_empty() && !changed.is_empty()).then(|| {
        format!(
            "the instruments are taken as correct, but once their errors are estimated {} are significant, and derivatives change, in standard errors: {}; \
             take the numbers of `--doubt-instruments`, and see `check`",
            significant.join(", "),
            changed.join(", ")
        )
    })
}
