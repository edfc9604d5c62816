//! One run's verdict out of the fit of all that share their instruments' errors.

use super::correction::{Alternative, Correction, effect_of, merged, splits};
use super::fault_selection::{Fault, FaultSearch, is_gusty, is_turbulent};
use super::fit::{RunWithNoise, parameter_at, place_of};
use super::flow_angle_r2::flow_angle_r2;
use super::mean_force_check::contradicted_mean_force;
use super::observability::{absent, insufficient_motion, may_be_misalignment, motion_std, undetectable, unreported};
use super::parameter::{BIAS, SHARED_BIAS, Theta};
use super::record::{AgreementScope, InstrumentErrorKind, NotObservable, UnreportedReason, VerdictReason};
use super::run_channels::RunChannels;
use super::screening::Screened;
use super::single_run::SingleRunFit;
use super::wiring::{miswired, wiring};
use crate::flight::channel::Channel;
use crate::flight::effect::Effect;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::flight::unit::STANDARD_GRAVITY;
use crate::realtime::estimation::screening::gross_error::speed_unit;

/// R2 of a flow angle's rate below which a run is not fit even when corrected.
const R2_FIT: f64 = 0.9;
/// R2 below which a flow angle's rate contradicts the kinematics: noise and rough air bring it towards zero, a sign that is wrong
/// far below; and the standard deviation from which an angle moves, rad.
const R2_CONTRARY: f64 = -0.5;
const MOVES_RAD: f64 = 0.01;
/// Factors beyond which no instrument reads.
const FACTOR_MIN: f64 = 0.5;
const FACTOR_MAX: f64 = 1.5;
/// Standard errors that an error has to exceed in turbulence, where gusts that correlate with the motion are no noise: of healthy
/// instruments in gusts of 0.3 m/s up to eight were found.
const TURBULENT_STDS: f64 = 10.0;

/// Fitness of a run for identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitness {
    /// As it is.
    Fit,
    /// Once the corrections are made.
    FitCorrected,
    /// Not for identification.
    NotFit,
}

impl Fitness {
    /// The words in results.
    pub const fn words(self) -> &'static str {
        match self {
            Fitness::Fit => "fit",
            Fitness::FitCorrected => "fit after corrections",
            Fitness::NotFit => "not fit",
        }
    }
}

/// A run's fitness for identification, with the corrections it needs.
#[derive(Clone, Debug, PartialEq)]
pub struct RunVerdict {
    /// Its name.
    pub run: String,
    /// Whether it is fit.
    pub fitness: Fitness,
    /// Why.
    pub reason: VerdictReason,
    /// Its corrections, the most significant first.
    pub corrections: Vec<Correction>,
    /// R2 of incidence and sideslip before and after.
    pub consistency: [Option<(f64, Option<f64>)>; 2],
    /// What cannot be known.
    pub not_observable: Vec<NotObservable>,
    /// Samples that no instrument measured, taken out before.
    pub screened: Vec<Screened>,
    /// Stretches without any sample that the check does not carry the motion over: the last time before and the first after, s.
    pub long_gaps: Vec<[f64; 2]>,
}

