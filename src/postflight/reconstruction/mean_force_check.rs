//! Mean specific force against attitude, turn and air data: the test of accelerometers that remains in turbulence.
//!
//! Consumes a run with its noise; per axis, over its length T, with V the velocity by airspeed and flow angles,
//!     D = mean(f + g - omega x V) - (V(T) - V(0))/T                                                   (1)
//! has mean zero for healthy instruments but for their biases, and variance, for gusts white in acceleration of density q,
//!     sigma^2 = sigma_f^2 + (g sigma_attitude)^2 + q/T                                                (2)
//! with prior standard deviations of bias and attitude. Reported where D^2 > ENTER sigma^2, the threshold of `fault_selection`.
//! Which of the channels in (1) is in error is not identifiable. SI, body axes. Source: ours.
//! Returns `None` where channels are missing or no axis is contradicted.

use super::fault_selection::ENTER;
use super::fit::RunWithNoise;
use super::parameter::{BIAS, CHANNELS, INPUT_CHANNELS, InstrumentError};
use super::record::MeanForceContradiction;
use super::run_channels::RunChannels;
use crate::dynamics::kinematics::{Attitude, velocity_rate};
use crate::dynamics::sensors::velocity_of_air_data;
use crate::flight::channel::Channel;
use crate::flight::unit::STANDARD_GRAVITY;

/// Interval between means, and the means at either end, s.
const STEP_S: f64 = 0.1;
const END_S: f64 = 0.5;
/// Relative deviation from twice its own mean within which (1) indicates a reversed sign of the accelerometer.
const REVERSED: f64 = 0.3;

/// Accelerometers across gravity that (1) contradicts; `None` where the run is too short or lacks a channel of (1).
pub(crate) fn contradicted_mean_force(run: &RunWithNoise) -> Option<Vec<MeanForceContradiction>> {
    let record = &run.record;
    let length_s = record.mesh.length_s() - END_S;
    let begin_s = record.mesh.time_s(0);
    if !(length_s > 10.0 * END_S) {
        return None;
    }
    let velocity_at = |from_s: f64, to_s: f64| velocity(record, from_s, to_s);
    let (first, last) = (velocity_at(begin_s, begin_s + END_S)?, velocity_at(begin_s + length_s, begin_s + length_s + END_S)?);
    let count = (length_s / STEP_S) as usize;
    let (mut sum, mut forces) = ([0.0; 3], [0.0; 3]);
    for step in 0..count {
        let from_s = begin_s + 0.5 * END_S + STEP_S * step as f64;
        let to_s = from_s + STEP_S;
        let [ax, ay, az, p, q, r] = all(core::array::from_fn(|i| Some(record.inputs.get(i)?.as_ref()?.mean(from_s, to_s))))?;
        let [phi, theta] = all([3, 4].map(|i| output(record, i, from_s, to_s)))?;
        let gravity = Attitude::regular(phi, theta)?.gravity();
        let rate = velocity_rate(velocity_at(from_s, to_s)?, [p, q, r], [ax, ay, az]);
        for i in 0..3 {
            sum[i] += rate[i] + gravity[i];
            forces[i] += [ax, ay, az][i];
        }
    }
    let normal_of = |channel: Channel| {
        let bias = CHANNELS.iter().position(|one| *one == channel).map(|place| InstrumentError::at(BIAS + place));
        bias.and_then(InstrumentError::priors).map_or(0.0, |(normal, _)| normal)
    };
    let contradictions = [(0, Channel::Theta), (1, Channel::Phi)]
        .into_iter()
        .filter_map(|(axis, attitude)| {
            let channel = *INPUT_CHANNELS.get(axis)?;
            let steps = count as f64;
            let excess = sum[axis] / steps - (last[axis] - first[axis]) / length_s;
            let normal = libm::hypot(normal_of(channel), STANDARD_GRAVITY * normal_of(attitude));
            let variance = normal * normal + run.noise.input[axis] / length_s;
            if !(excess * excess > ENTER * variance) {
                return None;
            }
            let mean = forces[axis] / steps;
            let reversed = (excess - 2.0 * mean).abs() < REVERSED * excess.abs();
            Some(MeanForceContradiction { channel, mean, attitude, expected: mean - excess, reversed })
        })
        .collect();
    Some(contradictions)
}

fn output(record: &RunChannels, place: usize, from_s: f64, to_s: f64) -> Option<f64> {
    Some(record.outputs.get(place)?.as_ref()?.mean(from_s, to_s))
}

/// Velocity by airspeed and flow angles; the arms of the vanes average to zero.
fn velocity(record: &RunChannels, from_s: f64, to_s: f64) -> Option<[f64; 3]> {
    let [speed, alpha, beta] = all([0, 1, 2].map(|i| output(record, i, from_s, to_s)))?;
    Some(velocity_of_air_data(speed, alpha, beta))
}

fn all<const N: usize>(values: [Option<f64>; N]) -> Option<[f64; N]> {
    let mut whole = [0.0; N];
    for (to, from) in whole.iter_mut().zip(values) {
        *to = from?;
    }
    Some(whole)
}
