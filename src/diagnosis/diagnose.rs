//! The diagnosis of a model: causes with probabilities, what remains, what the extended model gains.
//!
//! Consumes a model and runs; produces the findings. Where the search's evidence of causes i and of no cause (o_i, twice the
//! logarithm of the odds against nothing) is, the probability of each is
//!     P_i = exp(o_i/2T)/(1 + sum_j exp(o_j/2T))                                                       (1)
//! with T = [`TEMPERATURE`], for the evidence leaves out what linearising and the colour of what remains do to it.
//! What the search cannot explain is what noise of forces beyond that of the controls is still worth, axis by axis; where the
//! causes found explain less than [`EXPLAINED`] of what they and that noise explain together, the answer is `unknown`.

use super::aircraft::Aircraft;
use super::free_run::{self, NoPrediction, Prediction};
use super::gain::{Gain, Judged, gain};
use super::problem::Problem;
use super::record::{Record, Unfit};
use super::residual::{Discrepancy, discrepancy};
use super::screen::acts_on;
use super::search::{Rival, Searched, Settings, search};
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis};
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
}

/// A cause that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// It, with all other causes in the model.
    pub cause: Ranked,
    /// What else it may be, the most probable first, the cause itself among them.
    pub ranking: Vec<Ranked>,
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
    /// By axis.
    pub discrepancy: [Discrepancy; AXES],
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
    /// The model has not all axes.
    #[error("the model says nothing of {0}: expected derivatives on all six axes, which move together along a run")]
    Silent(String),
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
    let (mut records, mut set_aside) = (Vec::new(), Vec::new());
    for run in fit {
        match Record::of(&run.name, &run.samples, run.geometry) {
            Ok(record) => records.push(record),
            Err(unfit) => set_aside.push((run.name.clone(), unfit)),
        }
    }
    if records.is_empty() {
        return Err(match set_aside.pop() {
            Some((name, unfit)) => NoDiagnosis::NoRun(name, unfit),
            None => NoDiagnosis::Empty,
        });
    }
    let fixed: Vec<Effect> = model.file.effects.iter().map(|declared| declared.effect).collect();
    let problem = Problem::new(Aircraft::of(model), fixed, records, model.file.tolerance);
    let silent = problem.silent();
    if !silent.is_empty() {
        let names: Vec<&str> = silent.iter().map(|axis| axis.name()).collect();
        return Err(NoDiagnosis::Silent(names.join(", ")));
    }
    if !problem.moves() {
        return Err(NoDiagnosis::Still);
    }
    let searched = search(&problem, settings).ok_or(NoDiagnosis::Search(
        "the model cannot be followed along these runs: it leaves what the equations of motion can carry",
    ))?;
    let findings = findings(&problem, &searched);
    let discrepancy = discrepancy(&problem, &searched);
    let unknown = unknown(&searched, &discrepancy);
    let none = none(&searched);
    let gain = gained(model, &findings, holdout)?;
    let off_trim = if problem.is_off_trim() { problem.off_trim.clone() } else { Vec::new() };
    Ok(Diagnosis { findings, unknown, none, discrepancy, off_trim, set_aside, gain })
}

/// (1) for each of the rivals.
fn ranked(rivals: &[Rival]) -> Vec<Ranked> {
    let most = rivals.iter().map(|rival| rival.odds).fold(0.0, f64::max);
    let weight = |odds: f64| libm::exp((odds - most) / (2.0 * TEMPERATURE));
    let sum = weight(0.0) + rivals.iter().map(|rival| weight(rival.odds)).sum::<f64>();
    let told = rivals.iter().take(TOLD);
    told.map(|rival| Ranked { effect: rival.effect, std: rival.std, probability: weight(rival.odds) / sum }).collect()
}

fn findings(problem: &Problem, searched: &Searched) -> Vec<Finding> {
    let mut number = 0;
    let found = searched.rivals.iter().filter_map(|rivals| {
        let ranking = ranked(rivals);
        let first = ranking.first()?;
        let cause = if let Effect::Turbulence { .. } = first.effect {
            let length = searched.point.gust.1 * problem.aircraft.trim().airspeed();
            Ranked { effect: Effect::Turbulence { sigma: searched.point.gust.0, length }, ..*first }
        } else {
            let place = number;
            number += 1;
            let hypothesis = searched.point.hypotheses.get(place)?;
            let std = searched.local.std(searched.point.main_place_of(place));
            Ranked { effect: hypothesis.effect, std, probability: first.probability }
        };
        Some(Finding { cause, ranking })
    });
    found.collect()
}

/// Where the causes leave too much.
fn unknown(searched: &Searched, discrepancy: &[Discrepancy; AXES]) -> Option<Unknown> {
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
    Some(Unknown { axis, band_hz: discrepancy.get(place)?.band_hz, worth })
}

/// Nothing wrong, and what came nearest to being a cause.
fn none(searched: &Searched) -> (f64, Vec<Ranked>) {
    let first = searched.rivals.first().unwrap_or(&searched.refused);
    let others = ranked(first);
    (1.0 - others.iter().map(|rival| rival.probability).sum::<f64>().min(1.0), others)
}

/// Hold-out runs predicted before and after.
fn gained(model: &FlightModel, findings: &[Finding], holdout: &[Recorded]) -> Result<Option<Gained>, NoDiagnosis> {
    if holdout.is_empty() {
        return Ok(None);
    }
    let before: Vec<Effect> = model.file.effects.iter().map(|declared| declared.effect).collect();
    let after: Vec<Effect> = before.iter().copied().chain(findings.iter().map(|finding| finding.cause.effect)).collect();
    let mut pairs = Vec::new();
    for run in holdout {
        let flown = free_run::Run::of(&run.samples, &run.geometry);
        let predict = |effects: &[Effect]| {
            free_run::predict(model, effects, &flown).map_err(|wrong| NoDiagnosis::Holdout(run.name.clone(), wrong))
        };
        pairs.push((predict(&before)?, predict(&after)?));
    }
    let both: Vec<(&Prediction, &Prediction)> = pairs.iter().map(|(before, after)| (before, after)).collect();
    let gain = gain(&both);
    Ok(Some((gain, pairs)))
}
