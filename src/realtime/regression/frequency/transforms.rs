//! Finite Fourier transforms of the regression's signals, updated recursively.
//!
//! Consumes z_k \[17\] of `candidate` on its grid; keeps, for each frequency w of the band,
//!     X(w) = int x(t) g(t) dt,   g(t) = exp(-(sigma - j w)(T - t))                                     (1)
//! over the time so far, T its end: the transform over the record, but for the factor exp(j w T) that all signals share, with
//! old instants forgotten at sigma = 1/time constant. Between instants signals are straight lines, so one instant brings
//!     X <- rho X + a x_(k-1) + b x_k,   rho = exp(-D),   D = (sigma - j w) dt                          (2)
//!     b = dt (1 - f)/D,   a = dt f - b,   f = (1 - exp(-D))/D
//! exactly. The response of a moment equation is a derivative, which needs no differentiation: by parts
//!     int x' g dt = E + (j w - sigma) X,   E = sum over pieces of (x g at the end - x g at the start)   (3)
//! E, which most published real-time forms omit, is as large as the rest in a record of a cycle or two. A gap ends a piece and
//! begins another, and its length does not count. The end values are smoothed by the same kernel as every signal.
//! The error of an equation, white with intensity S, has a transform V with
//!     E\[V_i V_j^*\] = S K(w_i - w_j),   E\[V_i V_j\] = S K(w_i + w_j),   K(W) = int exp(-(2 sigma - j W)(T - t)) dt   (4)
//! which is updated like the signals.
//! Source: E. A. Morelli, AIAA 99-4043, 1999 (recursive Fourier transform regression); the ends as there in batch form.
//! Numerics: |rho| <= 1, so rounding does not grow; series where D is small.

use super::band::{Band, FREQUENCIES};
use crate::flight::derivative::{AXES, Axis};
use crate::realtime::regression::candidate::{REGRESSORS, SIGNALS};
use nalgebra::Complex;

/// Signals that are transformed: regressors and specific forces.
pub const TRANSFORMED: usize = REGRESSORS + 3;
/// Place of p in z.
const ROLL_RATE: usize = 4;
const SUMS: usize = 2 * FREQUENCIES - 1;
const ZERO: Complex<f64> = Complex::new(0.0, 0.0);
/// |D| below which the series serve.
const SMALL: f64 = 0.1;
const TERMS: u32 = 10;

/// A number at each frequency.
pub type Spectrum = [Complex<f64>; FREQUENCIES];

const _: () = assert!(SIGNALS == REGRESSORS + AXES);

/// What (2) and (4) take for one interval of the grid.
#[derive(Clone, Copy, Debug)]
struct Weights {
    turn: Complex<f64>,
    older: Complex<f64>,
    newer: Complex<f64>,
}

impl Weights {
    const NONE: Weights = Weights { turn: ZERO, older: ZERO, newer: ZERO };

    fn new(decay: f64, rad_s: f64, interval_s: f64) -> Self {
        let d = Complex::new(decay, -rad_s) * interval_s;
        let (sin, cos) = libm::sincos(-d.im);
        let turn = Complex::new(cos, sin) * libm::exp(-d.re);
        let (whole, part) = if d.norm_sqr() < SMALL * SMALL {
            series(d)
        } else {
            let whole = (Complex::new(1.0, 0.0) - turn) / d;
            (whole, (Complex::new(1.0, 0.0) - whole) / d)
        };
        let newer = part * interval_s;
        Weights { turn, older: whole * interval_s - newer, newer }
    }

    /// Transform of a constant 1 over the interval.
    fn of_one(&self) -> Complex<f64> {
        self.older + self.newer
    }
}

/// f of (2) and (1 - f)/D, from their series.
fn series(d: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let (mut term, mut whole, mut part) = (Complex::new(1.0, 0.0), ZERO, ZERO);
    for k in 0..TERMS {
        let k = f64::from(k);
        whole += term / (k + 1.0);
        part += term / ((k + 1.0) * (k + 2.0));
        term *= -d / (k + 1.0);
    }
    (whole, part)
}