/// One run's verdict out of all runs' fit.
pub(crate) fn run_verdict(
    name: &str,
    found: &FaultSearch,
    number: usize,
    names: &[String],
    alone: &[Option<SingleRunFit>],
) -> Option<RunVerdict> {
    let run = found.runs.get(number)?;
    let mut corrections: Vec<Correction> = Vec::new();
    let mut doubts: Vec<NotObservable> = Vec::new();
    let mut unfit = None;
    let mut rough = is_gusty(run);
    for fault in &found.faults {
        let (parameter, own) = parameter_at(fault.name.place);
        if own.is_some_and(|own| own != number) || !run.active.contains(&parameter.index) {
            continue;
        }
        // An axis that hardly moves is blamed only where one that moves would fit as well.
        if let Some(part) = insufficient_motion(&found.runs, parameter, fault.value)
            && fault.rivals.iter().all(|rival| insufficient_motion(&found.runs, parameter_at(rival.0.place).0, rival.1).is_some())
        {
            doubts.push(unreported(parameter, UnreportedReason::InsufficientMotion(part), fault.value, fault.std));
            continue;
        }
        let others = found.faults.iter().map(|other| parameter_at(other.name.place).0);
        if may_be_misalignment(parameter, others) {
            doubts.push(unreported(parameter, UnreportedReason::Misalignment, fault.value, fault.std));
            continue;
        }
        // Before turbulence: the residual of a wiring error resembles it.
        if let (InstrumentErrorKind::Bias, Some(channel)) = (parameter.kind, parameter.channel())
            && let Some(finding) = miswired(found, number, own.is_some(), channel, (fault.value, fault.std))
        {
            unfit = Some(VerdictReason::Wiring(finding));
        }
        // What is reported of all runs is reported of the roughest of them too.
        let turbulent = is_turbulent(run) || own.is_none() && found.runs.iter().any(is_turbulent);
        let normalised_excess = fault.value.abs() > TURBULENT_STDS * fault.std;
        if parameter.mimicked_by_gusts() && (is_gusty(run) || turbulent && !normalised_excess) {
            doubts.push(unreported(parameter, UnreportedReason::Gusts, fault.value, fault.std));
            rough = true;
            continue;
        }
        let Some((value, std)) = in_run(found, number, fault) else { continue };
        let Some((effect, vane)) = effect_of(fault.name, value) else { continue };
        let alternatives: Vec<Alternative> = fault
            .rivals
            .iter()
            .filter_map(|&(name, value, std, _)| {
                let (effect, vane) = effect_of(name, value)?;
                Some(Alternative { effect: DeclaredEffect { effect, std: Some(std) }, vane })
            })
            .collect();
        let by_run = if own.is_none() && parameter.kind != InstrumentErrorKind::Bias {
            alone
                .iter()
                .zip(names)
                .filter_map(|(one, name)| one.as_ref()?.estimate(parameter).map(|(x, std)| (name.clone(), x, std)))
                .collect()
        } else {
            Vec::new()
        };
        // No instrument reads so: something else is wrong with the channel, and a factor fits it best.
        if let Effect::SensorScale { channel, factor } = effect
            && !(FACTOR_MIN..=FACTOR_MAX).contains(&factor)
            && !(channel == Channel::Tas && speed_unit(factor, std).is_some())
        {
            doubts.push(unreported(parameter, UnreportedReason::ImplausibleScale, fault.value, fault.std));
            unfit = Some(VerdictReason::ImplausibleScale(channel, factor));
            continue;
        }
        let split_by = splits(fault.name, fault.rivals.iter().map(|rival| rival.0));
        let effect = DeclaredEffect { effect, std: Some(std) };
        let as_turned = match effect.effect {
            Effect::SensorBias { channel: Channel::Ax | Channel::Ay, value } => Some(value / STANDARD_GRAVITY),
            _ => None,
        };
        let axis_stds_m = match effect.effect {
            Effect::SensorPosition { offset_m, .. } => offset_m.map(|part| (part.abs() > 0.0).then_some(std)),
            _ => [None; 3],
        };
        corrections.push(Correction {
            axis_stds_m,
            turned: as_turned,
            effect,
            vane,
            significance: fault.significance,
            alternatives,
            split_by,
            by_run,
        });
    }
    corrections.sort_by(|a, b| b.significance.total_cmp(&a.significance));
    let mut corrections = merged(corrections);
    // A wiring error of a channel that hardly moves feigns errors of others, with small standard errors; in rough air not those
    // of attitude and rates, which hardly take part in the motion of the air there.
    if (unfit.is_some() || !corrections.iter().all(|one| is_gusty(run) && needs_no_air_data(one)))
        && let Some(miswired) = wiring(found, number)
    {
        if miswired.alone {
            corrections.clear();
        }
        unfit = Some(VerdictReason::Wiring(miswired.finding));
    }
    let before = flow_angle_r2(&run.record, &Theta::NONE);
    let after = flow_angle_r2(&run.record, &found.point.theta(number));
    let consistency = [0, 1].map(|angle| before[angle].map(|before| (before, after[angle])));
    let (fitness, reason) =
        unfit.map_or_else(|| fitness(run, after, corrections.len(), rough), |reason| (Fitness::NotFit, reason));
    let mut not_observable = absent(&run.record);
    not_observable.extend(doubts);
    not_observable.extend(undetectable(found, number));
    let screened = Vec::new();
    Some(RunVerdict {
        run: name.to_owned(),
        fitness,
        reason,
        corrections,
        consistency,
        not_observable,
        screened,
        long_gaps: Vec::new(),
    })
}

