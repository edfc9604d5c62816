//! The diagnosis of a model: causes with probabilities, what remains, what the extended model gains.
//!
//! Consumes a model and runs; produces the findings. Where the search's evidence of causes i and of no cause (o_i, twice the
//! logarithm of the odds against nothing) is, the probability of each is
//!     P_i = exp(o_i/2T)/(1 + sum_j exp(o_j/2T))                                                       (1)
//! with T = [`TEMPERATURE`], for the evidence leaves out what linearising and the colour of what remains do to it.
//! What the search cannot explain is what noise of forces beyond that of the controls is still worth, axis by axis; where the
//! causes found explain less than [`EXPLAINED`] of what they and that noise explain together, the answer is `unknown`.

use super::against::{Against, against};
use super::aircraft::Aircraft;
use super::companions::{Companions, companions};
use super::free_run::{self, NoPrediction, Prediction};
use super::gain::{Estimate, Gain, Judged, gain};
use super::kinematics::{Kinematics, kinematics};
use super::problem::Problem;
use super::residual::{Discrepancy, discrepancy};
use super::run_record::{Record, Unfit};
use super::screen::acts_on;
use super::search::{Rival, Searched, Settings, search};
use super::taken::taken;
use super::whole::whole;
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::Axis;
use crate::flight::effect::Effect;
use crate::flight::effect_file::DeclaredEffect;
use crate::flight::run::RunGeometry;
use crate::simulation::flight_model::FlightModel;
use crate::telemetry::record::Sample;

/// T of (1).
pub const TEMPERATURE: f64 = 2.0;
/// Least part of what is there that causes must explain.
pub const EXPLAINED: f64 = 0.85;
/// Less than this is no discrepancy, in cost.
pub const NOTHING: f64 = 25.0;
/// Part of what is there that many derivatives together may leave.
const MANY_LEAVE: f64 = 0.04;
/// So many causes on one axis are none.
const CROWD: usize = 3;
/// Rivals that are told.
const TOLD: usize = 12;

/// A run as it was recorded.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its name.
    pub name: String,
    /// Its samples.
    pub samples: Vec<Sample>,
    /// Where its instruments stand.
    pub geometry: RunGeometry,
}

/// An effect with how probable it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// The effect.
    pub effect: Effect,
    /// Standard error of its main number.
    pub std: f64,
    /// (1).
    pub probability: f64,
    /// Twice the logarithm of its odds against nothing; of the cause found.
    pub odds: f64,
}

/// A cause that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// It, with all other causes in the model.
    pub cause: Ranked,
    /// What else it may be, the most probable first, the cause itself among them.
    pub ranking: Vec<Ranked>,
    /// On the runs kept back: the pooled error with all causes over that with all but this one.
    pub held_out: Option<Estimate>,
    /// The residual against it; gusts have none.
    pub against: Option<Against>,
}

/// Something that no cause explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Where.
    pub axis: Axis,
    /// The band that holds most of it, Hz.
    pub band_hz: (f64, f64),
    /// What a free force or moment there would lower the cost by.
    pub worth: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The causes, the weightiest first.
    pub findings: Vec<Finding>,
    /// What is there besides.
    pub unknown: Option<Unknown>,
    /// Probability that nothing is wrong, and what else was looked at where nothing was found.
    pub none: (f64, Vec<Ranked>),
    /// By axis, of those that the model says something of.
    pub discrepancy: Vec<Discrepancy>,
    /// Axes that it says nothing of.
    pub silent: Vec<Axis>,
    /// What the residuals go with, by axis.
    pub companions: Vec<Companions>,
    /// Channels that do not begin in the model's trim, where so many are that the runs have another.
    pub off_trim: Vec<Channel>,
    /// Runs that were set aside, and why.
    pub set_aside: Vec<(String, Unfit)>,
    /// The gain over the runs that were not used; with each, the predictions before and after.
    pub gain: Option<Gained>,
}

/// The gain, and each run's predictions before and after.
pub type Gained = (Gain, Vec<(Prediction, Prediction)>);

