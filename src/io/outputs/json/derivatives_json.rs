//! `derivatives.json`: the estimates of one or several runs, for programs. SI and radians.
//!
//! `runs[]` contains for each run its name, status, warnings, consistency of the vanes, instrument biases, equations and modes;
//! `modes` and `output_error` at the top are those of the last run. `output_error` and `findings` are absent if these analyses
//! were not run. Numbers that are not finite, and modes that do not exist, are null.

use super::finding_json::FindingJson;
use super::message_json::{EquationsJson, reason_text, status_text};
use super::output_error_json::OutputErrorJson;
use crate::flight::channel::ControlNames;
use crate::io::outputs::words::noise_text::NoiseUsed;
use crate::postflight::diagnosis::record::FindingRecord;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::estimation::record::StateRecord;
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::realtime::regression::record::{DerivativesRecord, Status};
use serde::Serialize;

/// What one run came to.
#[derive(Clone, Copy, Debug)]
pub struct RunEstimates<'a> {
    /// The run's name.
    pub run: &'a str,
    /// How its controls are called.
    pub controls: ControlNames,
    /// Its last state, for the biases.
    pub state: Option<&'a StateRecord>,
    /// Its last derivatives.
    pub derivatives: Option<&'a DerivativesRecord>,
    /// Its last modes.
    pub modes: Option<&'a ModesRecord>,
    /// Output error as it stands, where it is run.
    pub output_error: Option<&'a OutputErrorRecord>,
    /// What the diagnosis says, where it is run.
    pub findings: &'a [FindingRecord],
    /// What a reader of the numbers must know, as sentences.
    pub warnings: &'a [String],
    /// Coefficients of determination of the rates of alpha and beta by the kinematics, where they can be estimated.
    pub consistency: [Option<f64>; 2],
    /// The noise statistics that the filter used.
    pub noise: Option<NoiseUsed>,
}

/// The estimates as a JSON document, ended by a line feed.
///
/// # Errors
/// Where the document cannot be encoded; no record of this program can bring that about.
pub fn derivatives_json(runs: &[RunEstimates<'_>]) -> Result<String, serde_json::Error> {
    let document = Document {
        runs: runs.iter().map(RunJson::new).collect(),
        modes: runs.last().and_then(|run| run.modes.map(|modes| AllModes::new(modes, run.controls))),
        output_error: runs.last().and_then(output_error),
    };
    let mut text = serde_json::to_string_pretty(&document)?;
    text.push('\n');
    Ok(text)
}

/// As of the newest derivatives.
fn output_error(run: &RunEstimates<'_>) -> Option<OutputErrorJson> {
    let record = run.output_error?;
    let time_s = run.derivatives.map_or(record.time_s, |newest| newest.time_s.max(record.time_s));
    Some(OutputErrorJson::at(record, run.controls, time_s))
}

/// The status of a run as a whole: that of its furthest equation (converged, converging, stale, exciting, waiting), and
/// not identifiable only where every equation is.
pub fn run_status(derivatives: Option<&DerivativesRecord>) -> Status {
    let equations = derivatives.map(|record| record.equations.as_slice()).unwrap_or_default();
    equations.iter().map(|equation| equation.status).max_by_key(Status::rank).unwrap_or(Status::Waiting)
}

#[derive(Serialize)]
struct Document<'a> {
    runs: Vec<RunJson<'a>>,
    modes: Option<AllModes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output_error: Option<OutputErrorJson>,
}

#[derive(Serialize)]
struct RunJson<'a> {
    run: &'a str,
    time: Option<f64>,
    status: String,
    reason: Option<String>,
    warnings: &'a [String],
    consistency: ConsistencyJson,
    bias: Option<BiasesJson>,
    noise: Option<NoiseUsed>,
    equations: EquationsJson<'a>,
    modes: Option<AllModes>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output_error: Option<OutputErrorJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    findings: Vec<FindingJson>,
}

impl<'a> RunJson<'a> {
    fn new(run: &RunEstimates<'a>) -> Self {
        let controls = run.controls;
        let status = run_status(run.derivatives);
        let equations = run.derivatives.map(|record| record.equations.as_slice()).unwrap_or_default();
        RunJson {
            run: run.run,
            time: run.derivatives.map(|record| record.time_s),
            status: status_text(status, controls),
            reason: reason_text(status, controls),
            warnings: run.warnings,
            consistency: ConsistencyJson::new(run.consistency),
            bias: run.state.map(BiasesJson::new),
            noise: run.noise,
            equations: EquationsJson { equations, controls },
            modes: run.modes.map(|modes| AllModes::new(modes, controls)),
            output_error: output_error(run),
            findings: run.findings.iter().map(|record| FindingJson::new(record, controls)).collect(),
        }
    }
}

#[derive(Serialize)]
struct VaneJson {
    r2: f64,
}

/// A vane without an estimate is left out.
#[derive(Serialize)]
struct ConsistencyJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    alpha: Option<VaneJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    beta: Option<VaneJson>,
}

impl ConsistencyJson {
    fn new(consistency: [Option<f64>; 2]) -> Self {
        let [alpha, beta] = consistency.map(|r2| r2.map(|r2| VaneJson { r2 }));
        ConsistencyJson { alpha, beta }
    }
}

