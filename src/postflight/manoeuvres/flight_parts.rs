//! A whole flight cut into manoeuvres: where the controls move and come to rest again, with the trim before and the free response
//! after each.
//!
//! Consumes samples of a recording of any length; produces parts that do not overlap, in order of time, each with what was flown
//! in it. Cost and memory grow with the number of readings, not with the length of the time axis.
//!
//! Readings of a control are gathered in bins of `BIN_S`. Its range R over a second about a bin is compared with
//!     R_c = max(TRAVEL_MIN, 8 s_n, R_99 / 4, min(3 R_30, R_99 / 2))                                    (1)
//! with s_n the noise of its readings and R_p the p-th percentile of R over the flight: above R_c the control moves. Where no
//! control moves for `REST_S` and none stands off its position before by more than `OFF` of its largest deviation, or where
//! none moves for `HELD_S`, a stretch of motion ends. A part begins at most `LEAD_S` before the motion and ends at most
//! `FREE_S` after it; between two stretches that are nearer the next one's trim has at most half of the time. A stretch in
//! which `manoeuvre` finds no pulse is none. Source: ours.

use super::manoeuvre::TRAVEL_MIN;
use super::record::Manoeuvre;
use super::{Run, interpret};
use crate::flight::channel::ControlNames;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::sample::Sample;
use crate::flight::signal::trace::Trace;
use std::collections::BTreeMap;

/// Width of a bin, s.
const BIN_S: f64 = 0.1;
/// Length over which the range of a control is taken, bins: a second.
const WINDOW: i64 = 10;
/// Time of rest after which a stretch of motion may end, s.
const REST_S: f64 = 1.5;
/// Time of rest after which it ends wherever the controls stand, s.
const HELD_S: f64 = 10.0;
/// Part of the largest deviation above which a control has not come back.
const OFF: f64 = 0.3;
/// Longest trim before a manoeuvre that belongs to its part, s.
const LEAD_S: f64 = 3.0;
/// Longest free response after a manoeuvre that belongs to its part, s.
const FREE_S: f64 = 15.0;

/// A manoeuvre of a flight, and the part of the flight that belongs to it.
#[derive(Clone, Debug)]
pub struct FlightPart {
    /// Start of the part: trim before the manoeuvre, s.
    pub from_s: f64,
    /// End of the part: after the free response, or where the next one begins, s.
    pub to_s: f64,
    /// What was flown: of controls that move at the same time, the one with the greatest travel.
    pub manoeuvre: Manoeuvre,
}

/// The manoeuvres of a flight in order of time.
pub fn flight_parts(samples: &[Sample], controls: ControlNames) -> Vec<FlightPart> {
    let traces = Control::ALL.map(|control| Trace::of(samples, control.channel()));
    let stretches = stretches(&traces);
    let ends = samples.iter().map(|sample| sample.time_s).filter(|time_s| time_s.is_finite());
    let (first_s, last_s) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), time_s| (a.min(time_s), b.max(time_s)));
    let lead = |place: usize| {
        let start_s = stretches.get(place).map_or(last_s, |stretch| stretch.0);
        let before_s = place.checked_sub(1).and_then(|before| stretches.get(before)).map_or(f64::NEG_INFINITY, |before| before.1);
        (start_s - LEAD_S).max(0.5 * (before_s + start_s)).max(first_s)
    };
    let part = |(place, &(_, end_s)): (usize, &(f64, f64))| {
        let next_s = if place + 1 < stretches.len() { lead(place + 1) } else { last_s };
        let (from_s, to_s) = (lead(place), (end_s + FREE_S).min(next_s));
        let inside: Vec<Sample> =
            samples.iter().filter(|sample| sample.time_s >= from_s && sample.time_s <= to_s).copied().collect();
        let interpreted = interpret(&[Run { name: "", samples: &inside, controls }]);
        let flown = interpreted.runs.into_iter().flat_map(|run| run.manoeuvres);
        let manoeuvre = flown.reduce(|one, other| if other.travel > one.travel { other } else { one })?;
        Some(FlightPart { from_s, to_s, manoeuvre })
    };
    stretches.iter().enumerate().filter_map(part).collect()
}

