//! Coupling: response of the other axes relative to the axis that the control is there for.
//!
//! Consumes the rates over the manoeuvre; produces the ratio of root mean squares about trim, the variance of white noise
//! subtracted from both,
//!     ratio = sqrt((rms_off^2 - noise_off^2) / (rms_on^2 - noise_on^2))                                (1)
//! with its standard error from the channels' motion in trim, and when the off-axis channel first exceeds [`COUPLING_LEVEL`] of
//! the on-axis peak. A ratio below twice its standard error is not significant. Source: ours.

use super::channels::{Channels, Rest};
use super::manoeuvre::Flown;
use super::record::{COUPLING_LEVEL, Coupling, Measured, NotEstimable, on_axis};
use super::sensitivity::peak;
use crate::flight::channel::Channel;
use crate::flight::signal::trace::Trace;

/// Time after the last pulse that counts as response to it, s.
const AFTER_S: f64 = 3.0;
/// Length of the response to a step, s.
const STEP_S: f64 = 6.0;

/// Time range of a manoeuvre with its response, s.
pub(crate) fn stretch(flown: &Flown, until_s: f64) -> (f64, f64) {
    let start_s = flown.start_s();
    let held = flown.pulses.last().is_some_and(|pulse| pulse.end_s - pulse.start_s > STEP_S);
    let end_s = if held { flown.pulses.last().map_or(start_s, |pulse| pulse.start_s) + STEP_S } else { flown.end_s() + AFTER_S };
    (start_s - 0.1, end_s.min(until_s))
}

/// (1) of every off-axis rate.
///
/// # Errors
/// [`NotEstimable`] where the on-axis channel is missing or does not respond.
pub(crate) fn couplings(
    channels: &Channels,
    flown: &Flown,
    trim: (f64, f64),
    until_s: f64,
) -> Result<Vec<Coupling>, NotEstimable> {
    let on = on_axis(flown.control);
    let trace = channels.get(on).ok_or(NotEstimable::NoChannel("on-axis channel"))?;
    let rest = Rest::of(trace, trim.0, trim.1).ok_or(NotEstimable::NoTrim)?;
    let (from_s, to_s) = stretch(flown, until_s);
    let main = rms_about_trim(trace, &rest, from_s, to_s).ok_or(NotEstimable::BelowNoise)?;
    let highest = peak(trace, &rest, from_s, to_s, 0.0).ok_or(NotEstimable::BelowNoise)?;
    if main.value < 3.0 * main.std {
        return Err(NotEstimable::BelowNoise);
    }
    let one = |channel: Channel| {
        let trace = channels.get(channel)?;
        let rest = Rest::of(trace, trim.0, trim.1)?;
        let off = rms_about_trim(trace, &rest, from_s, to_s)?;
        let ratio = off.value / main.value;
        let relative = main.std / main.value;
        // Motion in trim adds to the response in quadrature where independent of it, linearly where correlated.
        let std = libm::sqrt(off.std * off.std / (main.value * main.value) + ratio * ratio * relative * relative);
        let level = (COUPLING_LEVEL * highest.change.value.abs()).max(4.0 * rest.deviation_std());
        let step_s = trace.interval_s().max(0.01);
        let times = trace.line_times(from_s, to_s - step_s, step_s);
        let mut beyond = times.into_iter().filter(|t| trace.line(*t).is_some_and(|line| (line.value - rest.mean).abs() > level));
        Some(Coupling {
            channel,
            ratio: Measured { value: ratio, std },
            significant: off.value > 2.0 * off.std,
            exceeds_after_s: beyond.next().map(|time_s| time_s - flown.start_s()),
        })
    };
    let others = [Channel::P, Channel::Q, Channel::R].into_iter().filter(|channel| *channel != on);
    Ok(others.filter_map(one).collect())
}

/// Root mean square about trim, the noise variance subtracted.
fn rms_about_trim(trace: &Trace, rest: &Rest, from_s: f64, to_s: f64) -> Option<Measured> {
    let (count, squares) =
        trace.within(from_s, to_s).fold((0.0, 0.0), |(n, sum), (_, x)| (n + 1.0, sum + (x - rest.mean) * (x - rest.mean)));
    if count < 5.0 {
        return None;
    }
    let noise = trace.noise() * trace.noise();
    let value = libm::sqrt((squares / count - noise).max(0.0));
    // Variance of the mean square: noise times motion, and the noise variance, known to sqrt(2/n); its root near zero.
    let noise_std = noise * libm::sqrt(2.0 / count);
    let by_noise = noise_std / (2.0 * value).max(libm::sqrt(noise_std)).max(f64::MIN_POSITIVE);
    Some(Measured { value, std: libm::sqrt(by_noise * by_noise + noise / count + rest.motion * rest.motion) })
}
