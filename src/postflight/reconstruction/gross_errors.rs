//! Gross errors: a reversed sign, another unit, two channels exchanged; tested before any estimation.
//!
//! Consumes a record; tests each such error of one channel or of one group of them by the agreement of the increments of
//! attitude, flow angles, airspeed and altitude over `WINDOW_S` with those of the kinematics,
//!     a = var(measured - kinematic)/var(measured)        S = sum over outputs of n ln max(a, A_MIN)           (1)
//! with n windows that do not overlap (variances: constant biases cancel). The share of each accelerometer in its own output
//! (ax in airspeed, ay in sideslip, az in incidence) is an output of its own: the measurement less all other terms.
//! An error is reported where correcting it lowers S by more than `THRESHOLD`, an output that contradicted the kinematics
//! (a > `CONTRARY`) then agrees with them (a < `AGREES`), and none that agreed no longer does; with every other error within
//! `RIVAL` of it, which cannot be distinguished. Outputs count where their increments exceed their noise.
//! Source: ours; S is twice a log-likelihood ratio for independent Gaussian increments.
//! Returns `None` where no output contradicts the kinematics, or no error explains it.

use super::parameter::{INPUT_CHANNELS, OUTPUT_CHANNELS, OUTPUTS};
use super::record::GrossError;
use super::run_channels::RunChannels;
use crate::dynamics::kinematics::{Attitude, velocity_rate};
use crate::dynamics::sensors::velocity_of_air_data;
use crate::flight::channel::Channel;
use crate::flight::unit::{DEGREE, FOOT, STANDARD_GRAVITY};

const WINDOW_S: f64 = 0.8;
/// Length of the mean at either end of a window, s; steps of a window over which the kinematics are constant.
const END_S: f64 = 0.1;
const PARTS: usize = 8;
const A_MIN: f64 = 0.02;
const CONTRARY: f64 = 0.5;
const AGREES: f64 = 0.25;
/// A reversed sign makes a up to four: weaker limits on a, before and after, where noise contributes to both.
const OPPOSED: f64 = 1.5;
const AGREES_PARTLY: f64 = 0.6;
/// Twice a log-likelihood ratio: the entry threshold of `fault_selection`, raised for the 40 errors tested.
const THRESHOLD: f64 = 24.0;
const RIVAL: f64 = 6.0;
/// Least variance of an increment, relative to that of its noise.
const SIGNAL: f64 = 9.0;
const WINDOWS_MIN: usize = 8;
/// Airspeed below which flow angles are not used, m/s.
const SPEED_MIN: f64 = 5.0;
/// Outputs, and the shares of the three accelerometers in the first three of them.
const COMPARED: usize = OUTPUTS + CONTRIBUTES_TO.len();
/// The output to which each accelerometer contributes most: ax airspeed, ay sideslip, az incidence.
const CONTRIBUTES_TO: [usize; 3] = [0, 2, 1];

