//! The dominant oscillation after a manoeuvre, while no control moves.
//!
//! Consumes the channels and the manoeuvre; produces frequency and damping by a damped sine through all channels of the plane
//! at once (`damped_sine`) with a logarithmic decrement of the clearest channel, or the reason why there is none.
//! A control is at rest in a time range over which it stays within [`STILL`] of the manoeuvre's travel to either side, others
//! of the plane within three quarters of that (a rudder excites more than an aileron), those of the other plane within twice.
//! The longest such range is taken. Where the fit from a later start differs significantly, the later one is reported, with the
//! first beside it. Source: ours; `damped_sine` and `decrement` have theirs.

use super::channels::Channels;
use super::damped_sine::{Bins, DampedSine, NODES_MIN, fit};
use super::decrement::decrement;
use super::manoeuvre::Flown;
use super::record::{FreeOscillation, Measured, NotEstimable, Plane};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use core::f64::consts::PI;

/// Half width of the band of a control at rest, relative to its travel in the manoeuvre.
pub(crate) const STILL: f64 = 0.03;
/// Least length of a free response, s.
const SHORTEST_S: f64 = 2.0;
/// Greatest length of a free response, s.
const LONGEST_S: f64 = 40.0;
/// Least width of bins, s.
const BIN_S: f64 = 0.04;
/// Upper limit of a rigid-body oscillation, rad/s.
const FASTEST: f64 = 12.0;
/// Least number of cycles above the residual.
const CYCLES_MIN: f64 = 0.6;
/// Least length in periods, to distinguish an oscillation from a drift; or in decay times.
const PERIODS_MIN: f64 = 1.5;
const DECAYS: f64 = 2.5;
/// Least number of cycles of a fit from a later start.
const CYCLES_LATER: f64 = 2.0;
/// Least part of the variance about the drift that the damped sine explains.
const EXPLAINED_MIN: f64 = 0.5;
/// Least amplitude over residual.
const ABOVE: f64 = 3.0;
/// Largest standard error of a damping ratio that is reported.
const ZETA_STD: f64 = 0.1;
/// Least change of zeta by a later start, besides three standard errors.
const CHANGE_MIN: f64 = 0.015;

/// The oscillation between the start of a manoeuvre and that of the next.
///
/// # Errors
/// [`NotEstimable`] with the reason where there is none.
pub(crate) fn oscillation(channels: &Channels, flown: &Flown, until_s: f64) -> Result<FreeOscillation, NotEstimable> {
    let (from_s, to_s) = stillness(channels, flown, until_s)?;
    let plane = Plane::of(flown.control);
    let responding: Vec<Channel> = plane.channels().into_iter().filter(|channel| channels.get(*channel).is_some()).collect();
    // Specific force jumps with the control: used only where the vane is missing.
    let responding: Vec<Channel> = match responding.as_slice() {
        [rate, vane, Channel::Az] => vec![*rate, *vane],
        _ => responding,
    };
    if responding.is_empty() {
        return Err(NotEstimable::NoChannel("angular rate of its plane"));
    }
    let (mut begin_s, mut found) = (from_s, fitted(channels, &responding, from_s, to_s));
    let mut earlier = None;
    for _ in 0..4 {
        let Ok(now) = &mut found else { break };
        let later_s = begin_s + PI / now.damped;
        let Ok(later) = fitted(channels, &responding, later_s, to_s) else { break };
        // The second fit's data are part of the first's: var(difference) = difference of variances.
        let apart = |a: Measured, b: Measured| libm::sqrt((b.std * b.std - a.std * a.std).max(0.25 * b.std * b.std));
        let change = (later.zeta.value - now.zeta.value).abs();
        if change < CHANGE_MIN || change < 3.0 * apart(now.zeta, later.zeta) {
            break;
        }
        let (_, cycles) = amplitude_over_residual(&later, to_s - later_s);
        if cycles < CYCLES_LATER || later.zeta.std > CHANGE_MIN {
            // Neither can be preferred: the difference is added to the standard error.
            let widened = |a: Measured, b: Measured| {
                let apart = b.value - a.value;
                Measured { value: a.value, std: libm::sqrt(a.std * a.std + apart * apart) }
            };
            (now.omega, now.zeta) = (widened(now.omega, later.omega), widened(now.zeta, later.zeta));
            break;
        }
        earlier = earlier.or(Some((begin_s, now.zeta)));
        (begin_s, found) = (later_s, Ok(later));
    }
    let mut sine = found?;
    (sine.omega, sine.zeta) = with_start_uncertainty(channels, &responding, &sine, begin_s, to_s);
    if !(sine.zeta.std < ZETA_STD) {
        return Err(NotEstimable::Uncertain(sine.omega, sine.zeta));
    }
    free_oscillation(channels, flown, &responding, &sine, begin_s, to_s, earlier)
}