/// Whether a run is fit with that many corrections, R2 of incidence and sideslip after them given, and why.
fn fitness(run: &RunWithNoise, after: [Option<f64>; 2], corrections: usize, rough: bool) -> (Fitness, VerdictReason) {
    let record = &run.record;
    // Gravity turns the flow by bank and pitch: without both nothing says how the angles must move.
    let whole = [3, 4].into_iter().all(|output| record.outputs.get(output).is_some_and(Option::is_some));
    let contrary = [Channel::Alpha, Channel::Beta].into_iter().zip(after).enumerate().find_map(|(place, (angle, after))| {
        let after = after.filter(|after| whole && *after < R2_CONTRARY && spread(record, 1 + place) > MOVES_RAD)?;
        Some((angle, after))
    });
    if let Some((angle, after)) = contrary {
        return (Fitness::NotFit, VerdictReason::FlowAngleContradicted(angle, after));
    }
    // The angle that hardly moves is moved by what the kinematics do not know, such as the flow in sideslip.
    let (angle, place) = if spread(record, 1) > spread(record, 2) { (Channel::Alpha, 0) } else { (Channel::Beta, 1) };
    // Either angle's kinematics take the other's; and in rough air neither follows from what is measured.
    let both = [1, 2].into_iter().all(|output| record.outputs.get(output).is_some_and(Option::is_some));
    match after[place].filter(|after| *after < R2_FIT && both && whole && !is_gusty(run)) {
        Some(after) => (Fitness::NotFit, VerdictReason::FlowAngleNotFollowed(angle, after)),
        None if corrections == 0 => {
            let scope = match (record.velocities && whole, rough) {
                (false, _) => AgreementScope::AttitudeAndRates,
                (true, true) => AgreementScope::RoughAir(contradicted_mean_force(run).unwrap_or_default()),
                (true, false) => AgreementScope::Whole,
            };
            (Fitness::Fit, VerdictReason::Agree(scope))
        }
        None => (Fitness::FitCorrected, VerdictReason::ErrorsFound(corrections)),
    }
}

/// A fault's value and standard error in one run: a bias that stands over all is there with the run's own, once.
fn in_run(found: &FaultSearch, number: usize, fault: &Fault) -> Option<(f64, f64)> {
    let (parameter, _) = parameter_at(fault.name.place);
    let Some(measured) = parameter.measured.filter(|_| parameter.kind == InstrumentErrorKind::Bias) else {
        return Some((fault.value, fault.std));
    };
    let (shared, own) = (place_of(number, SHARED_BIAS + measured), place_of(number, BIAS + measured));
    if !found.point.free.contains(&shared) {
        return Some((fault.value, fault.std));
    }
    let places = [shared, own];
    let minimum = found.local.minimum(&found.point);
    let value = places.iter().map(|&place| minimum.get(place).copied().unwrap_or(0.0)).sum();
    let variance = found.local.colour(&found.runs, &places) * found.local.variance_of(&places);
    (fault.name.place == shared).then_some((value, libm::sqrt(variance)))
}

/// Whether a correction is of the attitude or the rates, which agree or not without air data and forces.
fn needs_no_air_data(correction: &Correction) -> bool {
    use Channel::{P, Phi, Psi, Q, R, Theta};
    matches!(correction.effect.effect.sensor_channel(), Some(P | Q | R | Phi | Theta | Psi))
}

fn spread(record: &RunChannels, output: usize) -> f64 {
    record.outputs.get(output).and_then(Option::as_ref).map_or(0.0, motion_std)
}
