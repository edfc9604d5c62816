//! Observability: channels not measured, instrument errors below the detection limit, axes with too little motion.
//!
//! The detection limit is the error whose F in `fault_selection` exceeds the threshold F_e even where the estimate is two
//! standard errors low,
//!     least = sqrt(F_e (c s^2 + sigma^2)) + 2 sqrt(c) s                                                (1)
//! (s the standard error for white residuals, c the factor for coloured ones, sigma the prior of healthy instruments). A scale
//! factor f or delay tau of one axis is observed through the motion of that axis, rms m, rms rate of change omega m. Where
//! another axis moves more (the busiest other, rms M), unmodelled cross-axis effects (gyro misalignment, platforms, curved
//! flight) reach the size of the error itself, so it is reported only where
//!     |f - 1| m > LEAK M,  |tau| omega m > LEAK M                                                     (2)

use super::fault_selection::{FaultSearch, candidates, enter_above, is_gusty};
use super::fit::{RunWithNoise, place_of};
use super::parameter::{
    ACCELEROMETER_PLACE, ALPHA_PLACE, INPUT_CHANNELS, InstrumentError, OUTPUT_CHANNELS, PARAMETERS, SHARED_BIAS,
};
use super::record::{ChannelError, InstrumentErrorKind, NotObservable, UnreportedReason};
use super::run_channels::RunChannels;
use crate::flight::channel::Channel;
use crate::flight::signal::series::Series;

/// What may leak from one axis into another: twice what is normal among healthy gyros.
const LEAK: f64 = 0.04;
/// Part of the busiest axis' motion that turns a vane enough for its arm alone, without the other vane's, to be estimated.
const ARM_PART: f64 = 0.4;
/// Interval over which the rate of change of a motion is taken, s.
const SLOPE_S: f64 = 0.2;
const GYRO: usize = 3;

/// Standard deviation of a series with the variance of its white noise subtracted.
pub(crate) fn motion_std(series: &Series) -> f64 {
    let count = series.len() as f64;
    let mean = series.samples().map(|(_, value)| value).sum::<f64>() / count;
    let square = series.samples().map(|(_, value)| (value - mean) * (value - mean)).sum::<f64>() / count;
    let noise = series.noise_std();
    libm::sqrt((square - noise * noise).max(0.0))
}

/// The least factor (less one) or lateness by (2) in one run, and this axis' motion as a part of that of the busiest other axis.
/// `None` where (2) does not apply.
fn least_in(run: &RunWithNoise, parameter: InstrumentError) -> Option<(f64, f64)> {
    // Incidence moves by pitching, sideslip by rolling and yawing, attitude each by its own; a vane's arm is felt by its turn.
    let axes: &[usize] = match (parameter.kind, parameter.channel()) {
        (InstrumentErrorKind::AlphaPlace(1) | InstrumentErrorKind::BetaPlace(2), _) => &[0],
        (InstrumentErrorKind::AlphaPlace(0), _) => &[1],
        (InstrumentErrorKind::BetaPlace(0), _) => &[2],
        (InstrumentErrorKind::Scale | InstrumentErrorKind::Timing, Some(Channel::P | Channel::Phi)) => &[0],
        (InstrumentErrorKind::Scale | InstrumentErrorKind::Timing, Some(Channel::Q | Channel::Theta | Channel::Alpha)) => &[1],
        (InstrumentErrorKind::Scale | InstrumentErrorKind::Timing, Some(Channel::R | Channel::Psi)) => &[2],
        (InstrumentErrorKind::Scale | InstrumentErrorKind::Timing, Some(Channel::Beta)) => &[0, 2],
        _ => return None,
    };
    let gyro = |axis: usize| run.record.inputs.get(GYRO + axis).and_then(Option::as_ref);
    let moves = |axis: usize| gyro(axis).map_or(0.0, motion_std);
    let own = axes.iter().copied().max_by(|a, b| moves(*a).total_cmp(&moves(*b)))?;
    let busiest = (0..3).filter(|axis| *axis != own).map(moves).fold(0.0, f64::max);
    let part = if busiest > 0.0 { moves(own) / busiest } else { f64::INFINITY };
    if matches!(parameter.kind, InstrumentErrorKind::AlphaPlace(_) | InstrumentErrorKind::BetaPlace(_)) {
        return Some((if part < ARM_PART { f64::INFINITY } else { 0.0 }, part));
    }
    let pace = if parameter.kind == InstrumentErrorKind::Timing { pace(run, gyro(own)?) } else { 1.0 };
    Some((LEAK / (part * pace).max(1e-6), part))
}

/// How fast a motion changes, omega of (2), 1/s.
fn pace(run: &RunWithNoise, series: &Series) -> f64 {
    let mean =
        |node: usize| series.mean(run.record.mesh.time_s(node) - 0.5 * SLOPE_S, run.record.mesh.time_s(node) + 0.5 * SLOPE_S);
    let apart = (libm::round(SLOPE_S / run.record.mesh.step_s) as usize).max(1);
    let pairs = run.record.mesh.nodes.saturating_sub(apart).max(1);
    let slope = |node: usize| (mean(node + apart) - mean(node)) / (apart as f64 * run.record.mesh.step_s);
    let square = (0..pairs).map(slope).map(|slope| slope * slope).sum::<f64>() / pairs as f64;
    libm::sqrt(square) / motion_std(series).max(1e-9)
}

