//! The signals that the residuals correlate with: spectra against noise, coherence with states and controls.
//!
//! Consumes the problem and where the search ended; produces by axis, all runs together, the density (2) of `spectrum` of the
//! residual before and after, that of the instruments' own noise, white in the reading,
//!     N_k = 2 dt sigma^2/n (forces)     N_k = 2 dt sigma^2/n (2 - 2 cos 2 pi f_k dt)/dt^2 (moments)        (1)
//! with n samples a step, and the coherence with each signal. A signal correlates with the residual in a band where the coherence
//! passes what chance passes once in 1/[`CHANCE`] such pictures, however many lines and signals they have.
//! Segments are [`SEGMENT_S`] long, less where the runs are so short that there would be fewer than [`FEWEST`].

use super::residual::{RunResiduals, run_residuals};
use super::residual_series::FilteredRun;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::derivative::{Axis, Variable};
use crate::num::welch::{SegmentSpectrum, WelchConfig, coherence_by_chance};
use crate::postflight::diagnosis::data::run_data::ROTOR;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::likelihood::state::ATTITUDE;
use crate::postflight::diagnosis::search::forward_search::SearchResult;
use core::f64::consts::TAU;

/// Length of a segment, s.
pub const SEGMENT_S: f64 = 8.0;
/// Fewest segments for an estimate of coherence.
pub const FEWEST: usize = 8;
/// Highest line, Hz.
pub const HIGHEST_HZ: f64 = 4.0;
/// Chance that anything at all is called coherent where nothing is, an axis.
pub const CHANCE: f64 = 0.01;
const STRONGEST: usize = 3;
/// A strongest line stands out of its noise by so much, in power.
const STANDS_OUT: f64 = 4.0;

/// A state or an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// A velocity, a rate or a control: its deviation from trim.
    Of(Variable),
    /// An attitude angle or the rotor's speed.
    Read(Channel),
}

impl Signal {
    /// As run files and models name it.
    pub fn name(self, naming: ControlNames) -> &'static str {
        match self {
            Signal::Of(variable) => variable.name(naming),
            Signal::Read(channel) => channel.name(naming),
        }
    }
}

/// Coherence of an axis's residual with a signal, by line.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalCoherence {
    /// The signal.
    pub signal: Signal,
    /// Of the model as it was.
    pub before: Vec<f64>,
    /// Of the extended model.
    pub after: Vec<f64>,
}

/// A band in which a residual is coherent with a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DominantSignal {
    /// The signal.
    pub signal: Signal,
    /// The largest coherence in the band.
    pub coherence: f64,
    /// The lines about it that all pass the level, Hz.
    pub band_hz: (f64, f64),
}

/// Of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSpectrum {
    /// The axis.
    pub axis: Axis,
    /// Frequencies of the lines, Hz.
    pub hz: Vec<f64>,
    /// Density of the residual, (m/s^2)^2/Hz or (rad/s^2)^2/Hz.
    pub before: Vec<f64>,
    /// With the causes in the model.
    pub after: Vec<f64>,
    /// (1).
    pub noise: Vec<f64>,
    /// Every signal that moves.
    pub signals: Vec<SignalCoherence>,
    /// Coherence that chance passes with [`CHANCE`].
    pub level: f64,
    /// How many segments were averaged.
    pub segments: usize,
}

impl AxisSpectrum {
    /// The most coherent signal in the band that holds most of it; `None` where none passes the level.
    pub fn dominant_signal(&self, after: bool) -> Option<DominantSignal> {
        let lines = self.signals.iter().flat_map(|one| {
            let coherence = if after { &one.after } else { &one.before };
            coherence.iter().enumerate().map(move |(line, value)| (one.signal, coherence, line, *value))
        });
        // A line of little power says little, however coherent.
        let power = if after { &self.after } else { &self.before };
        let carried = |line: usize, value: f64| value * power.get(line).copied().unwrap_or(0.0);
        let passing = lines.filter(|(.., value)| *value > self.level);
        let (signal, coherence, line, _) = passing.max_by(|a, b| carried(a.2, a.3).total_cmp(&carried(b.2, b.3)))?;
        let passes = |line: &usize| coherence.get(*line).is_some_and(|value| *value > self.level);
        let first = (0..=line).rev().take_while(passes).last().unwrap_or(line);
        let last = (line..coherence.len()).take_while(passes).last().unwrap_or(line);
        let most = coherence.get(first..=last)?.iter().copied().fold(0.0, f64::max);
        Some(DominantSignal { signal, coherence: most, band_hz: (*self.hz.get(first)?, *self.hz.get(last)?) })
    }