#[derive(Serialize)]
struct BiasJson {
    value: f64,
    std: f64,
    unit: &'static str,
}

#[derive(Serialize)]
struct BiasesJson {
    ax: BiasJson,
    ay: BiasJson,
    az: BiasJson,
    p: BiasJson,
    q: BiasJson,
    r: BiasJson,
}

impl BiasesJson {
    fn new(state: &StateRecord) -> Self {
        let force = |place| BiasJson { unit: "m/s^2", ..bias(&state.accelerometer_bias, &state.accelerometer_bias_std, place) };
        let rate = |place| BiasJson { unit: "rad/s", ..bias(&state.gyro_bias, &state.gyro_bias_std, place) };
        BiasesJson { ax: force(0), ay: force(1), az: force(2), p: rate(0), q: rate(1), r: rate(2) }
    }
}

fn bias(values: &[f64; 3], deviations: &[f64; 3], place: usize) -> BiasJson {
    let at = |array: &[f64; 3]| array.get(place).copied().unwrap_or(f64::NAN);
    BiasJson { value: at(values), std: at(deviations), unit: "" }
}

#[derive(Serialize)]
struct AllModes {
    status: String,
    reason: Option<String>,
    dutch_roll: Option<OscillatoryMode>,
    roll: Option<RealRoot>,
    spiral: Option<RealRoot>,
    lateral_phugoid: Option<OscillatoryMode>,
    coupled_dutch_roll: Option<OscillatoryMode>,
}

impl AllModes {
    fn new(modes: &ModesRecord, controls: ControlNames) -> Self {
        AllModes {
            status: status_text(modes.status, controls),
            reason: reason_text(modes.status, controls),
            dutch_roll: modes.dutch_roll,
            roll: modes.roll,
            spiral: modes.spiral,
            lateral_phugoid: modes.lateral_phugoid,
            coupled_dutch_roll: modes.coupled,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::realtime::modes::record::RealRoot;
    use crate::realtime::regression::record::{EquationRecord, FrequencyTerm, Reason, TermRecord};

    #[test]
    fn the_document_has_the_form_that_programs_expect() {
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::NotIdentifiable(Reason::NoRates)));
        let yaw = &mut equations[Axis::N.index()];
        yaw.status = Status::Converged;
        yaw.terms
            .push(TermRecord {
                variable: Some(Variable::Pedal),
                value: -1.5,
                std: 0.3,
                std_white: 0.0,
                step: 2,
                primary: true,
                frequency: Some(FrequencyTerm { value: -0.5, std: 0.4 }),
            })
            .unwrap();
        let derivatives = DerivativesRecord { time_s: 9.0, equations, lateral: None, excited: true };
        let spiral = Some(RealRoot { value: -0.01, std: f64::NAN });
        let modes = ModesRecord {
            time_s: 9.0,
            status: Status::Converged,
            dutch_roll: None,
            roll: None,
            spiral,
            lateral_phugoid: None,
            coupled: None,
        };
        let warnings = ["sideslip (beta) is rejected".to_owned()];
        let run = RunEstimates {
            run: "467/10/11",
            controls: ControlNames::FixedWing,
            state: None,
            derivatives: Some(&derivatives),
            modes: Some(&modes),
            output_error: None,
            findings: &[],
            warnings: &warnings,
            consistency: [None, Some(0.965)],
            noise: None,
        };
        let found: serde_json::Value = serde_json::from_str(&derivatives_json(&[run]).unwrap()).unwrap();
        let first = &found["runs"][0];
        assert_eq!((&first["run"], &first["status"]), (&"467/10/11".into(), &"converged".into()));
        assert_eq!(first["warnings"][0], "sideslip (beta) is rejected");
        assert_eq!(first["consistency"], serde_json::json!({"beta": {"r2": 0.965}}));
        let term = &first["equations"]["N"]["terms"][0];
        assert_eq!(term["name"], "N_rudder");
        assert_eq!((&term["partial_f"], &term["partial_f_white"]), (&25.0.into(), &serde_json::Value::Null));
        assert_eq!(term["frequency"], serde_json::json!({"value": -0.5, "std": 0.4, "disagreement": 2.0}));
        assert_eq!(first["equations"]["N"]["disagreement"], serde_json::json!({"name": "N_rudder", "standard_errors": 2.0}));
        assert_eq!(first["equations"]["X"]["reason"], "p, q and r come together too rarely or not at all");
        assert_eq!(first["equations"]["X"]["r2"], serde_json::Value::Null);
        assert_eq!(found["modes"], first["modes"]);
        assert_eq!(found["modes"]["spiral"]["value"], -0.01);
        assert!(found["modes"]["spiral"]["std"].is_null() && found["modes"]["dutch_roll"].is_null());
    }

    #[test]
    fn a_run_is_as_far_as_its_furthest_equation() {
        let mut equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::NotIdentifiable(Reason::NoRates)));
        let record = |equations| DerivativesRecord { time_s: 0.0, equations, lateral: None, excited: false };
        assert_eq!(run_status(Some(&record(equations.clone()))), Status::NotIdentifiable(Reason::NoRates));
        equations[1].status = Status::Exciting;
        equations[4].status = Status::Stale;
        assert_eq!(run_status(Some(&record(equations))), Status::Stale);
        assert_eq!(run_status(None), Status::Waiting);
    }
}