/// Least and greatest reading of a control by bin.
type ControlBins = BTreeMap<i64, (f64, f64)>;

fn bins(trace: &Trace) -> ControlBins {
    let mut bins = ControlBins::new();
    for (time_s, value) in trace.readings() {
        #[expect(clippy::cast_possible_truncation, reason = "saturates; no time of a flight does")]
        let place = libm::floor(time_s / BIN_S) as i64;
        let bin = bins.entry(place).or_insert((value, value));
        *bin = (bin.0.min(value), bin.1.max(value));
    }
    bins
}

/// The bins in which a control moves, by (1).
fn moving(trace: &Trace, bins: &ControlBins) -> Vec<i64> {
    let range = |place: i64| {
        let near = bins.range(place - WINDOW / 2..=place + WINDOW / 2).map(|(_, bin)| bin);
        let (least, most) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (low, high)| (a.min(*low), b.max(*high)));
        most - least
    };
    let ranges: Vec<(i64, f64)> = bins.keys().map(|&place| (place, range(place))).collect();
    let mut sorted: Vec<f64> = ranges.iter().map(|(_, range)| *range).collect();
    sorted.sort_by(f64::total_cmp);
    let percentile = |part: usize| sorted.get(sorted.len() * part / 100).copied().unwrap_or(0.0);
    let (low, high) = (percentile(30), percentile(99));
    let limit = TRAVEL_MIN.max(8.0 * trace.noise()).max(0.25 * high).max((3.0 * low).min(0.5 * high));
    ranges.into_iter().filter(|(_, range)| *range > limit).map(|(place, _)| place).collect()
}

/// Start and end of each stretch of motion, s.
fn stretches(controls: &[Option<Trace>; CONTROLS]) -> Vec<(f64, f64)> {
    let binned = controls.each_ref().map(|trace| trace.as_ref().map(bins));
    let mut all: Vec<i64> = controls
        .iter()
        .zip(&binned)
        .filter_map(|(trace, bins)| Some(moving(trace.as_ref()?, bins.as_ref()?)))
        .flatten()
        .collect();
    all.sort_unstable();
    all.dedup();
    let mut stretches: Vec<(i64, i64)> = Vec::new();
    for place in all {
        match stretches.last_mut() {
            Some(last) if goes_on(last, place, &binned) => last.1 = place,
            _ => stretches.push((place, place)),
        }
    }
    // A window sees a motion half its length before and after.
    let half = WINDOW / 2;
    let seconds = |place: i64| place as f64 * BIN_S;
    stretches.into_iter().map(|(from, to)| (seconds(from + half), seconds((to + 1 - half).max(from + half + 1)))).collect()
}

/// Whether the motion at a bin belongs to the stretch before it.
fn goes_on(stretch: &(i64, i64), place: i64, controls: &[Option<ControlBins>; CONTROLS]) -> bool {
    // Both ends are seen half a window early and late.
    let rest_s = (place - stretch.1 + WINDOW) as f64 * BIN_S;
    if place - stretch.1 <= 1 || rest_s < REST_S {
        return true;
    }
    rest_s < HELD_S && controls.iter().flatten().any(|bins| stands_off(bins, *stretch, place))
}

