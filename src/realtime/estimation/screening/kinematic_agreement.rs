//! Agreement of measured increments with the kinematics, as recorded and with a gross error corrected.
//!
//! Consumes readings of every channel at one instant; produces the kinematic rates of the outputs,
//!     tas' = (u u' + v v' + w w')/V    alpha' = (w' u - u' w)/(u^2 + w^2)    beta' = (v' - v V'/V)/sqrt(u^2 + w^2)   (1)
//! with [u' v' w'] = f + g - omega x v, Euler's rates, and the climb. From increments over a window,
//!     a = var(measured - kinematic)/var(measured),   S = sum over outputs of n ln max(a, A_MIN)      (2)
//! with n windows that do not overlap (variances: constant biases cancel). The share of each accelerometer in its own output
//! (ax in airspeed, ay in sideslip, az in incidence) is an output of its own: the measurement less all other terms.
//! A correction explains a contradiction where an output that contradicted the kinematics (a > `CONTRARY`) then agrees with
//! them (a < `AGREES`), a share together with its output, and none that agreed no longer does; its gain is by how much it
//! lowers S. Of two exchanged outputs each reading is compared with itself: as recorded in the place of the one, corrected in
//! that of the other.
//! Source: ours; S is twice a log-likelihood ratio for independent Gaussian increments.

use super::gross_error::GrossError;
use crate::dynamics::kinematics::{Attitude, velocity_rate};
use crate::dynamics::sensors::velocity_of_air_data;
use crate::flight::channel::Channel;
use heapless::Vec;

/// Outputs of the kinematics.
pub const OUTPUT_CHANNELS: [Channel; 7] =
    [Channel::Tas, Channel::Alpha, Channel::Beta, Channel::Phi, Channel::Theta, Channel::Psi, Channel::Altitude];
/// How many.
pub const OUTPUTS: usize = OUTPUT_CHANNELS.len();
/// The output to which each accelerometer contributes most: ax airspeed, ay sideslip, az incidence.
pub const CONTRIBUTES_TO: [usize; 3] = [0, 2, 1];
/// Place of the incidence among the outputs.
const INCIDENCE: usize = 1;
/// Place of the sideslip among the outputs.
pub const SIDESLIP: usize = INCIDENCE + 1;
/// Outputs, and the shares of the three accelerometers in the first three of them.
pub const COMPARED: usize = OUTPUTS + CONTRIBUTES_TO.len();

/// Length of a window, s.
pub const WINDOW_S: f64 = 0.8;
const A_MIN: f64 = 0.02;
const CONTRARY: f64 = 0.5;
/// a below which an output agrees with the kinematics.
pub const AGREES: f64 = 0.25;
/// A reversed sign makes a up to four: this is a weaker limit, with the next, where noise contributes before and after.
const OPPOSED: f64 = 1.5;
/// a below which an output agrees in air that moves.
pub const AGREES_PARTLY: f64 = 0.6;
/// Gain of an error that is reported: the entry threshold of `fault_selection`, raised for the 60 errors tested.
pub const THRESHOLD: f64 = 24.0;
/// Difference of gains within which two errors cannot be distinguished.
pub const RIVAL: f64 = 6.0;
/// Least variance of an increment, relative to that of its noise.
pub const SIGNAL: f64 = 9.0;
/// Airspeed below which flow angles are not used, m/s.
const SPEED_MIN: f64 = 5.0;

/// a of (2) by compared output; `None` where it is not measured, no kinematics contain it, or its increments are within noise.
pub type Agreement = [Option<f64>; COMPARED];

/// Channel of a compared output; the accelerometer of a share.
pub fn compared_channel(k: usize) -> Channel {
    k.checked_sub(OUTPUTS).map_or(OUTPUT_CHANNELS[k.min(OUTPUTS - 1)], |axis| Channel::ACCELEROMETERS[axis.min(2)])
}

/// The output that a compared one is, or that the accelerometer of a share contributes to.
pub fn compared_output(k: usize) -> Channel {
    let output = k.checked_sub(OUTPUTS).map_or(k, |axis| CONTRIBUTES_TO[axis.min(2)]);
    OUTPUT_CHANNELS[output.min(OUTPUTS - 1)]
}

/// Increments of the compared outputs over one window, measured and kinematic.
pub type Increments = [Option<(f64, f64)>; COMPARED];

/// Increments of incidence and sideslip over one window, measured less those of rotation, and by acceleration.
pub type AccelerationIncrements = [Option<(f64, f64)>; 2];