const GYROS: &[Channel] = &[Channel::P, Channel::Q, Channel::R];
const ATTITUDE: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi];
const VANES: &[Channel] = &[Channel::Alpha, Channel::Beta];
const ANGLES: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const ALL_ANGLES: &[Channel] =
    &[Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const FORCES: &[Channel] = &[Channel::Ax, Channel::Ay, Channel::Az];
/// Groups whose sign may be reversed.
const SIGNED: [&[Channel]; 10] = [
    &[Channel::P],
    &[Channel::Q],
    &[Channel::R],
    &[Channel::Phi],
    &[Channel::Theta],
    &[Channel::Psi],
    &[Channel::Alpha],
    &[Channel::Beta],
    &[Channel::Ax],
    &[Channel::Ay],
];
const SWAPPED: [[Channel; 2]; 6] = [
    [Channel::P, Channel::Q],
    [Channel::P, Channel::R],
    [Channel::Q, Channel::R],
    [Channel::Phi, Channel::Theta],
    [Channel::Alpha, Channel::Beta],
    [Channel::Ax, Channel::Ay],
];
/// Units of airspeed, in m/s.
const SPEEDS: [(&str, f64); 4] = [("kn", 1852.0 / 3600.0), ("km/h", 1.0 / 3.6), ("ft/s", FOOT), ("mph", 0.447_04)];

impl GrossError {
    fn all() -> Vec<GrossError> {
        let mut all: Vec<GrossError> = SIGNED.into_iter().map(GrossError::Turned).collect();
        for error in [GYROS, ATTITUDE, VANES] {
            all.push(GrossError::Turned(error));
        }
        for error in SIGNED.into_iter().take(8).chain([GYROS, ATTITUDE, VANES, ANGLES, ALL_ANGLES]) {
            all.push(GrossError::Unit(
                error,
                if error.iter().all(|channel| GYROS.contains(channel)) { "deg/s" } else { "deg" },
                DEGREE,
            ));
        }
        for (unit, size) in [("g", STANDARD_GRAVITY), ("ft/s^2", FOOT)] {
            all.extend([SIGNED[8], SIGNED[9], FORCES].map(|error| GrossError::Unit(error, unit, size)));
        }
        all.extend(SPEEDS.map(|(unit, size)| GrossError::Unit(&[Channel::Tas], unit, size)));
        all.push(GrossError::Unit(&[Channel::Altitude], "ft", FOOT));
        all.extend(SWAPPED.map(GrossError::Swapped));
        all
    }

    /// The channel whose reading corrects this one, and the factor on it.
    fn corrected_by(self, channel: Channel) -> (Channel, f64) {
        match self {
            GrossError::Turned(these) if these.contains(&channel) => (channel, -1.0),
            GrossError::Unit(these, _, size) if these.contains(&channel) => (channel, size),
            GrossError::Swapped([a, b]) if a == channel => (b, 1.0),
            GrossError::Swapped([a, b]) if b == channel => (a, 1.0),
            _ => (channel, 1.0),
        }
    }
}

/// A gross error of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct GrossFinding {
    /// The most likely error, and those that cannot be distinguished from it.
    pub either: Vec<GrossError>,
    /// The output that shows it, and its R2 = 1 - a as recorded and corrected.
    pub shown: (Channel, f64, f64),
}

/// Tests a record for gross errors.
pub fn gross_error(record: &RunChannels) -> Option<GrossFinding> {
    let measured = |channel: Channel| record.series(channel).is_some();
    let as_recorded = agreement(record, None);
    let windows = (record.mesh.length_s() / WINDOW_S).max(1.0);
    let score =
        |parts: &[Option<f64>; COMPARED]| -> f64 { parts.iter().flatten().map(|a| windows * libm::log(a.max(A_MIN))).sum() };
    if !as_recorded.iter().flatten().any(|a| *a > CONTRARY) {
        return None;
    }
    let mut candidates: Vec<(f64, GrossError, Channel, f64, f64)> = Vec::new();
    for error in GrossError::all() {
        // An error of a group needs all of its channels.
        let present = |these: &[Channel]| these.iter().all(|channel| measured(*channel) || *channel == Channel::Psi);
        let testable = match error {
            GrossError::Turned(these) | GrossError::Unit(these, ..) => present(these),
            GrossError::Swapped(two) => present(&two),
        };
        if !testable {
            continue;
        }
        let after = agreement(record, Some(error));
        let pairs = || as_recorded.iter().zip(&after).enumerate().filter_map(|(k, (a, b))| Some((k, (*a)?, (*b)?)));
        let improved = pairs()
            .filter(|(_, a, b)| *a > CONTRARY && *b < AGREES || *a > OPPOSED && *b < AGREES_PARTLY && *a > 3.0 * b)
            .max_by(|x, y| (x.1 / x.2).total_cmp(&(y.1 / y.2)));
        let worsened = pairs().any(|(_, a, b)| a < AGREES && b > CONTRARY);
        let lost = as_recorded.iter().zip(&after).take(OUTPUTS).any(|(a, b)| a.is_some() && b.is_none());
        if let Some((k, a, b)) = improved.filter(|_| !worsened && !lost) {
            candidates.push((score(&as_recorded) - score(&after), error, compared(k), a, b));
        }
    }
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let &(gain, _, channel, before, after) = candidates.first().filter(|best| best.0 > THRESHOLD)?;
    let either = candidates.iter().filter(|error| gain - error.0 < RIVAL).map(|error| error.1);
    Some(GrossFinding { either: either.collect(), shown: (channel, 1.0 - before, 1.0 - after) })
}

