//! A control at rest, replaced by its mean, so that the noise of its transducer does not excite the model.
//!
//! Consumes samples of a control; replaces by its mean every stretch over which they differ by white noise only. Noise on a
//! recorded control is not noise of an output: the model responds to it as to a gust (0.2 mrad of pedal at 128 Hz gives 0.7
//! mrad/s of the Puma's yaw rate after 18 s), and next to a lightly damped mode no standard error accounts for it.
//! Samples are taken in blocks of [`BLOCK_S`]. A block joins the stretch before it where no sample differs from its mean by more
//! than [`OUTLIER`] sigma, and the block's mean by no more than [`MEAN_SHIFT`] of its own standard errors, with the noise sigma
//! from the median second difference, (2) of `white_noise`.
//! A stretch shorter than [`LEAST_S`] stays unchanged.
//! Numerics: a motion slower than a block's standard error over a whole stretch is held too; it is smaller than the noise.

use crate::flight::signal::white_noise::white_noise_std_between_gaps;

/// Length of a block, s.
pub(crate) const BLOCK_S: f64 = 0.1;
/// Shortest stretch, s.
pub(crate) const LEAST_S: f64 = 0.3;
/// Largest deviation of a sample, in standard deviations of the noise.
pub(crate) const OUTLIER: f64 = 4.5;
/// Largest deviation of a block's mean, in its standard errors.
pub(crate) const MEAN_SHIFT: f64 = 3.0;

/// Replaces stretches at rest by their mean; NaN samples stay.
pub(crate) fn hold_resting(times_s: &[f64], values: &mut [f64]) {
    let known: Vec<usize> = values.iter().enumerate().filter(|(_, value)| value.is_finite()).map(|(place, _)| place).collect();
    let sample = |k: usize| known.get(k).and_then(|&place| Some((*times_s.get(place)?, *values.get(place)?)));
    let series: Vec<(f64, f64)> = (0..known.len()).filter_map(sample).collect();
    let noise = white_noise_std_between_gaps(&series);
    if !(noise > 0.0) {
        return;
    }
    // The current stretch: its first sample, and the one after its last.
    let (mut from, mut at) = (0, 0);
    while at < series.len() {
        let begin_s = series.get(at).map_or(0.0, |sample| sample.0);
        let end = series.partition_point(|(time_s, _)| *time_s < begin_s + BLOCK_S).max(at + 1);
        let (block, before) = (series.get(at..end).unwrap_or_default(), series.get(from..at).unwrap_or_default());
        let mean = mean(if before.is_empty() { block } else { before });
        let spread =
            noise * libm::sqrt(1.0 / block.len() as f64 + if before.is_empty() { 0.0 } else { 1.0 / before.len() as f64 });
        let near = block.iter().all(|(_, x)| libm::fabs(x - mean) < OUTLIER * noise);
        if near && libm::fabs(self::mean(block) - mean) < MEAN_SHIFT * spread {
            at = end;
            continue;
        }
        replace_by_mean(values, &known, &series, from..at);
        // A block that is no stretch itself is motion; one that only differs from the stretch before may begin the next.
        from = if at > from { at } else { end };
        at = from;
    }
    replace_by_mean(values, &known, &series, from..at);
}

/// Replaces a stretch of at least [`LEAST_S`] by its mean.
fn replace_by_mean(values: &mut [f64], known: &[usize], series: &[(f64, f64)], stretch: core::ops::Range<usize>) {
    let Some(part) = series.get(stretch.clone()) else { return };
    let (Some(first), Some(last)) = (part.first(), part.last()) else { return };
    if last.0 - first.0 < LEAST_S {
        return;
    }
    let level = mean(part);
    for &place in known.get(stretch).unwrap_or_default() {
        if let Some(value) = values.get_mut(place) {
            *value = level;
        }
    }
}

fn mean(series: &[(f64, f64)]) -> f64 {
    series.iter().map(|(_, x)| x).sum::<f64>() / series.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::hold_resting;

    #[test]
    fn what_is_still_is_held_and_what_moves_is_left() {
        let mut seed = 5_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let times: Vec<f64> = (0..1280).map(|k| f64::from(k) / 128.0).collect();
        // Still, a ramp of 0.1 s, still, and from 6 s on a sine.
        let truth = |t: f64| match t {
            t if t < 2.0 => 0.0,
            t if t < 2.1 => 0.1 * (t - 2.0),
            t if t < 6.0 => 0.01,
            t => 0.01 + 0.01 * f64::sin(6.0 * (t - 6.0)),
        };
        let read: Vec<f64> = times.iter().map(|&t| truth(t) + 2e-4 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect();
        let mut held = read.clone();
        hold_resting(&times, &mut held);
        let rms = |values: &[f64], from: f64, to: f64| {
            let part: Vec<f64> =
                times.iter().zip(values).filter(|(t, _)| (from..to).contains(*t)).map(|(t, x)| x - truth(*t)).collect();
            (part.iter().map(|x| x * x).sum::<f64>() / part.len() as f64).sqrt()
        };
        assert!(rms(&held, 0.0, 1.8) < 4e-5 && rms(&held, 2.4, 5.8) < 4e-5, "{} {}", rms(&held, 0.0, 1.8), rms(&held, 2.4, 5.8));
        assert!(
            rms(&held, 1.8, 2.4) < 3e-4 && rms(&held, 6.0, 10.0) < 2.5e-4,
            "{} {}",
            rms(&held, 1.8, 2.4),
            rms(&held, 6.0, 10.0)
        );
        // Without noise nothing is touched.
        let mut exact = vec![0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, f64::NAN, 1.0];
        hold_resting(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8], &mut exact);
        assert!(exact[7].is_nan() && exact[1] < 1e-12 && exact[2] > 1.0 - 1e-12);
    }
}
