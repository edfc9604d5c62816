//! Manoeuvres of one test point, and their repeatability.
//!
//! Consumes manoeuvres with their trims; produces groups (same control, pulses of the same lengths, same trim, same size of the
//! amplitude, either sign) and for each channel the scatter between runs over the mean response,
//!     scatter^2 = mean over time of var over runs of (x_i - trim_i) A / a_i                            (1)
//! with a_i the run's signed amplitude and A the group's mean size, so that left and right are compared; beside it the scatter of
//! white noise alone. Times are relative to half the first pulse's level; readings are averaged over a tenth of a second.
//! Source: ours. Returns [`NotEstimable`] for fewer than `RUNS_A_POINT` runs.

use super::channels::{Channels, Rest};
use super::coupling::stretch;
use super::manoeuvre::Flown;
use super::record::{Manoeuvre, Measured, NotEstimable, Scatter, TestPoint, TrimState};
use crate::flight::channel::Channel;

/// Relative tolerance of equal amplitudes.
pub(crate) const SAME_AMPLITUDE: f64 = 0.15;
/// Relative and absolute (s) tolerance of equal lengths of pulses.
const SAME_LENGTH: (f64, f64) = (0.25, 0.15);
/// Relative tolerance of equal airspeeds and densities.
const SAME_AIR: f64 = 0.05;
/// Tolerance of equal rates of climb, m/s, besides their standard errors.
const SAME_CLIMB: f64 = 1.5;
/// Time compared before the control moves, s.
const LEAD_S: f64 = 0.5;
/// Width of the averages, s.
const BIN_S: f64 = 0.1;
/// Channels that are compared.
const COMPARED: [Channel; 9] =
    [Channel::P, Channel::Q, Channel::R, Channel::Alpha, Channel::Beta, Channel::Phi, Channel::Theta, Channel::Ay, Channel::Az];

/// A manoeuvre with the run that it belongs to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunManoeuvre<'a> {
    /// Run, and place of the manoeuvre in it.
    pub(crate) place: (usize, usize),
    pub(crate) manoeuvre: &'a Manoeuvre,
    pub(crate) flown: &'a Flown,
    /// The run's channels.
    pub(crate) channels: &'a Channels,
    /// Start of the next manoeuvre, s.
    pub(crate) until_s: f64,
}

fn near(a: f64, b: f64, part: f64) -> bool {
    (a - b).abs() <= part * a.abs().max(b.abs())
}

fn same_trim(a: &TrimState, b: &TrimState) -> bool {
    let air = |a: Option<f64>, b: Option<f64>| a.zip(b).is_none_or(|(a, b)| near(a, b, SAME_AIR));
    let climbs = a
        .climb
        .zip(b.climb)
        .is_none_or(|(a, b)| (a.value - b.value).abs() < SAME_CLIMB + 2.0 * libm::sqrt(a.std * a.std + b.std * b.std));
    climbs && air(a.rho, b.rho) && air(a.tas.map(|tas| tas.value), b.tas.map(|tas| tas.value))
}

/// Whether two manoeuvres differ in sign and size alone.
pub(crate) fn alike(a: &Manoeuvre, b: &Manoeuvre) -> bool {
    let (Ok(trim), Ok(other)) = (&a.trim, &b.trim) else { return false };
    let lengths = a.pulses.iter().zip(&b.pulses).all(|(a, b)| {
        let (x, y) = (a.end_s - a.start_s, b.end_s - b.start_s);
        // The length of a step does not count.
        let held = !a.ended && !b.ended;
        held || near(x, y, SAME_LENGTH.0) || (x - y).abs() < SAME_LENGTH.1
    });
    let first = a.amplitude * b.amplitude > 0.0;
    let signs = a.pulses.iter().zip(&b.pulses).all(|(a, b)| (a.level * b.level > 0.0) == first);
    a.control == b.control && a.pulses.len() == b.pulses.len() && lengths && signs && same_trim(trim, other)
}

/// Groups of manoeuvres; `same` compares each with the first of a group.
pub(crate) fn grouped<'a>(all: &[RunManoeuvre<'a>], same: impl Fn(&Manoeuvre, &Manoeuvre) -> bool) -> Vec<Vec<RunManoeuvre<'a>>> {
    let mut groups: Vec<Vec<RunManoeuvre<'a>>> = Vec::new();
    for one in all {
        match groups.iter_mut().find(|group| group.first().is_some_and(|first| same(first.manoeuvre, one.manoeuvre))) {
            Some(group) => group.push(*one),
            None => groups.push(vec![*one]),
        }
    }
    groups
}