/// The transforms so far.
#[derive(Clone, Debug)]
pub struct Transforms {
    band: Band,
    /// sigma, 1/s.
    decay: f64,
    /// What the weights are for, s.
    interval_s: f64,
    weights: [Weights; FREQUENCIES],
    signals: [Spectrum; TRANSFORMED],
    /// E of (3) for p q r, without the end of a piece that still goes on.
    ends: [Spectrum; 3],
    differences: Spectrum,
    sums: [Complex<f64>; SUMS],
    /// Turn of K and its transform of 1, for differences and for sums.
    kept_differences: [[Complex<f64>; 2]; FREQUENCIES],
    kept_sums: [[Complex<f64>; 2]; SUMS],
    /// The instant before, where the piece goes on.
    last: Option<[f64; TRANSFORMED]>,
}

impl Transforms {
    /// Nothing transformed yet; forgets with that time constant, s.
    pub const fn new(band: Band, forgetting_s: f64) -> Self {
        Transforms {
            band,
            decay: 1.0 / forgetting_s,
            interval_s: 0.0,
            weights: [Weights::NONE; FREQUENCIES],
            signals: [[ZERO; FREQUENCIES]; TRANSFORMED],
            ends: [[ZERO; FREQUENCIES]; 3],
            differences: [ZERO; FREQUENCIES],
            sums: [ZERO; SUMS],
            kept_differences: [[ZERO; 2]; FREQUENCIES],
            kept_sums: [[ZERO; 2]; SUMS],
            last: None,
        }
    }

    /// The band.
    pub fn band(&self) -> &Band {
        &self.band
    }

    /// One instant, so long after the one before where that was not a hole.
    pub fn add(&mut self, z: &[f64; SIGNALS], interval_s: f64) {
        let now: [f64; TRANSFORMED] = core::array::from_fn(|i| z[i]);
        let count = self.band.count();
        let Some(before) = self.last.replace(now) else {
            for (i, ends) in self.ends.iter_mut().enumerate() {
                ends[..count].iter_mut().for_each(|end| *end -= now[ROLL_RATE + i]);
            }
            return;
        };
        if interval_s.to_bits() != self.interval_s.to_bits() {
            self.tune(interval_s);
        }
        for ((signal, x0), x1) in self.signals.iter_mut().zip(before).zip(now) {
            for (x, weights) in signal[..count].iter_mut().zip(&self.weights) {
                *x = weights.turn * *x + weights.older * x0 + weights.newer * x1;
            }
        }
        for ends in &mut self.ends {
            ends[..count].iter_mut().zip(&self.weights).for_each(|(end, weights)| *end *= weights.turn);
        }
        for (kept, [turn, one]) in self.differences[..count].iter_mut().zip(&self.kept_differences) {
            *kept = turn * *kept + one;
        }
        for (kept, [turn, one]) in self.sums[..2 * count - 1].iter_mut().zip(&self.kept_sums) {
            *kept = turn * *kept + one;
        }
    }

    /// An instant is left out: the piece ends at the one before.
    pub fn hole(&mut self) {
        let count = self.band.count();
        if let Some(last) = self.last.take() {
            for (i, ends) in self.ends.iter_mut().enumerate() {
                ends[..count].iter_mut().for_each(|end| *end += last[ROLL_RATE + i]);
            }
        }
    }

    fn tune(&mut self, interval_s: f64) {
        self.interval_s = interval_s;
        let (decay, rad_s) = (self.decay, |place| self.band.rad_s(place));
        let step = rad_s(1) - rad_s(0);
        let kept = |frequency: f64| {
            let weights = Weights::new(2.0 * decay, frequency, interval_s);
            [weights.turn, weights.of_one()]
        };
        self.weights = core::array::from_fn(|i| Weights::new(decay, rad_s(i), interval_s));
        self.kept_differences = core::array::from_fn(|i| kept(i as f64 * step));
        self.kept_sums = core::array::from_fn(|i| kept(2.0 * rad_s(0) + i as f64 * step));
    }

    /// Transform of a regressor, by its place in z.
    pub fn regressor(&self, place: usize) -> &Spectrum {
        &self.signals[place]
    }

    /// Transform of an axis' response: the specific force, or the angular acceleration by (3).
    pub fn response(&self, axis: Axis) -> Spectrum {
        if axis.is_force() {
            return self.signals[REGRESSORS + axis.index()];
        }
        let rate = axis.index() - 3;
        let end = self.last.map_or(0.0, |last| last[ROLL_RATE + rate]);
        let x = &self.signals[ROLL_RATE + rate];
        core::array::from_fn(|i| self.ends[rate][i] + end + Complex::new(-self.decay, self.band.rad_s(i)) * x[i])
    }

    /// K(w_i - w_j) of (4).
    pub fn kept_difference(&self, i: usize, j: usize) -> Complex<f64> {
        if i >= j { self.differences[i - j] } else { self.differences[j - i].conj() }
    }

