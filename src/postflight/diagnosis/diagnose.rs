//! The diagnosis of a model: causes with probabilities, what remains, what the extended model gains.
//!
//! Consumes a model and runs; produces the findings. Where the search's evidence of causes i and of no cause (o_i, twice the
//! logarithm of the odds against nothing) is, the probability of each is
//!     P_i = exp(o_i/2T)/(1 + sum_j exp(o_j/2T))                                                       (1)
//! with T = [`TEMPERATURE`], for the evidence leaves out what linearising and the colour of what remains do to it.
//! What the search cannot explain is what noise of forces beyond that of the controls is still worth, axis by axis; where the
//! causes found explain less than [`EXPLAINED`] of what they and that noise explain together, the answer is `unknown`.

use super::data::instrument_check::{InstrumentCheck, check_instruments};
use super::data::run_data::RunData;
use super::data::usable_runs::usable_runs;
use super::evidence::cause_size::{CauseSizes, cause_sizes};
use super::evidence::regressor_plot::{RegressorPlot, regressor_plots};
use super::evidence::reliance::{CauseRejection, is_modest_and_not_seen};
use super::evidence::residual::{Discrepancy, discrepancy};
use super::evidence::residual_coherence::{AxisSpectrum, residual_coherence};
use super::evidence::size_error::size_std;
use super::holdout::holdout_gain::{HoldoutEvidence, HoldoutImprovement, HoldoutVerdict, held_out, moves};
use super::holdout::horizon_prediction::{HORIZON_S, errors_over_horizon};
use super::likelihood::adequacy::{with_observed_noise, without_unidentifiable};
use super::likelihood::aircraft::Aircraft;
use super::likelihood::problem::DiagnosisProblem;
use super::record::{DiagnosisError, RankedCause, TrimDifference, UnexplainedAxis, Unusable};
use super::search::forward_search::{SearchResult, search};
use super::search::joint_derivatives::joint_derivatives;
use super::search::next_cause::{Rival, SearchSettings};
use super::search::recording_faults::{RecordingFault, as_it_should_be_recorded, factor_std, recording_faults, shares_of_faults};
use super::search::score_test::acts_on;
use crate::flight::derivative::Axis;
use crate::flight::effect::{Effect, same_cause};
use crate::flight::file::effect_file::DeclaredEffect;
use crate::postflight::recorded_run::RecordedRun;
use crate::postflight::validation::improvement::ImprovementVerdict;
use crate::simulation::flight_model::FlightModel;

/// T of (1).
pub const TEMPERATURE: f64 = 2.0;
/// Least part of what is there that causes must explain.
pub const EXPLAINED: f64 = 0.85;
/// Less than this is no discrepancy, in cost.
pub const NOTHING: f64 = 25.0;
/// Part of what is there that many derivatives together may leave.
const MANY_LEAVE: f64 = 0.04;
/// What remains of an axis is small where it is below this part of the axis's motion in air that moves.
const SMALL_REMAINDER: f64 = 0.25;
/// Shares of the error are those of predictions over so long, s: over a whole manoeuvre the effects on an aircraft add up, while
/// those of gusts pass.
const SHARES_OVER_S: f64 = 16.0;
/// So many causes on one axis are none.
const CROWD: usize = 3;
const TOLD: usize = 12;

/// A cause that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// It, with all other causes in the model.
    pub cause: RankedCause,
    /// What else it may be, the most probable first, the cause itself among them.
    pub ranking: Vec<RankedCause>,
    /// What it changes in the predicted motion, as a share of that motion; gusts change none.
    pub motion_share: Option<f64>,
    /// The part of the model's error that it explains, of all that is there beyond noise.
    pub error_share: f64,
    /// The same of predictions over the horizon of the hold-out runs, by which it is relied upon or not.
    pub horizon_share: f64,
    /// Whether it is too small to be relied upon.
    pub small: bool,
    /// On the hold-out runs.
    pub held_out: Option<HoldoutEvidence>,
    /// The residual against it; gusts have none.
    pub regressor_plot: Option<RegressorPlot>,
}

