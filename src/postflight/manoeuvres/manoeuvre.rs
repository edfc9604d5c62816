//! Detection of manoeuvres: which control moved, when, how far, and in what shape.
//!
//! Consumes the controls' traces; produces groups of pulses. A control is moved where its travel is above its noise, above
//! [`TRAVEL_MIN`], and at least `BESIDE` of that of the control that moves most (smaller motion is stabilisation by the pilot).
//! A pulse is a time range with more than `PULSE` of the largest deviation from the initial position; pulses that follow each
//! other closely are one manoeuvre, whose shape is the pattern of their lengths. Source: ours.

use super::record::{Pulse, Shape};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::signal::trace::Trace;

/// Travel below which a control is at rest, rad.
pub const TRAVEL_MIN: f64 = 0.002;
/// Least travel of a manoeuvre, relative to the control that moves most.
const BESIDE: f64 = 0.25;
/// Least deviation of a pulse, relative to the largest.
const PULSE: f64 = 0.3;
/// Gap between two manoeuvres, s, or the length of the longer pulse.
const APART_S: f64 = 1.5;
/// Length above which a pulse is a step and its return, s.
const HELD_S: f64 = 5.0;
/// Part of a pulse at either end, at most so many seconds, that its level excludes: the flanks.
const TOP: f64 = 0.15;
const TOP_MOST_S: f64 = 0.3;
/// Length over which the initial position is taken, s.
const FIRST_S: f64 = 1.0;

/// Consecutive pulses of one control.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// Control that was moved.
    pub control: Control,
    /// Initial position, rad.
    pub from: f64,
    /// Pulses, in order.
    pub pulses: Vec<Pulse>,
    /// Pattern of their lengths.
    pub shape: Shape,
    /// Greatest minus least deviation, rad.
    pub travel: f64,
}

impl Flown {
    /// Time of half the level of the first pulse, s.
    pub fn start_s(&self) -> f64 {
        self.pulses.first().map_or(0.0, |pulse| pulse.start_s)
    }

    /// End of the last pulse, s.
    pub fn end_s(&self) -> f64 {
        self.pulses.last().map_or(0.0, |pulse| pulse.end_s)
    }
}

/// Greatest minus least value, without the extreme 2 % of the readings.
pub fn travel(trace: &Trace, from_s: f64, to_s: f64) -> f64 {
    let mut values: Vec<f64> = trace.within(from_s, to_s).map(|(_, value)| value).collect();
    values.sort_by(f64::total_cmp);
    let cut = if values.len() >= 100 { values.len() / 200 } else { 0 };
    let last = values.len().saturating_sub(1 + cut);
    values.get(last).copied().unwrap_or(0.0) - values.get(cut).copied().unwrap_or(0.0)
}

/// The manoeuvres of a run, in order of time.
pub fn manoeuvres(controls: &[Option<Trace>; CONTROLS]) -> Vec<Flown> {
    let travels = controls.each_ref().map(|control| {
        let Some(trace) = control else { return 0.0 };
        let (from_s, to_s) = trace.range_s();
        let travel = travel(trace, from_s, to_s);
        if travel > TRAVEL_MIN.max(8.0 * trace.noise()) { travel } else { 0.0 }
    });
    let most = travels.iter().copied().fold(0.0, f64::max);
    let mut all = Vec::new();
    for ((control, trace), travel) in Control::ALL.into_iter().zip(controls).zip(travels) {
        if let Some(trace) = trace.as_ref().filter(|_| travel > 0.0 && travel >= BESIDE * most) {
            all.extend(of_control(control, trace));
        }
    }
    all.sort_by(|a, b| a.start_s().total_cmp(&b.start_s()));
    all
}

