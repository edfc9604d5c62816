//! Runs that no fit can use, and why.

use super::gross_errors::{GrossFinding, gross_error};
use super::observability::motion_std;
use super::parameter::channel_at;
use super::record::VerdictReason;
use super::run_channels::RunChannels;
use super::screening::{Damage, Screened, beyond, jump};
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;
use crate::flight::unit::STANDARD_GRAVITY;

const LENGTH_MIN_S: f64 = 5.0;
const RATE_MIN_HZ: f64 = 8.0;
/// Mean load factors that a run can have.
const LOAD_MIN: f64 = 0.4;
const LOAD_MAX: f64 = 3.0;
/// Standard deviation of the largest angular rate below which nothing moves, rad/s.
const MOTION_MIN: f64 = 0.004;

/// Why no fit can use a record.
pub(crate) fn refusal(record: &RunChannels, samples: &[Sample], screened: &[Screened]) -> Option<VerdictReason> {
    // What stood still was taken out, which may be why so little is left.
    let frozen = screened.iter().filter(|one| one.damage == Damage::Frozen).max_by_key(|one| one.count);
    let frozen = frozen.map(|one| one.channel);
    let too_short = |length_s: f64| VerdictReason::TooShort { length_s, least_s: LENGTH_MIN_S, frozen };
    let ends = samples.first().zip(samples.last());
    let length_s = ends.map_or(0.0, |(first, last)| last.time_s - first.time_s);
    if (0.0..LENGTH_MIN_S).contains(&length_s) {
        return Some(too_short(length_s));
    }
    let missing: Vec<Channel> =
        (3..6).filter(|&i| record.inputs.get(i).is_none_or(Option::is_none)).filter_map(channel_at).collect();
    if !missing.is_empty() {
        return Some(VerdictReason::NoRates(missing));
    }
    // One stamp far ahead leaves every later sample behind it.
    let mut latest_s = f64::NEG_INFINITY;
    let mut goes_back = |time_s: f64| {
        let back = !(time_s > latest_s);
        latest_s = latest_s.max(time_s);
        back
    };
    let backwards = samples.iter().filter(|sample| goes_back(sample.time_s)).count();
    if backwards * 20 > samples.len() {
        return Some(VerdictReason::ClockBackwards { backwards, samples: samples.len() });
    }
    if !(record.mesh.length_s() >= LENGTH_MIN_S) {
        return Some(too_short(record.mesh.length_s()));
    }
    if !(record.sample_s * RATE_MIN_HZ < 1.0 + 1e-6) {
        return Some(VerdictReason::RateTooLow { rate_hz: 1.0 / record.sample_s, least_hz: RATE_MIN_HZ });
    }
    // Whatever it does meanwhile, on average an aircraft is held up by its own weight.
    let (sum, count) = samples
        .iter()
        .filter_map(|sample| sample.get(Channel::Az))
        .filter(|az| az.is_finite())
        .fold((0.0, 0.0), |(sum, count), az| (sum + az, count + 1.0));
    let load = -sum / count / STANDARD_GRAVITY;
    if count > 0.0 && !(LOAD_MIN..=LOAD_MAX).contains(&load) {
        return Some(VerdictReason::MeanNormalForce(-load * STANDARD_GRAVITY));
    }
    if record.outputs.iter().all(Option::is_none) {
        return Some(VerdictReason::NoOutputs);
    }
    if record.gaps() as f64 > record.mesh.length_s() / LENGTH_MIN_S {
        return Some(VerdictReason::Gaps { count: record.gaps(), length_s: record.mesh.length_s(), frozen });
    }
    let moved = record.inputs.iter().skip(3).flatten().map(motion_std);
    let most = moved.fold(0.0, f64::max);
    if most < MOTION_MIN {
        return Some(VerdictReason::NoExcitation(most));
    }
    if let Some(GrossFinding { either, shown: (shown, before, after) }) = gross_error(record) {
        return Some(VerdictReason::Gross { either, shown, before, after });
    }
    if let Some((channel, time_s, by)) = jump(samples) {
        return Some(VerdictReason::Jump { channel, time_s, by });
    }
    beyond(samples).map(|(channel, part)| VerdictReason::OutOfRange(channel, part))
}