/// Result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The causes, the weightiest first.
    pub findings: Vec<Finding>,
    /// Causes that fitted and are not relied upon, with the reason.
    pub rejected: Vec<RejectedCause>,
    /// What is there besides.
    pub unknown: Option<UnexplainedAxis>,
    /// Probability that nothing is wrong, and what else was tested where nothing was found.
    pub none: (f64, Vec<RankedCause>),
    /// By axis, of those that the model says something of.
    pub discrepancy: Vec<Discrepancy>,
    /// Axes that the model does not cover.
    pub unmodelled: Vec<Axis>,
    /// The signals that the residuals correlate with, by axis.
    pub spectra: Vec<AxisSpectrum>,
    /// Where the runs do not begin in the model's trim.
    pub trim_differences: Vec<TrimDifference>,
    /// Runs that were set aside, and why.
    pub set_aside: Vec<(String, Unusable)>,
    /// The gain over the runs that were not used; with each, the predictions before and after.
    pub gain: Option<HoldoutImprovement>,
}

/// Less probable rivals are not reported.
pub const PLAUSIBLE: f64 = 0.05;

/// A cause that fits and is not relied upon.
#[derive(Clone, Debug, PartialEq)]
pub struct RejectedCause {
    /// The cause.
    pub finding: Finding,
    /// Why.
    pub reason: CauseRejection,
}

impl Finding {
    /// The causes that the data do not rule out, the cause itself first.
    pub fn plausible(&self) -> Vec<RankedCause> {
        self.ranking.iter().filter(|ranked| ranked.probability >= PLAUSIBLE).copied().collect()
    }
}

impl Diagnosis {
    /// The effects that mend the model, with standard errors; gusts too, though they are no fault of it.
    pub fn extension(&self) -> Vec<DeclaredEffect> {
        if self.unknown.is_some() || self.judged().is_some_and(|judged| judged != ImprovementVerdict::Gain) {
            return Vec::new();
        }
        let declared = |finding: &Finding| DeclaredEffect { effect: finding.cause.effect, std: Some(finding.cause.std) };
        self.findings.iter().map(declared).collect()
    }

    /// What the causes are worth on the runs that were not used.
    pub fn judged(&self) -> Option<ImprovementVerdict> {
        self.gain.as_ref()?.0.pooled.as_ref().map(|pooled| pooled.ratio.verdict())
    }
}