fn of_control(control: Control, trace: &Trace) -> Vec<Flown> {
    let (begin_s, end_s) = trace.range_s();
    let from = trace.median(begin_s, begin_s + FIRST_S).unwrap_or(0.0);
    let mut found: Vec<Vec<Pulse>> = Vec::new();
    for pulse in pulses(trace, from, end_s) {
        match found.last_mut() {
            Some(group) if group.last().is_some_and(|before| follows(before, &pulse)) => group.push(pulse),
            _ => found.push(vec![pulse]),
        }
    }
    let flown = |pulses: Vec<Pulse>| {
        let levels = pulses.iter().map(|pulse| pulse.level).chain([0.0]);
        let (least, most) = levels.fold((0.0f64, 0.0f64), |(a, b), level| (a.min(level), b.max(level)));
        let travel = most - least;
        Flown { control, from, shape: shape(&pulses), travel, pulses }
    };
    found.into_iter().map(flown).collect()
}

fn follows(before: &Pulse, pulse: &Pulse) -> bool {
    let longer = (before.end_s - before.start_s).max(pulse.end_s - pulse.start_s).min(HELD_S);
    before.ended && pulse.start_s - before.end_s < APART_S.max(0.7 * longer)
}

/// Time ranges beyond the level, each extended to half its own level.
fn pulses(trace: &Trace, from: f64, end_s: f64) -> Vec<Pulse> {
    let deviations: Vec<(f64, f64)> = trace.readings().map(|(t, x)| (t, x - from)).collect();
    let largest = deviations.iter().fold(0.0f64, |largest, (_, d)| largest.max(d.abs()));
    let sign = |d: f64| if d.abs() > PULSE * largest { libm::copysign(1.0, d) } else { 0.0 };
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(&(_, d)) = deviations.get(at) {
        let side = sign(d);
        let length = deviations.iter().skip(at).take_while(|(_, d)| sign(*d) * side > 0.0).count();
        if side == 0.0 || length == 0 {
            at += 1;
            continue;
        }
        let last = at + length - 1;
        let mut inside: Vec<f64> = deviations.iter().skip(at).take(length).map(|(_, d)| d * side).collect();
        inside.sort_by(f64::total_cmp);
        // The level excludes the ramps of both ends.
        let level = inside.get(inside.len() * 6 / 10).copied().unwrap_or(0.0);
        let high = |place: usize| deviations.get(place).is_some_and(|(_, d)| d * side >= 0.5 * level);
        let crossing = |inner: usize, outer: usize| {
            let (&(t1, d1), &(t0, d0)) = (deviations.get(inner)?, deviations.get(outer)?);
            Some(t0 + (t1 - t0) * (0.5 * level - d0 * side) / ((d1 - d0) * side))
        };
        let mut first_high = (at..=last).find(|place| high(*place)).unwrap_or(at);
        while first_high > 0 && high(first_high - 1) {
            first_high -= 1;
        }
        let mut last_high = (at..=last).rev().find(|place| high(*place)).unwrap_or(last);
        while high(last_high + 1) {
            last_high += 1;
        }
        let start_s = first_high.checked_sub(1).and_then(|outer| crossing(first_high, outer));
        let stop_s = crossing(last_high, last_high + 1);
        let begin_s = start_s.or(deviations.first().map(|(t, _)| *t)).unwrap_or(0.0);
        let top_s = (TOP * (stop_s.unwrap_or(end_s) - begin_s)).min(TOP_MOST_S);
        let top = trace.mean(begin_s + top_s, (stop_s.unwrap_or(end_s) - top_s).min(begin_s + HELD_S));
        let level = top.map_or(level, |(mean, _, _)| (mean - from) * side);
        found.push(Pulse { start_s: begin_s, end_s: stop_s.unwrap_or(end_s), level: level * side, ended: stop_s.is_some() });
        at = last + 1;
    }
    // A single reading is an outlier.
    found.retain(|pulse| pulse.end_s - pulse.start_s > 1.5 * trace.interval_s());
    found
}

/// The pattern of lengths.
pub fn shape(pulses: &[Pulse]) -> Shape {
    let lengths: Vec<f64> = pulses.iter().map(|pulse| pulse.end_s - pulse.start_s).collect();
    let alternating = pulses.windows(2).all(|pair| pair.iter().map(|pulse| pulse.level).product::<f64>() < 0.0);
    match (pulses, lengths.as_slice()) {
        ([only], [length]) => {
            if !only.ended || *length > HELD_S {
                Shape::Step
            } else {
                Shape::Pulse
            }
        }
        ([_, _], [a, b]) if alternating && (0.6..=1.0 / 0.6).contains(&(a / b)) => Shape::Doublet,
        _ if alternating => multistep(&lengths).map_or(Shape::Other(pulses.len()), Shape::Multistep),
        _ => Shape::Other(pulses.len()),
    }
}

