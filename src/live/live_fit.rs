//! One fit of output error to the manoeuvres in the buffer: structure from the regression's terms, search, modes.
//!
//! Consumes the samples of each manoeuvre, the terms of every equation and the last estimates; produces derivatives with standard
//! errors, and modes. Lateral and longitudinal motion are included where the regression has terms in L or N, and in M, and their
//! measurements were recorded: all eight states of a coupled helicopter. Samples are averaged over blocks.
//! A term that the regression has not selected is not zero: fixed at zero it biases the others, and no standard error accounts
//! for it. So every term is free as soon as the manoeuvres are long enough.
//! Where residuals are far from white, terms are left out or the search has not ended, standard errors are not below the
//! regression's (`error_scale`).
//! Refused: what [`crate::postflight::identification::identification_model`] and output error refuse, as a sentence.

use super::error_scale::ErrorScale;
use super::output_error_config::LiveOutputErrorConfig;
use super::regression_report::RegressionReport;
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::postflight::identification::columns::Columns;
use crate::postflight::identification::identification_model::IdentificationModel;
use crate::postflight::identification::model_variables::ModelVariables;
use crate::postflight::identification::roots::{IdentifiedRoot, modes};
use crate::postflight::identification::start_values::starts;
use crate::postflight::output_error::decimated::by_blocks;
use crate::postflight::output_error::record::{OutputErrorRecord, ParameterRecord};
use crate::postflight::output_error::{FitResult, FitSettings, InputOutputRecord, ModelStructure, fit as search};
use crate::realtime::modes::record::{OscillatoryMode, RealRoot};

/// Relative standard error of omega, and standard error of zeta, below which an oscillation is known.
const OMEGA_KNOWN: f64 = 0.05;
const ZETA_KNOWN: f64 = 0.02;
/// Length of the last step, standard errors.
const TOLERANCE: f64 = 0.02;
/// Ratio of corrected standard errors to those for white residuals (median) above which the model is inadequate.
const COLOURED: f64 = 2.0;
/// Standard errors from which on a control is known to cause a moment.
const CONTROLLED: f64 = 3.0;

const LATERAL: [&str; 4] = ["v", "p", "phi", "r"];
const LONGITUDINAL: [&str; 4] = ["u", "w", "q", "theta"];

/// One fit, before it is published.
pub(crate) struct LiveFit {
    pub(crate) record: OutputErrorRecord,
    /// Whether the search has converged.
    pub(crate) searched: bool,
    /// Whether its own standard errors do not hold: search not ended, residuals far from white, terms left out.
    pub(crate) doubted: bool,
}

/// Whether its oscillation is known well enough to be reported as converged.
pub(crate) fn is_known(record: &OutputErrorRecord) -> bool {
    let known = |pair: &OscillatoryMode| pair.std_omega < OMEGA_KNOWN * pair.omega && pair.std_zeta < ZETA_KNOWN;
    record.dutch_roll.as_ref().or(record.short_period.as_ref()).is_some_and(known)
}

/// Which derivatives are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FreeTerms {
    /// Those that the regression has selected; the others are zero.
    Selected,
    /// Those of every state, and of every control that is in any equation.
    All,
}

/// Fits the manoeuvres, the longest of which was excited for `excited_s`: with all terms where that is long enough, with the
/// selected ones where it is not, or where all are unidentifiable.
pub(crate) fn fit(
    runs: &[&[Sample]],
    geometry: RunGeometry,
    regression: &RegressionReport,
    before: &[(Axis, Variable, f64)],
    excited_s: f64,
    config: &LiveOutputErrorConfig,
) -> Result<LiveFit, String> {
    if excited_s >= config.all_terms_s
        && let Ok(found) = fit_with(FreeTerms::All, runs, geometry, regression, before, config)
        && found.searched
    {
        return Ok(found);
    }
    fit_with(FreeTerms::Selected, runs, geometry, regression, before, config)
}

