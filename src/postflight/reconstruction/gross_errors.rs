//! Coarse errors: a sign turned, another unit, two channels under each other's names. Looked for before anything finer.
//!
//! Consumes a record; tries each such error of one channel or of one group of them and asks how the increments of attitude, flow
//! angles, airspeed and altitude over `WINDOW_S` then agree with those that the kinematics give,
//!     a = var(measured - kinematic)/var(measured)        S = sum over outputs of n ln max(a, A_MIN)           (1)
//! with n windows that do not overlap (variances: constant biases do not count). The part of each accelerometer in its own output
//! (ax in airspeed, ay in sideslip, az in incidence) is an output of its own: what is measured less what all else gives.
//! An error is told where putting it right brings S down by more than `TOLD`, an output that contradicted the kinematics
//! (a > `CONTRARY`) then follows them (a < `FOLLOWS`), and none that followed no longer does; with every other one that does
//! as well within `RIVAL`.
//! Cannot tell what hardly moves: an output counts where its increments exceed their noise.

use super::parameter::{INPUT_CHANNELS, OUTPUT_CHANNELS, OUTPUTS};
use super::record::RunChannels;
use crate::dynamics::kinematics::{Attitude, velocity_rate};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::unit::{DEGREE, FOOT, STANDARD_GRAVITY};

const WINDOW_S: f64 = 0.8;
/// Mean over which an end of a window is read, and the part of it over which the kinematics are taken as constant, s.
const END_S: f64 = 0.1;
const PARTS: usize = 8;
const A_MIN: f64 = 0.02;
const CONTRARY: f64 = 0.5;
const FOLLOWS: f64 = 0.25;
/// A turned sign makes a up to four: where noise has a part in both, so much before and so little after will do.
const OPPOSED: f64 = 1.5;
const FOLLOWS_SOMEWHAT: f64 = 0.6;
/// Twice a logarithm of odds, as F against ENTER of `select` but for the 40 errors that are tried.
const TOLD: f64 = 24.0;
const RIVAL: f64 = 6.0;
/// Variance of an increment over that of its noise.
const SIGNAL: f64 = 9.0;
/// Fewer windows say nothing.
const WINDOWS_MIN: usize = 8;
/// No aircraft whose flow is looked at is slower, m/s.
const SPEED_MIN: f64 = 5.0;
/// Outputs, and the parts of the three accelerometers in the first three of them.
const COMPARED: usize = OUTPUTS + FELT_IN.len();
/// In which output each accelerometer is felt most: ax in airspeed, ay in sideslip, az in incidence.
const FELT_IN: [usize; 3] = [0, 2, 1];

