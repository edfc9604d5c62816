//! A slow input without the noise of its instrument: noise of what explains attenuates what is explained by it.
//!
//! Consumes a channel z_i = x(t_i) + e_i, e of variance sigma^2; produces about every sample the value of the parabola by
//! least squares through those within T of it, a linear smoother x^ = S z. T is the most of [`HALF_WIDTHS_S`], or none, that has
//! hardly more than the least expected error
//!     mean (x^ - x)^2  ~  mean (z - x^)^2 - sigma^2 + 2 sigma^2 mean S_ii                              (1)
//! (C. L. Mallows, Some comments on C_p, Technometrics 15, 1973, for linear smoothers). A rotor, whose speed inertia keeps from
//! jumping, comes out a few times better; what does move within a window is left as it was read. sigma is estimated by the median
//! of third differences, in which a few steps do not count.

use crate::flight::signal::series::Series;
use crate::flight::signal::white_noise::white_noise_std_by_median;
use nalgebra::{Matrix3, Vector3};

/// T, s.
const HALF_WIDTHS_S: [f64; 4] = [0.06, 0.125, 0.25, 0.5];
/// Part of the variance that (1) may be above the least: noise of the slope falls faster with a wider window than that of the
/// value, which this is about.
const SLACK: f64 = 0.1;
/// Fewer samples leave a parabola no more than it takes.
const SAMPLES_MIN: usize = 5;

/// A channel with hardly more than the least expected error (1).
pub(crate) struct SmoothedRotorSpeed {
    pub(crate) series: Series,
    /// Standard deviation of the noise that is left.
    pub(crate) noise_std: f64,
    /// Density of the noise of its slope over short steps: what a window takes in and leaves out at its ends, 3/(2n) of a sample
    /// of n each, makes that of the value over T.
    pub(crate) slope_density: f64,
}

impl SmoothedRotorSpeed {
    /// Values whose windows reach T to either side, with what is left of the noise.
    fn of(series: Series, noise_std: f64, half_s: f64) -> Self {
        SmoothedRotorSpeed { series, noise_std, slope_density: noise_std * noise_std / half_s }
    }
}

pub(crate) fn smoothed(series: &Series) -> SmoothedRotorSpeed {
    let read: Vec<(f64, f64)> = series.samples().collect();
    let noise_std = white_noise_std_by_median(series.values());
    let variance = noise_std * noise_std;
    let as_read = || SmoothedRotorSpeed::of(series.clone(), noise_std, series.interval_s().unwrap_or(f64::INFINITY));
    // With (1) of each, the narrowest first.
    let mut tried = vec![(variance, as_read())];
    for half_s in HALF_WIDTHS_S {
        let Some((values, own)) = parabolas(&read, half_s) else { continue };
        let left: f64 = read.iter().zip(&values).map(|((_, read), (_, value))| (read - value) * (read - value)).sum();
        let error = left / read.len().max(1) as f64 - variance + 2.0 * variance * own;
        // Of a smoother by least squares, S_ii is the variance of what it gives over that of what it takes.
        tried.push((error, SmoothedRotorSpeed::of(Series::of(values), noise_std * libm::sqrt(own), half_s)));
    }
    let least = tried.iter().map(|(error, _)| *error).fold(f64::INFINITY, f64::min);
    let widest = tried.into_iter().rev().find(|(error, _)| *error <= least + SLACK * variance);
    widest.map_or_else(as_read, |(_, smoothed)| smoothed)
}

/// The parabolas' values at the samples, and the mean of S_ii; `None` where a window has too few samples.
fn parabolas(samples: &[(f64, f64)], half_s: f64) -> Option<(Vec<(f64, f64)>, f64)> {
    let mut own = 0.0;
    let mut values = Vec::with_capacity(samples.len());
    for &(time_s, _) in samples {
        let from = samples.partition_point(|&(t, _)| t < time_s - half_s);
        let to = samples.partition_point(|&(t, _)| t <= time_s + half_s);
        let window = samples.get(from..to).filter(|window| window.len() >= SAMPLES_MIN)?;
        let (mut information, mut vector) = (Matrix3::zeros(), Vector3::zeros());
        for &(t, value) in window {
            let s = (t - time_s) / half_s;
            let row = Vector3::new(1.0, s, s * s);
            information += row * row.transpose();
            vector += row * value;
        }
        let inverse = information.cholesky()?.inverse();
        own += inverse[(0, 0)];
        values.push((time_s, (inverse * vector).x));
    }
    Some((values, own / samples.len().max(1) as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    const NOISE: f64 = 0.02;

    fn read(truth: impl Fn(f64) -> f64) -> (Vec<f64>, Series) {
        let mut noise = NormalNoise::new(5, 0);
        let times: Vec<f64> = (0..700).map(|k| f64::from(k) / 32.0).collect();
        let series = Series::of(times.iter().map(|&t| (t, truth(t) + NOISE * noise.draw())));
        (times.into_iter().map(truth).collect(), series)
    }

    fn rms_error(truth: &[f64], series: &Series) -> f64 {
        let squares = series.samples().zip(truth).map(|((_, x), truth)| (x - truth) * (x - truth));
        (squares.sum::<f64>() / truth.len() as f64).sqrt()
    }

    #[test]
    fn what_wanders_slowly_loses_most_of_its_noise_and_says_how_much() {
        let (truth, series) = read(|t| 27.0 + 0.1 * (t / 0.8).sin() + 0.1 * (t / 1.7).cos());
        let SmoothedRotorSpeed { series: found, noise_std: std, slope_density } = smoothed(&series);
        let error = rms_error(&truth, &found);
        assert!(error < 0.4 * NOISE && std < 0.4 * NOISE, "{error} {std}");
        assert!((error / std - 1.0).abs() < 0.3, "{error} {std}");
        // Of the slope over two samples, in a band that no motion is in.
        let step_s = 2.0 / 32.0;
        let rate = |series: &Series, t: f64| (series.at(t + step_s) - series.at(t)) / step_s;
        let clean = Series::of(series.samples().zip(&truth).map(|((t, _), truth)| (t, *truth)));
        let off: Vec<f64> =
            (16..300).map(|k| rate(&found, step_s * f64::from(k)) - rate(&clean, step_s * f64::from(k))).collect();
        let density = off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64 * step_s;
        assert!((density / slope_density - 1.0).abs() < 0.4, "{density} {slope_density}");
    }

    /// What moves within the windows, and a step every few seconds.
    #[test]
    fn nothing_is_smoothed_further_than_it_pays() {
        let shaken = |t: f64| 27.0 + 0.3 * (25.0 * t).sin();
        let stepped = |t: f64| 27.0 + if (t / 3.0) as i32 % 2 == 0 { 0.2 } else { -0.2 };
        for (truth, series) in [read(shaken), read(stepped)] {
            let (there, here) = (rms_error(&truth, &smoothed(&series).series), rms_error(&truth, &series));
            assert!(there <= here, "{there} {here}");
        }
    }

    #[test]
    fn a_few_samples_are_left_as_they_were_read() {
        let few = Series::of((0..4).map(|k| (f64::from(k), 1.0)));
        assert!(smoothed(&few).series == few);
    }
}
