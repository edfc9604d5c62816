//! Fault selection: which instrument errors are estimated as faults, by stepwise entry and removal, and their alternatives.
//!
//! Consumes runs; produces the faults, each with its estimate, standard error, significance and its alternative explanations.
//! A parameter enters where its estimate is significant against both its (coloured) noise and the scatter among healthy
//! instruments,
//!     F = m^2/(c s^2 + sigma^2) > `enter_above`                                                      (1)
//! (m, s its estimate and standard error from the data alone, sigma the prior of healthy instruments). The best few candidates
//! are fitted in full, timing errors both as lag and as skew, and the one of least
//!     E = J + sum over the free ones of ln(sigma_free^2/C_ii)                                         (2)
//! enters: minus twice the logarithm of the Laplace approximation of the evidence, up to a constant (C the inverse information).
//! A fault whose F falls below `LEAVE` of that is removed. Each remaining one is replaced by each rival in turn: a rival whose
//! E is at most [`RIVAL`] greater cannot be distinguished from it and is reported with it.

use super::filter::KinematicNoise;
use super::fit::{FitLinearisation, ParameterPoint, ROUGH, Released, RunWithNoise, SHARED, minimise, minimise_to, parameter_at};
use super::noise::{first_guess, improve};
use super::parameter::{PER_RUN, SHARED_BIAS, TIMING};
use super::record::InstrumentErrorKind;
use crate::flight::signal::series::Series;
use crate::num::parallel_map::parallel_map;

/// F of (1) above which one of `ENTER_CANDIDATES` enters: by chance one in 250 runs.
pub(crate) const ENTER: f64 = 16.0;
const ENTER_CANDIDATES: f64 = 64.0;
/// Decrease of F per ln of the chance to exceed it, of chi-squared with one degree of freedom near ENTER.
const PER_LN_CHANCE: f64 = 1.9;
/// Part of it below which a fault is removed.
const LEAVE: f64 = 0.75;
/// Evidence within which two explanations are not separable: odds of e^6, for the residuals are not quite white.
pub(crate) const RIVAL: f64 = 12.0;
/// Spectral density of unexplained acceleration above which the air is rough, m^2/s^3: gusts of about 0.3 m/s.
const GUSTY: f64 = 0.05;

/// The same above which they feign small ones: flights in gusts of 0.3 m/s have 0.015 to 0.03, of 0.2 m/s half of it, calm ones
/// below 0.00001.
const TURBULENT: f64 = 0.003;
/// Below this speed, m/s, gusts turn the flow more than they accelerate: their angle goes as the acceleration over V^2.
const SLOW: f64 = 50.0;
const FAULTS_MAX: usize = 8;
/// Exchanges of a fault for a better rival, and one.
const ROUNDS_MAX: usize = 4;
/// A lag from which two starts are tried, s.
const LONG_LAG_S: f64 = 0.2;
/// Candidates that are fitted in full.
const SHORTLIST: usize = 6;
/// A skew with the wrong sign (a reading ahead of time) and a vane moved backwards are unusual.
const UNUSUAL: f64 = 4.0;

/// Identifies a fault: its parameter and, for timing, the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FaultKey {
    /// Its place among all values.
    pub(crate) place: usize,
    /// Of timing: a lag instead of a skew.
    pub(crate) lag: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    pub(crate) name: FaultKey,
    /// Its value, SI; a factor less one.
    pub(crate) value: f64,
    /// Standard error, coloured residuals allowed for.
    pub(crate) std: f64,
    /// F of (1).
    pub(crate) significance: f64,
    /// Rivals: key, value, standard error, evidence less its own.
    pub(crate) rivals: Vec<(FaultKey, f64, f64, f64)>,
}

/// Faults found in runs that share them, with the fit at the end.
#[derive(Clone, Debug)]
pub(crate) struct FaultSearch {
    /// Runs with their final noise.
    pub(crate) runs: Vec<RunWithNoise>,
    /// Where the parameters stand.
    pub(crate) point: ParameterPoint,
    pub(crate) local: FitLinearisation,
    pub(crate) faults: Vec<Fault>,
}

/// (2).
fn evidence(point: &ParameterPoint, local: &FitLinearisation) -> f64 {
    local.cost + penalty(point, local)
}

