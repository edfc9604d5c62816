//! What the aircraft did less what the model says at the state and controls that it had: forces and moments, axis by axis.
//!
//! Consumes the problem and where the search ended; the state along each run is that of the extended model's filter. Produces
//!     e = a_measured - F_model(x, u)                                                                  (1)
//! as the instruments see it (`residual_series`); its rms, the part of its power that the causes explain,
//! 1 - (rms after)^2/(rms before)^2 with the noise taken from both, and the band that holds 80 % of the power of what is left.
//! Powers are those of means over a quarter of a second: what instruments' noise makes of a moment at a single step, a
//! difference of two rates, would drown every motion that an aircraft has.

use super::residual_series::FilteredRun;
use crate::flight::derivative::{AXES, Axis, VARIABLES};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::search::forward_search::SearchResult;
use core::f64::consts::TAU;

/// Part of the power that a band holds.
const HELD: f64 = 0.8;
/// Length of the means whose power is reported, s.
const MEAN_S: f64 = 0.25;
/// Highest frequency of the spectrum, Hz.
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
    /// What the instruments' noise alone would make, as the records show it.
    pub noise: f64,
    /// Of what was measured about its mean, its noise taken off.
    pub motion: f64,
    /// Part of the power that the causes explain.
    pub explained: f64,
    /// Where most of the power is that is left, or was there where little is left, Hz.
    pub band_hz: (f64, f64),
}

impl Discrepancy {
    /// Whether what is left is more than what the instruments' noise makes there.
    pub(crate) fn exceeds_noise(&self) -> bool {
        self.rms_after > self.noise
    }
}

/// (1) of one run by axis: before and after, at the steps.
#[derive(Default)]
pub(crate) struct RunResiduals {
    pub(crate) before: [Vec<f64>; AXES],
    pub(crate) after: [Vec<f64>; AXES],
    /// What was measured, about its mean.
    pub(crate) measured: [Vec<f64>; AXES],
    pub(crate) step_s: f64,
}

/// By axis.
pub fn discrepancy(problem: &DiagnosisProblem, searched: &SearchResult) -> [Discrepancy; AXES] {
    let all: Vec<RunResiduals> = (0..problem.runs.len()).map(|number| run_residuals(problem, searched, number)).collect();
    core::array::from_fn(|axis| {
        let of = |series: fn(&RunResiduals) -> &[Vec<f64>; AXES]| {
            all.iter().map(|one| (&series(one)[axis], one.step_s)).collect::<Vec<_>>()
        };
        let (before_series, after_series) = (of(|one| &one.before), of(|one| &one.after));
        let noise = noise_power(problem, axis);
        let beyond_noise = |series: &[(&Vec<f64>, f64)]| (mean_power(series) - noise).max(0.0);
        let (before, after) = (beyond_noise(&before_series), beyond_noise(&after_series));
        let motion = beyond_noise(&of(|one| &one.measured));
        let explained = if before > 0.0 { (1.0 - after / before).clamp(0.0, 1.0) } else { 0.0 };
        let band_hz = band(if explained < 0.5 { after_series } else { before_series });
        Discrepancy {
            axis: Axis::ALL.get(axis).copied().unwrap_or(Axis::X),
            rms: libm::sqrt(before),
            rms_after: libm::sqrt(after),
            noise: libm::sqrt(noise),
            motion: libm::sqrt(motion),
            explained,
            band_hz,
        }
    })
}

/// Mean square of means over [`MEAN_S`].
fn mean_power(series: &[(&Vec<f64>, f64)]) -> f64 {
    let means = series.iter().flat_map(|(values, step_s)| {
        let steps = steps(*step_s);
        values.chunks_exact(steps).map(move |part| part.iter().sum::<f64>() / steps as f64)
    });
    let (sum, count) = means.fold((0.0, 0.0), |(sum, count), e| (sum + e * e, count + 1.0));
    sum / f64::max(count, 1.0)
}

fn steps(step_s: f64) -> usize {
    (libm::round(MEAN_S / step_s) as usize).max(1)
}

/// Power of the instruments' noise in means of (1).
fn noise_power(problem: &DiagnosisProblem, axis: usize) -> f64 {
    let parts = problem.runs.iter().filter_map(|run| {
        let run_residuals = run.outputs.get(axis)?.as_ref()?;
        let count = (run.mesh.step_s / run_residuals.interval_s()?).max(1.0);
        let one = run.recorded_noise.get(axis)?;
        // A step's mean of straight lines between n samples weighs the two at either end by 7/8 and 1/8, the latter those of
        // the step beside, so that neighbours have something in common.
        let (own, beside) = if count > 1.5 { (count - 0.4375, 0.21875) } else { (0.59375, 0.1875) };
        let one = one * one / (count * count);
        let n = steps(run.mesh.step_s) as f64;
        Some(match axis {
            0..3 => one * (n * own + 2.0 * (n - 1.0) * beside) / (n * n),
            // Differences add up to one between the ends.
            _ => 2.0 * one * (own - if n > 1.0 { 0.0 } else { beside }) / (n * n * run.mesh.step_s * run.mesh.step_s),
        })
    });
    let (sum, count) = parts.fold((0.0, 0.0), |(sum, count), part| (sum + part, count + 1.0));
    sum / f64::max(count, 1.0)
}

pub(crate) fn run_residuals(problem: &DiagnosisProblem, searched: &SearchResult, number: usize) -> RunResiduals {
    let Some(flown) = FilteredRun::of(problem, searched, number) else { return RunResiduals::default() };
    let nodes = problem.runs.get(number).map_or(0, |run| run.mesh.nodes.saturating_sub(1));
    RunResiduals {
        measured: core::array::from_fn(|axis| about_mean(flown.measured(axis, nodes))),
        before: flown.residuals(&problem.fixed, &[[0.0; VARIABLES]; AXES]),
        after: flown.residuals(&problem.effects(&searched.point), &searched.point.derivative_errors),
        step_s: flown.step_s(),
    }
}

fn about_mean(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
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
