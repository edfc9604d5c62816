//! The state before a manoeuvre: speed, climb, density, and how steady it was.
//!
//! Consumes the channels over the stretch before a control moves, at most `WINDOW_S`; produces means with standard errors of
//! coloured readings (one independent value a second), rates of change by lines, and reasons why it is not steady.

use super::channels::Channels;
use super::record::{Measured, NotEstimable, TrimState};
use crate::flight::channel::Channel;
use crate::flight::signal::trace::Trace;
use crate::realtime::estimation::trim::STEADY_RATE_RMS;

/// Greatest length of the window, s.
const WINDOW_S: f64 = 3.0;
/// Least length of the window, s.
const SHORTEST_S: f64 = 0.5;
/// Time before half the level of a pulse from which the control may move already, s.
const HAND_S: f64 = 0.25;
/// Largest rate of change of a steady airspeed, m/s^2.
const STEADY_ACCELERATION: f64 = 0.5;

/// The window before a manoeuvre that starts at that time, after what ended before it, s.
pub(crate) fn window(begin_s: f64, start_s: f64) -> Result<(f64, f64), NotEstimable> {
    let to_s = start_s - HAND_S;
    let from_s = begin_s.max(to_s - WINDOW_S);
    if to_s - from_s < SHORTEST_S { Err(NotEstimable::NoTrim) } else { Ok((from_s, to_s)) }
}

pub(crate) fn state(channels: &Channels, from_s: f64, to_s: f64) -> TrimState {
    let trace = |channel: Channel| channels.get(channel);
    let mean = |channel: Channel| trace(channel).and_then(|trace| trace.mean(from_s, to_s));
    let independent = (to_s - from_s).max(1.0);
    let tas = mean(Channel::Tas).map(|(value, std, _)| Measured { value, std: std / libm::sqrt(independent) });
    let change = |channel: Channel| trace(channel).and_then(|trace| slope(trace, from_s, to_s));
    let acceleration = change(Channel::Tas);
    let mut unsteady = Vec::new();
    let rates = [Channel::P, Channel::Q, Channel::R].map(|channel| {
        let (mean, std, _) = mean(channel)?;
        let rms = libm::sqrt(mean * mean + std * std);
        if rms > STEADY_RATE_RMS {
            let name = channel.name(crate::flight::channel::ControlNames::Rotorcraft);
            unsteady.push(format!("{name} is {rms:.3} rad/s rms"));
        }
        Some(rms)
    });
    if let Some(Measured { value, std }) = acceleration
        && value.abs() > STEADY_ACCELERATION + 2.0 * std
    {
        unsteady.push(format!("airspeed changes by {value:+.2} m/s^2"));
    }
    TrimState {
        from_s,
        to_s,
        tas,
        acceleration,
        rho: mean(Channel::Rho).map(|(value, _, _)| value),
        altitude: mean(Channel::Altitude).map(|(value, _, _)| value),
        climb: change(Channel::Altitude),
        rates,
        unsteady,
    }
}

/// Slope of a line through the window, with a standard error in which readings within a quarter of the window count as one.
fn slope(trace: &Trace, from_s: f64, to_s: f64) -> Option<Measured> {
    let (mean, _, count) = trace.mean(from_s, to_s)?;
    let middle_s = trace.within(from_s, to_s).map(|(t, _)| t / count).sum::<f64>();
    let (sxx, sxy) = trace
        .within(from_s, to_s)
        .fold((0.0, 0.0), |(a, b), (t, x)| (a + (t - middle_s) * (t - middle_s), b + (t - middle_s) * (x - mean)));
    if !(sxx > 0.0) || count < 4.0 {
        return None;
    }
    let value = sxy / sxx;
    let left: f64 = trace.within(from_s, to_s).map(|(t, x)| x - mean - value * (t - middle_s)).map(|e| e * e).sum();
    Some(Measured { value, std: libm::sqrt(left / (count - 2.0) / sxx * (count / 4.0).max(1.0)) })
}