/// Diagnoses a model by some runs, and measures what the causes gain on others.
///
/// # Errors
/// [`DiagnosisError`] where no run can be used.
pub fn diagnose(
    model: &FlightModel,
    fit: &[RecordedRun],
    holdout: &[RecordedRun],
    settings: &SearchSettings,
) -> Result<Diagnosis, DiagnosisError> {
    let (records, mut set_aside) = usable_runs(model, fit);
    let recorded: Vec<RunData> = records.iter().map(|(_, record)| record.clone()).collect();
    let posed_with = |effects: &[Effect]| {
        let fixed = [&model.file.own_effects()[..], effects].concat();
        DiagnosisProblem::new(Aircraft::of(model), fixed, recorded.clone(), model.file.tolerance, &model.file.stds)
    };
    let faults = if records.is_empty() { Vec::new() } else { recording_faults(&posed_with) };
    let fixed: Vec<Effect> = model.file.own_effects().into_iter().chain(faults.iter().map(|one| one.effect)).collect();
    let problem = pose(model, &fixed, recorded.clone(), &set_aside)?;
    let as_it_should_be = as_it_should_be_recorded(fit, &faults);
    // Instruments are checked without the model meanwhile; mostly they are correct, and the first search is valid.
    let (check_instruments, first) = std::thread::scope(|scope| {
        let beside = scope.spawn(|| check_instruments(&as_it_should_be, settings.watch));
        let first = search_with_observed_noise(problem, &[], settings);
        (beside.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), first)
    });
    let InstrumentCheck { set_aside: unlike, known } = check_instruments;
    // In gusts, which the search has a word for, air data do not follow from the rest, and are none the worse.
    let gusty = first.as_ref().is_some_and(|(_, searched, _)| searched.point.gust.0 > 0.0);
    let (apart, same_instruments): (Vec<_>, Vec<_>) =
        records.into_iter().partition(|(place, _)| !gusty && unlike.iter().any(|(there, _)| there == place));
    // What every run has alike sets none of them aside: it is an error that they share, for the search to find.
    let result = if (apart.is_empty() && known.is_empty()) || same_instruments.is_empty() {
        first
    } else {
        for (place, record) in apart {
            let why = unlike.iter().find(|(there, _)| *there == place).map(|(_, why)| why.clone());
            set_aside.extend(why.map(|why| (record.name, Unusable::Instruments(why))));
        }
        let problem = pose(model, &fixed, same_instruments.into_iter().map(|(_, record)| record).collect(), &set_aside)?;
        search_with_observed_noise(problem, &known, settings)
    };
    let Some((problem, searched, unknown)) = result else {
        return Err(DiagnosisError::Diverged);
    };
    let mut findings = findings(&problem, &searched);
    if !faults.is_empty() {
        let without = fixed.len() - faults.len();
        let error = |mended: usize| errors_over_horizon(model, fixed.get(..without + mended).unwrap_or_default(), &recorded);
        let shares = shares_of_faults(&(0..=faults.len()).map(error).collect::<Vec<_>>());
        for (place, (one, share)) in faults.iter().zip(shares).enumerate() {
            add_recording_fault(one, factor_std(&problem, &searched, &one.effect), share, (place, &mut findings));
        }
    }
    let discrepancy = discrepancy(&problem, &searched);
    let spectra =
        residual_coherence(&problem, &searched).into_iter().filter(|own| !problem.unmodelled[own.axis.index()]).collect();
    // Many derivatives that are off stand together: none of them is left out for being small.
    let (gain, rejected) = judge_on_holdout(model, &mut findings, holdout, searched.is_joint())?;
    let none = none(&searched, findings.is_empty());
    let contradicted = rejected.iter().find(|one| one.reason != CauseRejection::Small);
    let unknown = unknown.or_else(|| if findings.is_empty() { of_rejected(&contradicted?.finding, &discrepancy) } else { None });
    let trim_differences = problem.trim_differences.iter().copied().filter(TrimDifference::is_significant).collect();
    let (unmodelled, said): (Vec<Axis>, Vec<Axis>) = Axis::ALL.into_iter().partition(|axis| problem.unmodelled[axis.index()]);
    let discrepancy = discrepancy.into_iter().filter(|one| said.contains(&one.axis)).collect();
    Ok(Diagnosis { findings, rejected, unknown, none, discrepancy, unmodelled, spectra, trim_differences, set_aside, gain })
}

/// The runs and the model, where there is anything to tell.
fn pose(
    model: &FlightModel,
    fixed: &[Effect],
    records: Vec<RunData>,
    set_aside: &[(String, Unusable)],
) -> Result<DiagnosisProblem, DiagnosisError> {
    if records.is_empty() {
        return Err(match set_aside.last() {
            Some((name, unfit)) => DiagnosisError::NoRun(name.clone(), unfit.clone()),
            None => DiagnosisError::Empty,
        });
    }
    let problem = DiagnosisProblem::new(Aircraft::of(model), fixed.to_vec(), records, model.file.tolerance, &model.file.stds);
    if problem.unmodelled.iter().all(|unmodelled| *unmodelled) {
        return Err(DiagnosisError::Silent);
    }
    if !problem.moves() {
        return Err(DiagnosisError::Still);
    }
    Ok(without_unidentifiable(problem))
}

