//! Smoothing and differentiation of piecewise linear signals by one symmetric kernel of compact support.
//!
//! Consumes sample times t_i (increasing) around a centre t and a half width T; produces weights w_i, w'_i with
//!     (k * x)(t) = sum_i w_i x_i        d/dt (k * x)(t) = sum_i w'_i x_i                          (1)
//! for x a straight line between samples and, with s = (t_i - t)/T,
//!     k(s) = 35/32 (1 - s^2)^3 / T,  |s| <= 1                                                      (2)
//! Both are exact integrals, so for y = dx/dt = a x + b z the smoothed signals obey the same equation: the kernel commutes with
//! differentiation, and smoothing adds no bias.
//! Integrals of (2) from 0 to s:
//!     K0 = 35/32 (s - s^3 + 3/5 s^5 - s^7/7)       K1 = integral of s k = 35/256 (1 - (1 - s^2)^4)  (3)
//! Kernel: the triweight of M. P. Wand and M. C. Jones, Kernel Smoothing, 1995, section 2.7 (family of (1 - s^2)^m).
//! Numerics: variance of the kernel is T^2/9, so T = 0.4 s passes 1 Hz at 0.70 and 2 Hz at 0.19 of its amplitude.
//! Returns false where the samples do not cover t - T .. t + T, or leave a gap under the kernel.

/// K0 of (3), odd in s; s within -1 .. 1.
fn integral(s: f64) -> f64 {
    let s2 = s * s;
    35.0 / 32.0 * s * (1.0 - s2 * (1.0 - s2 * (0.6 - s2 / 7.0)))
}

/// K1 of (3), even in s; s within -1 .. 1.
fn first_moment(s: f64) -> f64 {
    let c = 1.0 - s * s;
    let c2 = c * c;
    35.0 / 256.0 * (1.0 - c2 * c2)
}

/// Weights (1) of the samples at `times` for the kernel of half width `half_width` about `centre`.
///
/// `smooth` and `slope` must be as long as `times`. Returns `false`, with both undefined, where the samples do not cover
/// the kernel's support, two times are not increasing, or an interval inside it is longer than `longest_interval`.
#[must_use]
pub fn weights(
    times: &[f64],
    centre: f64,
    half_width: f64,
    longest_interval: f64,
    smooth: &mut [f64],
    slope: &mut [f64],
) -> bool {
    if times.len() != smooth.len() || times.len() != slope.len() {
        return false;
    }
    let (Some(&begin), Some(&end)) = (times.first(), times.last()) else { return false };
    if begin > centre - half_width || end < centre + half_width {
        return false;
    }
    smooth.fill(0.0);
    slope.fill(0.0);
    for i in 1..times.len() {
        let interval = times[i] - times[i - 1];
        let a = (times[i - 1] - centre) / half_width;
        let b = (times[i] - centre) / half_width;
        if b <= -1.0 || a >= 1.0 {
            continue;
        }
        if !(interval > 0.0) || interval > longest_interval {
            return false;
        }
        let (from, to) = (a.max(-1.0), b.min(1.0));
        let mass = integral(to) - integral(from);
        let moment = first_moment(to) - first_moment(from);
        let right = (moment - a * mass) / (b - a);
        smooth[i - 1] += mass - right;
        smooth[i] += right;
        let rate = mass / interval;
        slope[i - 1] -= rate;
        slope[i] += rate;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(times: &[f64], values: &[f64], centre: f64, half_width: f64) -> (f64, f64) {
        let (mut w, mut d) = (vec![0.0; times.len()], vec![0.0; times.len()]);
        assert!(weights(times, centre, half_width, 1.0, &mut w, &mut d));
        let dot = |weights: &[f64]| weights.iter().zip(values).map(|(w, x)| w * x).sum();
        (dot(&w), dot(&d))
    }

    #[test]
    fn a_straight_line_comes_back_with_its_slope_on_an_uneven_grid() {
        let times = [-0.71, -0.4, -0.37, -0.1, -0.099, 0.0, 0.23, 0.31, 0.52, 0.8];
        let values = times.map(|t| 3.0 - 2.0 * t);
        for centre in [0.0, 0.05, -0.2] {
            let (value, slope) = apply(&times, &values, centre, 0.5);
            assert!((value - (3.0 - 2.0 * centre)).abs() < 1e-14 && (slope + 2.0).abs() < 1e-13);
        }
    }

    /// The slow obvious version: the integral of the interpolated signal by a fine sum.
    #[test]
    fn agrees_with_a_fine_sum_over_the_interpolated_signal() {
        let times: Vec<f64> = (0..60).map(|i| 0.02 * f64::from(i) + 0.003 * libm::sin(f64::from(i))).collect();
        let values: Vec<f64> = times.iter().map(|t| libm::sin(7.0 * t) + 0.3 * libm::cos(31.0 * t)).collect();
        let (centre, half_width) = (0.55, 0.4);
        let (mut sum, mut sum_slope) = (0.0, 0.0);
        let n = 400_000;
        for k in 0..n {
            let s = -1.0 + 2.0 * (f64::from(k) + 0.5) / f64::from(n);
            let t = centre + half_width * s;
            let i = times.partition_point(|&x| x <= t);
            let x = values[i - 1] + (values[i] - values[i - 1]) * (t - times[i - 1]) / (times[i] - times[i - 1]);
            let c = 1.0 - s * s;
            sum += 35.0 / 32.0 * c * c * c * x * 2.0 / f64::from(n);
            sum_slope += 35.0 / 32.0 * 6.0 * s * c * c * x * 2.0 / f64::from(n) / half_width;
        }
        let (value, slope) = apply(&times, &values, centre, half_width);
        assert!((value - sum).abs() < 1e-9, "{value} {sum}");
        assert!((slope - sum_slope).abs() < 1e-8, "{slope} {sum_slope}");
    }

    #[test]
    fn says_no_where_the_samples_do_not_cover_the_kernel_or_leave_a_hole() {
        let (mut w, mut d) = ([0.0; 3], [0.0; 3]);
        assert!(!weights(&[0.0, 0.1, 0.2], 0.1, 0.2, 1.0, &mut w, &mut d));
        assert!(!weights(&[-1.0, 0.1, 0.9], 0.1, 0.5, 0.5, &mut w, &mut d));
        assert!(!weights(&[-1.0, 0.1, 0.1], 0.1, 0.0, 5.0, &mut w, &mut d));
        assert!(!weights(&[], 0.0, 0.1, 1.0, &mut [], &mut []));
    }
}