/// a of (1) by output; `None` where it is not measured, no kinematics contain it, or its increments are within noise.
fn agreement(record: &RunChannels, corrected_by: Option<GrossError>) -> [Option<f64>; COMPARED] {
    let raw = |channel: Channel, from_s: f64, to_s: f64| -> Option<f64> {
        let (whose, factor) = corrected_by.map_or((channel, 1.0), |error| error.corrected_by(channel));
        Some(factor * record.series(whose)?.mean(from_s, to_s))
    };
    let read = |channel: Channel, from_s: f64, to_s: f64| -> Option<f64> {
        Some(raw(channel, from_s, to_s)? - by_arm(record, &raw, channel, from_s, to_s))
    };
    let begin_s = record.mesh.time_s(0) + END_S;
    let count = ((record.mesh.length_s() - 2.0 * END_S) / (0.5 * WINDOW_S)) as usize;
    let mut pairs: [Vec<(f64, f64)>; COMPARED] = Default::default();
    for window in 0..count.saturating_sub(1) {
        let from_s = begin_s + 0.5 * WINDOW_S * window as f64;
        let moved = OUTPUT_CHANNELS.map(|channel| {
            let end = |time_s: f64| read(channel, time_s - 0.5 * END_S, time_s + 0.5 * END_S);
            let moved = end(from_s + WINDOW_S)? - end(from_s)?;
            let turn = 2.0 * core::f64::consts::PI;
            Some(if channel == Channel::Psi { moved - turn * libm::round(moved / turn) } else { moved })
        });
        let whole = increments(&read, from_s);
        for k in 0..OUTPUTS {
            if let (Some(moved), Some(kinematic)) = (moved[k], whole[k]) {
                pairs[k].push((moved, kinematic));
            }
        }
        for (axis, (output, force)) in CONTRIBUTES_TO.into_iter().zip(FORCES).enumerate() {
            let without = |channel: Channel, from_s: f64, to_s: f64| {
                if channel == *force { Some(0.0) } else { read(channel, from_s, to_s) }
            };
            let without = increments(&without, from_s)[output];
            if let ((Some(moved), Some(kinematic)), Some(without)) = ((moved[output], whole[output]), without) {
                pairs[OUTPUTS + axis].push((moved - without, kinematic - without));
            }
        }
    }
    core::array::from_fn(|k| {
        let (pairs, channel) = (pairs.get(k)?, OUTPUT_CHANNELS[k.checked_sub(OUTPUTS).map_or(k, |axis| CONTRIBUTES_TO[axis])]);
        if pairs.len() < WINDOWS_MIN {
            return None;
        }
        let (whose, factor) = corrected_by.map_or((channel, 1.0), |error| error.corrected_by(channel));
        let source = record.series(whose)?;
        let averaged = (END_S / source.interval_s()?).max(1.0);
        let noise = 2.0 * factor * factor * source.noise_std() * source.noise_std() / averaged;
        let signal = variance(pairs.iter().map(|pair| pair.0));
        (signal > SIGNAL * noise && signal > 0.0).then(|| variance(pairs.iter().map(|pair| pair.0 - pair.1)) / signal)
    })
}

/// Contribution of the arm of an instrument to its reading: of vanes by the rates over the airspeed, of accelerometers by the
/// rates' increments.
fn by_arm(
    record: &RunChannels,
    raw: &impl Fn(Channel, f64, f64) -> Option<f64>,
    channel: Channel,
    from_s: f64,
    to_s: f64,
) -> f64 {
    let rate = |gyro: Channel| raw(gyro, from_s, to_s).unwrap_or(0.0);
    let growth = |gyro: Channel| {
        let at = |time_s: f64| raw(gyro, time_s - 0.5 * END_S, time_s + 0.5 * END_S);
        at(to_s).zip(at(from_s)).map_or(0.0, |(after, before)| (after - before) / (to_s - from_s))
    };
    let [vx, vy, vz] = record.vane_place;
    let [ax, ay, az] = record.accelerometer_place;
    let speed = || raw(Channel::Tas, from_s, to_s).unwrap_or(f64::INFINITY).max(SPEED_MIN);
    match channel {
        Channel::Alpha => (rate(Channel::P) * vy - rate(Channel::Q) * vx) / speed(),
        Channel::Beta => (rate(Channel::R) * vx - rate(Channel::P) * vz) / speed(),
        Channel::Ax => growth(Channel::Q) * az - growth(Channel::R) * ay,
        Channel::Ay => growth(Channel::R) * ax - growth(Channel::P) * az,
        Channel::Az => growth(Channel::P) * ay - growth(Channel::Q) * ax,
        _ => 0.0,
    }
}