/// The increments that are compared, from those of the outputs and the integral of their kinematic rates.
pub fn compared_increments(measured: [Option<f64>; OUTPUTS], kinematic: &OutputRates) -> Increments {
    let mut increments = [None; COMPARED];
    for (k, increment) in increments.iter_mut().enumerate() {
        *increment = match k.checked_sub(OUTPUTS) {
            None => measured[k].zip(kinematic.whole[k]),
            Some(axis) => {
                let output = CONTRIBUTES_TO[axis];
                of_share(measured[output], kinematic.whole[output], kinematic.by_force[axis])
            }
        };
    }
    increments
}

/// The increments of incidence and sideslip by acceleration.
pub fn acceleration_increments(measured: [Option<f64>; OUTPUTS], kinematic: &OutputRates) -> AccelerationIncrements {
    core::array::from_fn(|i| of_share(measured[INCIDENCE + i], kinematic.whole[INCIDENCE + i], kinematic.by_acceleration[i]))
}

/// The measurement less all other terms than a share, beside that share.
fn of_share(measured: Option<f64>, whole: Option<f64>, share: Option<f64>) -> Option<(f64, f64)> {
    let (measured, whole, share) = (measured?, whole?, share?);
    Some((measured - (whole - share), share))
}

/// Whether an output contradicts the kinematics.
pub fn contradicts(agreement: &Agreement) -> bool {
    agreement.iter().flatten().any(|a| *a > CONTRARY)
}

/// What a correction brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrectionGain {
    /// By how much it lowers S of (2).
    pub gain: f64,
    /// Place of the compared output that shows it most.
    pub output: usize,
    /// a of that output, as recorded and corrected.
    pub a: [f64; 2],
}

/// The agreement with an error corrected, by the place that each reading has as recorded.
fn by_reading(error: &GrossError, corrected: &Agreement) -> Agreement {
    if !matches!(error, GrossError::Swapped(_)) {
        return *corrected;
    }
    core::array::from_fn(|k| {
        let (output, is_share) = (compared_output(k), k >= OUTPUTS);
        let (whose, _) = error.corrected_by(output);
        let place = (0..COMPARED).find(|other| compared_output(*other) == whose && (*other >= OUTPUTS) == is_share);
        place.and_then(|place| corrected.get(place).copied().flatten())
    })
}

/// The gain of correcting an error; `None` where it explains no contradiction.
pub fn correction_gain(
    error: &GrossError,
    as_recorded: &Agreement,
    corrected: &Agreement,
    windows: f64,
) -> Option<CorrectionGain> {
    let corrected = &by_reading(error, corrected);
    let pairs = || as_recorded.iter().zip(corrected).enumerate().filter_map(|(k, (a, b))| Some((k, (*a)?, (*b)?)));
    // Where a correction makes the airspeed along x small, gravity and force vary together: a share then agrees with itself.
    let whole_agrees = |k: usize| match k.checked_sub(OUTPUTS).and_then(|axis| CONTRIBUTES_TO.get(axis)) {
        Some(&whole) => corrected.get(whole).copied().flatten().is_some_and(|a| a < AGREES),
        None => true,
    };
    let (output, a, b) = pairs()
        .filter(|(k, ..)| whole_agrees(*k))
        .filter(|(_, a, b)| *a > CONTRARY && *b < AGREES || *a > OPPOSED && *b < AGREES_PARTLY && *a > 3.0 * b)
        .max_by(|x, y| (x.1 / x.2).total_cmp(&(y.1 / y.2)))?;
    let worsened = pairs().any(|(_, a, b)| a < AGREES && b > CONTRARY);
    let lost = as_recorded.iter().zip(corrected).take(OUTPUTS).any(|(a, b)| a.is_some() && b.is_none());
    if worsened || lost {
        return None;
    }
    let score = |parts: &Agreement| -> f64 { parts.iter().flatten().map(|a| windows * libm::log(a.max(A_MIN))).sum() };
    Some(CorrectionGain { gain: score(as_recorded) - score(corrected), output, a: [a, b] })
}

