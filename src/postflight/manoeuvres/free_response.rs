//! The dominant oscillation after a manoeuvre, while no control moves.
//!
//! Consumes the channels and the manoeuvre; produces frequency and damping by a damped sine through all channels of the plane
//! at once (`damped_sine`), a logarithmic decrement of the clearest channel beside it, or the reason why there is none.
//! A control is still in a stretch over which it stays in a band of `STILL` of the manoeuvre's travel to either side, others
//! of the plane in one of three quarters of that (a rudder does more than an aileron to the same swing), those of the other plane
//! in one twice as wide. The longest such stretch is taken. Where a later
//! start gives another answer than chance explains, the later one counts and the first is said beside it.

use super::channels::Channels;
use super::damped_sine::{Bins, DampedSine, NODES_MIN, fit};
use super::decrement::decrement;
use super::manoeuvre::Flown;
use super::record::{Measured, Oscillation, Plane, Untold};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use core::f64::consts::PI;

/// Half width of the band in which a control is still, of its travel in the manoeuvre.
pub const STILL: f64 = 0.03;
/// Shorter stillness shows nothing, s.
const SHORTEST_S: f64 = 2.0;
/// Longer stretches are cut, s.
const LONGEST_S: f64 = 40.0;
/// Bins are not finer, s.
const BIN_S: f64 = 0.04;
/// No rigid-body oscillation is faster, rad/s.
const FASTEST: f64 = 12.0;
/// Cycles that must stand above the rest.
const CYCLES_MIN: f64 = 0.6;
/// Periods that the stretch must hold, so that a swing is told from a drift; or so many times over it must decay.
const PERIODS_MIN: f64 = 1.5;
const DECAYS: f64 = 2.5;
/// Cycles that must be left for a later start to count.
const CYCLES_LATER: f64 = 2.0;
/// Part of the motion about its drift that one damped sine must explain.
const EXPLAINED_MIN: f64 = 0.5;
/// Size over residual that is an oscillation.
const ABOVE: f64 = 3.0;
/// A damping ratio less certain is none.
const ZETA_STD: f64 = 0.1;
/// A start put off must change zeta by more, besides chance.
const CHANGE_MIN: f64 = 0.015;

