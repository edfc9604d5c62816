//! Outlier runs: groups of runs that share one set of instrument errors, found by backward elimination of runs.
//!
//! Consumes runs; produces groups, each with its fault search: the runs that share their instruments' errors, and outliers. With
//! J_i a run's part of the joint cost at the joint minimum, E_i the evidence of its own fit (complexity penalty included) and f_i
//! the effective number of shared parameters that it determines by itself,
//!     G_i = J_i - E_i,  expected value f_i (1 - 1/runs) for healthy runs                                 (1)
//! because each of those parameters also fits some of that run's noise. Where (G_i - f_i)/sqrt(2 f_i) > ODD in any run, or two
//! runs' own estimates of a shared fault differ significantly, the run is removed whose removal gives the least total cost, and
//! the test is repeated on the others. Outliers that agree with each other are joined in one group.
//! E_i needs a fault search of its own. An upper bound spares most runs that search: with every candidate fault free and no
//! penalty, a run costs less than after any search, and one linearisation about the joint minimum gives
//!     G_i <= J_i - J_free + g' C g                                                                      (2)
//! (J_free its cost there under the priors of the free parameters, g the gradient's negative half, C the inverse information).

use super::fault_selection::{FaultSearch, candidates, penalty, select};
use super::filter::{Prepared, pass};
use super::fit::{FitLinearisation, ParameterPoint, RunWithNoise, SHARED, linearise, parameter_at};
use super::noise::{first_guess, improve, prior};
use super::record::InstrumentErrorKind;
use super::single_run::{SingleRunFit, separate};
use crate::num::parallel_map::parallel_map;

/// Normalised (1): healthy runs have -2.5 to 0, one with r or beta 1.15 times the truth in a lateral manoeuvre 20.
const ODD: f64 = 6.0;
/// Standard errors of their difference by which two runs' own values of a shared fault are apart.
const APART: f64 = 5.0;
/// Sweeps over the variances within which the noise settles.
const SWEEPS: usize = 8;

/// Runs that were fitted together.
#[derive(Clone, Debug)]
pub(crate) struct RunGroup {
    /// Which, by their places among all.
    pub(crate) members: Vec<usize>,
    /// The fault search of these runs, in that order.
    pub(crate) found: FaultSearch,
    /// Single-run fits, where the group has more than one run.
    pub(crate) alone: Vec<Option<SingleRunFit>>,
    /// Whether it was separated from other runs as an outlier.
    pub(crate) apart: bool,
}

/// The fault search of one run alone.
struct SeparateFit {
    found: FaultSearch,
    /// E of (1).
    cost: Option<f64>,
    /// f of (1).
    freedom: f64,
}

impl SeparateFit {
    fn of(run: &RunWithNoise) -> Option<SeparateFit> {
        let found = select(vec![run.clone()])?;
        Some(SeparateFit { cost: single_run_evidence(&found), freedom: freedom(&found.point, &found.local), found })
    }

    fn group(&self, run: usize, apart: bool) -> RunGroup {
        RunGroup { members: vec![run], found: self.found.clone(), alone: Vec::new(), apart }
    }
}

/// E of a run by itself, at its maximum-likelihood noise.
pub(crate) fn single_run_evidence(found: &FaultSearch) -> Option<f64> {
    Some(settled(found, 0)? + found.point.prior_cost() + penalty(&found.point, &found.local))
}