/// What a search came to, the problem with the noise that it was ended with.
type SearchOutcome = (DiagnosisProblem, SearchResult, Option<UnexplainedAxis>);

/// Searches; where even the causes that were found leave instruments that scatter by more than their noise, that is their noise,
/// and the search is begun again with it.
fn search_with_observed_noise(
    problem: DiagnosisProblem,
    known: &[Vec<DeclaredEffect>],
    settings: &SearchSettings,
) -> Option<SearchOutcome> {
    let (searched, unknown) = search_causes(&problem, known, settings)?;
    // What many derivatives leave is the model's, and no noise of instruments.
    match if searched.is_joint() || settings.is_stopped() { None } else { with_observed_noise(&problem, &searched.point) } {
        Some(noisier) => {
            let (searched, _) = search_causes(&noisier, known, settings)?;
            let unknown = unknown
                .filter(|one| discrepancy(&noisier, &searched).get(one.axis.index()).is_some_and(Discrepancy::exceeds_noise));
            Some((noisier, searched, unknown))
        }
        None => Some((problem, searched, unknown)),
    }
}

/// A few causes, or where these do not do many derivatives that are off.
fn search_causes(
    problem: &DiagnosisProblem,
    known: &[Vec<DeclaredEffect>],
    settings: &SearchSettings,
) -> Option<(SearchResult, Option<UnexplainedAxis>)> {
    let searched = search(problem, known, settings)?;
    let unknown = unknown_of(problem, &searched);
    if problem.models_all_axes() && known.is_empty() && (unknown.is_some() || searched.rivals.len() >= settings.causes) {
        let most = MANY_LEAVE * searched.before.iter().sum::<f64>();
        let better = |many: &SearchResult| {
            let less = many.left.iter().sum::<f64>() < most && many.local.evidence() < searched.local.evidence();
            less && !is_pieced_together(problem, many)
        };
        if let Some(many) = joint_derivatives(problem, &searched, settings).filter(better) {
            return Some((many, None));
        }
    }
    Some((searched, unknown))
}

/// Whether several terms of the library stand on one axis of a linear model: derivatives may be off by the dozen, but products
/// beside each other make up what none of them is. A simulation that curves where flight does not may need them.
fn is_pieced_together(problem: &DiagnosisProblem, many: &SearchResult) -> bool {
    let on = |axis: Axis| move |one: &Effect| matches!(one, Effect::Nonlinear { axis: its, .. } if *its == axis);
    let terms = |axis: Axis| many.point.effects().filter(on(axis)).count();
    !problem.aircraft.is_curved() && Axis::ALL.into_iter().any(|axis| terms(axis) > 1)
}

/// (1) for each of the rivals.
fn ranked(rivals: &[Rival]) -> Vec<RankedCause> {
    let most = rivals.iter().map(|rival| rival.odds).fold(0.0, f64::max);
    let weight = |odds: f64| libm::exp((odds - most) / (2.0 * TEMPERATURE));
    let sum = weight(0.0) + rivals.iter().map(|rival| weight(rival.odds)).sum::<f64>();
    let told = rivals.iter().take(TOLD);
    let one = |rival: &Rival| {
        let (effect, std, odds) = (rival.effect, rival.std, rival.odds);
        RankedCause { effect, std, probability: weight(odds) / sum, odds }
    };
    told.map(one).collect()
}

