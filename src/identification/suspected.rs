//! What speaks against the instruments of runs that were taken at their word.
//!
//! Consumes a fit; produces notes in words: the outputs that the model does not follow though they move by far more than their
//! noise, and the scales and latenesses of instruments (`doubts`) that stand out once they are free, where derivatives move
//! with them. A linear model answers for an instrument's error with its derivatives, whose standard errors know nothing of it.

use super::held::noise;
use super::identify::{Flown, about};
use super::linear::Linear;
use crate::regression::output_error::{Fitted, Record, Settings, fit};

/// Part of an output's variance that a model which is right leaves at most.
const LEFT: f64 = 0.1;
/// An output is not followed where the residual is so many times its noise.
const TIMES_NOISE: f64 = 3.0;
/// Standard errors by which a doubt stands out, and by which a derivative moves with it.
const STANDS_OUT: f64 = 4.0;
const MOVES: f64 = 2.0;

/// The outputs of a run that the model does not follow.
pub(super) fn unlike(flown: &Flown, outputs: &[String]) -> Option<String> {
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
pub(super) fn suspected(linear: &Linear, records: &[Record], fitted: &Fitted, settings: &Settings) -> Option<String> {
    let mut doubted = linear.clone();
    let mut records = records.to_vec();
    doubted.doubt();
    about(&doubted, &mut records, fitted).ok()?;
    let with = fit(&doubted.structure, &doubted.doubted_parameters(fitted), &[], &records, settings)
        .ok()
        .filter(|with| with.converged)?;
    let count = linear.derivatives.len();
    let numbers = with.theta.iter().zip(&with.std);
    let out: Vec<String> = doubted
        .doubts
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
