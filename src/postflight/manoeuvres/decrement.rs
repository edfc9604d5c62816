//! Logarithmic decrement of one channel: damping and frequency from sizes and times of successive peaks.
//!
//! Consumes bins of a channel with its drift subtracted; produces omega and zeta with the standard errors of the line
//!     ln |peak_k| = ln |peak_0| - s t_k,    t_k = t_0 + k pi / w                                       (1)
//! through the peaks above four times the noise, each interpolated by a parabola through three bins.
//! Returns `None` for fewer than four peaks (a cycle and a half).

use super::record::Measured;
use core::f64::consts::PI;

/// Omega, rad/s, and zeta by (1).
pub(crate) fn decrement(bins: &[(f64, f64)], noise: f64) -> Option<(Measured, Measured)> {
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for three in bins.windows(3) {
        let [(t0, x0), (t1, x1), (t2, x2)] = *three else { continue };
        let side = libm::copysign(1.0, x1);
        let highest = x1 * side >= x0 * side && x1 * side > x2 * side;
        if !highest || x1.abs() < 4.0 * noise {
            continue;
        }
        let h = 0.5 * (t2 - t0);
        let bend = x0 - 2.0 * x1 + x2;
        let shift = if bend == 0.0 { 0.0 } else { 0.5 * (x0 - x2) / bend };
        let peak = (t1 + shift * h, x1 - 0.25 * (x0 - x2) * shift);
        match peaks.last_mut() {
            // Several maxima of one half cycle: the largest counts.
            Some(last) if last.1 * peak.1 > 0.0 => {
                if peak.1.abs() > last.1.abs() {
                    *last = peak;
                }
            }
            _ => peaks.push(peak),
        }
    }
    if peaks.len() < 4 {
        return None;
    }
    let times = peaks.iter().zip(0..).map(|((t, _), k)| (f64::from(k), *t));
    let (half_period, half_period_std) = slope(times.collect())?;
    let sizes = peaks.iter().map(|(t, x)| (*t, libm::log(x.abs())));
    let (growth, growth_std) = slope(sizes.collect())?;
    let (s, w) = (-growth, PI / half_period);
    let omega = libm::sqrt(s * s + w * w);
    let w_std = w * half_period_std / half_period;
    let hypot = |a: f64, b: f64| libm::sqrt(a * a + b * b);
    let cube = omega * omega * omega;
    Some((
        Measured { value: omega, std: hypot(s / omega * growth_std, w / omega * w_std) },
        Measured { value: s / omega, std: hypot(w * w / cube * growth_std, s * w / cube * w_std) },
    ))
}

/// Slope of a line and its standard error.
fn slope(points: Vec<(f64, f64)>) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (sxx, sxy) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (x - mx), b + (x - mx) * (y - my)));
    if !(sxx > 0.0) || n < 3.0 {
        return None;
    }
    let slope = sxy / sxx;
    let left: f64 = points.iter().map(|(x, y)| (y - my - slope * (x - mx)) * (y - my - slope * (x - mx))).sum();
    Some((slope, libm::sqrt(left / (n - 2.0) / sxx)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_of_a_damped_sine_give_it_back() {
        let (omega, zeta) = (1.77, 0.083);
        let damped = omega * (1.0f64 - zeta * zeta).sqrt();
        let bins: Vec<(f64, f64)> =
            (0..400).map(|i| f64::from(i) * 0.04).map(|t| (t, 0.1 * (-zeta * omega * t).exp() * (damped * t).cos())).collect();
        let (o, z) = decrement(&bins, 1e-4).unwrap();
        assert!((o.value - omega).abs() < 2e-3 && (z.value - zeta).abs() < 2e-3, "{o:?} {z:?}");
        assert!(decrement(&bins[..60], 1e-4).is_none());
    }
}
