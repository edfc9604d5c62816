//! Vibration removed from measured outputs: spectral lines of the residuals above the bandwidth of the aircraft's motion.
//!
//! Consumes an output as measured and as a first fit predicts it; removes from the measured one, at each frequency w above
//! [`LEAST_OMEGA`] whose power exceeds [`LINE`] times the median power of its neighbours (gusts leave a sloped spectrum),
//!     a_j cos(w t) + b_j sin(w t)     a_j, b_j by least squares over the residual, a window of [`WINDOW_S`] each        (1)
//! Blade-passing vibration of gyros and accelerometers is some ten times their noise. Left in, it counts as white noise, so that
//! gyros lose weight against vanes, and the residuals' autocovariance does not decay, so that there are no corrected standard
//! errors. Half a hertz about the line is removed with it, where the aircraft's motion has no power.
//! Source: ours. Numerics: power by the fast Fourier transform over times rounded to the median interval; the frequency is then
//! refined at the sampling times themselves. A series shorter than `LEAST_SAMPLES` stays unchanged.

use super::identification_model::IdentificationModel;
use crate::num::fft::{ComplexSeries, FourierTransform};
use crate::postflight::output_error::InputOutputRecord;
use core::f64::consts::TAU;

/// Least frequency of a vibration, rad/s.
pub const LEAST_OMEGA: f64 = 25.0;
/// Power of a line over the median power of its neighbours.
pub const LINE: f64 = 40.0;
/// Half width of those neighbours, rad/s.
pub const ABOUT_OMEGA: f64 = 10.0;
/// Window of constant amplitude and phase, s.
pub const WINDOW_S: f64 = 3.0;
const MOST: usize = 8;
/// Least number of samples in which a line is detected.
const LEAST_SAMPLES: usize = 256;
const REFINEMENTS: usize = 24;

/// A line that was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibrationLine {
    /// Its frequency, rad/s.
    pub omega: f64,
    /// Its rms, the output's unit.
    pub rms: f64,
}

/// Subtracts (1) from the measured series; NaN stays.
pub fn remove_lines(times_s: &[f64], measured: &mut [f64], predicted: &[f64]) -> Vec<VibrationLine> {
    let places: Vec<usize> =
        measured.iter().zip(predicted).enumerate().filter(|(_, (z, y))| (*z - *y).is_finite()).map(|(k, _)| k).collect();
    let time = |k: usize| times_s.get(k).copied().unwrap_or(f64::NAN);
    let left = |k: usize| measured.get(k).copied().unwrap_or(f64::NAN) - predicted.get(k).copied().unwrap_or(f64::NAN);
    let mut series: Vec<(f64, f64)> = places.iter().map(|&k| (time(k), left(k))).collect();
    if series.len() < LEAST_SAMPLES {
        return Vec::new();
    }
    let before = series.clone();
    let mut lines = Vec::new();
    while lines.len() < MOST {
        let Some(omega) = strongest(&series) else { break };
        let rms = subtract(&mut series, omega);
        lines.push(VibrationLine { omega, rms });
    }
    for (&place, (old, new)) in places.iter().zip(before.iter().zip(&series)) {
        if let Some(value) = measured.get_mut(place) {
            *value += new.1 - old.1;
        }
    }
    lines
}

/// Removes vibration from all outputs of a run, with a note; whether there was any.
pub fn remove_vibration(linear: &mut IdentificationModel, record: &mut InputOutputRecord, predicted: &[Vec<f64>]) -> bool {
    let before = linear.notes.len();
    for ((name, z), y) in linear.structure.outputs.iter().zip(&mut record.outputs).zip(predicted) {
        for VibrationLine { omega, rms } in remove_lines(&record.times_s, z, y) {
            linear
                .notes
                .push(format!("vibration taken out of `{name}`: {omega:.1} rad/s, rms {rms:.2e}, half a hertz about it with it"));
        }
    }
    linear.notes.len() > before
}

/// Tapered periodogram of a series at its median interval, and its frequency step, rad/s.
fn power(series: &[(f64, f64)]) -> Option<(Vec<f64>, f64)> {
    let (first_s, last_s) = (series.first()?.0, series.last()?.0);
    let span_s = last_s - first_s;
    let mut lengths: Vec<f64> = series.iter().zip(series.iter().skip(1)).map(|(a, b)| b.0 - a.0).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = *lengths.get(lengths.len() / 2)?;
    let transform = FourierTransform::at_least(libm::round(span_s / usual) as usize + 1);
    let mut x = ComplexSeries::zeros(transform.length());
    let mean = mean(series);
    for (t, e) in series {
        if let Some(slot) = x.re.get_mut(libm::round((t - first_s) / usual) as usize) {
            *slot += taper(t - first_s, span_s) * (e - mean);
        }
    }
    transform.forward(&mut x);
    let power = x.re.iter().zip(&x.im).map(|(re, im)| re * re + im * im).take(transform.length() / 2);
    Some((power.collect(), TAU / (transform.length() as f64 * usual)))
}

fn taper(time_s: f64, span_s: f64) -> f64 {
    1.0 - libm::cos(TAU * time_s / span_s)
}

