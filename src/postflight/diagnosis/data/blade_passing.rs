//! Removal of vibration at the blade-passing frequency, which follows the rotor's speed.
//!
//! Consumes a channel z(t), the rotor's speed Omega(t), rad/s, and the number of blades b; subtracts, with phi = b int Omega dt,
//!     a(t) cos(phi) + b(t) sin(phi)                                                                  (1)
//! a and b by least squares in windows of [`WINDOW_S`], weighted by 1 + cos, beside a parabola for the motion; straight lines
//! between the windows' centres. This removes a band of about 1 Hz about the line, which contains no motion.
//! Where the run does not give the number of blades, it is the order whose line exceeds those beside it.

use crate::flight::signal::series::Series;
use nalgebra::{SMatrix, SVector};

/// Length of a window, s.
const WINDOW_S: f64 = 1.0;
/// From one window to the next, s.
const HOP_S: f64 = 0.25;
const TERMS: usize = 5;
/// Numbers of blades that are tested.
const BLADES: core::ops::RangeInclusive<u32> = 2..=8;
/// How far beside an order of the rotor the background of its line is.
const BESIDE: f64 = 0.4;
/// Power of a line over that beside it, both means of twenty windows or so: noise makes five of it once in 10^6.
const STANDS_OUT: f64 = 5.0;

/// How many blades' passing stands out from what is beside it; of several numbers the clearest.
pub(crate) fn blades_of(series: &Series, rotor: &Series) -> Option<u32> {
    let (first_s, last_s) = series.range_s()?;
    let samples = turned(series, rotor);
    let windows = libm::floor((last_s - first_s) / WINDOW_S);
    // Those that hold samples: a gap costs nothing, however long it is.
    let mut held: Vec<f64> = samples.iter().map(|(time_s, ..)| libm::floor((time_s - first_s) / WINDOW_S)).collect();
    held.dedup();
    held.retain(|window| *window < windows);
    let power = |order: f64| {
        let lines = held.iter().map(|window| line_at(&samples, order, first_s + WINDOW_S * (window + 0.5)));
        is_below_nyquist(series, rotor, order).then(|| lines.map(|[a, b]| a * a + b * b).sum::<f64>())
    };
    let contrast = |blades: u32| {
        let order = f64::from(blades);
        Some(power(order)? / f64::max(power(order - BESIDE)?, power(order + BESIDE)?))
    };
    let seen = BLADES.filter_map(|blades| Some((blades, contrast(blades).filter(|contrast| *contrast > STANDS_OUT)?)));
    seen.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(blades, _)| blades)
}

/// The channel without (1).
pub(crate) fn removed(series: &Series, rotor: &Series, blades: f64) -> Series {
    let Some((first_s, _)) = series.range_s().filter(|_| is_below_nyquist(series, rotor, blades)) else {
        return series.clone();
    };
    let samples = turned(series, rotor);
    let line = |hop: f64| line_at(&samples, blades, first_s + HOP_S * hop);
    // The lines about the newest sample: before and after it.
    let (mut hop, mut lines) = (f64::NEG_INFINITY, [[0.0; 2]; 2]);
    Series::of(samples.iter().map(|&(time_s, value, angle)| {
        let place = (time_s - first_s) / HOP_S;
        let before = libm::floor(place);
        if before > hop {
            let shared = if before - hop <= 1.0 { lines[1] } else { line(before) };
            (hop, lines) = (before, [shared, line(before + 1.0)]);
        }
        let part = place - before;
        let [[a0, b0], [a1, b1]] = lines;
        let (sin, cos) = libm::sincos(blades * angle);
        (time_s, value - (a0 + part * (a1 - a0)) * cos - (b0 + part * (b1 - b0)) * sin)
    }))
}

/// Whether a line is well below the Nyquist frequency: one above it is aliased, and is not tested.
fn is_below_nyquist(series: &Series, rotor: &Series, order: f64) -> bool {
    series.interval_s().is_some_and(|interval_s| order * rotor.average() * interval_s < 0.95 * core::f64::consts::PI)
}

/// Time and value of each sample, and how far the rotor has turned by then.
fn turned(series: &Series, rotor: &Series) -> Vec<(f64, f64, f64)> {
    let (first_s, _) = series.range_s().unwrap_or_default();
    let angle = |time_s: f64| rotor.mean(first_s, time_s) * (time_s - first_s);
    series.samples().map(|(time_s, value)| (time_s, value, angle(time_s))).collect()
}

/// a and b of that order about one time; nothing where the window is empty.
fn line_at(samples: &[(f64, f64, f64)], order: f64, centre_s: f64) -> [f64; 2] {
    let from = samples.partition_point(|sample| sample.0 < centre_s - 0.5 * WINDOW_S);
    let to = samples.partition_point(|sample| sample.0 <= centre_s + 0.5 * WINDOW_S);
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut side = SVector::<f64, TERMS>::zeros();
    for &(time_s, value, angle) in samples.get(from..to).unwrap_or(&[]) {
        let s = 2.0 * (time_s - centre_s) / WINDOW_S;
        let weight = 1.0 + libm::cos(core::f64::consts::PI * s);
        let (sin, cos) = libm::sincos(order * angle);
        let row = SVector::<f64, TERMS>::from([1.0, s, s * s, cos, sin]);
        normal += weight * row * row.transpose();
        side += weight * value * row;
    }
    match normal.cholesky().map(|factor| factor.solve(&side)) {
        Some(found) if to.saturating_sub(from) > 4 * TERMS && found.iter().all(|x| x.is_finite()) => [found[3], found[4]],
        _ => [0.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    #[test]
    fn a_wandering_line_goes_and_the_motion_stays() {
        let omega = |t: f64| 27.0 * (1.0 + 0.01 * libm::sin(0.5 * t));
        let turned = |t: f64| 27.0 * (t + 0.01 * (1.0 - libm::cos(0.5 * t)) / 0.5);
        let rotor = Series::of((0..640).map(|k| (f64::from(k) / 32.0, omega(f64::from(k) / 32.0))));
        let motion = |t: f64| libm::sin(3.0 * t) + 0.5 * t;
        let shaken = Series::of((0..2560).map(|k| {
            let t = f64::from(k) / 128.0;
            (t, motion(t) + 0.4 * libm::cos(4.0 * turned(t) + 0.7))
        }));
        assert_eq!(blades_of(&shaken, &rotor), Some(4));
        let still = removed(&shaken, &rotor, 4.0);
        let left = still.samples().map(|(t, x)| (x - motion(t)).powi(2)).sum::<f64>() / still.len() as f64;
        assert!(left.sqrt() < 0.01, "{}", left.sqrt());
    }

    #[test]
    fn noise_and_motion_have_no_blades() {
        let rotor = Series::of((0..640).map(|k| (f64::from(k) / 32.0, 27.0)));
        for seed in 0..200_u64 {
            let mut noise = NormalNoise::new(seed, 0);
            let plain = Series::of((0..2560).map(|k| {
                let t = f64::from(k) / 128.0;
                (t, libm::sin(3.0 * t) + 0.08 * noise.draw())
            }));
            assert_eq!(blades_of(&plain, &rotor), None, "seed {seed}");
        }
    }
}