/// A gross error and what its correction brings.
pub type ErrorGain = (&'static GrossError, CorrectionGain);

/// The likeliest of the corrections, and those that cannot be distinguished from it: gains less than `rival` apart.
pub fn likeliest<const N: usize>(gains: impl Iterator<Item = ErrorGain>, rival: f64) -> Vec<ErrorGain, N> {
    let mut all: Vec<ErrorGain, N> = gains.collect();
    all.sort_unstable_by(|a, b| b.1.gain.total_cmp(&a.1.gain));
    let best = all.first().map_or(0.0, |first| first.1.gain);
    all.retain(|one| best - one.1.gain < rival);
    all
}

/// Contribution of the arm of an instrument to its reading: of vanes by the rates over the airspeed, of accelerometers by the
/// rates' growth. `rates` p q r and their growth, rad/s and rad/s^2; `vane` and `accelerometer` the positions x y z, m.
pub fn by_arm(channel: Channel, rates: [f64; 3], growth: [f64; 3], speed: f64, vane: [f64; 3], accelerometer: [f64; 3]) -> f64 {
    let ([p, q, r], [dp, dq, dr]) = (rates, growth);
    let ([vx, vy, vz], [ax, ay, az]) = (vane, accelerometer);
    let speed = speed.max(SPEED_MIN);
    match channel {
        Channel::Alpha => (p * vy - q * vx) / speed,
        Channel::Beta => (r * vx - p * vz) / speed,
        Channel::Ax => dq * az - dr * ay,
        Channel::Ay => dr * ax - dp * az,
        Channel::Az => dp * ay - dq * ax,
        _ => 0.0,
    }
}

/// Kinematic rates at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutputRates {
    /// (1) and their like, of every output.
    pub whole: [Option<f64>; OUTPUTS],
    /// Contribution of each accelerometer to the output in `CONTRIBUTES_TO`.
    pub by_force: [Option<f64>; 3],
    /// What specific force and gravity together contribute to incidence and sideslip: their rates less those of rotation.
    pub by_acceleration: [Option<f64>; 2],
}

impl OutputRates {
    /// An integral before its first step.
    pub const ZERO: OutputRates =
        OutputRates { whole: [Some(0.0); OUTPUTS], by_force: [Some(0.0); 3], by_acceleration: [Some(0.0); 2] };

    /// Adds rates over a step, s; what has none has no integral.
    pub fn integrate(&mut self, rates: &OutputRates, step_s: f64) {
        let add = |sum: &mut Option<f64>, rate: Option<f64>| *sum = sum.zip(rate).map(|(sum, rate)| sum + step_s * rate);
        self.whole.iter_mut().zip(rates.whole).for_each(|(sum, rate)| add(sum, rate));
        self.by_force.iter_mut().zip(rates.by_force).for_each(|(sum, rate)| add(sum, rate));
        self.by_acceleration.iter_mut().zip(rates.by_acceleration).for_each(|(sum, rate)| add(sum, rate));
    }
}