fn mean(series: &[(f64, f64)]) -> f64 {
    series.iter().map(|(_, e)| e).sum::<f64>() / series.len().max(1) as f64
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Frequency of the strongest line, rad/s.
fn strongest(series: &[(f64, f64)]) -> Option<f64> {
    let (first_s, span_s) = (series.first()?.0, series.last()?.0 - series.first()?.0);
    let (power, step) = power(series)?;
    let from = libm::ceil(LEAST_OMEGA / step) as usize;
    let above = power.get(from..)?;
    let wide = libm::ceil(ABOUT_OMEGA / step) as usize;
    let stands_out = |&(place, power): &(usize, &f64)| {
        let about = above.get(place.saturating_sub(wide)..above.len().min(place + wide + 1)).unwrap_or_default();
        *power > LINE * median(about)
    };
    // Only bins that exceed the global median by as much need a median of their neighbours.
    let least = 0.1 * LINE * median(above);
    let strong = above.iter().enumerate().filter(|(_, power)| **power > least).filter(stands_out);
    let (peak, _) = strong.max_by(|a, b| a.1.total_cmp(b.1))?;
    let (peak, mean) = (from + peak, mean(series));
    // Ternary search for the maximum.
    let size = |omega: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (t, e) in series {
            let (sin, cos) = libm::sincos(omega * (t - first_s));
            re += taper(t - first_s, span_s) * (e - mean) * cos;
            im += taper(t - first_s, span_s) * (e - mean) * sin;
        }
        re * re + im * im
    };
    let (mut low, mut high) = (step * (peak as f64 - 1.0), step * (peak as f64 + 1.0));
    for _ in 0..REFINEMENTS {
        let third = (high - low) / 3.0;
        if size(low + third) < size(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    Some(0.5 * (low + high))
}

/// Subtracts (1); its rms.
fn subtract(series: &mut [(f64, f64)], omega: f64) -> f64 {
    let (Some(first), Some(last)) = (series.first(), series.last()) else { return 0.0 };
    let (first_s, span_s) = (first.0, last.0 - first.0);
    let windows = libm::round(span_s / WINDOW_S).max(1.0);
    let window = |t: f64| libm::floor((t - first_s) / span_s * windows).min(windows - 1.0);
    let (mut from, mut squares, count) = (0, 0.0, series.len());
    while from < count {
        let own = series.get(from).map_or(0.0, |sample| window(sample.0));
        let to = from + series.iter().skip(from).take_while(|(t, _)| window(*t) <= own).count();
        let part = series.get_mut(from..to).unwrap_or_default();
        let mean = mean(part);
        let (mut cc, mut ss, mut cs, mut ce, mut se) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, e) in part.iter() {
            let (sin, cos) = libm::sincos(omega * (t - first_s));
            cc += cos * cos;
            ss += sin * sin;
            cs += cos * sin;
            ce += cos * (e - mean);
            se += sin * (e - mean);
        }
        let det = cc * ss - cs * cs;
        if det > 1e-3 * cc * ss {
            let (a, b) = ((ss * ce - cs * se) / det, (cc * se - cs * ce) / det);
            for (t, e) in part.iter_mut() {
                let (sin, cos) = libm::sincos(omega * (*t - first_s));
                let line = a * cos + b * sin;
                *e -= line;
                squares += line * line;
            }
        }
        from = to.max(from + 1);
    }
    libm::sqrt(squares / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lines_go_and_motion_and_noise_stay() {
        let mut seed = 9_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let times: Vec<f64> = (0..2304).map(|k| f64::from(k) / 128.0).collect();
        let motion: Vec<f64> = times.iter().map(|t| 0.1 * f64::sin(1.2 * t)).collect();
        let noise: Vec<f64> = times.iter().map(|_| 1e-3 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect();
        let clean: Vec<f64> = motion.iter().zip(&noise).map(|(x, e)| x + e).collect();
        let shaken = |(t, x): (&f64, &f64)| x + 0.01 * f64::cos(107.3 * t + 1.0) + 0.003 * f64::cos(214.6 * t);
        let mut measured: Vec<f64> = times.iter().zip(&clean).map(shaken).collect();
        measured[700..740].fill(f64::NAN);
        let lines = remove_lines(&times, &mut measured, &motion);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!((lines[0].omega - 107.3).abs() < 0.02 && (lines[1].omega - 214.6).abs() < 0.05, "{lines:?}");
        let off = |k: usize| measured[k] - clean[k];
        let rms = ((0..2304).filter(|&k| off(k).is_finite()).map(|k| off(k) * off(k)).sum::<f64>() / 2264.0).sqrt();
        assert!(rms < 2e-4 && measured[720].is_nan(), "{rms}");
        // Without lines nothing is touched.
        let mut same = clean.clone();
        assert!(remove_lines(&times, &mut same, &motion).is_empty() && same == clean);
        // What gusts leave falls with the square of the frequency and is no line, strong as it is at 25 rad/s.
        let mut gust = 0.0;
        let mut gusty: Vec<f64> = noise
            .iter()
            .zip(&clean)
            .map(|(e, x)| {
                gust = 0.98 * gust + 10.0 * e;
                x + gust
            })
            .collect();
        let lines = remove_lines(&times, &mut gusty, &motion);
        assert!(lines.is_empty(), "{lines:?}");
    }
}