fn findings(problem: &DiagnosisProblem, searched: &SearchResult) -> Vec<Finding> {
    let mut number = 0;
    let [sizes, shares] = cause_sizes(problem, &searched.point, [HORIZON_S, SHARES_OVER_S]);
    let share = |of: &CauseSizes, own: f64| {
        let error = of.of.iter().map(|size| size.error).sum::<f64>() + of.left;
        if error > 0.0 { own / error } else { 0.0 }
    };
    let mut pictures = regressor_plots(problem, searched).into_iter();
    let found = searched.rivals.iter().filter_map(|rivals| {
        let ranking = ranked(rivals);
        let first = ranking.first()?;
        // Gusts are no fault of the model, and never too small.
        let (mut picture, mut motion_share, mut own_error, mut small) = (None, None, (shares.left, sizes.left), false);
        let cause = if let Effect::Turbulence { .. } = first.effect {
            let length = searched.point.gust.1 * problem.aircraft.trim().airspeed();
            RankedCause { effect: Effect::Turbulence { sigma: searched.point.gust.0, length }, ..*first }
        } else {
            let place = number;
            number += 1;
            motion_share = sizes.of.get(place).map(|size| size.motion_share);
            let error = |of: &CauseSizes| of.of.get(place).map_or(0.0, |size| size.error);
            own_error = (error(&shares), error(&sizes));
            small = sizes.is_small(place);
            picture = pictures.next().flatten();
            let hypothesis = searched.point.hypotheses.get(place)?;
            let std = size_std(problem, searched, place);
            RankedCause { effect: hypothesis.effect, std, ..*first }
        };
        let (error_share, horizon_share) = (share(&shares, own_error.0), share(&sizes, own_error.1));
        let finding =
            Finding { cause, ranking, motion_share, error_share, horizon_share, small, held_out: None, regressor_plot: picture };
        Some(finding)
    });
    let mut found: Vec<Finding> = found.collect();
    found.sort_by(|a, b| b.error_share.total_cmp(&a.error_share));
    found
}

/// A fault of the recording as a finding, with the factor of the same channel or control that the search found beside it. They
/// stand before the other causes: nothing is right before they are.
fn add_recording_fault(
    fault: &RecordingFault,
    std: Option<f64>,
    error_share: f64,
    (place, findings): (usize, &mut Vec<Finding>),
) {
    let mut cause = RankedCause { effect: fault.effect, std: std.unwrap_or(0.0), probability: 1.0, odds: fault.odds };
    if let Some(same) = findings.iter().position(|one| same_cause(&one.cause.effect, &cause.effect)) {
        let beside = findings.remove(same).cause;
        cause.std = beside.std;
        if let (Some(factor), Some(by)) = (cause.effect.main_number_mut(), beside.effect.main_number()) {
            *factor *= by;
        }
    }
    let ranking = vec![cause];
    let finding = Finding {
        cause,
        ranking,
        motion_share: None,
        error_share,
        horizon_share: error_share,
        small: false,
        held_out: None,
        regressor_plot: None,
    };
    findings.insert(place.min(findings.len()), finding);
}

/// Where the causes leave too much.
fn unknown_of(problem: &DiagnosisProblem, searched: &SearchResult) -> Option<UnexplainedAxis> {
    let explained: f64 = searched.rivals.iter().filter_map(|rivals| rivals.first()).map(|rival| rival.odds.max(0.0)).sum();
    let left: f64 = searched.left.iter().filter(|left| **left > 0.0).sum();
    // Many causes on one axis are the library's terms making up one that it does not have.
    let crowded = Axis::ALL.into_iter().find(|&axis| {
        let own = |rivals: &&Vec<Rival>| rivals.first().is_some_and(|rival| acts_on(&rival.effect) == Some(axis));
        searched.rivals.iter().filter(own).count() >= CROWD
    });
    if crowded.is_none() && (left < NOTHING || explained > EXPLAINED * (explained + left)) {
        return None;
    }
    let (place, worth) = searched.left.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let axis = if left < NOTHING { crowded? } else { Axis::ALL.get(place).copied()? };
    let place = axis.index();
    let remains = *discrepancy(problem, searched).get(place)?;
    // In still air nothing but the model leaves anything; beside gusts, what is significant may be small, and the table of
    // residuals has it.
    let gusty = searched.point.gust.0 > 0.0;
    let is_small = gusty && crowded.is_none() && remains.rms_after < SMALL_REMAINDER * remains.motion;
    (!is_small).then_some(UnexplainedAxis { axis, band_hz: remains.band_hz, worth })
}