    /// The strongest lines of the residual that stand out of the noise: places, the strongest first.
    pub fn strongest(&self) -> Vec<usize> {
        let at = |line: usize| self.before.get(line).copied().unwrap_or(0.0);
        let peak = |line: &usize| (*line == 0 || at(*line) >= at(line - 1)) && at(*line) > at(line + 1);
        let stands_out = |line: &usize| self.noise.get(*line).is_some_and(|noise| at(*line) > STANDS_OUT * noise);
        let mut lines: Vec<usize> = (0..self.before.len()).filter(peak).filter(stands_out).collect();
        lines.sort_by(|a, b| at(*b).total_cmp(&at(*a)));
        lines.truncate(STRONGEST);
        lines
    }
}

/// By axis.
pub fn residual_coherence(problem: &DiagnosisProblem, searched: &SearchResult) -> Vec<AxisSpectrum> {
    let lengths_s = problem.runs.iter().map(|run| run.mesh.length_s());
    // Of half-overlapping segments of length T, runs of lengths L have 2 L/T - 1 each.
    let segment_s = SEGMENT_S.min(2.0 * lengths_s.sum::<f64>() / (FEWEST + problem.runs.len()) as f64);
    let cut = WelchConfig::lines(segment_s, (HIGHEST_HZ * segment_s + 1e-9) as u32);
    let all: Vec<RunResiduals> = (0..problem.runs.len()).map(|number| run_residuals(problem, searched, number)).collect();
    let signals = signals(problem, searched, &cut);
    Axis::ALL.into_iter().map(|axis| of_axis(problem, &cut, &all, &signals, axis)).collect()
}

/// The segments of every signal that moves, run after run.
fn signals(problem: &DiagnosisProblem, searched: &SearchResult, cut: &WelchConfig) -> Vec<(Signal, Vec<Vec<SegmentSpectrum>>)> {
    let effects = problem.effects(&searched.point);
    let flown: Vec<_> = (0..problem.runs.len())
        .filter_map(|number| FilteredRun::of(problem, searched, number).map(|flown| (flown.step_s(), flown.motion(&effects))))
        .collect();
    let attitude = [Channel::Phi, Channel::Theta, Channel::RotorSpeed].map(Signal::Read);
    let every = Variable::ALL.into_iter().map(Signal::Of).chain(attitude);
    let moving = every.filter_map(|signal| {
        let mut moves = false;
        let of_run = flown.iter().map(|(step_s, motion)| {
            let values: Vec<f64> = motion
                .iter()
                .map(|(deviations, x, rotor)| match signal {
                    Signal::Of(variable) => deviations[variable.index()],
                    Signal::Read(Channel::Phi) => x[ATTITUDE],
                    Signal::Read(Channel::Theta) => x[ATTITUDE + 1],
                    Signal::Read(_) => *rotor,
                })
                .collect();
            moves |= values.iter().any(|value| values.first().is_some_and(|first| libm::fabs(value - first) > 1e-9));
            // A moment's residual has a node less.
            cut.segments(values.get(..values.len().saturating_sub(1)).unwrap_or(&[]), *step_s)
        });
        let of_run: Vec<Vec<SegmentSpectrum>> = of_run.collect();
        moves.then_some((signal, of_run))
    });
    moving.filter(|(signal, _)| *signal != Signal::Read(Channel::RotorSpeed) || problem.has_input(ROTOR)).collect()
}