fn fit_with(
    which: FreeTerms,
    runs: &[&[Sample]],
    geometry: RunGeometry,
    regression: &RegressionReport,
    before: &[(Axis, Variable, f64)],
    config: &LiveOutputErrorConfig,
) -> Result<LiveFit, String> {
    let columns = runs.iter().enumerate().map(|(place, samples)| columns(place, samples, geometry, config.trim_s));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let (choice, only) = structure(which, &columns, geometry, &regression.terms)?;
    let mut linear = IdentificationModel::new(choice, &columns, Some(&only)).map_err(|wrong| wrong.to_string())?;
    // The airspeed's accelerometer has no state where u is none.
    linear.notes.clear();
    // Standard errors would be half as large then, and the noise of the controls, which they do not know of, as large as they.
    linear.nonlinear_outputs = false;
    let records = columns.iter().map(|run| {
        let mut record = linear.record(run)?;
        if config.hold_controls {
            linear.hold_controls(run, &mut record)?;
        }
        Ok(thinned(record, config.rate_hz))
    });
    let records = records
        .collect::<Result<Vec<InputOutputRecord>, crate::postflight::identification::columns::ColumnError>>()
        .map_err(|wrong| wrong.to_string())?;
    let settings = FitSettings { iterations: config.iterations, tolerance: TOLERANCE, ..FitSettings::default() };
    let names: Vec<(Axis, Variable)> = linear.derivatives.iter().filter_map(|(axis, name)| placed(*axis, name)).collect();
    if names.len() != linear.derivatives.len() {
        return Err("a derivative without a place in the record".to_owned());
    }
    let known = names.iter().map(|name| before.iter().find(|one| (one.0, one.1) == *name).map(|one| one.2));
    let warm: Option<Vec<f64>> = known.collect();
    let attempt = |values: &[f64]| search(&linear.structure, &linear.parameters(values), &[], &records, &settings);
    let mut fitted = warm.and_then(|warm| attempt(&warm).ok().filter(|fitted| fitted.converged));
    if fitted.is_none() {
        fitted = Some(attempt(&starts(&linear, &records)).map_err(|refused| refused.to_string())?);
    }
    let Some(fitted) = fitted else { return Err("no fit".to_owned()) };
    if fitted.theta.iter().chain(&fitted.std).any(|x| !x.is_finite()) {
        return Err("the estimates or their errors are no numbers".to_owned());
    }
    let found = output_error_record(which, &linear, &names, &fitted, &records, regression);
    if found.record.parameters.is_empty() {
        return Err("the fit is in doubt, and the regression has no number in L, M or N".to_owned());
    }
    Ok(found)
}

/// Axis and variable of a derivative by its name in an identification.
fn placed(axis: char, name: &str) -> Option<(Axis, Variable)> {
    Some((Axis::from_name(axis.encode_utf8(&mut [0; 4]))?, Variable::from_name(name)?))
}

fn columns(place: usize, samples: &[Sample], geometry: RunGeometry, trim_s: f64) -> Result<Columns, String> {
    let there = Channel::ALL.into_iter().filter(|channel| samples.iter().any(|sample| sample.get(*channel).is_some()));
    let column = |channel: Channel| {
        let value = |sample: &Sample| sample.get(channel).filter(|value| value.is_finite()).unwrap_or(f64::NAN);
        (channel.name(geometry.controls).to_owned(), samples.iter().map(value).collect())
    };
    let times_s = samples.iter().map(|sample| sample.time_s).collect();
    let columns = there.map(column).collect();
    Columns::new(format!("manoeuvre {}", place + 1), geometry, times_s, columns, trim_s).map_err(|wrong| wrong.to_string())
}

fn thinned(record: InputOutputRecord, rate_hz: f64) -> InputOutputRecord {
    let span_s = record.times_s.last().zip(record.times_s.first()).map_or(0.0, |(last, first)| last - first);
    let rate = (record.times_s.len().max(1) - 1) as f64 / span_s.max(1e-9);
    let block = libm::floor(rate / rate_hz + 0.1) as usize;
    if block > 1 { by_blocks(&record, block) } else { record }
}

type Only = Vec<(char, String)>;