const GYROS: &[Channel] = &[Channel::P, Channel::Q, Channel::R];
const ATTITUDE: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi];
const VANES: &[Channel] = &[Channel::Alpha, Channel::Beta];
const ANGLES: &[Channel] = &[Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const ALL_ANGLES: &[Channel] =
    &[Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Alpha, Channel::Beta];
const FORCES: &[Channel] = &[Channel::Ax, Channel::Ay, Channel::Az];
/// Of one channel: what may be turned.
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
/// Of airspeed: unit, in m/s.
const SPEEDS: [(&str, f64); 4] = [("kn", 1852.0 / 3600.0), ("km/h", 1.0 / 3.6), ("ft/s", FOOT), ("mph", 0.447_04)];

/// A coarse error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GrossError {
    /// These read with the opposite sign.
    Turned(&'static [Channel]),
    /// These read in that unit; its size in SI.
    Unit(&'static [Channel], &'static str, f64),
    /// Two are exchanged.
    Swapped([Channel; 2]),
}

impl GrossError {
    fn all() -> Vec<GrossError> {
        let mut all: Vec<GrossError> = SIGNED.into_iter().map(GrossError::Turned).collect();
        for one in [GYROS, ATTITUDE, VANES] {
            all.push(GrossError::Turned(one));
        }
        for one in SIGNED.into_iter().take(8).chain([GYROS, ATTITUDE, VANES, ANGLES, ALL_ANGLES]) {
            all.push(GrossError::Unit(
                one,
                if one.iter().all(|channel| GYROS.contains(channel)) { "deg/s" } else { "deg" },
                DEGREE,
            ));
        }
        for (unit, size) in [("g", STANDARD_GRAVITY), ("ft/s^2", FOOT)] {
            all.extend([SIGNED[8], SIGNED[9], FORCES].map(|one| GrossError::Unit(one, unit, size)));
        }
        all.extend(SPEEDS.map(|(unit, size)| GrossError::Unit(&[Channel::Tas], unit, size)));
        all.push(GrossError::Unit(&[Channel::Altitude], "ft", FOOT));
        all.extend(SWAPPED.map(GrossError::Swapped));
        all
    }

    /// Whose reading a channel's is, and by what it is to be multiplied.
    fn put_right(self, channel: Channel) -> (Channel, f64) {
        match self {
            GrossError::Turned(these) if these.contains(&channel) => (channel, -1.0),
            GrossError::Unit(these, _, size) if these.contains(&channel) => (channel, size),
            GrossError::Swapped([a, b]) if a == channel => (b, 1.0),
            GrossError::Swapped([a, b]) if b == channel => (a, 1.0),
            _ => (channel, 1.0),
        }
    }

    /// In words.
    pub fn words(self) -> String {
        let names = |these: &[Channel]| {
            let names: Vec<&str> = these.iter().map(|channel| channel.name(ControlNames::Rotorcraft)).collect();
            names.join(" ")
        };
        match self {
            GrossError::Turned(these) => format!("{} with the sign turned", names(these)),
            GrossError::Unit(these, unit, _) => format!("{} in {unit}", names(these)),
            GrossError::Swapped([a, b]) => format!("{} and {} exchanged", names(&[a]), names(&[b])),
        }
    }
}

/// What the record looks like instead.
#[derive(Clone, Debug, PartialEq)]
pub struct GrossFinding {
    /// The error and all that do as well.
    pub either: Vec<GrossError>,
    /// The output that shows it, its R2 = 1 - a as recorded and put right.
    pub shown: (Channel, f64, f64),
}

/// Looks for a coarse error.
pub fn gross_error(record: &RunChannels) -> Option<GrossFinding> {
    let measured = |channel: Channel| record.series(channel).is_some();
    let none = agreement(record, None);
    let windows = (record.mesh.length_s() / WINDOW_S).max(1.0);
    let score =
        |parts: &[Option<f64>; COMPARED]| -> f64 { parts.iter().flatten().map(|a| windows * libm::log(a.max(A_MIN))).sum() };
    if !none.iter().flatten().any(|a| *a > CONTRARY) {
        return None;
    }
    let mut told: Vec<(f64, GrossError, Channel, f64, f64)> = Vec::new();
    for one in GrossError::all() {
        // A group counts as one error only where all of it is there.
        let present = |these: &[Channel]| these.iter().all(|channel| measured(*channel) || *channel == Channel::Psi);
        let there = match one {
            GrossError::Turned(these) | GrossError::Unit(these, ..) => present(these),
            GrossError::Swapped(two) => present(&two),
        };
        if !there {
            continue;
        }
        let after = agreement(record, Some(one));
        let pairs = || none.iter().zip(&after).enumerate().filter_map(|(k, (a, b))| Some((k, (*a)?, (*b)?)));
        let mended = pairs()
            .filter(|(_, a, b)| *a > CONTRARY && *b < FOLLOWS || *a > OPPOSED && *b < FOLLOWS_SOMEWHAT && *a > 3.0 * b)
            .max_by(|x, y| (x.1 / x.2).total_cmp(&(y.1 / y.2)));
        let spoilt = pairs().any(|(_, a, b)| a < FOLLOWS && b > CONTRARY);
        let lost = none.iter().zip(&after).take(OUTPUTS).any(|(a, b)| a.is_some() && b.is_none());
        if let Some((k, a, b)) = mended.filter(|_| !spoilt && !lost) {
            told.push((score(&none) - score(&after), one, compared(k), a, b));
        }
    }
    told.sort_by(|a, b| b.0.total_cmp(&a.0));
    let &(gain, _, channel, before, after) = told.first().filter(|best| best.0 > TOLD)?;
    let either = told.iter().filter(|one| gain - one.0 < RIVAL).map(|one| one.1);
    Some(GrossFinding { either: either.collect(), shown: (channel, 1.0 - before, 1.0 - after) })
}

/// a of (1) by output; `None` where it is not measured, not connected with anything, or hardly moves.
fn agreement(record: &RunChannels, put_right: Option<GrossError>) -> [Option<f64>; COMPARED] {
    let raw = |channel: Channel, from_s: f64, to_s: f64| -> Option<f64> {
        let (whose, factor) = put_right.map_or((channel, 1.0), |one| one.put_right(channel));
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
        for (axis, (output, force)) in FELT_IN.into_iter().zip(FORCES).enumerate() {
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
        let (pairs, channel) = (pairs.get(k)?, OUTPUT_CHANNELS[k.checked_sub(OUTPUTS).map_or(k, |axis| FELT_IN[axis])]);
        if pairs.len() < WINDOWS_MIN {
            return None;
        }
        let (whose, factor) = put_right.map_or((channel, 1.0), |one| one.put_right(channel));
        let source = record.series(whose)?;
        let averaged = (END_S / source.interval_s()?).max(1.0);
        let noise = 2.0 * factor * factor * source.noise_std() * source.noise_std() / averaged;
        let signal = variance(pairs.iter().map(|pair| pair.0));
        (signal > SIGNAL * noise && signal > 0.0).then(|| variance(pairs.iter().map(|pair| pair.0 - pair.1)) / signal)
    })
}

/// What an instrument reads because it stands where the run says and not at the centre of mass: vanes through the rates, over the
/// airspeed; accelerometers through the rates' increments.
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

/// What is compared, as a channel: an accelerometer for its own part.
fn compared(k: usize) -> Channel {
    k.checked_sub(OUTPUTS).map_or(OUTPUT_CHANNELS[k.min(OUTPUTS - 1)], |axis| INPUT_CHANNELS[axis])
}

/// The unit of speed, other than m/s, in which a reading is that many times the truth.
pub fn speed_unit(factor: f64, std: f64) -> Option<&'static str> {
    let off = |size: f64| (factor * size - 1.0).abs();
    SPEEDS.into_iter().find(|(_, size)| off(*size) < 3.0 * std * size && off(*size) < 0.05).map(|(unit, _)| unit)
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

/// What tas, alpha, beta, phi, theta, psi and altitude must gain from then on over a window.
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

/// Their rates; readings are those of the centre of mass.
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
    let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) = (libm::sincos(alpha.unwrap_or(0.0)), libm::sincos(beta.unwrap_or(0.0)));
    let velocity = [speed * cos_alpha * cos_beta, speed * sin_beta, speed * sin_alpha * cos_beta];
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