/// The groups of runs; a run on which the filter fails is in none.
pub(crate) fn groups(runs: &[RunWithNoise]) -> Vec<RunGroup> {
    if let [run] = runs {
        let found = select(vec![run.clone()]);
        return found.into_iter().map(|found| RunGroup { members: vec![0], found, alone: Vec::new(), apart: false }).collect();
    }
    let joint = |these: &[usize]| select(these.iter().filter_map(|&run| runs.get(run).cloned()).collect());
    let all: Vec<usize> = (0..runs.len()).collect();
    let of_all = (all.len() > 1).then(|| joint(&all)).flatten();
    let agreed = of_all.as_ref().and_then(agreeing_by_bound);
    let of_all = match (of_all, agreed) {
        (Some(found), Some(alone)) => return vec![RunGroup { members: all, found, alone, apart: false }],
        (of_all, _) => of_all,
    };
    let itself: Vec<Option<SeparateFit>> = parallel_map(runs, SeparateFit::of);
    let mut together: Vec<usize> = (0..runs.len()).filter(|&run| itself.get(run).is_some_and(Option::is_some)).collect();
    let by_itself = |run: usize, apart: bool| itself.get(run)?.as_ref().map(|one| one.group(run, apart));
    let mut groups = Vec::new();
    let mut rest = if together == all { of_all } else { (together.len() > 1).then(|| joint(&together)).flatten() };
    let mut agreed = None;
    while together.len() > 1 {
        agreed = rest.as_ref().and_then(|joint| agreeing(joint, &together, &itself));
        if agreed.is_some() {
            break;
        }
        if together.len() == 2 {
            groups.extend(together.drain(..).filter_map(|run| by_itself(run, true)));
        } else {
            let Some((run, others)) = most_outlying(&together, &itself, joint) else { break };
            groups.extend(by_itself(run, true));
            together.retain(|one| *one != run);
            rest = Some(others);
        }
    }
    rejoin(&mut groups, &joint, &itself);
    match rest {
        Some(found) if together.len() > 1 => {
            let alone = agreed.unwrap_or_else(|| SingleRunFit::each(&found.runs, &found.point));
            groups.push(RunGroup { members: together, found, alone, apart: false });
        }
        _ => {
            let first = groups.is_empty();
            groups.extend(together.pop().and_then(|run| by_itself(run, !first)));
        }
    }
    groups
}

/// Joins outliers that agree with each other.
fn rejoin(groups: &mut Vec<RunGroup>, joint: &impl Fn(&[usize]) -> Option<FaultSearch>, itself: &[Option<SeparateFit>]) {
    let mut members: Vec<usize> = groups.iter().flat_map(|group| group.members.clone()).collect();
    members.sort_unstable();
    if members.len() < 2 {
        return;
    }
    let Some(found) = joint(&members) else { return };
    if let Some(alone) = agreeing(&found, &members, itself) {
        *groups = vec![RunGroup { members, found, alone, apart: true }];
    }
}

/// Single-run fits; `None` where a run is an outlier by (1) or runs differ significantly in a shared fault.
fn agreeing(joint: &FaultSearch, together: &[usize], itself: &[Option<SeparateFit>]) -> Option<Vec<Option<SingleRunFit>>> {
    let places: Vec<usize> = (0..together.len()).collect();
    let excess = parallel_map(&places, |&place| {
        let itself = itself.get(*together.get(place)?)?.as_ref()?;
        let shared = settled(joint, place)? + joint.point.own_prior_cost(place);
        Some((shared - itself.cost?, itself.freedom))
    });
    if excess.into_iter().flatten().any(|excess| normalised_excess(excess) > ODD) {
        return None;
    }
    let alone = SingleRunFit::each(&joint.runs, &joint.point);
    (!disagree(joint, &alone)).then_some(alone)
}

/// (G - f)/sqrt(2 f) for G and f of (1).
fn normalised_excess((excess, free): (f64, f64)) -> f64 {
    let free = free.max(1.0);
    (excess - free) / libm::sqrt(2.0 * free)
}

/// [`agreeing`] by the bound (2), without a fault search per run; `None` also where the bound decides nothing.
fn agreeing_by_bound(joint: &FaultSearch) -> Option<Vec<Option<SingleRunFit>>> {
    let places: Vec<usize> = (0..joint.runs.len()).collect();
    let excess = parallel_map(&places, |&place| excess_at_most(joint, place));
    if !excess.into_iter().all(|excess| excess.is_some_and(|excess| normalised_excess(excess) <= ODD)) {
        return None;
    }
    let alone = SingleRunFit::each(&joint.runs, &joint.point);
    (!disagree(joint, &alone)).then_some(alone)
}

