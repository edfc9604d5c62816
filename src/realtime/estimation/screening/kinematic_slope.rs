//! Slope of measured increments on kinematic ones: the sign and scale of an instrument where moving air hides its agreement.
//!
//! Consumes the increments of one output over a window that ends with every bin, measured m and kinematic k; produces
//!     b = sum (k - k_mean)(m - m_mean)/sum (k - k_mean)^2                                                          (1)
//!     var b = sum_i sum_j w(i - j) g_i g_j/(sum (k - k_mean)^2)^2,   g = (k - k_mean)(m - m_mean - b (k - k_mean))   (2)
//! with Bartlett weights w, because windows overlap and air that moves is coloured. An instrument that reads right has b = 1,
//! a reversed one -1, one in another unit the ratio of the units; moving air adds to m and hardly correlates with k, which makes
//! var b larger. Old windows are forgotten.
//! Source: Newey and West 1987 for (2).

use super::bin_means::BIN_S;
use core::f64::consts::SQRT_2;

/// Lags of (2): twice the windows that overlap.
const LAGS: usize = 16;
/// Bins of one window.
const WINDOW_BINS: f64 = 8.0;
/// Windows before there is a slope: five seconds; two, where the increments are the kinematic ones all but exactly.
const COUNT_MIN: f32 = 50.0;
const EXACT_COUNT_MIN: f32 = 20.0;
/// Least squared correlation of such increments.
const EXACT: f64 = 0.95;

/// The slope of one output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// b of (1).
    pub value: f64,
    /// Its standard error, by (2).
    pub std: f64,
    /// Squared correlation of measured and kinematic increments.
    pub correlation_squared: f64,
}

/// Sums of (1) and (2).
#[derive(Clone, Copy, Debug)]
pub struct KinematicSlope {
    count: f32,
    k: f32,
    m: f32,
    /// Sums of (k - k_mean)^2, (k - k_mean)(m - m_mean) and (m - m_mean)^2, each about the means so far.
    kk: f32,
    km: f32,
    mm: f32,
    /// Sums of w km_i km_j, w (km_i kk_j + kk_i km_j) and w kk_i kk_j.
    scores: [f32; 3],
    /// The products kk and km of the last windows, newest first.
    past: [[f32; 2]; LAGS],
}

impl KinematicSlope {
    /// Without windows.
    pub const ZERO: KinematicSlope =
        KinematicSlope { count: 0.0, k: 0.0, m: 0.0, kk: 0.0, km: 0.0, mm: 0.0, scores: [0.0; 3], past: [[0.0; 2]; LAGS] };

    /// The window that ends with the next bin; `None` where an increment is missing. `memory_s` is the time constant of
    /// forgetting.
    pub fn window(&mut self, increments: Option<(f64, f64)>, memory_s: f64) {
        let Some((m, k)) = increments.map(|(measured, kinematic)| (measured as f32, kinematic as f32)) else {
            self.past.rotate_right(1);
            self.past[0] = [0.0; 2];
            return;
        };
        let kept = libm::exp(-BIN_S / memory_s) as f32;
        self.count = kept * self.count + 1.0;
        self.k = kept * self.k + k;
        self.m = kept * self.m + m;
        let (k, m) = (k - self.k / self.count, m - self.m / self.count);
        let (kk, km) = (k * k, k * m);
        self.kk = kept * self.kk + kk;
        self.km = kept * self.km + km;
        self.mm = kept * self.mm + m * m;
        // Twice the weighted sums of the past, and once the present.
        let (mut sum_kk, mut sum_km) = (0.5 * kk, 0.5 * km);
        for (lag, [past_kk, past_km]) in self.past.iter().enumerate() {
            let weight = 1.0 - (lag + 1) as f32 / (LAGS + 1) as f32;
            sum_kk += weight * past_kk;
            sum_km += weight * past_km;
        }
        let new = [2.0 * km * sum_km, 2.0 * (km * sum_kk + kk * sum_km), 2.0 * kk * sum_kk];
        self.scores.iter_mut().zip(new).for_each(|(sum, new)| *sum = kept * *sum + new);
        self.past.rotate_right(1);
        self.past[0] = [kk, km];
    }

    /// Whether there has been a window.
    pub fn has_begun(&self) -> bool {
        self.count > 0.0
    }

    /// The slope as soon as it may confirm an instrument: early in air that does not move.
    pub fn early_slope(&self) -> Option<Slope> {
        let early = || self.slope_after(EXACT_COUNT_MIN).filter(|slope| slope.correlation_squared > EXACT);
        self.slope().or_else(early)
    }

    /// (1) and (2); `None` with too few windows.
    pub fn slope(&self) -> Option<Slope> {
        self.slope_after(COUNT_MIN)
    }

    fn slope_after(&self, count_min: f32) -> Option<Slope> {
        if self.count < count_min || !(self.kk > 0.0) {
            return None;
        }
        let [kk, km, mm] = [self.kk, self.km, self.mm].map(f64::from);
        let [of_km, of_both, of_kk] = self.scores.map(f64::from);
        let value = km / kk;
        let score_var = (of_km - value * of_both + value * value * of_kk).max(0.0);
        let independent = f64::from(self.count) / WINDOW_BINS;
        let few = libm::sqrt(independent / (independent - SQRT_2));
        let correlation_squared = if mm > 0.0 { (km * km / (kk * mm)).min(1.0) } else { 0.0 };
        Some(Slope { value, std: few * libm::sqrt(score_var) / kk, correlation_squared })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    /// Slopes of 200 draws of 20 s: k a slow motion integrated over windows, m so many times it and noise of both ends.
    fn drawn(factor: f64, noise: f64) -> (f64, f64) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..200 {
            let mut draw = NormalNoise::new(seed, 3);
            let ends: Vec<f64> = (0..210).map(|_| noise * draw.draw()).collect();
            let phase = draw.draw();
            let mut slope = KinematicSlope::ZERO;
            for i in 8..210 {
                let k = 0.4 + libm::sin(0.11 * i as f64 + phase) + 0.5 * libm::sin(0.27 * i as f64);
                slope.window(Some((factor * k + ends[i] - ends[i - 8], k)), 1e6);
            }
            let found = slope.slope().unwrap();
            sum += (found.value - factor) / 200.0;
            squares += ((found.value - factor) / found.std).powi(2) / 200.0;
        }
        (sum, squares.sqrt())
    }

    #[test]
    fn the_slope_is_unbiased_and_its_standard_error_holds_the_scatter() {
        for (factor, noise) in [(1.0, 0.5), (-1.0, 0.5), (9.8, 2.0)] {
            let (bias, spread) = drawn(factor, noise);
            assert!(bias.abs() < 0.03 * noise && spread < 1.2, "{factor}: bias {bias:.3}, spread {spread:.2}");
        }
    }

    #[test]
    fn too_few_windows_have_no_slope() {
        let mut slope = KinematicSlope::ZERO;
        for i in 0..40 {
            slope.window(Some((libm::sin(0.2 * f64::from(i)), libm::sin(0.2 * f64::from(i)))), 30.0);
        }
        assert!(slope.slope().is_none() && KinematicSlope::ZERO.slope().is_none());
    }
}