/// States, inputs, outputs and derivatives that the regression's terms ask for and the recording can bear.
fn structure(
    which: FreeTerms,
    runs: &[Columns],
    geometry: RunGeometry,
    terms: &[u16; AXES],
) -> Result<(ModelVariables, Only), String> {
    let has = |axis: Axis, variable: Variable| terms.get(axis.index()).is_some_and(|bits| bits & 1 << variable.index() != 0);
    let any = |axes: &[Axis], variables: &[Variable]| axes.iter().any(|&axis| variables.iter().any(|&one| has(axis, one)));
    let all = |name: &str| runs.iter().all(|run| run.has(name));
    let measured = |names: &[&str]| names.iter().all(|name| all(name));
    let lateral = any(&[Axis::L, Axis::N], &[Variable::V, Variable::P, Variable::R]);
    let longitudinal = any(&[Axis::M], &[Variable::W, Variable::Q]);
    if !lateral && !longitudinal {
        return Err("the regression has no terms yet in L, M or N".to_owned());
    }
    let lateral_measured = measured(&["beta", "p", "r", "phi", "tas"]);
    let longitudinal_measured = measured(&["tas", "alpha", "q", "theta"]);
    let (lateral, longitudinal) = (lateral && lateral_measured, longitudinal && longitudinal_measured);
    let (states, outputs): (Vec<&str>, Vec<&str>) = match (lateral, longitudinal) {
        (false, false) => return Err("needs tas with beta, p, r, phi or with alpha, q, theta".to_owned()),
        (true, false) => (LATERAL.to_vec(), vec!["beta", "p", "phi", "r", "ay"]),
        (false, true) => (LONGITUDINAL.to_vec(), vec!["tas", "alpha", "q", "theta", "ax", "az"]),
        (true, true) => (
            vec!["u", "v", "w", "p", "q", "r", "phi", "theta"],
            vec!["tas", "alpha", "beta", "p", "q", "r", "phi", "theta", "ax", "ay", "az"],
        ),
    };
    let own = |axis: Axis| if axis.is_lateral() { lateral } else { longitudinal };
    let name = |variable: Variable| variable.name(geometry.controls);
    let axes = || Axis::ALL.into_iter().filter(|axis| own(*axis));
    let inputs: Vec<Variable> =
        Variable::CONTROLS.into_iter().filter(|&control| all(name(control)) && axes().any(|axis| has(axis, control))).collect();
    if inputs.is_empty() {
        return Err("no control is in the regression's equations".to_owned());
    }
    let mut only = Only::new();
    for axis in axes() {
        let known = |variable: &Variable| states.contains(&name(*variable)) || inputs.contains(variable);
        let free = |variable: &Variable| which == FreeTerms::All || has(axis, *variable);
        for variable in Variable::ALL.into_iter().filter(|one| free(one) && known(one)) {
            only.push((axis.name().chars().next().unwrap_or_default(), name(variable).to_owned()));
        }
    }
    let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    let outputs: Vec<&str> = outputs.into_iter().filter(|name| all(name)).collect();
    let inputs: Vec<&str> = inputs.into_iter().map(name).collect();
    Ok((ModelVariables { states: owned(&states), inputs: owned(&inputs), outputs: owned(&outputs) }, only))
}