pub(crate) fn points(all: &[RunManoeuvre<'_>]) -> Vec<TestPoint> {
    let same = |a: &Manoeuvre, b: &Manoeuvre| alike(a, b) && near(a.amplitude.abs(), b.amplitude.abs(), SAME_AMPLITUDE);
    grouped(all, same).iter().filter_map(|group| point(group)).collect()
}

fn point(group: &[RunManoeuvre<'_>]) -> Option<TestPoint> {
    let first = group.first()?.manoeuvre;
    let count = group.len() as f64;
    let amplitude = group.iter().map(|one| one.manoeuvre.amplitude.abs() / count).sum();
    let trims = || group.iter().filter_map(|one| one.manoeuvre.trim.as_ref().ok());
    let mean = |value: &dyn Fn(&TrimState) -> Option<Measured>| {
        let values: Vec<f64> = trims().filter_map(|trim| Some(value(trim)?.value)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let scatter = if group.len() < 2 { Err(NotEstimable::TooFewRuns(1, 2)) } else { Ok(scatter(group, amplitude)) };
    Some(TestPoint {
        control: first.control,
        shape: first.shape.clone(),
        amplitude,
        tas: mean(&|trim| trim.tas),
        climb: mean(&|trim| trim.climb),
        members: group.iter().map(|one| one.place).collect(),
        scatter,
    })
}

fn scatter(group: &[RunManoeuvre<'_>], amplitude: f64) -> Vec<Scatter> {
    let length_s =
        group.iter().map(|one| stretch(one.flown, one.until_s).1 - one.manoeuvre.start_s).fold(f64::INFINITY, f64::min);
    COMPARED.into_iter().filter_map(|channel| of_channel(group, amplitude, channel, length_s)).collect()
}

fn of_channel(group: &[RunManoeuvre<'_>], amplitude: f64, channel: Channel, length_s: f64) -> Option<Scatter> {
    let mut runs: Vec<Vec<Option<f64>>> = Vec::new();
    let mut noise = 0.0;
    for one in group {
        let trace = one.channels.get(channel)?;
        let trim = one.manoeuvre.trim.as_ref().ok()?;
        let rest = Rest::of(trace, trim.from_s, trim.to_s)?;
        let scale = amplitude / one.manoeuvre.amplitude;
        let width_s = BIN_S.max(trace.interval_s());
        let from_s = one.manoeuvre.start_s - LEAD_S;
        let bins = trace.binned(from_s, one.manoeuvre.start_s + length_s, width_s);
        // Means of unevenly spaced readings are shifted to the middle of the bin along the line through its neighbours.
        let middle = |place: usize| from_s + width_s * (place as f64 + 0.5);
        let slope = |place: usize| {
            let (t0, x0) = bins.get(place.checked_sub(1)?).copied().flatten()?;
            let (t1, x1) = bins.get(place + 1).copied().flatten()?;
            Some((x1 - x0) / (t1 - t0))
        };
        let value = |(place, bin): (usize, &Option<(f64, f64)>)| {
            bin.map(|(t, x)| (x + slope(place).unwrap_or(0.0) * (middle(place) - t) - rest.mean) * scale)
        };
        runs.push(bins.iter().enumerate().map(value).collect());
        noise += trace.noise() * trace.noise() * scale * scale * (trace.interval_s() / width_s).min(1.0);
    }
    let count = runs.len() as f64;
    let nodes = runs.iter().map(Vec::len).min()?;
    let (mut times, mut between, mut response) = (0.0, 0.0, 0.0);
    for node in 0..nodes {
        let values: Vec<f64> = runs.iter().filter_map(|run| run.get(node).copied().flatten()).collect();
        if values.len() < runs.len() {
            continue;
        }
        let mean = values.iter().sum::<f64>() / count;
        times += 1.0;
        response += mean * mean;
        between += values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (count - 1.0);
    }
    let (response, between, noise) = (libm::sqrt(response / times), libm::sqrt(between / times), libm::sqrt(noise / count));
    if !(times > 5.0) || !(response > 5.0 * noise) {
        return None;
    }
    // One independent value a second: the scatter is coloured.
    let value = between / response;
    let std = value / libm::sqrt(2.0 * (count - 1.0) * (length_s + LEAD_S).max(1.0));
    Some(Scatter { channel, scatter: Measured { value, std }, noise: noise / response })
}