/// Why there is no diagnosis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoDiagnosis {
    /// No run is left.
    #[error("no run is left to diagnose: {0}: {1}")]
    NoRun(String, Unfit),
    /// None was given.
    #[error("expected at least one run to diagnose, found none")]
    Empty,
    /// The model has nothing.
    #[error("the model says nothing of any axis: expected derivatives, found none")]
    Silent,
    /// A control that never moves, and nothing else does.
    #[error("no control moves in any run: there is nothing to tell a cause by")]
    Still,
    /// The model leaves what the kinematics can carry.
    #[error("{0}")]
    Search(&'static str),
    /// A run to be predicted can not be.
    #[error("{0}: {1}")]
    Holdout(String, NoPrediction),
}

impl Diagnosis {
    /// The effects that mend the model, with standard errors; gusts too, though they are no fault of it.
    pub fn extension(&self) -> Vec<DeclaredEffect> {
        if self.unknown.is_some() || self.judged().is_some_and(|judged| judged != Judged::Gain) {
            return Vec::new();
        }
        let declared = |finding: &Finding| DeclaredEffect { effect: finding.cause.effect, std: Some(finding.cause.std) };
        self.findings.iter().map(declared).collect()
    }

    /// What the causes are worth on the runs that were not used.
    pub fn judged(&self) -> Option<Judged> {
        self.gain.as_ref()?.0.pooled.as_ref().map(|pooled| pooled.ratio.judged())
    }
}

/// Diagnoses a model by some runs, and measures what the causes gain on others.
///
/// # Errors
/// [`NoDiagnosis`] where no run can be used.
pub fn diagnose(
    model: &FlightModel,
    fit: &[Recorded],
    holdout: &[Recorded],
    settings: &Settings,
) -> Result<Diagnosis, NoDiagnosis> {
    let (records, mut set_aside) = taken(model, fit);
    let problem = posed(model, records.iter().map(|(_, record)| record.clone()).collect(), &set_aside)?;
    // Instruments are judged without the model meanwhile; mostly they are well, and the first look stands.
    let (kinematics, first) = std::thread::scope(|scope| {
        let beside = scope.spawn(|| kinematics(fit));
        let first = look(problem, &[], settings);
        (beside.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), first)
    });
    let Kinematics { set_aside: unlike, known } = kinematics;
    // In gusts, which the search has a word for, air data do not follow from the rest, and are none the worse.
    let gusty = first.as_ref().is_some_and(|(_, searched, _)| searched.point.gust.0 > 0.0);
    let (apart, alike): (Vec<_>, Vec<_>) =
        records.into_iter().partition(|(place, _)| !gusty && unlike.iter().any(|(there, _)| there == place));
    let looked = if apart.is_empty() && known.is_empty() {
        first
    } else {
        for (place, record) in apart {
            let why = unlike.iter().find(|(there, _)| *there == place).map(|(_, why)| why.clone()).unwrap_or_default();
            set_aside.push((record.name, Unfit::Instruments(why)));
        }
        let problem = posed(model, alike.into_iter().map(|(_, record)| record).collect(), &set_aside)?;
        look(problem, &known, settings)
    };
    let Some((problem, searched, unknown)) = looked else {
        return Err(NoDiagnosis::Search(
            "the model cannot be followed along these runs: it leaves what the equations of motion can carry",
        ));
    };
    let mut findings = findings(&problem, &searched);
    let discrepancy = discrepancy(&problem, &searched);
    let none = none(&searched);
    let companions = companions(&problem, &searched).into_iter().filter(|own| !problem.silent[own.axis.index()]).collect();
    let gain = gained(model, &mut findings, holdout)?;
    let off_trim = if problem.other_trim { problem.off_trim.clone() } else { Vec::new() };
    let (silent, said): (Vec<Axis>, Vec<Axis>) = Axis::ALL.into_iter().partition(|axis| problem.silent[axis.index()]);
    let discrepancy = discrepancy.into_iter().filter(|one| said.contains(&one.axis)).collect();
    Ok(Diagnosis { findings, unknown, none, discrepancy, silent, companions, off_trim, set_aside, gain })
}