/// The oscillation in the stretch after a manoeuvre starts and before the next one does.
///
/// # Errors
/// [`Untold`], why none can be given.
pub fn oscillation(channels: &Channels, flown: &Flown, until_s: f64) -> Result<Oscillation, Untold> {
    let (from_s, to_s) = stillness(channels, flown, until_s)?;
    let plane = Plane::of(flown.control);
    let seen: Vec<Channel> = plane.channels().into_iter().filter(|channel| channels.get(*channel).is_some()).collect();
    // Specific force is no better than the vane, and jumps with the control: only where the vane is missing.
    let seen: Vec<Channel> = match seen.as_slice() {
        [rate, vane, Channel::Az] => vec![*rate, *vane],
        _ => seen,
    };
    if seen.is_empty() {
        return Err(Untold::NoChannel("angular rate of its plane"));
    }
    let (mut begin_s, mut found) = (from_s, fitted(channels, &seen, from_s, to_s));
    let mut earlier = None;
    for _ in 0..4 {
        let Ok(now) = &mut found else { break };
        let later_s = begin_s + PI / now.damped;
        let Ok(later) = fitted(channels, &seen, later_s, to_s) else { break };
        // Of two fits, one within the other's stretch, the difference varies as the variances differ.
        let apart = |a: Measured, b: Measured| libm::sqrt((b.std * b.std - a.std * a.std).max(0.25 * b.std * b.std));
        let change = (later.zeta.value - now.zeta.value).abs();
        if change < CHANGE_MIN || change < 3.0 * apart(now.zeta, later.zeta) {
            break;
        }
        let (_, cycles) = visible(&later, to_s - later_s);
        if cycles < CYCLES_LATER || later.zeta.std > CHANGE_MIN {
            // Which of the two is right cannot be told: the difference is part of the error.
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
    (sine.omega, sine.zeta) = moved_with_start(channels, &seen, &sine, begin_s, to_s);
    if !(sine.zeta.std < ZETA_STD) {
        return Err(Untold::Uncertain(sine.omega, sine.zeta));
    }
    told(channels, flown, &seen, &sine, begin_s, to_s, earlier)
}

/// Frequency and damping with what they change by when the fit starts later, beyond chance, as part of their errors: other
/// modes than the one that swings die within the first period.
fn moved_with_start(channels: &Channels, seen: &[Channel], sine: &DampedSine, from_s: f64, to_s: f64) -> (Measured, Measured) {
    let (mut omega_excess, mut zeta_excess) = (0.0f64, 0.0f64);
    for half_periods in [1.0, 2.0] {
        let later_s = from_s + half_periods * PI / sine.damped;
        let Ok(later) = fitted(channels, seen, later_s, to_s) else { break };
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

/// The longest stretch in which no control moves.
pub fn stillness(channels: &Channels, flown: &Flown, until_s: f64) -> Result<(f64, f64), Untold> {
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
        return Err(Untold::StillMoves(breaker, to_s - from_s));
    }
    Ok((from_s, to_s.min(from_s + LONGEST_S)))
}

fn bins(channels: &Channels, seen: &[Channel], from_s: f64, to_s: f64) -> Vec<Bins> {
    let traces = || seen.iter().filter_map(|channel| channels.get(*channel));
    let width_s = traces().map(|trace| trace.interval_s()).fold(BIN_S, f64::max);
    let shifted = |bin: Option<(f64, f64)>| bin.map(|(t, x)| (t - from_s, x));
    traces().map(|trace| trace.binned(from_s, to_s, width_s).into_iter().map(shifted).collect()).collect()
}

/// How far the clearest channel stands above its residual at the start, and for how many cycles.
fn visible(sine: &DampedSine, length_s: f64) -> (f64, f64) {
    let above = sine.channels.iter().map(|fit| fit.size() / fit.residual).fold(0.0, f64::max);
    let visible_s = if sine.decay > 0.0 { libm::log(above.max(1.0)) / sine.decay } else { length_s };
    (above, visible_s.min(length_s) * sine.damped / (2.0 * PI))
}

fn fitted(channels: &Channels, seen: &[Channel], from_s: f64, to_s: f64) -> Result<DampedSine, Untold> {
    let lanes = bins(channels, seen, from_s, to_s);
    let length_s = to_s - from_s;
    let width_s = length_s / lanes.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
    let fastest = FASTEST.min(0.3 * 2.0 * PI / width_s);
    let slowest = 2.0 * PI * CYCLES_MIN / length_s;
    if length_s < SHORTEST_S || lanes.iter().any(|lane| lane.iter().flatten().count() < NODES_MIN) {
        return Err(Untold::TooFewCycles(0.0));
    }
    let sine = fit(&lanes, slowest, fastest).ok_or(Untold::NoOscillation(0.0, 0.0))?;
    let (above, seen_cycles) = visible(&sine, length_s);
    if above < ABOVE || sine.explained < EXPLAINED_MIN {
        return Err(Untold::NoOscillation(sine.explained.max(0.0), above));
    }
    let periods = length_s * sine.damped / (2.0 * PI);
    if seen_cycles < CYCLES_MIN || sine.damped < 1.05 * slowest || (periods < PERIODS_MIN && sine.decay * length_s < DECAYS) {
        return Err(Untold::TooFewCycles(seen_cycles));
    }
    if !(sine.omega.std < 0.15 * sine.omega.value && sine.zeta.std < ZETA_STD) {
        return Err(Untold::Uncertain(sine.omega, sine.zeta));
    }
    Ok(sine)
}

fn told(
    channels: &Channels,
    flown: &Flown,
    seen: &[Channel],
    sine: &DampedSine,
    from_s: f64,
    to_s: f64,
    earlier: Option<(f64, Measured)>,
) -> Result<Oscillation, Untold> {
    let lanes = bins(channels, seen, from_s, to_s);
    let clearest =
        lanes.iter().zip(&sine.channels).max_by(|(_, a), (_, b)| (a.size() / a.residual).total_cmp(&(b.size() / b.residual)));
    let beside = clearest.and_then(|(lane, fit)| {
        let [_, _, offset, drift] = fit.coefficients;
        let about: Vec<(f64, f64)> = lane.iter().flatten().map(|(t, x)| (*t, x - offset - drift * t)).collect();
        decrement(&about, fit.residual)
    });
    let (_, cycles) = visible(sine, to_s - from_s);
    let control = channels.get(flown.control.channel());
    Ok(Oscillation {
        omega: sine.omega,
        zeta: sine.zeta,
        from_s,
        to_s,
        cycles,
        explained: sine.explained,
        channels: seen.iter().copied().zip(sine.channels.iter().map(|fit| fit.size())).collect(),
        control_motion: control.map_or(0.0, |trace| super::manoeuvre::travel(trace, from_s, to_s) / flown.travel),
        decrement: beside,
        earlier,
    })
}