    /// K(w_i + w_j) of (4).
    pub fn kept_sum(&self, i: usize, j: usize) -> Complex<f64> {
        self.sums[i + j]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The integral of a function by Simpson's rule on a fine mesh.
    fn simpson(from: f64, to: f64, f: impl Fn(f64) -> Complex<f64>) -> Complex<f64> {
        let n = 2000;
        let h = (to - from) / n as f64;
        let weight = |k: usize| {
            if k == 0 || k == n {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=n).fold(ZERO, |sum, k| sum + f(from + k as f64 * h) * weight(k)) * (h / 3.0)
    }

    fn kernel(decay: f64, rad_s: f64, ago_s: f64) -> Complex<f64> {
        let (sin, cos) = libm::sincos(rad_s * ago_s);
        Complex::new(cos, sin) * libm::exp(-decay * ago_s)
    }

    #[test]
    fn transforms_are_the_integrals_of_straight_lines_whatever_is_left_out() {
        let (interval_s, decay) = (0.08, 1.0 / 15.0);
        let z = |k: usize| -> [f64; SIGNALS] {
            core::array::from_fn(|i| libm::sin(0.11 * (k * (i + 1)) as f64 + i as f64) + 0.2 * i as f64)
        };
        let mut transforms = Transforms::new(Band::DEFAULT, 15.0);
        let pieces: [core::ops::RangeInclusive<usize>; 3] = [0..=40, 55..=55, 60..=110];
        for k in 0..=110 {
            if pieces.iter().any(|piece| piece.contains(&k)) { transforms.add(&z(k), interval_s) } else { transforms.hole() }
        }
        // Time counts in pieces only: how long ago each instant is.
        let ago_s = |k: usize| {
            let later: usize = pieces.iter().map(|piece| (*piece.start()..*piece.end()).filter(|&n| n >= k).count()).sum();
            interval_s * later as f64
        };
        for place in [0, 7, 35] {
            let rad_s = Band::DEFAULT.rad_s(place);
            let mut sums: Vec<Complex<f64>> = (0..TRANSFORMED + 3).map(|_| ZERO).collect();
            let (mut difference, mut sum) = (ZERO, ZERO);
            for k in pieces.iter().flat_map(|piece| *piece.start()..*piece.end()) {
                let (now, next, end_s) = (z(k), z(k + 1), ago_s(k + 1));
                for (i, total) in sums.iter_mut().enumerate() {
                    *total += simpson(0.0, interval_s, |t| {
                        let g = kernel(decay, rad_s, end_s + interval_s - t);
                        match i.checked_sub(TRANSFORMED) {
                            None => g * (now[i] + (next[i] - now[i]) * t / interval_s),
                            // The derivative of the straight line.
                            Some(rate) => g * ((next[4 + rate] - now[4 + rate]) / interval_s),
                        }
                    });
                }
                let kept = |frequency: f64| simpson(end_s, end_s + interval_s, |ago| kernel(2.0 * decay, frequency, ago));
                difference += kept(rad_s - Band::DEFAULT.rad_s(2));
                sum += kept(rad_s + Band::DEFAULT.rad_s(2));
            }
            for (i, expected) in sums.iter().enumerate() {
                let found = match i.checked_sub(TRANSFORMED) {
                    None => transforms.signals[i][place],
                    Some(rate) => transforms.response(Axis::ALL[3 + rate])[place],
                };
                assert!((found - expected).norm() < 1e-10, "signal {i} at {place}: {found} for {expected}");
            }
            assert!((transforms.kept_difference(place, 2) - difference).norm() < 1e-10);
            assert!((transforms.kept_sum(place, 2) - sum).norm() < 1e-10);
        }
    }

    #[test]
    fn small_arguments_lose_nothing() {
        for interval_s in [1e-3, 0.0101, 0.0099] {
            let found = Weights::new(0.1, 10.0, interval_s);
            let line = |newer: bool| {
                simpson(0.0, interval_s, |t| {
                    let x = if newer { t / interval_s } else { 1.0 - t / interval_s };
                    kernel(0.1, 10.0, interval_s - t) * x
                })
            };
            assert!((found.newer - line(true)).norm() < 1e-13 * interval_s.max(1e-3), "{interval_s}");
            assert!((found.older - line(false)).norm() < 1e-13 * interval_s.max(1e-3), "{interval_s}");
        }
    }
}
