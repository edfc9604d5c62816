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
/// Windows before there is a slope: five seconds.
const COUNT_MIN: f32 = 50.0;
/// Standard errors from zero, and how large they may be, of a slope that confirms: a reversed instrument, at -1, is then three or
/// more away.
const CONFIRMS: f64 = 1.0;
const KNOWN: f64 = 0.5;
/// Least slope of an aircraft that follows the air: what its vanes measure then is against the force.
const FOLLOWS_AIR: f64 = -0.4;
/// Standard errors below it, and above 1, of a slope that contradicts.
const BELOW: f64 = 1.5;
const ABOVE: f64 = 2.5;
/// Limit of the deviation from 1 within which a slope is that of the right unit.
const AROUND_ONE: f64 = 0.4;
/// Slopes between which an instrument reads in its unit and with its sign; g for m/s^2, and feet, are beyond.
const SLOPE_LOW: f64 = 0.4;
const SLOPE_HIGH: f64 = 2.5;

/// The slope of one output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// b of (1).
    pub value: f64,
    /// Its standard error, by (2).
    pub std: f64,
}

/// What the kinematics tell about sign and unit of an accelerometer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Confirmation {
    /// They contradict, or tell too little where only they could.
    #[default]
    Doubted,
    /// They do not contradict.
    Plausible,
    /// They are right.
    Confirmed,
}

/// Sums of (1) and (2).
#[derive(Clone, Copy, Debug)]
pub struct KinematicSlope {
    count: f32,
    k: f32,
    m: f32,
    /// Sum of (k - k_mean)^2 and of (k - k_mean)(m - m_mean), each about the means so far.
    kk: f32,
    km: f32,
    /// Sums of w km_i km_j, w (km_i kk_j + kk_i km_j) and w kk_i kk_j.
    scores: [f32; 3],
    /// The products kk and km of the last windows, newest first.
    past: [[f32; 2]; LAGS],
}

impl KinematicSlope {
    /// Without windows.
    pub const ZERO: KinematicSlope =
        KinematicSlope { count: 0.0, k: 0.0, m: 0.0, kk: 0.0, km: 0.0, scores: [0.0; 3], past: [[0.0; 2]; LAGS] };

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

    /// Whether sign and unit are right: the slope is known to 0.5 and more than one standard error above zero, so that a
    /// reversed instrument, at -1, is three or more away.
    pub fn confirms(&self) -> bool {
        self.slope().is_some_and(|Slope { value, std }| {
            let (low, high) = (value - CONFIRMS * std, value + CONFIRMS * std);
            std < KNOWN && low > 0.0 && value < SLOPE_HIGH && high > SLOPE_LOW
        })
    }

    /// Whether the slope is beyond what an instrument that reads right has, in air that may move and that the aircraft follows.
    pub fn contradicts(&self) -> bool {
        self.slope().is_some_and(|Slope { value, std }| value < FOLLOWS_AIR - BELOW * std || value > 1.0 + ABOVE * std)
    }

    /// Whether the slope is known to be that of the right unit and of still air.
    pub fn is_one(&self) -> bool {
        self.slope().is_some_and(|Slope { value, std }| (value - 1.0).abs() + 2.0 * std < AROUND_ONE)
    }

    /// (1) and (2); `None` with too few windows.
    pub fn slope(&self) -> Option<Slope> {
        if self.count < COUNT_MIN || !(self.kk > 0.0) {
            return None;
        }
        let [kk, km] = [self.kk, self.km].map(f64::from);
        let [of_km, of_both, of_kk] = self.scores.map(f64::from);
        let value = km / kk;
        let score_var = (of_km - value * of_both + value * value * of_kk).max(0.0);
        let independent = f64::from(self.count) / WINDOW_BINS;
        let few = libm::sqrt(independent / (independent - SQRT_2));
        Some(Slope { value, std: few * libm::sqrt(score_var) / kk })
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

    fn after(factor: f64, windows: usize) -> KinematicSlope {
        let mut slope = KinematicSlope::ZERO;
        for i in 0..windows {
            let k = libm::sin(0.2 * i as f64);
            let air = 0.2 * libm::cos(0.13 * i as f64);
            slope.window(Some((factor * k + air, k)), 30.0);
        }
        slope
    }

    #[test]
    fn a_sign_and_a_unit_are_confirmed_where_they_are_right() {
        let right = after(1.0, 200);
        assert!(right.confirms() && !right.contradicts(), "{right:?}");
        // Reversed, in g, and what the kinematics say hardly appears in the readings: air that moves, or a wrong unit.
        for wrong in [-1.0, 9.8, 0.1] {
            let wrong = after(wrong, 200);
            assert!(!wrong.confirms(), "{wrong:?}");
        }
        for contradicting in [-1.0, 9.8] {
            assert!(after(contradicting, 200).contradicts());
        }
        // As of an aircraft that follows the air.
        assert!(!after(0.1, 200).contradicts() && !after(-0.4, 200).contradicts());
        assert!(!after(1.0, 40).confirms() && !after(-1.0, 40).contradicts(), "too few windows");
        assert!(KinematicSlope::ZERO.slope().is_none());
    }
}
