//! Noise of a run by maximum likelihood of its innovations: nothing is tuned by hand.
//!
//! Consumes a record and parameters; produces [`KinematicNoise`]. Begins with what third differences say of each channel
//! (`series`), which knows no gusts, and goes down the cost of `filter` along the logarithm of one
//! variance after the other by parabolas. A prior holds what the record does not tell: a factor of e^3 upwards, but
//! of e downwards for the inputs, for there is seldom less noise than the samples themselves show.

use super::filter::{KinematicNoise, Prepared, pass};
use super::parameter::{INPUTS, OUTPUTS, Theta};
use super::run_channels::RunChannels;

const ACCELEROMETER_FLOOR: f64 = 0.003;
const GYRO_FLOOR: f64 = 1e-4;
const OUTPUT_FLOOR: [f64; OUTPUTS] = [0.02, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 0.05];
/// Spectral density of what an accelerometer that is missing would have read.
const MISSING: f64 = 1.0;
/// Of the vertical wind's walk.
const CLIMB: f64 = 0.001;
const PRIOR_STD: f64 = 3.0;
/// Of an input below what its samples show.
const LESS_STD: f64 = 1.0;
/// Longest move of a logarithm at once.
const MOVE_MAX: f64 = 2.5;

/// What the channels themselves show of their noise.
pub fn first_guess(record: &RunChannels) -> KinematicNoise {
    let input = core::array::from_fn(|i| {
        let floor = if i < 3 { ACCELEROMETER_FLOOR } else { GYRO_FLOOR };
        record.inputs.get(i).and_then(Option::as_ref).map_or(MISSING, |series| {
            let std = series.noise_std().max(floor);
            std * std * series.interval_s().unwrap_or(record.mesh.step_s)
        })
    });
    let output = core::array::from_fn(|c| {
        let series = record.outputs.get(c).and_then(Option::as_ref);
        let std = series.map_or(1.0, |series| series.noise_std().max(OUTPUT_FLOOR[c]));
        std * std
    });
    KinematicNoise { input, climb: CLIMB, output }
}

/// The k-th variance, where this record knows anything of it.
fn variance<'n>(noise: &'n mut KinematicNoise, record: &RunChannels, k: usize) -> Option<&'n mut f64> {
    match k {
        0..INPUTS => (record.inputs[k].is_some() && (k >= 3 || record.velocities)).then(|| &mut noise.input[k]),
        INPUTS => record.outputs[OUTPUTS - 1].is_some().then_some(&mut noise.climb),
        _ => record.outputs.get(k - INPUTS - 1)?.is_some().then(|| &mut noise.output[k - INPUTS - 1]),
    }
}

/// Improves the noise by so many sweeps over all variances; `None` where the motion cannot be followed.
pub fn improve(
    record: &RunChannels,
    theta: &Theta,
    start: &KinematicNoise,
    guess: &KinematicNoise,
    sweeps: usize,
) -> Option<KinematicNoise> {
    let mut best = *start;
    let prepared = &Prepared::of(record, theta);
    let mut cost = pass(prepared, &best, &[], true)?.cost + prior(&best, guess);
    let mut widths = [0.8; INPUTS + 1 + OUTPUTS];
    for _ in 0..sweeps {
        let before = cost;
        for (k, width_k) in widths.iter_mut().enumerate() {
            if variance(&mut best, record, k).is_none() || *width_k < 0.03 {
                continue;
            }
            let width = *width_k;
            let at = |by: f64| -> Option<(f64, KinematicNoise)> {
                let mut tried = best;
                *variance(&mut tried, record, k)? *= libm::exp(by);
                Some((pass(prepared, &tried, &[], true)?.cost + prior(&tried, guess), tried))
            };
            let (Some(up), Some(down)) = (at(width), at(-width)) else { continue };
            let curvature = up.0 + down.0 - 2.0 * cost;
            let by = if curvature > 1e-9 {
                (0.5 * width * (down.0 - up.0) / curvature).clamp(-MOVE_MAX, MOVE_MAX)
            } else if up.0 < down.0 {
                MOVE_MAX
            } else {
                -MOVE_MAX
            };
            let there = at(by);
            *width_k = (0.7 * by.abs()).clamp(0.02, 0.8);
            for (tried_cost, tried) in [Some(up), Some(down), there].into_iter().flatten() {
                if tried_cost < cost {
                    (cost, best) = (tried_cost, tried);
                }
            }
        }
        if before - cost < 1.0 {
            break;
        }
    }
    Some(best)
}

/// Minus twice the logarithm of the prior.
pub fn prior(noise: &KinematicNoise, guess: &KinematicNoise) -> f64 {
    let one = |(a, b): (&f64, &f64)| {
        let z = libm::log(a / b) / PRIOR_STD;
        z * z
    };
    let input = |(a, b): (&f64, &f64)| {
        let z = libm::log(a / b) / if a < b { LESS_STD } else { PRIOR_STD };
        z * z
    };
    noise.input.iter().zip(&guess.input).map(input).sum::<f64>()
        + noise.output.iter().zip(&guess.output).map(one).sum::<f64>()
        + one((&noise.climb, &guess.climb))
}