/// Whole numbers of a clock that the lengths are nearest to, where each is within a third of a clock.
fn multistep(lengths: &[f64]) -> Option<Vec<u8>> {
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let total: f64 = lengths.iter().sum();
    let mut best: Option<(f64, Vec<u8>)> = None;
    for first in 1..=2u8 {
        let mut clock = shortest / f64::from(first);
        for _ in 0..4 {
            let clocks: f64 = lengths.iter().map(|length| libm::round(length / clock).max(1.0)).sum();
            clock = total / clocks;
        }
        let worst = lengths.iter().map(|l| (l / clock - libm::round(l / clock)).abs()).fold(0.0, f64::max);
        // A finer clock fits any lengths: the tolerance shrinks with it.
        let worst = worst * f64::from(first);
        let digits: Vec<u8> = lengths.iter().map(|length| libm::round(length / clock).clamp(1.0, 255.0) as u8).collect();
        if worst < 0.34 && digits.iter().all(|digit| *digit <= 9) && best.as_ref().is_none_or(|(least, _)| worst < *least) {
            best = Some((worst, digits));
        }
    }
    best.map(|(_, digits)| digits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::input::InputSpec;

    fn flown(inputs: &[&str]) -> Vec<Flown> {
        let mut controls: [Option<Trace>; CONTROLS] = [const { None }; CONTROLS];
        for (control, trace) in Control::ALL.into_iter().zip(&mut controls) {
            let specs: Vec<InputSpec> = inputs.iter().map(|text| InputSpec::parse(text).unwrap()).collect();
            let histories: Vec<_> =
                specs.iter().filter(|spec| spec.channel == control.channel()).map(|spec| spec.deviation(2.0)).collect();
            let value = |t: f64| 0.1 + histories.iter().map(|history| history.at(t)).sum::<f64>();
            *trace = Trace::through((0..2000).map(|i| f64::from(i) * 0.01).map(|t| (t, value(t))));
        }
        manoeuvres(&controls)
    }

    #[test]
    fn shapes_times_and_levels_are_those_flown() {
        for (text, expected) in [
            ("pedal:3211:-0.02:0.7", Shape::Multistep(vec![3, 2, 1, 1])),
            ("pedal:doublet:0.02:1", Shape::Doublet),
            ("pedal:step:0.02", Shape::Step),
            ("pedal:2:0.02:0.5", Shape::Pulse),
            ("pedal:1123:0.02:0.5", Shape::Multistep(vec![1, 1, 2, 3])),
            ("pedal:121:0.02:0.5", Shape::Multistep(vec![1, 2, 1])),
        ] {
            let found = flown(&[text]);
            let spec = InputSpec::parse(text).unwrap();
            assert_eq!(found.len(), 1, "{text}: {found:?}");
            assert_eq!(found[0].shape, expected, "{text}");
            assert!((found[0].pulses[0].level - spec.amplitude).abs() < 1e-9, "{text}");
            // Half the level, 0.02 rad at 0.5 rad/s.
            assert!((found[0].start_s() - 2.02).abs() < 1e-6, "{text}: {}", found[0].start_s());
        }
    }

    #[test]
    fn two_inputs_are_two_manoeuvres_and_a_small_correction_is_none() {
        let found = flown(&["pedal:3211:0.02:0.7", "lat_cyclic:doublet:0.01:1:12", "lon_cyclic:doublet:0.003:1:5"]);
        let controls: Vec<Control> = found.iter().map(|one| one.control).collect();
        assert_eq!(controls, [Control::Pedal, Control::LatCyclic]);
        assert!(flown(&["pedal:doublet:0.0005:1"]).is_empty());
    }
}