/// Nothing wrong, and what came nearest to being a cause: beside those that are not relied upon, where no other was found.
fn none(searched: &SearchResult, none_relied_upon: bool) -> (f64, Vec<RankedCause>) {
    let first = if none_relied_upon { None } else { searched.rivals.first() }.unwrap_or(&searched.refused);
    let others = ranked(first);
    (1.0 - others.iter().map(|rival| rival.probability).sum::<f64>().min(1.0), others)
}

/// What the hold-out runs say of each cause, and the gain. A cause that they contradict is taken out, the worst first, and the
/// others are judged again; at the end those that are small.
fn judge_on_holdout(
    model: &FlightModel,
    findings: &mut Vec<Finding>,
    holdout: &[RecordedRun],
    joint: bool,
) -> Result<(Option<HoldoutImprovement>, Vec<RejectedCause>), DiagnosisError> {
    let mut rejected = Vec::new();
    if holdout.is_empty() {
        rejected.extend(if joint { Vec::new() } else { take_small(findings) });
        return Ok((None, rejected));
    }
    loop {
        let causes: Vec<Effect> = findings.iter().map(|finding| finding.cause.effect).collect();
        let (ratios, gain) = held_out(model, &causes, holdout)?;
        for (finding, own) in findings.iter_mut().zip(ratios) {
            // A control that rests there says nothing of what it does.
            let acts = |control| moves(holdout, control);
            let own = own.filter(|_| finding.cause.effect.acting_control().is_none_or(acts));
            finding.held_out = own;
        }
        let contradicted = findings.iter().enumerate().filter_map(|(place, finding)| {
            let own = finding.held_out?;
            // Derivatives that were fitted together stand or fall by the pooled error: without one the others are others.
            if joint {
                return own.ratio.is_refuted().then_some((place, CauseRejection::Refuted, own.ratio.value));
            }
            let reason = match own.verdict() {
                HoldoutVerdict::Refuted => CauseRejection::Refuted,
                HoldoutVerdict::GainNotSeen => CauseRejection::GainNotSeen,
                HoldoutVerdict::BorneOut | HoldoutVerdict::NotSeen => return None,
            };
            Some((place, reason, own.ratio.value))
        });
        if let Some((worst, reason, _)) = contradicted.max_by(|(.., a), (.., b)| a.total_cmp(b)) {
            rejected.push(RejectedCause { finding: findings.remove(worst), reason });
            continue;
        }
        let small = if joint { Vec::new() } else { take_small(findings) };
        if small.is_empty() {
            return Ok((Some(gain), rejected));
        }
        rejected.extend(small);
    }
}

/// Takes out those that are too small to be relied upon.
fn take_small(findings: &mut Vec<Finding>) -> Vec<RejectedCause> {
    let not_seen = |finding: &Finding| finding.held_out.is_some_and(|own| is_modest_and_not_seen(finding.horizon_share, &own));
    let small = findings.extract_if(.., |finding| finding.small || not_seen(finding));
    small.map(|finding| RejectedCause { finding, reason: CauseRejection::Small }).collect()
}

/// What is unknown where all that fitted is refuted.
fn of_rejected(rejected: &Finding, discrepancy: &[Discrepancy]) -> Option<UnexplainedAxis> {
    let strength = |one: &&Discrepancy| one.rms / one.noise.max(f64::MIN_POSITIVE);
    let most = discrepancy.iter().max_by(|a, b| strength(a).total_cmp(&strength(b)))?.axis;
    let axis = acts_on(&rejected.cause.effect).unwrap_or(most);
    let band_hz = discrepancy.iter().find(|one| one.axis == axis)?.band_hz;
    Some(UnexplainedAxis { axis, band_hz, worth: rejected.cause.odds })
}
