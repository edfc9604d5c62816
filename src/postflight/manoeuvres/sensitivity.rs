//! Control sensitivity: peak angular acceleration and peak rate in the first pulse, a radian of control.
//!
//! Consumes the channels, the manoeuvre and each channel's level in trim; produces per axis
//!     (peak of d(rate)/dt) / level     and     (peak of rate - trim) / level                           (1)
//! smoothed by local lines (half window a tenth of a second or two readings). Standard errors: white noise through the lines, the
//! channel's motion in trim, and the control's noise. Of either sign the larger is the peak, so a response below noise still has
//! one: it is marked as not significant. Source: ours.

use super::channels::{Channels, Rest};
use super::manoeuvre::Flown;
use super::record::{Measured, Sensitivity};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::signal::trace::Trace;

/// Greatest length of the first pulse, s.
const FIRST_S: f64 = 3.0;
/// Greatest length over which a step's level is averaged, s.
const STEP_MEAN_S: f64 = 5.0;
/// Lag of the response behind the pulse, s.
const LAG_S: f64 = 0.3;
/// Half duration of a flank, s.
const FLANK_S: f64 = 0.05;
/// Least significant response, in standard errors.
const ABOVE: f64 = 3.0;

/// Largest change of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Peak {
    /// The change from trim, in the channel's unit.
    pub(crate) change: Measured,
    pub(crate) time_s: f64,
}

/// Channels that respond to the control.
fn answering(control: Control) -> Vec<Channel> {
    let mut all = vec![Channel::P, Channel::Q, Channel::R];
    if control == Control::Collective {
        all.push(Channel::Az);
    }
    all
}

/// Time range in which the response is to the first pulse alone, s.
pub(crate) fn first_stretch(flown: &Flown) -> Option<(f64, f64)> {
    let first = flown.pulses.first()?;
    // The flank begins before half the level.
    Some((first.start_s - 0.1, (first.end_s + LAG_S).min(first.start_s + FIRST_S)))
}

/// The local lines over a stretch at the trace's own interval, at most 100 a second.
fn lines(trace: &Trace, from_s: f64, to_s: f64) -> Vec<(f64, crate::flight::signal::trace::LocalLine)> {
    let step_s = trace.interval_s().max(0.01);
    let times = trace.line_times(from_s, to_s, step_s).into_iter();
    times.filter_map(|time_s| Some((time_s, trace.line(time_s)?))).collect()
}

/// The largest change of a channel in a stretch; signed with `side` where the sign is known (1 or -1), the larger where it is 0.
pub(crate) fn peak(trace: &Trace, rest: &Rest, from_s: f64, to_s: f64, side: f64) -> Option<Peak> {
    let size = |value: f64| if side == 0.0 { (value - rest.mean).abs() } else { (value - rest.mean) * side };
    let all = lines(trace, from_s, to_s);
    let (time_s, line) = all.into_iter().max_by(|(_, a), (_, b)| size(a.value).total_cmp(&size(b.value)))?;
    let std = libm::sqrt(line.value_std * line.value_std + rest.motion * rest.motion);
    Some(Peak { change: Measured { value: line.value - rest.mean, std }, time_s })
}

/// Greatest minus least of a channel in a time range.
pub(crate) fn span(trace: &Trace, rest: &Rest, from_s: f64, to_s: f64) -> Option<Measured> {
    let most = peak(trace, rest, from_s, to_s, 1.0)?.change;
    let least = peak(trace, rest, from_s, to_s, -1.0)?.change;
    Some(Measured { value: most.value - least.value, std: libm::sqrt(most.std * most.std + least.std * least.std) })
}

/// Noise of the control's level, rad.
pub(crate) fn level_std(channels: &Channels, flown: &Flown) -> f64 {
    let Some((trace, first)) = channels.get(flown.control.channel()).zip(flown.pulses.first()) else { return 0.0 };
    let readings = (0.7 * (first.end_s - first.start_s).min(STEP_MEAN_S) / trace.interval_s()).max(1.0);
    // The level is relative to the median of the first second.
    let before = (1.0 / trace.interval_s()).max(1.0);
    trace.noise() * libm::sqrt(1.0 / readings + 0.5 * core::f64::consts::PI / before)
}

pub(crate) fn sensitivities(channels: &Channels, flown: &Flown, from_s: f64, to_s: f64) -> Vec<Sensitivity> {
    let Some(((first_s, last_s), first)) = first_stretch(flown).zip(flown.pulses.first()) else { return Vec::new() };
    let level = Measured { value: first.level, std: level_std(channels, flown) };
    let over = |peak: Measured| {
        let value = peak.value / level.value;
        let relative = level.std / level.value;
        Measured {
            value,
            std: libm::sqrt(peak.std * peak.std / (level.value * level.value) + value * value * relative * relative),
        }
    };
    let one = |channel: Channel| {
        let trace = channels.get(channel)?;
        let rest = Rest::of(trace, from_s, to_s)?;
        let peak = peak(trace, &rest, first_s, last_s, 0.0)?;
        // Only during the pulse: its end flank gives the larger acceleration, of opposite sign.
        let stands_s = (first.end_s - trace.half_window_s() - FLANK_S).max(first.start_s + FLANK_S);
        let slopes = lines(trace, first_s, last_s.min(stands_s)).into_iter();
        let steepest = slopes.max_by(|a, b| a.1.slope.abs().total_cmp(&b.1.slope.abs()));
        // Motion in trim has a time scale of about a second.
        let acceleration = steepest.filter(|_| channel != Channel::Az).map(|(_, line)| {
            over(Measured { value: line.slope, std: libm::sqrt(line.slope_std * line.slope_std + rest.motion * rest.motion) })
        });
        Some(Sensitivity {
            channel,
            acceleration,
            rate: over(peak.change),
            peak: peak.change,
            after_s: peak.time_s - first.start_s,
            significant: peak.change.value.abs() > ABOVE * peak.change.std,
        })
    };
    answering(flown.control).into_iter().filter_map(one).collect()
}