/// The bound (2) on G, and f.
fn excess_at_most(joint: &FaultSearch, place: usize) -> Option<(f64, f64)> {
    let (mut run, mut point) = separate(&joint.runs, &joint.point, place)?;
    let guess = first_guess(&run.record);
    run.noise = improve(&run.record, &point.theta(0), &run.noise, &guess, SWEEPS)?;
    let run = std::slice::from_ref(&run);
    let free = freedom(&point, &linearise(run, &point)?);
    point.free = candidates(run, &point.clone()).into_iter().chain(point.free).collect();
    let local = linearise(run, &point)?;
    let step = local.step();
    let falls: f64 = step.iter().zip(&local.pull).map(|(step, pull)| step * pull).sum();
    Some((joint.point.own_prior_cost(place) - point.prior_cost() + falls, free))
}

/// Whether the runs' own values of a shared fault are too far apart.
fn disagree(joint: &FaultSearch, alone: &[Option<SingleRunFit>]) -> bool {
    let shared = joint.point.free.iter().map(|&place| parameter_at(place)).filter(|(_, own)| own.is_none());
    shared.map(|(parameter, _)| parameter).filter(|parameter| parameter.kind != InstrumentErrorKind::Bias).any(|parameter| {
        let said: Vec<(f64, f64)> = alone.iter().flatten().filter_map(|one| one.estimate(parameter)).collect();
        let pairs = said.iter().enumerate().flat_map(|(k, a)| said.iter().skip(k + 1).map(move |b| (a, b)));
        pairs.into_iter().any(|(a, b)| (a.0 - b.0).abs() > APART * libm::hypot(a.1, b.1))
    })
}

/// The run without which the others, fitted anew, and it by itself cost least; with that fit of the others.
fn most_outlying(
    together: &[usize],
    itself: &[Option<SeparateFit>],
    joint: impl Fn(&[usize]) -> Option<FaultSearch>,
) -> Option<(usize, FaultSearch)> {
    let mut best: Option<(f64, usize, FaultSearch)> = None;
    for &run in together {
        let rest: Vec<usize> = together.iter().copied().filter(|other| *other != run).collect();
        let Some(own) = itself.get(run).and_then(|one| one.as_ref()?.cost) else { continue };
        let Some(found) = joint(&rest) else { continue };
        let shared: Option<f64> = (0..rest.len()).map(|place| settled(&found, place)).sum();
        let Some(shared) = shared else { continue };
        let cost = own + shared + found.point.prior_cost() + penalty(&found.point, &found.local);
        if best.as_ref().is_none_or(|best| cost < best.0) {
            best = Some((cost, run, found));
        }
    }
    best.map(|(_, run, found)| (run, found))
}

/// A run's cost at the given parameters, at the maximum-likelihood noise there, so that fits are compared at their own noise.
fn settled(found: &FaultSearch, place: usize) -> Option<f64> {
    let run = found.runs.get(place)?;
    let (theta, guess) = (found.point.theta(place), first_guess(&run.record));
    let noise = improve(&run.record, &theta, &run.noise, &guess, SWEEPS)?;
    Some(pass(&Prepared::of(&run.record, &theta), &noise, &[], true)?.cost + prior(&noise, &guess))
}

/// Effective number of shared parameters that one run determines: sum over them of 1 - C_ii/sigma_i^2, f of (1).
fn freedom(point: &ParameterPoint, local: &FitLinearisation) -> f64 {
    let determined = |place: usize| {
        let (normal, _) = point.priors(place)?;
        (!point.free.contains(&place)).then(|| 1.0 - local.dispersion[(place, place)] / (normal * normal))
    };
    (0..SHARED).filter_map(determined).map(|part| part.max(0.0)).sum()
}