/// (2) over all runs: the run where the axis moves most decides.
fn least_of_motion(runs: &[RunWithNoise], parameter: InstrumentError) -> Option<(f64, f64)> {
    let acted = runs.iter().filter(|run| run.active.contains(&parameter.index));
    acted.filter_map(|run| least_in(run, parameter)).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The part of the busiest axis' motion that a parameter's own axis has, where by (2) that is too little for such a value.
pub(crate) fn insufficient_motion(runs: &[RunWithNoise], parameter: InstrumentError, value: f64) -> Option<f64> {
    least_of_motion(runs, parameter).filter(|(least, _)| value.abs() < *least).map(|(_, part)| part)
}

/// Whether a factor or delay of an accelerometer across gravity is not named, for there is a bias of it: accelerometers that are
/// misaligned read a part of gravity as a bias and the same part of the load's changes, which correlate with its own reading.
pub(crate) fn may_be_misalignment(parameter: InstrumentError, mut faults: impl Iterator<Item = InstrumentError>) -> bool {
    let across = matches!(parameter.channel(), Some(Channel::Ax | Channel::Ay));
    let asked = across && matches!(parameter.kind, InstrumentErrorKind::Scale | InstrumentErrorKind::Timing);
    let beside = |one: InstrumentError| one.kind == InstrumentErrorKind::Bias && one.channel() == parameter.channel();
    asked && faults.any(beside)
}

/// An estimate that would improve the fit but is not reported as a fault, with the reason.
pub(crate) fn unreported(parameter: InstrumentError, reason: UnreportedReason, value: f64, std: f64) -> NotObservable {
    let value = if parameter.kind == InstrumentErrorKind::Scale { 1.0 + value } else { value };
    NotObservable::Unreported { error: named(parameter), value, std, reason }
}

fn named(parameter: InstrumentError) -> ChannelError {
    ChannelError { kind: parameter.kind, channel: parameter.channel() }
}

/// Parameters whose error would stay below the detection limit (1).
pub(crate) fn undetectable(found: &FaultSearch, number: usize) -> Vec<NotObservable> {
    let enter = enter_above(candidates(&found.runs, &found.point).len());
    let Some(run) = found.runs.get(number) else { return Vec::new() };
    let minimum = found.local.minimum(&found.point);
    let mut said = Vec::new();
    let mut rough = false;
    for index in 0..PARAMETERS {
        let parameter = InstrumentError::at(index);
        let place = place_of(number, index);
        if !parameter.can_be_fault() || !run.active.contains(&index) || index >= SHARED_BIAS {
            continue;
        }
        let error = named(parameter);
        if parameter.mimicked_by_gusts() && is_gusty(run) {
            rough = true;
            continue;
        }
        let shared =
            parameter.kind == InstrumentErrorKind::Bias && found.point.free.contains(&place_of(number, SHARED_BIAS + index));
        if found.point.free.contains(&place) || shared {
            continue;
        }
        // Of a sensor that is known to stand elsewhere nothing is missing.
        let (from, axis) = (ALPHA_PLACE, index.saturating_sub(ALPHA_PLACE) % 3);
        let known = |other: usize| found.point.free.contains(&place_of(number, from + 3 * other + axis));
        if (ALPHA_PLACE..ACCELEROMETER_PLACE + 3).contains(&index) && (0..4).any(known) {
            continue;
        }
        let released = found.local.released(&found.point, &minimum, place);
        let (Some(one), Some((normal, _))) = (released, found.point.priors(place)) else {
            said.push(NotObservable::NotExcited(error));
            continue;
        };
        let variance = found.local.colour(&found.runs, &[place]) * one.std * one.std;
        let least = libm::sqrt(enter * (variance + normal * normal)) + 2.0 * libm::sqrt(variance);
        let least = least_of_motion(&found.runs, parameter).map_or(least, |(leaked, _)| least.max(leaked));
        if least.is_infinite() {
            said.push(NotObservable::InsufficientMotion(error));
        } else if least > parameter.worth_finding() {
            said.push(NotObservable::BelowLimit(error, least));
        }
    }
    if rough {
        said.push(NotObservable::Gusts);
    }
    if run.record.outputs.get(5).is_some_and(Option::is_some) {
        said.push(NotObservable::HeadingBias);
    }
    if run.record.outputs.get(6).is_some_and(Option::is_some) {
        said.push(NotObservable::Altitude);
    }
    said.push(NotObservable::Controls);
    said
}

/// Channels that are not measured.
pub(crate) fn absent(record: &RunChannels) -> Vec<NotObservable> {
    let mut said = Vec::new();
    let inputs = INPUT_CHANNELS.iter().zip(&record.inputs).filter(|(_, series)| series.is_none());
    let inputs: Vec<Channel> = inputs.map(|(channel, _)| *channel).collect();
    if !inputs.is_empty() {
        said.push(NotObservable::NotMeasured(inputs));
    }
    if !record.velocities {
        said.push(NotObservable::VelocityUndetermined(record.inputs.iter().take(3).any(Option::is_none)));
    }
    let velocity = |channel: &Channel| !matches!(channel, Channel::Phi | Channel::Theta | Channel::Psi);
    for (channel, series) in OUTPUT_CHANNELS.iter().zip(&record.outputs) {
        if series.is_none() && (record.velocities || !velocity(channel)) {
            said.push(NotObservable::NotMeasured(vec![*channel]));
        }
    }
    said
}
