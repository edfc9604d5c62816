//! Screening of a whole record, before anything is estimated from it: samples that no instrument measured are taken out.
//!
//! Consumes a run's samples; takes out of them, and says, what is
//! - no finite number, or beyond what any aircraft reaches (the limits of `admission`), unless a twentieth of the channel is:
//!   then its unit is in question, not its samples;
//! - a spike: up to `WIDTH_MAX` samples that leave both neighbours to one side by more than `SPIKE_STDS` standard deviations
//!   of the channel's noise and `SPIKE_STEPS` times what it usually changes, there and in nine of ten steps;
//! - standing still (frozen, clipped, zeroed): equal values in a row by (1) of `constant_readings`. Not where nothing else
//!   moves either, and not of a channel that goes in steps, as an altimeter does: its own slow motion stands as well.
//!
//! Nothing is put in their place. Not for controls, which jump and rest as the pilot likes.

use super::parameter::CHANNELS;
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;
use crate::realtime::estimation::admission::range;
use crate::realtime::estimation::screening::constant_readings::{ROUNDING, is_improbable};

/// What a spike stands out of: the noise, and the changes beside it.
const SPIKE_STDS: f64 = 15.0;
const SPIKE_STEPS: f64 = 4.0;
const WIDTH_MAX: usize = 2;
/// Part of a channel beyond the limits from which its unit is in question.
const UNIT_PART: f64 = 0.05;
/// Median change over the smallest (2 %) of a channel that does not go in steps; of normal noise it is 27.
const FINE: f64 = 10.0;
/// A jump beside nine of ten steps, and the samples on either side of it.
const JUMP_STEPS: f64 = 8.0;
const LEVEL: usize = 5;
/// Fewer samples of a channel say nothing of what is usual.
const COUNT_MIN: usize = 20;
/// Median of the absolute value of normal noise, and the third difference's gain for white noise, (1) of `series`.
const MEDIAN: f64 = 0.6745;
const THIRD_GAIN: f64 = 4.472_135_954_999_579;
/// Neighbours of a spike are not further apart, s: what lasts longer may be the aircraft.
const SPIKE_S: f64 = 0.13;

/// What was wrong with samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// No finite number.
    NotFinite,
    /// Beyond what any aircraft reaches.
    OutOfRange,
    /// Away from both neighbours.
    Spike,
    /// Frozen, clipped or zeroed.
    Frozen,
}

impl Damage {
    /// The words in results.
    pub const fn words(self) -> &'static str {
        match self {
            Damage::NotFinite => "no finite number",
            Damage::OutOfRange => "beyond what any aircraft reaches",
            Damage::Spike => "a spike",
            Damage::Frozen => "standing still (frozen, clipped or zeroed)",
        }
    }
}

/// Samples of one channel that were taken out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screened {
    /// Of which channel.
    pub channel: Channel,
    /// Why.
    pub damage: Damage,
    /// How many.
    pub count: usize,
    /// First and last of them, s.
    pub range_s: [f64; 2],
}

/// One channel of the samples: place, time and value where it was sampled.
type ChannelReadings = Vec<(usize, f64, f64)>;

/// A heading's full turns are taken out, as are bank's.
fn line(samples: &[Sample], channel: Channel) -> ChannelReadings {
    let sampled = samples.iter().enumerate().filter_map(|(place, sample)| Some((place, sample.time_s, sample.get(channel)?)));
    if !matches!(channel, Channel::Psi | Channel::Phi) {
        return sampled.collect();
    }
    let turn = 2.0 * core::f64::consts::PI;
    let mut before: Option<f64> = None;
    let unwrapped = sampled.map(|(place, time_s, value)| {
        let value =
            before.filter(|_| value.is_finite()).map_or(value, |before| value - turn * libm::round((value - before) / turn));
        before = Some(value).filter(|value| value.is_finite()).or(before);
        (place, time_s, value)
    });
    unwrapped.collect()
}

