//! What the aircraft did less what the model says at the state and controls that it had: forces and moments, axis by axis.
//!
//! Consumes the problem and where the search ended; the state along each run is that of the extended model's filter. Produces
//!     e = a_measured - F_model(x, u)                                                                  (1)
//! for accelerometers at the nodes and, of the gyros, for the difference of two means over the step between them; its rms, the
//! part of its power that the causes explain, 1 - (rms after)^2/(rms before)^2 with the noise taken from both, and the band that
//! holds 80 % of the power of what is left.

use super::driven::Driven;
use super::filter::State;
use super::posed::deviations;
use super::problem::Problem;
use super::record::{ROTOR, Record};
use super::search::Searched;
use crate::flight::derivative::{AXES, Axis, VARIABLES};
use crate::flight::effect::Effect;
use core::f64::consts::TAU;

/// Part of the power that a band holds.
const HELD: f64 = 0.8;
/// Highest frequency that is looked at, Hz.
const HIGHEST_HZ: f64 = 4.0;

/// Of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy {
    /// The axis.
    pub axis: Axis,
    /// Of (1) for the model as it was, its noise taken off, m/s^2 or rad/s^2.
    pub rms: f64,
    /// For the extended model.
    pub rms_after: f64,
    /// What noise alone would make.
    pub noise: f64,
    /// Part of the power that the causes explain.
    pub explained: f64,
    /// Where most of the power is that is left, or was there where little is left, Hz.
    pub band_hz: (f64, f64),
}

/// (1) of one run by axis: before and after, at the steps.
struct Series {
    before: [Vec<f64>; AXES],
    after: [Vec<f64>; AXES],
    step_s: f64,
}

/// By axis.
pub fn discrepancy(problem: &Problem, searched: &Searched) -> [Discrepancy; AXES] {
    let all: Vec<Series> = problem.runs.iter().enumerate().map(|(number, run)| series(problem, searched, number, run)).collect();
    core::array::from_fn(|axis| {
        let pick =
            |after: bool| all.iter().map(move |one| (if after { &one.after[axis] } else { &one.before[axis] }, one.step_s));
        let power = |after: bool| {
            let (sum, count) =
                pick(after).flat_map(|(values, _)| values).fold((0.0, 0.0), |(sum, count), e| (sum + e * e, count + 1.0));
            sum / f64::max(count, 1.0)
        };
        let noise = noise_power(problem, axis);
        let (before, after) = ((power(false) - noise).max(0.0), (power(true) - noise).max(0.0));
        let explained = if before > 0.0 { (1.0 - after / before).clamp(0.0, 1.0) } else { 0.0 };
        let band_hz = band(pick(explained < 0.5).collect());
        Discrepancy {
            axis: Axis::ALL.get(axis).copied().unwrap_or(Axis::X),
            rms: libm::sqrt(before),
            rms_after: libm::sqrt(after),
            noise: libm::sqrt(noise),
            explained,
            band_hz,
        }
    })
}

/// Power of the instruments' noise in (1).
fn noise_power(problem: &Problem, axis: usize) -> f64 {
    let parts = problem.runs.iter().filter_map(|run| {
        let series = run.outputs.get(axis)?.as_ref()?;
        let count = (run.mesh.step_s / series.interval_s()?).max(1.0);
        let one = run.output_noise.get(axis)?;
        let mean = one * one / count;
        Some(if axis < 3 { mean } else { 2.0 * mean / (run.mesh.step_s * run.mesh.step_s) })
    });
    let (sum, count) = parts.fold((0.0, 0.0), |(sum, count), part| (sum + part, count + 1.0));
    sum / f64::max(count, 1.0)
}

fn series(problem: &Problem, searched: &Searched, number: usize, run: &Record) -> Series {
    let trim = problem.aircraft.trim();
    let small = &searched.point.small;
    let plain: Vec<Effect> = problem.fixed.clone();
    let whole = problem.effects(&searched.point);
    let (model, extended) =
        (problem.aircraft.changed(&plain, &[[0.0; VARIABLES]; AXES]), problem.aircraft.changed(&whole, small));
    let (driven, moved) = (Driven::of(run, trim, &plain), Driven::of(run, trim, &whole));
    let mut series = Series { before: Default::default(), after: Default::default(), step_s: run.mesh.step_s };
    let Some(passed) = searched.local.runs.get(number) else { return series };
    let half = 0.5 * run.mesh.step_s;
    for (node, x) in passed.states.iter().enumerate() {
        let (Some(at_node), Some(moved_at_node)) = (driven.nodes.get(node), moved.nodes.get(node)) else { continue };
        let before = model.forces(&deviations(trim, x, at_node), at_node[ROTOR]);
        let after = extended.forces(&deviations(trim, x, moved_at_node), moved_at_node[ROTOR]);
        let time_s = run.mesh.time_s(node);
        for axis in 0..3 {
            if let Some(series_of) = run.outputs[axis].as_ref() {
                let measured = series_of.mean(time_s - half, time_s + half);
                series.before[axis].push(measured - before[axis]);
                series.after[axis].push(measured - after[axis]);
            }
        }
        let Some(next) = passed.states.get(node + 1) else { continue };
        let (Some(over), Some(moved_over)) = (driven.steps.get(node), moved.steps.get(node)) else { continue };
        let middle: State = core::array::from_fn(|i| 0.5 * (x[i] + next[i]));
        let before = model.forces(&deviations(trim, &middle, over), over[ROTOR]);
        let after = extended.forces(&deviations(trim, &middle, moved_over), moved_over[ROTOR]);
        for axis in 3..AXES {
            if let Some(gyro) = run.outputs[axis].as_ref() {
                let at = |t: f64| gyro.mean(t - half, t + half);
                let measured = (at(time_s + run.mesh.step_s) - at(time_s)) / run.mesh.step_s;
                series.before[axis].push(measured - before[axis]);
                series.after[axis].push(measured - after[axis]);
            }
        }
    }
    series
}

/// The narrowest band from below that leaves out as much on either side of [`HELD`] of the power.
fn band(all: Vec<(&Vec<f64>, f64)>) -> (f64, f64) {
    let longest_s = all.iter().map(|(values, step_s)| values.len() as f64 * step_s).fold(0.0, f64::max);
    if !(longest_s > 0.0) {
        return (0.0, 0.0);
    }
    let lines = (HIGHEST_HZ * longest_s) as usize;
    let mut power = vec![0.0; lines + 1];
    for (values, step_s) in all {
        for (line, power) in power.iter_mut().enumerate().skip(1) {
            let omega = TAU * line as f64 / longest_s * step_s;
            let (mut re, mut im) = (0.0, 0.0);
            for (k, value) in values.iter().enumerate() {
                let (sin, cos) = libm::sincos(omega * k as f64);
                re += value * cos;
                im -= value * sin;
            }
            *power += re * re + im * im;
        }
    }
    let whole: f64 = power.iter().sum();
    let at = |part: f64| {
        let mut sum = 0.0;
        let line = power.iter().position(|one| {
            sum += one;
            sum >= part * whole
        });
        line.unwrap_or(lines) as f64 / longest_s
    };
    (at(0.5 * (1.0 - HELD)), at(1.0 - 0.5 * (1.0 - HELD)))
}