/// The runs and the model, where there is anything to tell.
fn posed(model: &FlightModel, records: Vec<Record>, set_aside: &[(String, Unfit)]) -> Result<Problem, NoDiagnosis> {
    if records.is_empty() {
        return Err(match set_aside.last() {
            Some((name, unfit)) => NoDiagnosis::NoRun(name.clone(), unfit.clone()),
            None => NoDiagnosis::Empty,
        });
    }
    let problem = Problem::new(Aircraft::of(model), model.file.own_effects(), records, model.file.tolerance, &model.file.stds);
    if problem.silent.iter().all(|silent| *silent) {
        return Err(NoDiagnosis::Silent);
    }
    if !problem.moves() {
        return Err(NoDiagnosis::Still);
    }
    Ok(problem.of_what_shows())
}

/// What a search came to, the problem with the noise that it was ended with.
type Looked = (Problem, Searched, Option<Unknown>);

/// Searches; where even the causes that were found leave instruments that scatter by more than their noise, that is their noise,
/// and the search is begun again with it.
fn look(problem: Problem, known: &[Vec<DeclaredEffect>], settings: &Settings) -> Option<Looked> {
    let (searched, unknown) = look_once(&problem, known, settings)?;
    // What many derivatives leave is the model's, and no noise of instruments.
    let many = searched.rivals.len() > known.len() + settings.causes;
    match if many { None } else { problem.with_noise_about(&searched.point) } {
        Some(noisier) => {
            let (searched, _) = look_once(&noisier, known, settings)?;
            Some((noisier, searched, unknown))
        }
        None => Some((problem, searched, unknown)),
    }
}

/// A few causes, or where these do not do many derivatives that are off.
fn look_once(problem: &Problem, known: &[Vec<DeclaredEffect>], settings: &Settings) -> Option<(Searched, Option<Unknown>)> {
    let searched = search(problem, known, settings)?;
    let unknown = unknown_of(problem, &searched);
    if problem.says_all() && known.is_empty() && (unknown.is_some() || searched.rivals.len() >= settings.causes) {
        let most = MANY_LEAVE * searched.before.iter().sum::<f64>();
        let better = |many: &Searched| {
            let less = many.left.iter().sum::<f64>() < most && many.local.evidence() < searched.local.evidence();
            less && !is_pieced_together(problem, many)
        };
        if let Some(many) = whole(problem, &searched, settings).filter(better) {
            return Some((many, None));
        }
    }
    Some((searched, unknown))
}

/// Whether several terms of the library stand on one axis of a linear model: derivatives may be off by the dozen, but products
/// beside each other make up what none of them is. A simulation that curves where flight does not may need them.
fn is_pieced_together(problem: &Problem, many: &Searched) -> bool {
    let on = |axis: Axis| move |one: &Effect| matches!(one, Effect::Nonlinear { axis: its, .. } if *its == axis);
    let terms = |axis: Axis| many.point.effects().filter(on(axis)).count();
    !problem.aircraft.is_curved() && Axis::ALL.into_iter().any(|axis| terms(axis) > 1)
}

/// (1) for each of the rivals.
fn ranked(rivals: &[Rival]) -> Vec<Ranked> {
    let most = rivals.iter().map(|rival| rival.odds).fold(0.0, f64::max);
    let weight = |odds: f64| libm::exp((odds - most) / (2.0 * TEMPERATURE));
    let sum = weight(0.0) + rivals.iter().map(|rival| weight(rival.odds)).sum::<f64>();
    let told = rivals.iter().take(TOLD);
    let one = |rival: &Rival| {
        let (effect, std, odds) = (rival.effect, rival.std, rival.odds);
        Ranked { effect, std, probability: weight(odds) / sum, odds }
    };
    told.map(one).collect()
}

fn findings(problem: &Problem, searched: &Searched) -> Vec<Finding> {
    let mut number = 0;
    let mut pictures = against(problem, searched).into_iter();
    let found = searched.rivals.iter().filter_map(|rivals| {
        let ranking = ranked(rivals);
        let first = ranking.first()?;
        let mut picture = None;
        let cause = if let Effect::Turbulence { .. } = first.effect {
            let length = searched.point.gust.1 * problem.aircraft.trim().airspeed();
            Ranked { effect: Effect::Turbulence { sigma: searched.point.gust.0, length }, ..*first }
        } else {
            let place = number;
            number += 1;
            picture = pictures.next().flatten();
            let hypothesis = searched.point.hypotheses.get(place)?;
            let std = searched.std(place);
            Ranked { effect: hypothesis.effect, std, ..*first }
        };
        Some(Finding { cause, ranking, held_out: None, against: picture })
    });
    found.collect()
}