/// Takes damaged samples out; what was taken, by channel.
pub fn screen(samples: &mut [Sample]) -> Vec<Screened> {
    let mut all = Vec::new();
    for channel in CHANNELS {
        let readings = line(samples, channel);
        let broken = of(&readings, |value| !value.is_finite());
        take(samples, channel, Damage::NotFinite, &readings, &broken, &mut all);
        let readings = line(samples, channel);
        let (low, high) = limits(channel);
        let beyond = of(&readings, |value| value < low || value > high);
        if (beyond.len() as f64) <= UNIT_PART * readings.len() as f64 {
            take(samples, channel, Damage::OutOfRange, &readings, &beyond, &mut all);
        }
    }
    let lines = CHANNELS.map(|channel| line(samples, channel));
    let none = ChannelReadings::new();
    for (place, (channel, readings)) in CHANNELS.into_iter().zip(&lines).enumerate() {
        // An altimeter goes in steps, whatever it is written as.
        let slow = channel == Channel::Altitude;
        let frozen = frozen(if slow { &none } else { readings }, |from_s, to_s| {
            let other = |other: usize| other != place && moves(lines.get(other).unwrap_or(readings), from_s, to_s);
            (0..CHANNELS.len()).any(other)
        });
        take(samples, channel, Damage::Frozen, readings, &frozen, &mut all);
        let readings = line(samples, channel);
        let spikes = spikes(&readings);
        take(samples, channel, Damage::Spike, &readings, &spikes, &mut all);
    }
    all
}

/// A heading may have gone round any number of times.
fn limits(channel: Channel) -> (f64, f64) {
    if channel == Channel::Psi { (f64::NEG_INFINITY, f64::INFINITY) } else { range(channel) }
}

/// A channel that is mostly beyond what any aircraft reaches, and how much of it.
pub fn beyond(samples: &[Sample]) -> Option<(Channel, f64)> {
    CHANNELS.into_iter().find_map(|channel| {
        let readings = line(samples, channel);
        let (low, high) = limits(channel);
        let part = of(&readings, |value| value < low || value > high).len() as f64 / readings.len().max(1) as f64;
        (part > UNIT_PART).then_some((channel, part))
    })
}

/// Places in a line where that holds of the value.
fn of(readings: &ChannelReadings, holds: impl Fn(f64) -> bool) -> Vec<usize> {
    (0..readings.len()).filter(|&k| readings.get(k).is_some_and(|one| holds(one.2))).collect()
}

fn take(
    samples: &mut [Sample],
    channel: Channel,
    damage: Damage,
    readings: &ChannelReadings,
    taken: &[usize],
    all: &mut Vec<Screened>,
) {
    let mut range_s = [f64::INFINITY, f64::NEG_INFINITY];
    for &(place, time_s, _) in taken.iter().filter_map(|&k| readings.get(k)) {
        range_s = [range_s[0].min(time_s), range_s[1].max(time_s)];
        if let Some(sample) = samples.get_mut(place) {
            sample.clear(channel);
        }
    }
    if !taken.is_empty() {
        all.push(Screened { channel, damage, count: taken.len(), range_s });
    }
}

/// Whether a channel changes between two times, by more than rounding.
fn moves(readings: &ChannelReadings, from_s: f64, to_s: f64) -> bool {
    let span = |readings: &[(usize, f64, f64)]| {
        let ends = readings.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(one.2), high.max(one.2)));
        (ends.1 - ends.0).max(0.0)
    };
    let from = readings.partition_point(|one| one.1 < from_s);
    let to = readings.partition_point(|one| one.1 <= to_s);
    let inside = readings.get(from..to).unwrap_or(&[]);
    inside.len() > 2 && span(inside) > ROUNDING * span(readings)
}

/// Stretches by (1), all but the first sample of each, where something else moves meanwhile.
fn frozen(readings: &ChannelReadings, else_moves: impl Fn(f64, f64) -> bool) -> Vec<usize> {
    let count = readings.len();
    if count < COUNT_MIN {
        return Vec::new();
    }
    let changes = steps(&readings.iter().map(|one| one.2).collect::<Vec<_>>());
    if quantile(changes.clone(), 0.5) < FINE * quantile(changes, 0.02) {
        return Vec::new();
    }
    let mut stretches: Vec<(usize, usize)> = Vec::new();
    let mut from = 0;
    for k in 1..=count {
        let same = readings.get(k).zip(readings.get(from)).is_some_and(|(a, b)| a.2.to_bits() == b.2.to_bits());
        if !same {
            stretches.push((from, k));
            from = k;
        }
    }
    let repeats: usize = stretches.iter().map(|(from, to)| to - from - 1).sum();
    let mut taken = Vec::new();
    for (from, to) in stretches {
        let own = to - from - 1;
        let time = |k: usize| readings.get(k).map_or(0.0, |one| one.1);
        if own > 0 && is_improbable(count as f64, repeats as f64, own as f64) && else_moves(time(from), time(to - 1)) {
            taken.extend(from + 1..to);
        }
    }
    taken
}