/// Whether a control rests off the position that it had before a stretch.
fn stands_off(bins: &ControlBins, stretch: (i64, i64), until: i64) -> bool {
    let middle = |(low, high): &(f64, f64)| 0.5 * (low + high);
    let Some(before) = bins.range(..=stretch.0).next_back().map(|(_, bin)| middle(bin)) else { return false };
    let inside = bins.range(stretch.0..=stretch.1);
    let largest = inside.fold(0.0f64, |largest, (_, (low, high))| largest.max((low - before).abs()).max((high - before).abs()));
    let rest: Vec<f64> = bins.range(stretch.1..until).map(|(_, bin)| middle(bin)).collect();
    let off = rest.get(rest.len() / 2).map_or(0.0, |rest| (rest - before).abs());
    largest > TRAVEL_MIN && off > OFF * largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::postflight::manoeuvres::record::Shape;

    /// Pedal and lateral stick at 50 Hz, moved by these pulses: control, from, to, level.
    fn flight(long_s: f64, pulses: &[(Channel, f64, f64, f64)]) -> Vec<Sample> {
        let count = (long_s * 50.0) as u32;
        (0..count)
            .map(|place| {
                let mut sample = Sample::new(f64::from(place) / 50.0);
                for control in [Channel::Pedal, Channel::LatCyclic] {
                    let own = pulses
                        .iter()
                        .filter(|(channel, from_s, to_s, _)| *channel == control && (*from_s..*to_s).contains(&sample.time_s));
                    sample.set(control, 0.1 + own.map(|pulse| pulse.3).sum::<f64>());
                }
                sample.set(Channel::Tas, 50.0 + 0.01 * sample.time_s);
                sample
            })
            .collect()
    }

    #[test]
    fn each_input_has_a_part_with_its_trim_and_its_free_response() {
        let (pedal, stick) = (Channel::Pedal, Channel::LatCyclic);
        // A doublet at 10 s, a 3211 of 2 s clocks at 60 s (its first pulse stands still for 6 s), a pulse of the stick at 83 s.
        let pulses = [
            (pedal, 10.0, 11.0, 0.02),
            (pedal, 11.0, 12.0, -0.02),
            (pedal, 60.0, 66.0, 0.02),
            (pedal, 66.0, 70.0, -0.02),
            (pedal, 70.0, 72.0, 0.02),
            (pedal, 72.0, 74.0, -0.02),
            (stick, 83.0, 85.0, 0.015),
        ];
        let parts = flight_parts(&flight(120.0, &pulses), ControlNames::Rotorcraft);
        let found: Vec<(Control, Shape)> =
            parts.iter().map(|part| (part.manoeuvre.control, part.manoeuvre.shape.clone())).collect();
        let known = [
            (Control::Pedal, Shape::Doublet),
            (Control::Pedal, Shape::Multistep(vec![3, 2, 1, 1])),
            (Control::LatCyclic, Shape::Pulse),
        ];
        assert_eq!(found, known);
        let near = |found: f64, known: f64| (found - known).abs() < 0.3;
        assert!(near(parts[0].from_s, 7.0) && near(parts[0].to_s, 27.0), "{} {}", parts[0].from_s, parts[0].to_s);
        assert!(near(parts[1].from_s, 57.0) && near(parts[1].to_s, 80.0), "{} {}", parts[1].from_s, parts[1].to_s);
        assert!(near(parts[2].from_s, 80.0) && near(parts[2].to_s, 100.0), "{} {}", parts[2].from_s, parts[2].to_s);
        assert!((parts[2].manoeuvre.trim.as_ref().unwrap().tas.unwrap().value - 50.8).abs() < 0.1);
    }

    #[test]
    fn controls_that_move_together_are_one_part_and_still_ones_none() {
        let pulses = [(Channel::Pedal, 10.0, 12.0, 0.02), (Channel::LatCyclic, 11.0, 13.0, 0.03)];
        let parts = flight_parts(&flight(40.0, &pulses), ControlNames::Rotorcraft);
        assert!(parts.len() == 1 && parts[0].manoeuvre.control == Control::LatCyclic, "{parts:?}");
        assert_eq!(parts[0].manoeuvre.others.len(), 1);
        assert!(flight_parts(&flight(40.0, &[]), ControlNames::Rotorcraft).is_empty());
    }

    #[test]
    fn a_clock_that_jumps_costs_no_more() {
        let mut samples = flight(40.0, &[(Channel::Pedal, 10.0, 12.0, 0.02)]);
        samples.iter_mut().skip(1500).for_each(|sample| sample.time_s += 1.7e9);
        assert_eq!(flight_parts(&samples, ControlNames::Rotorcraft).len(), 1);
    }
}
