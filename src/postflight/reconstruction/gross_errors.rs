//! Gross errors in a whole record: a reversed sign, another unit, two channels exchanged; tested before any estimation.
//!
//! Consumes a record; tests each such error of one channel or of one group of them by `kinematic_agreement` (2) over windows
//! that overlap by half. An error is reported where its gain is above `THRESHOLD`, with every other error within `RIVAL` of it,
//! which cannot be distinguished. Outputs count where their increments exceed their noise.
//! Returns `None` where no output contradicts the kinematics, or no error explains it.

use super::run_channels::RunChannels;
use crate::flight::channel::Channel;
use crate::realtime::estimation::screening::gross_error::{GROSS_ERRORS, GrossError};
use crate::realtime::estimation::screening::kinematic_agreement::{
    Agreement, COMPARED, CorrectionGain, OUTPUT_CHANNELS, OutputRates, RIVAL, SIGNAL, THRESHOLD, WINDOW_S, by_arm,
    compared_channel, compared_increments, compared_output, contradicts, correction_gain, likeliest, output_rates,
};

/// Length of the mean at either end of a window, s; steps of a window over which the kinematics are constant.
const END_S: f64 = 0.1;
const PARTS: usize = 8;
const WINDOWS_MIN: usize = 8;

/// A gross error of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct GrossFinding {
    /// The most likely error, and those that cannot be distinguished from it.
    pub either: Vec<&'static GrossError>,
    /// The output that shows it, and its R2 = 1 - a as recorded and corrected.
    pub shown: (Channel, f64, f64),
}

/// Tests a record for gross errors.
pub fn gross_error(record: &RunChannels) -> Option<GrossFinding> {
    let as_recorded = agreement(record, None);
    let windows = (record.mesh.length_s() / WINDOW_S).max(1.0);
    if !contradicts(&as_recorded) {
        return None;
    }
    // An error of a group needs all of its channels.
    let measured = |channel: &Channel| record.series(*channel).is_some() || *channel == Channel::Psi;
    let testable = GrossError::ALL.iter().filter(|error| error.channels().iter().all(measured));
    let gains = testable.filter_map(|error| {
        let corrected = agreement(record, Some(error));
        Some((error, correction_gain(error, &as_recorded, &corrected, windows)?))
    });
    let best = likeliest::<GROSS_ERRORS>(gains, RIVAL);
    let (_, CorrectionGain { output, a, .. }) = *best.first().filter(|(_, found)| found.gain > THRESHOLD)?;
    let either = best.iter().map(|(error, _)| *error).collect();
    Some(GrossFinding { either, shown: (compared_channel(output), 1.0 - a[0], 1.0 - a[1]) })
}

/// a by output; `None` where it is not measured, no kinematics contain it, or its increments are within noise.
fn agreement(record: &RunChannels, error: Option<&GrossError>) -> Agreement {
    let corrected_by = |channel: Channel| error.map_or((channel, 1.0), |error| error.corrected_by(channel));
    let raw = |channel: Channel, from_s: f64, to_s: f64| -> Option<f64> {
        let (whose, factor) = corrected_by(channel);
        Some(factor * record.series(whose)?.mean(from_s, to_s))
    };
    let read = |channel: Channel, from_s: f64, to_s: f64| -> Option<f64> {
        let reading = raw(channel, from_s, to_s)?;
        let gyros = [Channel::P, Channel::Q, Channel::R];
        let rates = gyros.map(|gyro| raw(gyro, from_s, to_s).unwrap_or(0.0));
        let growth = gyros.map(|gyro| {
            let at = |time_s: f64| raw(gyro, time_s - 0.5 * END_S, time_s + 0.5 * END_S);
            at(to_s).zip(at(from_s)).map_or(0.0, |(after, before)| (after - before) / (to_s - from_s))
        });
        let speed = raw(Channel::Tas, from_s, to_s).unwrap_or(f64::INFINITY);
        Some(reading - by_arm(channel, rates, growth, speed, record.vane_place, record.accelerometer_place))
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
        let increments = compared_increments(moved, &integral(&read, from_s));
        pairs.iter_mut().zip(increments).for_each(|(pairs, pair)| pairs.extend(pair));
    }
    core::array::from_fn(|k| {
        let pairs = pairs.get(k)?;
        if pairs.len() < WINDOWS_MIN {
            return None;
        }
        let (whose, factor) = corrected_by(compared_output(k));
        let source = record.series(whose)?;
        let averaged = (END_S / source.interval_s()?).max(1.0);
        let noise = 2.0 * factor * factor * source.noise_std() * source.noise_std() / averaged;
        let signal = variance(pairs.iter().map(|pair| pair.0));
        (signal > SIGNAL * noise && signal > 0.0).then(|| variance(pairs.iter().map(|pair| pair.0 - pair.1)) / signal)
    })
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

/// Integral of the kinematic rates over the window from `from_s`.
fn integral(read: &impl Fn(Channel, f64, f64) -> Option<f64>, from_s: f64) -> OutputRates {
    let mut sum = OutputRates::ZERO;
    let step_s = WINDOW_S / PARTS as f64;
    for part in 0..PARTS {
        let (from_s, to_s) = (from_s + step_s * part as f64, from_s + step_s * (part + 1) as f64);
        sum.integrate(&output_rates(|channel| read(channel, from_s, to_s)).unwrap_or_default(), step_s);
    }
    sum
}