/// Where the causes leave too much.
fn unknown_of(problem: &Problem, searched: &Searched) -> Option<Unknown> {
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
    let discrepancy = discrepancy(problem, searched);
    Some(Unknown { axis, band_hz: discrepancy.get(place)?.band_hz, worth })
}

/// Nothing wrong, and what came nearest to being a cause.
fn none(searched: &Searched) -> (f64, Vec<Ranked>) {
    let first = searched.rivals.first().unwrap_or(&searched.refused);
    let others = ranked(first);
    (1.0 - others.iter().map(|rival| rival.probability).sum::<f64>().min(1.0), others)
}

/// The control without whose motion an effect does nothing.
fn acts_by(effect: &Effect) -> Option<Control> {
    match *effect {
        Effect::ControlEffectiveness { control, .. }
        | Effect::ActuatorLag { control, .. }
        | Effect::TransportDelay { control, .. }
        | Effect::RateLimit { control, .. }
        | Effect::DeadZone { control, .. }
        | Effect::CrossFeed { from: control, .. } => Some(control),
        Effect::Derivative { variable, .. } | Effect::FlightPath { variable, .. } => {
            Control::ALL.into_iter().find(|control| control.variable() == variable)
        }
        _ => None,
    }
}

/// Hold-out runs predicted before and after, and without each of the causes.
fn gained(model: &FlightModel, findings: &mut [Finding], holdout: &[Recorded]) -> Result<Option<Gained>, NoDiagnosis> {
    if holdout.is_empty() {
        return Ok(None);
    }
    let causes: Vec<Effect> = findings.iter().map(|finding| finding.cause.effect).collect();
    let (ratios, gained) = held_out(model, &causes, holdout)?;
    let seen = holdout.iter().filter_map(|run| Record::of(&run.name, &run.samples, run.geometry).ok());
    let seen: Vec<Record> = seen.collect();
    let moves = |control: Control| seen.iter().any(|run| run.moves(control.index()));
    for (finding, ratio) in findings.iter_mut().zip(ratios) {
        // A control that rests there says nothing of what it does.
        finding.held_out = ratio.filter(|_| acts_by(&finding.cause.effect).is_none_or(moves));
    }
    Ok(Some(gained))
}

/// What causes gain on runs that they were not found in: for each, the pooled error with all of them over that with all but this
/// one; and the gain of all.
///
/// # Errors
/// [`NoDiagnosis::Holdout`] where a run cannot be predicted.
pub fn held_out(
    model: &FlightModel,
    causes: &[Effect],
    holdout: &[Recorded],
) -> Result<(Vec<Option<Estimate>>, Gained), NoDiagnosis> {
    let flown: Vec<free_run::Run<'_>> = holdout.iter().map(|run| free_run::Run::of(&run.samples, &run.geometry)).collect();
    let own = model.file.own_effects();
    let predict = |causes: &[Effect]| -> Result<Vec<Prediction>, NoDiagnosis> {
        let effects: Vec<Effect> = own.iter().chain(causes).copied().collect();
        let all = flown.iter().zip(holdout).map(|(flown, run)| {
            free_run::predict(model, &effects, flown).map_err(|wrong| NoDiagnosis::Holdout(run.name.clone(), wrong))
        });
        all.collect()
    };
    let gain_of = |before: &[Prediction], after: &[Prediction]| gain(&before.iter().zip(after).collect::<Vec<_>>());
    let (before, after) = (predict(&[])?, predict(causes)?);
    let mut ratios = Vec::new();
    for place in 0..causes.len() {
        let others: Vec<Effect> =
            causes.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, effect)| *effect).collect();
        let without = if others.is_empty() { before.clone() } else { predict(&others)? };
        ratios.push(gain_of(&without, &after).pooled.map(|pooled| pooled.ratio));
    }
    let gain = gain_of(&before, &after);
    Ok((ratios, (gain, before.into_iter().zip(after).collect())))
}