/// Kinematic rates of the outputs, from readings at the centre of mass.
pub fn output_rates(at: impl Fn(Channel) -> Option<f64>) -> Option<OutputRates> {
    let omega = [at(Channel::P)?, at(Channel::Q)?, at(Channel::R)?];
    let (phi, theta) = (at(Channel::Phi), at(Channel::Theta));
    let attitude = Attitude::regular(phi.unwrap_or(0.0), theta.unwrap_or(0.0))?;
    let [by_phi, by_theta, by_psi] = attitude.euler_rates(omega);
    let known = phi.and(theta);
    let mut rates = OutputRates::default();
    rates.whole[3..6].copy_from_slice(&[phi.map(|_| by_phi), known.map(|_| by_theta), known.map(|_| by_psi)]);
    let force = || Some([at(Channel::Ax)?, at(Channel::Ay)?, at(Channel::Az)?]);
    let (Some(speed), Some(force), Some(_)) = (at(Channel::Tas), force(), known) else { return Some(rates) };
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
    let root = libm::sqrt(along);
    let by_speed = (0..3).map(|i| velocity[i] * change[i]).sum::<f64>() / speed;
    rates.whole[0] = Some(by_speed);
    rates.whole[1] = alpha.map(|_| (change[2] * u - change[0] * w) / along);
    rates.whole[2] = beta.map(|_| (change[1] - v * by_speed / speed) / root);
    rates.whole[6] = alpha.map(|_| attitude.climb(velocity));
    rates.by_force = [
        Some(u * force[0] / speed),
        beta.map(|_| force[1] * (1.0 - v * v / (speed * speed)) / root),
        alpha.map(|_| force[2] * u / along),
    ];
    let [fx, fy, fz]: [f64; 3] = core::array::from_fn(|i| force[i] + gravity[i]);
    rates.by_acceleration = [alpha.map(|_| (fz * u - fx * w) / along), beta.map(|_| (fy - v * by_speed / speed) / root)];
    Some(rates)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of a rolling, yawing aircraft at 50 m/s whose forces are those that make its velocity change by `rate`.
    fn readings(rate: [f64; 3]) -> impl Fn(Channel) -> Option<f64> {
        let (tas, alpha, beta) = (50.0, 0.05, 0.03);
        let (omega, phi, theta) = ([0.2, -0.1, 0.15], 0.3, 0.08);
        let velocity = velocity_of_air_data(tas, alpha, beta);
        let gravity = Attitude::new(phi, theta).gravity();
        let without = velocity_rate(velocity, omega, [0.0; 3]);
        let force: [f64; 3] = core::array::from_fn(|i| rate[i] - gravity[i] - without[i]);
        move |channel| match channel {
            Channel::Ax | Channel::Ay | Channel::Az => force.get(channel.index()).copied(),
            Channel::P | Channel::Q | Channel::R => omega.get(channel.index() - Channel::P.index()).copied(),
            Channel::Phi => Some(phi),
            Channel::Theta => Some(theta),
            Channel::Tas => Some(tas),
            Channel::Alpha => Some(alpha),
            Channel::Beta => Some(beta),
            _ => None,
        }
    }

    #[test]
    fn rates_of_the_air_data_are_those_of_the_velocity() {
        let rate = [1.3, -0.7, 2.1];
        let rates = output_rates(readings(rate)).unwrap();
        let velocity = velocity_of_air_data(50.0, 0.05, 0.03);
        let air_data = |v: [f64; 3]| {
            let speed = libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            [speed, libm::atan2(v[2], v[0]), libm::asin(v[1] / speed)]
        };
        let step = 1e-6;
        let [after, before] = [step, -step].map(|step| air_data(core::array::from_fn(|i| velocity[i] + step * rate[i])));
        for k in 0..3 {
            let by_difference = (after[k] - before[k]) / (2.0 * step);
            assert!((rates.whole[k].unwrap() - by_difference).abs() < 1e-7, "{:?}", OUTPUT_CHANNELS[k]);
        }
        // Without rotation the flow angles change by acceleration alone.
        let unturned = |channel| {
            readings(rate)(channel).map(|value| match channel {
                Channel::P | Channel::Q | Channel::R => 0.0,
                _ => value,
            })
        };
        let unturned = output_rates(unturned).unwrap();
        for (k, by_acceleration) in [1, 2].into_iter().zip(rates.by_acceleration) {
            assert!((unturned.whole[k].unwrap() - by_acceleration.unwrap()).abs() < 1e-12);
        }
        // What an accelerometer contributes is what is missing without it.
        for (axis, output) in CONTRIBUTES_TO.into_iter().enumerate() {
            let all = readings(rate);
            let without = output_rates(|channel| if channel.index() == axis { Some(0.0) } else { all(channel) }).unwrap();
            let missing = rates.whole[output].unwrap() - without.whole[output].unwrap();
            assert!((missing - rates.by_force[axis].unwrap()).abs() < 1e-12, "axis {axis}");
        }
    }

    #[test]
    fn a_correction_has_a_gain_where_it_makes_an_output_agree_and_spoils_none() {
        const TURNED: GrossError = GrossError::Turned(&[Channel::Beta]);
        let mut as_recorded: Agreement = [Some(0.05); COMPARED];
        as_recorded[2] = Some(1.9);
        let corrected: Agreement = [Some(0.05); COMPARED];
        let found = correction_gain(&TURNED, &as_recorded, &corrected, 10.0).unwrap();
        assert_eq!((found.output, found.a), (2, [1.9, 0.05]));
        assert!((found.gain - 10.0 * libm::log(1.9 / 0.05)).abs() < 1e-9);
        let mut spoiled = corrected;
        spoiled[3] = Some(0.8);
        assert_eq!(correction_gain(&TURNED, &as_recorded, &spoiled, 10.0), None);
        let mut lost = corrected;
        lost[3] = None;
        assert_eq!(correction_gain(&TURNED, &as_recorded, &lost, 10.0), None);
        assert_eq!(correction_gain(&TURNED, &corrected, &corrected, 10.0), None);
    }

    #[test]
    fn of_two_exchanged_outputs_the_one_that_does_not_move_is_not_lost() {
        let exchanged = GrossError::Swapped([Channel::Phi, Channel::Theta]);
        let (phi, theta) = (3, 4);
        // The bank is read as pitch and contradicts q; the pitch, read as bank, stands.
        let mut as_recorded: Agreement = [Some(0.05); COMPARED];
        (as_recorded[phi], as_recorded[theta], as_recorded[SIDESLIP]) = (None, Some(1.0), Some(0.9));
        let mut corrected: Agreement = [Some(0.05); COMPARED];
        corrected[theta] = None;
        let found = correction_gain(&exchanged, &as_recorded, &corrected, 10.0).unwrap();
        assert!((found.gain - 10.0 * (libm::log(1.0 / 0.05) + libm::log(0.9 / 0.05))).abs() < 1e-9, "{found:?}");
        assert_eq!(correction_gain(&GrossError::Turned(&[Channel::Phi]), &as_recorded, &corrected, 10.0), None);
    }
}