/// The complexity penalty of (2), with penalties for physically unusual values.
pub(crate) fn penalty(point: &ParameterPoint, local: &FitLinearisation) -> f64 {
    let mut sum = 0.0;
    for &place in &point.free {
        let (parameter, _) = parameter_at(place);
        let free = parameter.priors().map_or(1.0, |(_, free)| free);
        sum += libm::log(free * free / local.dispersion[(place, place)].max(1e-300));
        let value = point.values[place];
        let alone = matches!(parameter.kind, InstrumentErrorKind::AlphaPlace(_) | InstrumentErrorKind::BetaPlace(_));
        sum += if alone { 0.5 * UNUSUAL } else { 0.0 };
        let backwards = match parameter.kind {
            InstrumentErrorKind::Timing | InstrumentErrorKind::VanePlace(0) | InstrumentErrorKind::BetaPlace(0) => value < 0.0,
            _ => false,
        };
        sum += if backwards { UNUSUAL } else { 0.0 };
    }
    sum
}

/// F of (1).
fn significance(runs: &[RunWithNoise], point: &ParameterPoint, local: &FitLinearisation, released: &Released) -> (f64, f64) {
    let colour = local.colour(runs, &[released.place]);
    let normal = point.priors(released.place).map_or(f64::INFINITY, |(normal, _)| normal);
    let variance = colour * released.std * released.std;
    (released.value * released.value / (variance + normal * normal), libm::sqrt(variance))
}

/// A point with one more fault of that name.
fn with(point: &ParameterPoint, name: FaultKey, value: f64) -> ParameterPoint {
    let mut next = point.clone();
    next.free.push(name.place);
    next.values[name.place] = value;
    if let Some(lag) = lag_flag(&mut next, name.place) {
        *lag = name.lag;
    }
    next
}

/// A point with one fault less.
fn without(point: &ParameterPoint, place: usize) -> ParameterPoint {
    let mut next = point.clone();
    next.free.retain(|&free| free != place);
    next.values[place] = 0.0;
    if let Some(lag) = lag_flag(&mut next, place) {
        *lag = false;
    }
    next
}

fn lag_flag(point: &mut ParameterPoint, place: usize) -> Option<&mut bool> {
    point.lag.get_mut((place + PER_RUN).checked_sub(TIMING)?)
}

/// Whether both are the bias of one channel, shared or of one run.
fn same_bias(a: usize, b: usize) -> bool {
    let of = |place: usize| {
        Some(parameter_at(place).0).filter(|one| one.kind == InstrumentErrorKind::Bias).and_then(|one| one.measured)
    };
    of(a).is_some() && of(a) == of(b)
}

/// Whether that place is one of timing.
fn is_timing(place: usize) -> bool {
    parameter_at(place).0.kind == InstrumentErrorKind::Timing
}

/// F of (1) above which one of so many candidates enters: fewer, as of the attitude and the rates alone in rough air, enter by
/// chance less often in all. Bonferroni's bound to first order, p = p_64 64/n.
pub(crate) fn enter_above(candidates: usize) -> f64 {
    let fewer = (candidates.max(1) as f64 / ENTER_CANDIDATES).min(1.0);
    ENTER + PER_LN_CHANCE * libm::log(fewer)
}

/// What may be let go: everything but the flow and what no channel shows.
pub(crate) fn candidates(runs: &[RunWithNoise], point: &ParameterPoint) -> Vec<usize> {
    let acts = |place: usize| {
        let (parameter, own) = parameter_at(place);
        let on = |run: &RunWithNoise| run.active.contains(&parameter.index) && !(parameter.mimicked_by_gusts() && is_gusty(run));
        own.map_or_else(|| runs.iter().any(on), |run| runs.get(run).is_some_and(on))
    };
    let all = 0..point.values.len();
    all.filter(|&place| parameter_at(place).0.can_be_fault() && acts(place) && !point.free.contains(&place)).collect()
}

/// Whether the air of a run is so rough that gusts feign errors of air data and accelerometers.
pub(crate) fn is_gusty(run: &RunWithNoise) -> bool {
    is_rougher(run, GUSTY)
}

/// Whether the air was rough enough to feign errors that are small.
pub(crate) fn is_turbulent(run: &RunWithNoise) -> bool {
    is_rougher(run, TURBULENT)
}

fn is_rougher(run: &RunWithNoise, limit: f64) -> bool {
    let speed = run.record.outputs.first().and_then(Option::as_ref).map_or(SLOW, Series::average);
    let slower = (SLOW / speed.max(1.0)).max(1.0);
    let limit = limit / (slower * slower * slower * slower);
    run.record.velocities && run.noise.input.iter().take(3).any(|density| *density > limit)
}