/// Frequency and damping with their change by a later start, beyond chance, added to their standard errors: other modes decay
/// within the first period.
fn with_start_uncertainty(
    channels: &Channels,
    responding: &[Channel],
    sine: &DampedSine,
    from_s: f64,
    to_s: f64,
) -> (Measured, Measured) {
    let (mut omega_excess, mut zeta_excess) = (0.0f64, 0.0f64);
    for half_periods in [1.0, 2.0] {
        let later_s = from_s + half_periods * PI / sine.damped;
        let Ok(later) = fitted(channels, responding, later_s, to_s) else { break };
        let excess = |a: Measured, b: Measured| {
            let change = b.value - a.value;
            change * change - (b.std * b.std - a.std * a.std).max(0.0)
        };
        omega_excess = omega_excess.max(excess(sine.omega, later.omega));
        zeta_excess = zeta_excess.max(excess(sine.zeta, later.zeta));
    }
    let with = |one: Measured, excess: f64| Measured { value: one.value, std: libm::sqrt(one.std * one.std + excess) };
    (with(sine.omega, omega_excess), with(sine.zeta, zeta_excess))
}

/// The longest time range in which no control moves, s.
pub(crate) fn stillness(channels: &Channels, flown: &Flown, until_s: f64) -> Result<(f64, f64), NotEstimable> {
    let begin_s = flown.start_s();
    let end_s = until_s.min(begin_s + 2.0 * LONGEST_S);
    let plane = Plane::of(flown.control);
    let mut tracks: Vec<(Control, f64, Bins)> = Vec::new();
    for control in Control::ALL {
        let Some(trace) = channels.get(control.channel()) else { continue };
        let factor = if control == flown.control {
            1.0
        } else if Plane::of(control) == plane {
            0.75
        } else {
            2.0
        };
        let band = 2.0 * (STILL * factor * flown.travel + 3.0 * trace.noise());
        tracks.push((control, band, trace.binned(begin_s, end_s, BIN_S)));
    }
    let nodes = tracks.iter().map(|(_, _, bins)| bins.len()).max().unwrap_or(0);
    let (mut best, mut breaker) = ((0, 0), flown.control);
    let mut from = 0;
    while from + (best.1 - best.0) < nodes {
        let mut ranges: Vec<(f64, f64)> = vec![(f64::INFINITY, f64::NEG_INFINITY); tracks.len()];
        let mut to = from;
        'grow: while to < nodes {
            for ((control, band, bins), range) in tracks.iter().zip(&mut ranges) {
                let Some((_, value)) = bins.get(to).copied().flatten() else { continue };
                *range = (range.0.min(value), range.1.max(value));
                if range.1 - range.0 > *band {
                    if to - from >= best.1 - best.0 {
                        breaker = *control;
                    }
                    break 'grow;
                }
            }
            to += 1;
        }
        if to - from > best.1 - best.0 {
            best = (from, to);
        }
        from += 1;
    }
    let at = |node: usize| begin_s + BIN_S * node as f64;
    let (from_s, to_s) = (at(best.0), at(best.1).min(end_s));
    if to_s - from_s < SHORTEST_S {
        return Err(NotEstimable::StillMoves(breaker, to_s - from_s));
    }
    Ok((from_s, to_s.min(from_s + LONGEST_S)))
}