/// Samples that leave both neighbours to one side.
fn spikes(readings: &ChannelReadings) -> Vec<usize> {
    let values: Vec<f64> = readings.iter().map(|one| one.2).collect();
    if values.len() < COUNT_MIN {
        return Vec::new();
    }
    let third = |w: &[f64; 4]| (w[0] - 3.0 * w[1] + 3.0 * w[2] - w[3]).abs();
    let noise = quantile(values.array_windows().map(third).collect(), 0.5) / (MEDIAN * THIRD_GAIN);
    let usual = quantile(steps(&values), 0.9);
    let limit = (SPIKE_STDS * noise).max(SPIKE_STEPS * usual);
    let mut taken = Vec::new();
    let mut k = 1;
    while k + 1 < values.len() {
        let brief = |width: usize| {
            let [before, after] = [k - 1, k + width].map(|place| readings.get(place).map_or(f64::NAN, |one| one.1));
            after - before <= SPIKE_S
        };
        match (1..=WIDTH_MAX).find(|&width| brief(width) && normalised_excess(&values, k, width, limit)) {
            Some(width) => {
                taken.extend(k..k + width);
                k += width + 1;
            }
            None => k += 1,
        }
    }
    taken
}

/// The first instant at which a channel goes to another level from one sample to the next, as nothing that flies does:
/// the channel, the time and by how much.
///
/// Levels are means over `LEVEL` samples, which have to be apart by what a spike has to stand out by and by far more than the
/// channel changes within either.
pub fn jump(samples: &[Sample]) -> Option<(Channel, f64, f64)> {
    let slow = [Channel::Altitude, Channel::Ax, Channel::Ay, Channel::Az];
    CHANNELS.into_iter().filter(|channel| !slow.contains(channel)).find_map(|channel| {
        let readings = line(samples, channel);
        let values: Vec<f64> = readings.iter().map(|one| one.2).collect();
        let changes = steps(&values);
        if values.len() < COUNT_MIN {
            return None;
        }
        let limit = JUMP_STEPS * quantile(changes, 0.9);
        let at = (LEVEL..values.len().saturating_sub(LEVEL)).find(|&k| {
            let (Some(before), Some(after)) = (values.get(k - LEVEL..k), values.get(k..k + LEVEL)) else { return false };
            let mean = |part: &[f64]| part.iter().sum::<f64>() / LEVEL as f64;
            let within = |part: &[f64]| steps(part).into_iter().fold(0.0, f64::max);
            let step = values.get(k).zip(values.get(k - 1)).map_or(0.0, |(a, b)| (a - b).abs());
            let brief = readings.get(k).zip(readings.get(k - 1)).is_some_and(|(a, b)| a.1 - b.1 <= SPIKE_S / 2.0);
            let apart = (mean(after) - mean(before)).abs();
            brief && step > limit && apart > 0.7 * step && within(before).max(within(after)) < 0.25 * step
        })?;
        let (time_s, by) = (readings.get(at)?.1, values.get(at)? - values.get(at - 1)?);
        Some((channel, time_s, by))
    })
}

fn normalised_excess(values: &[f64], from: usize, width: usize, limit: f64) -> bool {
    let at = |k: usize| values.get(k).copied();
    let (Some(left), Some(right)) = (from.checked_sub(1).and_then(at), at(from + width)) else { return false };
    let change = |a: Option<f64>, b: f64| a.map_or(0.0, |a| (a - b).abs());
    let before = change(from.checked_sub(2).and_then(at), left);
    let usual = (right - left).abs() + before.max(change(at(from + width + 1), right));
    let needed = limit.max(SPIKE_STEPS * usual);
    let inside = values.get(from..from + width).unwrap_or(&[]);
    let above = inside.iter().all(|value| value - left > needed && value - right > needed);
    let below = inside.iter().all(|value| left - value > needed && right - value > needed);
    !inside.is_empty() && (above || below)
}

/// Sizes of the changes from sample to sample, those that are none left out.
fn steps(values: &[f64]) -> Vec<f64> {
    values.array_windows().map(|[a, b]| (b - a).abs()).filter(|step| *step > 0.0).collect()
}

fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((part * values.len() as f64) as usize).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flown(noise: f64) -> Vec<Sample> {
        let wiggle = |k: i32, salt: f64| noise * libm::sin(salt * f64::from(k * k % 1009));
        (0..800)
            .map(|k| {
                let t = 0.02 * f64::from(k);
                let mut sample = Sample::new(t);
                sample.set(Channel::P, 0.3 * libm::sin(2.0 * t) + wiggle(k, 7.3));
                sample.set(Channel::Phi, -0.15 * libm::cos(2.0 * t) + wiggle(k, 3.1));
                // In steps of half a metre.
                sample.set(Channel::Altitude, libm::round(2.0 * (100.0 + 2.0 * libm::sin(0.5 * t))) / 2.0);
                sample
            })
            .collect()
    }

    #[test]
    fn healthy_samples_are_left_alone() {
        for noise in [0.0, 1e-3, 0.02] {
            let samples = flown(noise);
            let mut screened = samples.clone();
            assert_eq!(screen(&mut screened), Vec::new(), "noise {noise}");
            assert_eq!(screened, samples);
        }
    }

    #[test]
    fn a_trim_without_noise_is_no_frozen_channel() {
        let mut samples = flown(0.0);
        for sample in samples.iter_mut().take(100) {
            sample.set(Channel::P, 0.0);
            sample.set(Channel::Phi, 0.1);
            sample.set(Channel::Altitude, 100.0);
        }
        assert!(screen(&mut samples).is_empty());
    }

    #[test]
    fn spikes_frozen_clipped_zeroed_and_broken_samples_are_taken_out() {
        let mut samples = flown(1e-3);
        samples[100].set(Channel::P, 3.0);
        samples[200].set(Channel::P, -1.0);
        samples[201].set(Channel::P, -1.1);
        samples[300].set(Channel::P, f64::NAN);
        samples[310].set(Channel::P, 90.0);
        let held = samples[500].values[Channel::P.index()];
        samples[500..560].iter_mut().for_each(|sample| sample.set(Channel::P, held));
        for sample in &mut samples {
            let clipped = sample.get(Channel::Phi).unwrap().min(0.12);
            sample.set(Channel::Phi, clipped);
        }
        let clipped = samples.iter().filter(|sample| sample.get(Channel::Phi) == Some(0.12)).count();
        let said = screen(&mut samples);
        let counted = |channel, damage| {
            said.iter().filter(|one| one.channel == channel && one.damage == damage).map(|one| one.count).sum::<usize>()
        };
        assert_eq!(counted(Channel::P, Damage::NotFinite), 1);
        assert_eq!(counted(Channel::P, Damage::OutOfRange), 1);
        assert_eq!(counted(Channel::P, Damage::Spike), 3);
        assert_eq!(counted(Channel::P, Damage::Frozen), 59);
        let left = counted(Channel::Phi, Damage::Frozen);
        assert!(left + 20 > clipped && left < clipped, "{left} of {clipped}");
        assert!(said.iter().all(|one| one.channel != Channel::Altitude));
        assert_eq!(samples[100].get(Channel::P), None);
    }

    #[test]
    fn a_jump_is_seen_and_a_heading_through_north_is_none() {
        let mut samples = flown(1e-3);
        for sample in &mut samples {
            let heading = (6.0 + 0.05 * sample.time_s) % (2.0 * core::f64::consts::PI);
            sample.set(Channel::Psi, heading);
        }
        assert_eq!((screen(&mut samples), jump(&samples)), (Vec::new(), None));
        for sample in samples.iter_mut().filter(|sample| sample.time_s > 10.0) {
            let jumped = sample.get(Channel::Phi).unwrap() + 0.1;
            sample.set(Channel::Phi, jumped);
        }
        let (channel, time_s, by) = jump(&samples).unwrap();
        assert!(channel == Channel::Phi && (time_s - 10.02).abs() < 0.021 && (by - 0.1).abs() < 0.01, "{time_s} {by}");
    }

    #[test]
    fn a_channel_in_another_unit_is_not_a_few_damaged_samples() {
        let mut samples = flown(1e-3);
        for sample in &mut samples {
            let degrees = sample.get(Channel::Phi).unwrap() * 57.3;
            sample.set(Channel::Phi, degrees);
        }
        assert_eq!(screen(&mut samples), Vec::new());
        assert!(beyond(&samples).is_some_and(|(channel, part)| channel == Channel::Phi && part > 0.5));
    }
}