/// Channel of a compared output; the accelerometer of a share.
fn compared(k: usize) -> Channel {
    k.checked_sub(OUTPUTS).map_or(OUTPUT_CHANNELS[k.min(OUTPUTS - 1)], |axis| INPUT_CHANNELS[axis])
}

/// The unit of speed other than m/s that a scale factor with this standard error agrees with.
pub fn speed_unit(factor: f64, std: f64) -> Option<&'static str> {
    let off = |size: f64| (factor * size - 1.0).abs();
    SPEEDS.into_iter().find(|(_, size)| off(*size) < 3.0 * std * size && off(*size) < 0.05).map(|(unit, _)| unit)
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

/// Kinematic increments of tas, alpha, beta, phi, theta, psi and altitude over the window from `from_s`.
fn increments(read: &impl Fn(Channel, f64, f64) -> Option<f64>, from_s: f64) -> [Option<f64>; OUTPUTS] {
    let mut sums = [Some(0.0); OUTPUTS];
    let step_s = WINDOW_S / PARTS as f64;
    for part in 0..PARTS {
        let (from_s, to_s) = (from_s + step_s * part as f64, from_s + step_s * (part + 1) as f64);
        let at = |channel: Channel| read(channel, from_s, to_s);
        let rates = rates(at).unwrap_or([None; OUTPUTS]);
        for (sum, rate) in sums.iter_mut().zip(rates) {
            *sum = sum.zip(rate).map(|(sum, rate)| sum + step_s * rate);
        }
    }
    sums
}

/// Kinematic rates of the outputs, from readings at the centre of mass.
fn rates(at: impl Fn(Channel) -> Option<f64>) -> Option<[Option<f64>; OUTPUTS]> {
    let three = |these: &[Channel]| -> Option<[f64; 3]> {
        let [a, b, c] = these else { return None };
        Some([at(*a)?, at(*b)?, at(*c)?])
    };
    let omega = three(GYROS)?;
    let (phi, theta) = (at(Channel::Phi), at(Channel::Theta));
    let attitude = Attitude::regular(phi.unwrap_or(0.0), theta.unwrap_or(0.0))?;
    let [by_phi, by_theta, by_psi] = attitude.euler_rates(omega);
    let known = phi.and(theta);
    let mut rates = [None, None, None, phi.map(|_| by_phi), known.map(|_| by_theta), known.map(|_| by_psi), None];
    let (Some(speed), Some(force), Some(_)) = (at(Channel::Tas), three(FORCES), known) else { return Some(rates) };
    let (alpha, beta) = (at(Channel::Alpha), at(Channel::Beta));
    let velocity = velocity_of_air_data(speed, alpha.unwrap_or(0.0), beta.unwrap_or(0.0));
    let by_force = velocity_rate(velocity, omega, force);
    let gravity = attitude.gravity();
    let change: [f64; 3] = core::array::from_fn(|i| by_force[i] + gravity[i]);
    let [u, v, w] = velocity;
    let along = u * u + w * w;
    if !(along > 25.0) {
        return Some(rates);
    }
    let by_speed = (0..3).map(|i| velocity[i] * change[i]).sum::<f64>() / speed;
    rates[0] = Some(by_speed);
    rates[1] = alpha.map(|_| (change[2] * u - change[0] * w) / along);
    rates[2] = beta.map(|_| (change[1] - v * by_speed / speed) / libm::sqrt(along));
    rates[6] = alpha.map(|_| attitude.climb(velocity));
    Some(rates)
}
