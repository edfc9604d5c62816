//! Single-run fits: each run of a joint fit refitted by itself, for comparison of the estimates between runs.
//!
//! Consumes the runs and the joint minimum; for each run minimises (1) of `fit` from the joint estimate, with the run's noise and
//! the same set of free parameters. A full minimisation is needed: one linearisation about the joint minimum would carry the
//! joint estimate into each run's. A bias shared by all runs becomes the run's own bias. `None` where the filter fails on a run.

use super::fit::{FitLinearisation, ParameterPoint, RunWithNoise, minimise, parameter_at, place_of};
use super::parameter::{BIAS, InstrumentError, PARAMETERS, SHARED_BIAS};
use super::record::InstrumentErrorKind;
use crate::num::parallel_map::parallel_map;

/// A run fitted by itself: parameters and normal equations at its minimum.
#[derive(Clone, Debug)]
pub(crate) struct SingleRunFit {
    run: RunWithNoise,
    point: ParameterPoint,
    local: FitLinearisation,
}

impl SingleRunFit {
    /// Fits one run; `None` where the filter fails.
    fn of(runs: &[RunWithNoise], joint: &ParameterPoint, number: usize) -> Option<SingleRunFit> {
        let (run, point) = separate(runs, joint, number)?;
        let (point, local) = minimise(std::slice::from_ref(&run), &point)?;
        Some(SingleRunFit { run, point, local })
    }

    /// A fit for each of two or more runs; empty for a single run.
    pub(crate) fn each(runs: &[RunWithNoise], joint: &ParameterPoint) -> Vec<Option<SingleRunFit>> {
        let numbers: Vec<usize> = if runs.len() > 1 { (0..runs.len()).collect() } else { Vec::new() };
        parallel_map(&numbers, |&number| SingleRunFit::of(runs, joint, number))
    }

    /// A parameter and its standard error, a factor as such; `None` where it does not act on this run.
    pub(crate) fn estimate(&self, parameter: InstrumentError) -> Option<(f64, f64)> {
        let place = place_of(0, parameter.index);
        let value = *self.local.minimum(&self.point).get(place)?;
        let colour = self.local.colour(std::slice::from_ref(&self.run), &[place]);
        let std = libm::sqrt(colour * self.local.variance_of(&[place]));
        let shown = if parameter.kind == InstrumentErrorKind::Scale { 1.0 + value } else { value };
        self.run.active.contains(&parameter.index).then_some((shown, std))
    }
}

/// One run of the joint fit with the start of its single-run fit: the joint estimates, shared biases made the run's own.
pub(crate) fn separate(runs: &[RunWithNoise], joint: &ParameterPoint, number: usize) -> Option<(RunWithNoise, ParameterPoint)> {
    let mut run = runs.get(number)?.clone();
    run.active.retain(|&index| index < SHARED_BIAS);
    let mut point = ParameterPoint::zero(std::slice::from_ref(&run));
    (point.lag, point.sample_s) = (joint.lag, joint.sample_s);
    let own = |index: usize| if index >= SHARED_BIAS { BIAS + index - SHARED_BIAS } else { index };
    for (index, value) in joint.theta(number).values.into_iter().enumerate().take(PARAMETERS) {
        point.values[place_of(0, own(index))] += value;
    }
    for &place in &joint.free {
        let (parameter, whose) = parameter_at(place);
        let here = place_of(0, own(parameter.index));
        if whose.is_none_or(|whose| whose == number) && !point.free.contains(&here) {
            point.free.push(here);
        }
    }
    Some((run, point))
}