/// Fits one name more, in full.
fn try_name(
    runs: &[RunWithNoise],
    point: &ParameterPoint,
    name: FaultKey,
    value: f64,
) -> Option<(f64, ParameterPoint, FitLinearisation)> {
    let value = if name.lag { value.max(0.02) } else { value };
    let start = with(point, name, value.clamp(-1.0, 1.5));
    let start = if is_timing(name.place) || parameter_at(name.place).0.kind == InstrumentErrorKind::Scale {
        start
    } else {
        with(point, name, 0.0)
    };
    let from = |start: &ParameterPoint| {
        let (point, local) = minimise_to(runs, start, ROUGH)?;
        Some((evidence(&point, &local), point, local))
    };
    let near = from(&start);
    if !(name.lag && value > LONG_LAG_S) {
        return near;
    }
    // Far from the optimum a long lag is underestimated.
    let far = from(&with(point, name, (2.0 * value).min(1.5)));
    near.into_iter().chain(far).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The names that a place may have.
fn names(place: usize, value: f64) -> Vec<FaultKey> {
    let skew = FaultKey { place, lag: false };
    if is_timing(place) && value > 0.0 { vec![skew, FaultKey { place, lag: true }] } else { vec![skew] }
}

fn estimate_noise(runs: &mut [RunWithNoise], point: &ParameterPoint, sweeps: usize) -> Option<()> {
    for (number, run) in runs.iter_mut().enumerate() {
        let guess = first_guess(&run.record);
        run.noise = improve(&run.record, &point.theta(number), &run.noise, &guess, sweeps)?;
    }
    Some(())
}

/// The candidates by their F, best first.
fn ranked(runs: &[RunWithNoise], point: &ParameterPoint, local: &FitLinearisation) -> Vec<(f64, Released)> {
    let minimum = local.minimum(point);
    let mut all: Vec<Released> =
        candidates(runs, point).into_iter().filter_map(|place| local.released(point, &minimum, place)).collect();
    all.sort_by(|a, b| b.fall.total_cmp(&a.fall));
    all.truncate(3 * SHORTLIST);
    let matters = |one: &Released| parameter_at(one.place).0.matters(one.value, point.sample_s);
    let mut ranked: Vec<(f64, Released)> =
        all.into_iter().filter(matters).map(|one| (significance(runs, point, local, &one).0, one)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked
}

/// Finds what is at fault. `None` where the motion of a run cannot be followed at all.
pub(crate) fn select(mut runs: Vec<RunWithNoise>) -> Option<FaultSearch> {
    let one = runs.len() == 1;
    for run in &mut runs {
        run.noise = first_guess(&run.record);
        // Of one run alone what stands is the run's own.
        run.active.retain(|&index| !(one && index >= SHARED_BIAS));
    }
    // The noise of what is left when everything may be at fault: no fault is taken for noise.
    let mut everything = ParameterPoint::zero(&runs);
    everything.free = candidates(&runs, &everything);
    let (anything, _) = minimise(&runs, &everything)?;
    estimate_noise(&mut runs, &anything, 4)?;
    if runs.iter().any(is_gusty) {
        // What may not be at fault there must not explain the gusts either.
        everything.free = candidates(&runs, &everything);
        let (anything, _) = minimise(&runs, &everything)?;
        estimate_noise(&mut runs, &anything, 3)?;
    }
    let (mut point, mut local) = minimise(&runs, &ParameterPoint::zero(&runs))?;
    for round in 0..ROUNDS_MAX {
        enter(&mut runs, &mut point, &mut local)?;
        leave(&runs, &mut point, &mut local)?;
        let faults = parallel_map(&point.free, |&place| fault(&runs, &point, &local, place));
        let faults: Vec<Fault> = faults.into_iter().flatten().collect();
        let better = faults.iter().filter_map(|fault| Some((fault, fault.rivals.first().filter(|rival| rival.3 < -1.0)?)));
        let swap = better.min_by(|a, b| a.1.3.total_cmp(&b.1.3));
        let Some((fault, &(name, value, ..))) = swap.filter(|_| round + 1 < ROUNDS_MAX) else {
            return Some(FaultSearch { runs, point, local, faults });
        };
        let (_, next, _) = try_name(&runs, &without(&point, fault.name.place), name, value)?;
        estimate_noise(&mut runs, &next, 2)?;
        (point, local) = minimise(&runs, &next)?;
    }
    None
}

/// A run with nothing at fault, its noise that of what is left then.
pub(crate) fn with_no_fault(run: &RunWithNoise) -> Option<FaultSearch> {
    let mut runs = vec![run.clone()];
    for run in &mut runs {
        run.noise = first_guess(&run.record);
        run.active.retain(|&index| index < SHARED_BIAS);
    }
    let (point, _) = minimise(&runs, &ParameterPoint::zero(&runs))?;
    estimate_noise(&mut runs, &point, 4)?;
    let (point, local) = minimise(&runs, &ParameterPoint::zero(&runs))?;
    Some(FaultSearch { runs, point, local, faults: Vec::new() })
}

fn enter(runs: &mut [RunWithNoise], point: &mut ParameterPoint, local: &mut FitLinearisation) -> Option<()> {
    while point.free.len() < FAULTS_MAX {
        let ranked = ranked(runs, point, local);
        let Some(&(best, _)) = ranked.first() else { break };
        let least = enter_above(candidates(runs, point).len());
        if best < least {
            break;
        }
        let most = ranked.iter().map(|(_, one)| one.fall).fold(0.0, f64::max);
        let worth = ranked.iter().filter(|(f, one)| *f >= 0.5 * least && one.fall > 0.4 * most).take(SHORTLIST);
        let tried = worth.flat_map(|(_, one)| names(one.place, one.value).into_iter().map(move |name| (name, one.value)));
        let tried: Vec<(FaultKey, f64)> = tried.collect();
        let fitted = parallel_map(&tried, |&(name, value)| try_name(runs, point, name, value));
        let Some((_, next, _)) = fitted.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        // A fault hides others behind the noise that it makes.
        estimate_noise(runs, &next, 2)?;
        (*point, *local) = minimise(runs, &next)?;
    }
    Some(())
}

fn leave(runs: &[RunWithNoise], point: &mut ParameterPoint, local: &mut FitLinearisation) -> Option<()> {
    loop {
        let minimum = local.minimum(point);
        let weakest = point.free.iter().filter_map(|&place| {
            let one = local.released(point, &minimum, place)?;
            Some((significance(runs, point, local, &one).0, place))
        });
        match weakest.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((f, place)) if f < LEAVE * enter_above(candidates(runs, point).len()) => {
                (*point, *local) = minimise(runs, &without(point, place))?
            }
            _ => return Some(()),
        }
    }
}

fn fault(runs: &[RunWithNoise], point: &ParameterPoint, local: &FitLinearisation, place: usize) -> Option<Fault> {
    let minimum = local.minimum(point);
    let one = local.released(point, &minimum, place)?;
    let (f, std) = significance(runs, point, local, &one);
    let is_lag = place.checked_sub(TIMING - PER_RUN).and_then(|m| point.lag.get(m)).copied().unwrap_or(false) && place < SHARED;
    let name = FaultKey { place, lag: is_timing(place) && is_lag };
    let own = evidence(point, local);
    // From where it is put back to normal, as from far away.
    let (back, back_local) = minimise_to(runs, &without(point, place), ROUGH)?;
    let mut rivals: Vec<(FaultKey, f64, f64, f64)> = Vec::new();
    let ranked = ranked(runs, &back, &back_local);
    let lost = back_local.cost - local.cost;
    let worth = |other: &Released| other.place != place && other.fall > 0.5 * lost - RIVAL && other.fall > 4.0;
    let others = ranked.iter().map(|(_, other)| *other).filter(worth).take(SHORTLIST);
    // Timing is always put beside its own other form.
    for other in std::iter::once(one).chain(others) {
        for other_name in names(other.place, other.value) {
            if other_name == name || same_bias(place, other.place) {
                continue;
            }
            let Some((evidence, there, there_local)) = try_name(runs, &back, other_name, other.value) else { continue };
            if evidence - own < RIVAL {
                let value = there_local.minimum(&there).get(other.place).copied().unwrap_or(0.0);
                let std = libm::sqrt(there_local.dispersion[(other.place, other.place)]);
                rivals.push((other_name, value, std, evidence - own));
            }
        }
    }
    rivals.sort_by(|a, b| a.3.total_cmp(&b.3));
    Some(Fault { name, value: one.value, std, significance: f, rivals })
}

/// A run before its noise is known.
pub(crate) fn run_of(record: super::run_channels::RunChannels) -> RunWithNoise {
    let noise = KinematicNoise { input: [1.0; 6], climb: 1.0, output: [1.0; 7] };
    RunWithNoise { active: super::fit::active(&record), noise, record, watch: None }
}