fn output_error_record(
    which: FreeTerms,
    linear: &IdentificationModel,
    names: &[(Axis, Variable)],
    fitted: &FitResult,
    records: &[InputOutputRecord],
    regression: &RegressionReport,
) -> LiveFit {
    let mut record = OutputErrorRecord::EMPTY;
    let errors: Vec<_> = names.iter().copied().zip(fitted.std.iter().copied()).collect();
    let own = ErrorScale::own(&errors, &regression.curvature_std);
    let coloured = fitted.colour_ratio().is_some_and(|ratio| ratio > COLOURED);
    let doubt = if !fitted.converged {
        Some("search not ended")
    } else if coloured {
        Some("residuals not white")
    } else if which == FreeTerms::Selected {
        Some("terms left out")
    } else if own.is_dominated_by_curvature() {
        Some("the motion may be too large for a linear model")
    } else {
        None
    };
    let scale = if doubt.is_none() { own } else { ErrorScale::limited(&errors, &regression.std) };
    let numbers = fitted.theta.iter().zip(&fitted.std).zip(&fitted.std_cramer_rao);
    for (&(axis, variable), ((&value, &std), &std_cramer_rao)) in names.iter().zip(numbers) {
        let Some(std) = scale.std(axis, variable, std) else { continue };
        let _ = record.parameters.push(ParameterRecord { axis, variable, value, std, std_cramer_rao });
    }
    let cov = scale.covariance(names, &fitted.cov);
    let count = |records: &[InputOutputRecord]| records.iter().map(|record| record.times_s.len()).sum::<usize>();
    record.manoeuvres = u32::try_from(records.len()).unwrap_or(u32::MAX);
    record.samples = u32::try_from(count(records)).unwrap_or(u32::MAX);
    if let Some(doubt) = doubt {
        record.explain(format_args!("{doubt}; errors not below the regression's"));
    }
    let roots = |structure: &ModelStructure| {
        modes(structure, &fitted.theta, &cov, &linear.reference_trim.steps(linear.reference_trim_std, &structure.states))
            .unwrap_or_default()
    };
    for (part, lateral) in [(LATERAL, true), (LONGITUDINAL, false)] {
        let Some(part) = subsystem(&linear.structure, &part) else { continue };
        if !scale.has(lateral) || !is_controlled(&record, lateral) {
            continue;
        }
        for root in roots(&part) {
            match root.name {
                Some("dutch_roll") => record.dutch_roll = resolved_pair(&root),
                Some("lateral_phugoid") => record.lateral_phugoid = resolved_pair(&root),
                Some("roll") => record.roll = resolved_root(&root),
                Some("spiral") => record.spiral = resolved_root(&root),
                Some("short_period") => record.short_period = resolved_pair(&root),
                _ => {}
            }
        }
    }
    let coupled = linear.structure.states.len() > LATERAL.len() && scale.has(false);
    if let Some(alone) = record.dutch_roll.filter(|_| coupled) {
        let away = |root: &IdentifiedRoot| libm::hypot(root.real - alone.real, root.imag - alone.imag);
        let all = roots(&linear.structure);
        let pairs = all.iter().filter(|root| root.imag > 0.0);
        record.coupled = pairs.min_by(|a, b| away(a).total_cmp(&away(b))).and_then(resolved_pair);
    }
    LiveFit { record, searched: fitted.converged, doubted: doubt.is_some() }
}

fn resolved_pair(root: &IdentifiedRoot) -> Option<OscillatoryMode> {
    let IdentifiedRoot { real, imag, omega, zeta, std_omega, std_zeta, .. } = *root;
    Some(OscillatoryMode { real, imag, omega, zeta, std_omega, std_zeta }).filter(OscillatoryMode::is_resolved)
}

fn resolved_root(root: &IdentifiedRoot) -> Option<RealRoot> {
    Some(RealRoot { value: root.real, std: root.std_real }).filter(RealRoot::is_resolved)
}

/// Whether a control is known to cause a moment of its own plane: motion that none of its controls causes is of gusts, of the
/// other plane or of noise, and its modes are not identified.
fn is_controlled(record: &OutputErrorRecord, lateral: bool) -> bool {
    let mut of_plane = record.parameters.iter().filter(|one| !one.axis.is_force() && one.axis.is_lateral() == lateral);
    of_plane
        .any(|one| one.variable.is_control() && one.variable.is_lateral() == lateral && one.value.abs() > CONTROLLED * one.std)
}

/// The part of the structure that is of those states alone; `None` where one is missing.
fn subsystem(whole: &ModelStructure, states: &[&str]) -> Option<ModelStructure> {
    let places = states.iter().map(|name| whole.states.iter().position(|state| state == name));
    let places = places.collect::<Option<Vec<usize>>>()?;
    let row = |place: &usize| -> Option<Vec<_>> {
        let row = whole.a.get(*place)?;
        places.iter().map(|column| row.get(*column).cloned()).collect()
    };
    let a = places.iter().map(row).collect::<Option<Vec<_>>>()?;
    Some(ModelStructure { states: states.iter().map(|&name| name.to_owned()).collect(), a, ..ModelStructure::default() })
}