fn bins(channels: &Channels, responding: &[Channel], from_s: f64, to_s: f64) -> Vec<Bins> {
    let traces = || responding.iter().filter_map(|channel| channels.get(*channel));
    let width_s = traces().map(|trace| trace.interval_s()).fold(BIN_S, f64::max);
    let shifted = |bin: Option<(f64, f64)>| bin.map(|(t, x)| (t - from_s, x));
    traces().map(|trace| trace.binned(from_s, to_s, width_s).into_iter().map(shifted).collect()).collect()
}

/// Largest ratio of amplitude to residual at the start, and the cycles until it is one.
fn amplitude_over_residual(sine: &DampedSine, length_s: f64) -> (f64, f64) {
    let above = sine.channels.iter().map(|fit| fit.size() / fit.residual).fold(0.0, f64::max);
    let visible_s = if sine.decay > 0.0 { libm::log(above.max(1.0)) / sine.decay } else { length_s };
    (above, visible_s.min(length_s) * sine.damped / (2.0 * PI))
}

fn fitted(channels: &Channels, responding: &[Channel], from_s: f64, to_s: f64) -> Result<DampedSine, NotEstimable> {
    let lanes = bins(channels, responding, from_s, to_s);
    let length_s = to_s - from_s;
    let width_s = length_s / lanes.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
    let fastest = FASTEST.min(0.3 * 2.0 * PI / width_s);
    let slowest = 2.0 * PI * CYCLES_MIN / length_s;
    if length_s < SHORTEST_S || lanes.iter().any(|lane| lane.iter().flatten().count() < NODES_MIN) {
        return Err(NotEstimable::TooFewCycles(0.0));
    }
    let sine = fit(&lanes, slowest, fastest).ok_or(NotEstimable::NoOscillation(0.0, 0.0))?;
    let (above, cycles) = amplitude_over_residual(&sine, length_s);
    if above < ABOVE || sine.explained < EXPLAINED_MIN {
        return Err(NotEstimable::NoOscillation(sine.explained.max(0.0), above));
    }
    let periods = length_s * sine.damped / (2.0 * PI);
    if cycles < CYCLES_MIN || sine.damped < 1.05 * slowest || (periods < PERIODS_MIN && sine.decay * length_s < DECAYS) {
        return Err(NotEstimable::TooFewCycles(cycles));
    }
    if !(sine.omega.std < 0.15 * sine.omega.value && sine.zeta.std < ZETA_STD) {
        return Err(NotEstimable::Uncertain(sine.omega, sine.zeta));
    }
    Ok(sine)
}

fn free_oscillation(
    channels: &Channels,
    flown: &Flown,
    responding: &[Channel],
    sine: &DampedSine,
    from_s: f64,
    to_s: f64,
    earlier: Option<(f64, Measured)>,
) -> Result<FreeOscillation, NotEstimable> {
    let lanes = bins(channels, responding, from_s, to_s);
    let clearest =
        lanes.iter().zip(&sine.channels).max_by(|(_, a), (_, b)| (a.size() / a.residual).total_cmp(&(b.size() / b.residual)));
    let by_decrement = clearest.and_then(|(lane, fit)| {
        let [_, _, offset, drift] = fit.coefficients;
        let about: Vec<(f64, f64)> = lane.iter().flatten().map(|(t, x)| (*t, x - offset - drift * t)).collect();
        decrement(&about, fit.residual)
    });
    let (_, cycles) = amplitude_over_residual(sine, to_s - from_s);
    let control = channels.get(flown.control.channel());
    Ok(FreeOscillation {
        omega: sine.omega,
        zeta: sine.zeta,
        from_s,
        to_s,
        cycles,
        explained: sine.explained,
        channels: responding.iter().copied().zip(sine.channels.iter().map(|fit| fit.size())).collect(),
        control_motion: control.map_or(0.0, |trace| super::manoeuvre::travel(trace, from_s, to_s) / flown.travel),
        decrement: by_decrement,
        earlier,
    })
}