fn of_axis(
    problem: &DiagnosisProblem,
    cut: &WelchConfig,
    all: &[RunResiduals],
    signals: &[(Signal, Vec<Vec<SegmentSpectrum>>)],
    axis: Axis,
) -> AxisSpectrum {
    let place = axis.index();
    let segments = |after: bool| -> Vec<Vec<SegmentSpectrum>> {
        let of_run = all.iter().map(|one| {
            let values = if after { &one.after[place] } else { &one.before[place] };
            // As many as the motion has, above.
            let count = if axis.is_force() { values.len().saturating_sub(1) } else { values.len() };
            cut.segments(values.get(..count).unwrap_or(&[]), one.step_s)
        });
        of_run.collect()
    };
    let (before, after) = (segments(false), segments(true));
    let with = |residual: &[Vec<SegmentSpectrum>], signal: &[Vec<SegmentSpectrum>]| {
        let pairs =
            residual.iter().zip(signal).flat_map(|(residual, signal)| residual.iter().cloned().zip(signal.iter().cloned()));
        let (residual, signal): (Vec<SegmentSpectrum>, Vec<SegmentSpectrum>) = pairs.unzip();
        cut.coherence(&residual, &signal)
    };
    let residual_coherence: Vec<SignalCoherence> = signals
        .iter()
        .map(|(signal, own)| SignalCoherence { signal: *signal, before: with(&before, own), after: with(&after, own) })
        .collect();
    let count = before.iter().map(Vec::len).sum();
    let tests = (cut.hz.len() * residual_coherence.len()).max(1) as f64;
    AxisSpectrum {
        axis,
        hz: cut.hz.clone(),
        before: cut.density(&before.concat()),
        after: cut.density(&after.concat()),
        noise: cut.hz.iter().map(|&hz| noise_density(problem, axis, hz)).collect(),
        level: coherence_by_chance(count, CHANCE / tests),
        signals: residual_coherence,
        segments: count,
    }
}

/// (1), the mean over the runs.
fn noise_density(problem: &DiagnosisProblem, axis: Axis, hz: f64) -> f64 {
    let of_run = problem.runs.iter().filter_map(|run| {
        let step_s = run.mesh.step_s;
        let count = (step_s / run.outputs.get(axis.index())?.as_ref()?.interval_s()?).max(1.0);
        let std = run.recorded_noise.get(axis.index())?;
        let level = 2.0 * step_s * std * std / count;
        Some(if axis.is_force() { level } else { level * (2.0 - 2.0 * libm::cos(TAU * hz * step_s)) / (step_s * step_s) })
    });
    let (sum, count) = of_run.fold((0.0, 0.0), |(sum, count), level| (sum + level, count + 1.0));
    sum / f64::max(count, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(before: &[f64], coherence: &[(Signal, &[f64])]) -> AxisSpectrum {
        AxisSpectrum {
            axis: Axis::N,
            hz: (0..before.len()).map(|line| 0.125 * (line + 1) as f64).collect(),
            before: before.to_vec(),
            after: vec![0.0; before.len()],
            noise: vec![1.0; before.len()],
            signals: coherence
                .iter()
                .map(|(signal, before)| SignalCoherence {
                    signal: *signal,
                    before: before.to_vec(),
                    after: vec![0.0; before.len()],
                })
                .collect(),
            level: 0.5,
            segments: 16,
        }
    }

    #[test]
    fn the_strongest_lines_and_the_signal_that_carries_them_are_told() {
        let (pedal, phi) = (Signal::Of(Variable::Pedal), Signal::Read(Channel::Phi));
        let residual = [1.0, 9.0, 20.0, 8.0, 2.0, 5.0, 3.0];
        let with_pedal = [0.2, 0.6, 0.9, 0.7, 0.4, 0.6, 0.1];
        // More coherent, where hardly anything is.
        let with_phi = [0.99, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3];
        let found = one(&residual, &[(phi, &with_phi), (pedal, &with_pedal)]);
        assert_eq!(found.strongest(), [2, 5]);
        let together = found.dominant_signal(false).unwrap();
        assert_eq!(together, DominantSignal { signal: pedal, coherence: 0.9, band_hz: (0.25, 0.5) });
        assert!(found.dominant_signal(true).is_none());
        assert_eq!((pedal.name(ControlNames::FixedWing), phi.name(ControlNames::Rotorcraft)), ("rudder", "phi"));
    }
}
