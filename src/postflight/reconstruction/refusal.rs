//! Runs that no fit can use, and why.

use super::gross_errors::gross_error;
use super::observability::motion_std;
use super::parameter::channel_at;
use super::record::RunChannels;
use super::screening::{Damage, Screened, beyond, jump};
use crate::flight::channel::{Channel, ControlNames};
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
pub(crate) fn refusal(record: &RunChannels, samples: &[Sample], screened: &[Screened]) -> Option<String> {
    // What stood still was taken out, which may be why so little is left.
    let standing = screened.iter().filter(|one| one.damage == Damage::Standing).max_by_key(|one| one.count);
    let because = standing.map_or(String::new(), |one| {
        format!(", for {} stands still (frozen, clipped or zeroed)", one.channel.name(ControlNames::Rotorcraft))
    });
    let too_short = |length_s: f64| format!("too short: {length_s:.1} s, at least {LENGTH_MIN_S:.0} s are needed{because}");
    let ends = samples.first().zip(samples.last());
    let length_s = ends.map_or(0.0, |(first, last)| last.time_s - first.time_s);
    if (0.0..LENGTH_MIN_S).contains(&length_s) {
        return Some(too_short(length_s));
    }
    let missing: Vec<&str> = (3..6)
        .filter(|&i| record.inputs.get(i).is_none_or(Option::is_none))
        .filter_map(|i| Some(channel_at(i)?.name(ControlNames::Rotorcraft)))
        .collect();
    if !missing.is_empty() {
        return Some(format!("no angular rate {}: nothing else says how the aircraft turns", missing.join(" ")));
    }
    let backwards = samples.windows(2).filter(|pair| matches!(pair, [a, b] if !(b.time_s > a.time_s))).count();
    if backwards * 20 > samples.len() {
        return Some(format!("its clock does not go forward at {backwards} of {} samples", samples.len()));
    }
    if !(record.mesh.length_s() >= LENGTH_MIN_S) {
        return Some(too_short(record.mesh.length_s()));
    }
    if !(record.sample_s * RATE_MIN_HZ < 1.0 + 1e-6) {
        return Some(format!("angular rates at {:.1} Hz: at least {RATE_MIN_HZ:.0} Hz are needed", 1.0 / record.sample_s));
    }
    // Whatever it does meanwhile, on average an aircraft is held up by its own weight.
    let (sum, count) = samples
        .iter()
        .filter_map(|sample| sample.get(Channel::Az))
        .filter(|az| az.is_finite())
        .fold((0.0, 0.0), |(sum, count), az| (sum + az, count + 1.0));
    let load = -sum / count / STANDARD_GRAVITY;
    if count > 0.0 && !(LOAD_MIN..=LOAD_MAX).contains(&load) {
        let found = -load * STANDARD_GRAVITY;
        return Some(format!(
            "az is {found:.2} m/s^2 on average, expected near -9.81 (z points down): its sign or its unit is wrong"
        ));
    }
    if record.outputs.iter().all(Option::is_none) {
        return Some("no attitude and no air data to compare the rates with".to_owned());
    }
    if record.gaps() as f64 > record.mesh.length_s() / LENGTH_MIN_S {
        return Some(format!("{} gaps in {:.0} s: no stretch is long enough{because}", record.gaps(), record.mesh.length_s()));
    }
    let moved = record.inputs.iter().skip(3).flatten().map(motion_std);
    let most = moved.fold(0.0, f64::max);
    if most < MOTION_MIN {
        return Some(format!("no excitation: no angular rate moves more than {most:.4} rad/s rms"));
    }
    if let Some(told) = gross_error(record) {
        let either: Vec<String> = told.either.iter().map(|one| one.words()).collect();
        let (channel, before, after) = told.shown;
        return Some(format!(
            "reads like {}: put right, {} follows from the other channels (R2 {after:.2} instead of {before:.2})",
            either.join(" or "),
            channel.name(ControlNames::Rotorcraft),
        ));
    }
    if let Some((channel, time_s, by)) = jump(samples) {
        return Some(format!(
            "{} jumps by {by:.3} {} at {time_s:.2} s, as nothing that flies does: cut the record there",
            channel.name(ControlNames::Rotorcraft),
            channel.si_unit(),
        ));
    }
    if let Some((channel, part)) = beyond(samples) {
        return Some(format!(
            "{} is beyond what any aircraft reaches at {:.0} % of its samples: its unit, or its instrument",
            channel.name(ControlNames::Rotorcraft),
            100.0 * part
        ));
    }
    None
}
