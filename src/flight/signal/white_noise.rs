//! White noise of a channel from differences of its samples, which a motion that is smooth from sample to sample hardly enters.
//!
//! Consumes samples x_i; produces the standard deviation sigma of their white noise, in the channel's unit, from
//!     x_i - 3 x_(i+1) + 3 x_(i+2) - x_(i+3)     of variance 20 sigma^2                                 (1)
//!     x_i - 2 x_(i+1) + x_(i+2)                 of variance 6 sigma^2                                  (2)
//! by their mean square, or robustly, where spikes or steps are among them: by the mean square of the smaller nine tenths (of
//! normal values 0.6230 of the whole), or by the median of their sizes (of normal values 0.6745 standard deviations).
//! Source: sums of squared binomial coefficients, 1 + 9 + 9 + 1 and 1 + 4 + 1; quantiles of the normal distribution.
//! Returns zero for too few samples.

/// Mean square of the smaller nine tenths of normal values, of the whole.
const TRIMMED: f64 = 0.6230;
/// Median size of normal values, of their standard deviation, and its inverse.
const MEDIAN: f64 = 0.6745;
const OF_MEDIAN: f64 = 1.482_602_218_505_602;
/// Two intervals longer than so many usual ones have a gap in them.
const GAP: f64 = 4.0;

/// (1) at every four samples.
fn third_differences(values: &[f64]) -> impl Iterator<Item = f64> + '_ {
    values.array_windows().map(|[a, b, c, d]| a - 3.0 * b + 3.0 * c - d)
}

/// By the mean square of (1).
pub fn white_noise_std(values: &[f64]) -> f64 {
    let squares: Vec<f64> = third_differences(values).map(|x| x * x).collect();
    if squares.is_empty() {
        return 0.0;
    }
    libm::sqrt(squares.iter().sum::<f64>() / (20.0 * squares.len() as f64))
}

/// By the mean square of the smaller nine tenths of (1).
pub fn white_noise_std_trimmed(values: &[f64]) -> f64 {
    let mut squares: Vec<f64> = third_differences(values).map(|x| x * x).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate((squares.len() * 9 / 10).max(1));
    let count = squares.len().max(1) as f64;
    libm::sqrt(squares.iter().sum::<f64>() / (count * 20.0 * TRIMMED))
}

/// By the median size of (1).
pub fn white_noise_std_by_median(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = third_differences(values).map(libm::fabs).collect();
    sizes.sort_by(f64::total_cmp);
    OF_MEDIAN * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / libm::sqrt(20.0)
}

/// By the median size of (2) of samples with their times, s; over a gap, where the signal may have gone anywhere, none is taken.
pub fn white_noise_std_between_gaps(samples: &[(f64, f64)]) -> f64 {
    let mut lengths: Vec<f64> = samples.array_windows().map(|[a, b]| b.0 - a.0).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
    let whole = samples.array_windows().filter(|[a, _, c]| c.0 - a.0 <= GAP * usual);
    let mut sizes: Vec<f64> = whole.map(|[a, b, c]| libm::fabs(a.1 - 2.0 * b.1 + c.1)).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.0, |middle| middle / (MEDIAN * libm::sqrt(6.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    #[test]
    fn every_variant_tells_noise_from_motion() {
        let mut noise = NormalNoise::new(1, 1);
        let samples: Vec<(f64, f64)> = (0..4000)
            .map(|i| {
                let t = f64::from(i) * 0.01;
                (t, 0.03 * libm::sin(2.0 * t) + 0.002 * noise.draw())
            })
            .collect();
        let values: Vec<f64> = samples.iter().map(|(_, value)| *value).collect();
        let of_all =
            |values: &[f64]| [white_noise_std(values), white_noise_std_trimmed(values), white_noise_std_by_median(values)];
        for found in of_all(&values).into_iter().chain([white_noise_std_between_gaps(&samples)]) {
            assert!((found / 0.002 - 1.0).abs() < 0.1, "{found}");
        }
        // A step of 0.2 is in three of the differences: once, twice and once its size.
        let stepped: Vec<f64> = values.iter().enumerate().map(|(i, value)| value + if i < 2000 { 0.0 } else { 0.2 }).collect();
        let [mean, trimmed, median] = of_all(&stepped);
        let by_hand = libm::sqrt(0.002 * 0.002 + 6.0 * 0.2 * 0.2 / (20.0 * 3997.0));
        assert!((mean / by_hand - 1.0).abs() < 0.1, "{mean} {by_hand}");
        assert!((trimmed / 0.002 - 1.0).abs() < 0.1 && (median / 0.002 - 1.0).abs() < 0.1, "{trimmed} {median}");
        assert!(of_all(&[1.0, 2.0, 3.0]).into_iter().chain([white_noise_std_between_gaps(&[])]).all(|none| none < 1e-300));
    }
}
