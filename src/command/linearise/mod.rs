//! `sideslip linearise`: trim, matrices, derivatives and modes of a model.

use super::options::flight_condition;
use super::options::flight_condition::FlightCondition;
use super::options::replace_option::ReplaceOption;
use super::recordings::provenance::Provenance;
use super::terminal::console::print;
use super::terminal::output_file::refuse_to_overwrite;
use crate::command::{message, message_text};
use nalgebra::Complex;
use serde_json::{Map, Value, json};
use sideslip::dynamics::linear::{INPUTS, STATES, input_matrix, state_matrix, with_effects};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::effect::{Effect, Family};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::number::Fixed;
use sideslip::io::outputs::words::printable::printable;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::modes::naming::{Eigenmodes, eigenmodes};
use sideslip::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use sideslip::realtime::regression::record::{LateralDerivatives, Status};
use sideslip::simulation::flight_model::FlightModel;
use sideslip::simulation::level1::aircraft::{Level1, Perturbation};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Trim, linear model and modes of a model
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  sideslip linearise --model puma-100kn.toml --json -\n  \
                  sideslip linearise --model puma --speed 51.44 --climb 5.08 --density 1.024 --set hub=exact")]
pub(crate) struct LineariseArgs {
    #[command(flatten)]
    condition: FlightCondition,
    /// Write the result as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

pub(crate) fn run(args: &LineariseArgs) -> Result<Outcome, Failure> {
    if let Some(json) = &args.json {
        refuse_to_overwrite("--json", json, std::slice::from_ref(&args.condition.model))?;
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    let read = args.condition.read()?;
    let FlightModel { file, level1, .. } = &read;
    let effects = file.own_effects();
    let model = with_effects(&file.linear, &effects)
        .map_err(|_| Failure::file(&args.condition.model, "its effects add more nonlinear terms than a model may have"))?;
    let modes = eigenmodes(&state_matrix(&model)).ok_or_else(|| {
        Failure::Running(format!("{}: the modes cannot be computed from its derivatives", args.condition.model.display()))
    })?;
    for effect in &effects {
        if matches!(
            effect,
            Effect::ActuatorLag { .. } | Effect::TransportDelay { .. } | Effect::RateLimit { .. } | Effect::DeadZone { .. }
        ) || matches!(effect.kind().family(), Family::Disturbance | Family::Instrument)
        {
            message(format_args!("note: `{}` is no part of A and B and is left out of them", effect.kind().name()));
        }
    }
    let mut result = to_json(file, &model, &effects, &modes);
    if let Some(result) = result.as_object_mut() {
        result.insert("level1".to_owned(), flight_condition::to_json(&read));
    }
    let mut table = to_table(&read, &model, &effects, &modes);
    if let Some(trimmed) = level1.as_ref().filter(|trimmed| trimmed.aircraft.options.active().contains(&true)) {
        let whole = trimmed.whole_eigenvalues().ok_or_else(|| {
            Failure::Running(format!("{}: the modes of the whole system cannot be computed", args.condition.model.display()))
        })?;
        add_whole(&mut result, &mut table, &whole);
    }
    match &args.json {
        None => print(&table)?,
        Some(path) => {
            message_text(table.trim_end());
            let mut text = serde_json::to_string_pretty(&result).map_err(|error| Failure::Running(error.to_string()))?;
            text.push('\n');
            Provenance::of([args.condition.model.clone()]).write_json(path, DocumentSchema::Linearise, &text)?;
        }
    }
    Ok(Outcome::Done)
}

fn to_json(file: &ModelFile, model: &LinearModel, effects: &[Effect], modes: &Eigenmodes) -> Value {
    let trim = &model.trim;
    let controls: Map<String, Value> = Control::ALL
        .into_iter()
        .zip(trim.controls)
        .map(|(control, value)| (control.name(file.controls).to_owned(), json!(value)))
        .collect();
    let mut trim_json =
        json!({"u": trim.u, "v": trim.v, "w": trim.w, "phi": trim.phi, "theta": trim.theta, "controls": controls});
    if let (Some(rotor_speed), Some(entries)) = (trim.rotor_speed, trim_json.as_object_mut()) {
        entries.insert("rotor_speed".to_owned(), json!(rotor_speed));
    }
    let a = state_matrix(model);
    let b = input_matrix(model, effects);
    let derivatives: Map<String, Value> =
        Axis::ALL.into_iter().map(|axis| (axis.name().to_owned(), axis_json(file, model, axis))).collect();
    json!({
        "trim": trim_json,
        "states": STATES,
        "inputs": INPUTS.map(|input| input.name(file.controls)),
        "A": a.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>(),
        "B": b.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>(),
        "derivatives": derivatives,
        "modes": modes_json(modes),
        "lateral_subsystem": subsystem(model).map(|lateral| subsystem_json(&lateral)),
    })
}

/// Modes of the whole system: those above belong to the eight states, with rotor, engine and actuators at once.
fn add_whole(result: &mut Value, table: &mut String, whole: &[Complex<f64>]) {
    let upper: Vec<&Complex<f64>> = whole.iter().filter(|mode| mode.im >= 0.0).collect();
    if let Some(modes) = result.get_mut("modes").and_then(Value::as_object_mut) {
        let all = upper.iter().map(|mode| json!({"real": mode.re, "imag": mode.im})).collect::<Vec<Value>>();
        modes.insert("whole".to_owned(), json!(all));
    }
    let _ = writeln!(table, "\nmodes with the states of rotor, engine and actuators (1/s; effects left out)");
    for mode in upper {
        write_mode(table, "mode", mode);
    }
}

fn write_mode(text: &mut String, name: &str, mode: &Complex<f64>) {
    let _ = match mode.im > 0.0 {
        true => writeln!(text, "{name:<12}  {:>9} +- {}i", Fixed(mode.re, 4), Fixed(mode.im, 4)),
        false => writeln!(text, "{name:<12}  {:>9}", Fixed(mode.re, 4)),
    };
}

fn axis_json(file: &ModelFile, model: &LinearModel, axis: Axis) -> Value {
    let mut entries: Map<String, Value> = Variable::ALL
        .into_iter()
        .map(|variable| (variable.name(file.controls).to_owned(), json!(model.derivative(axis, variable))))
        .collect();
    if let Some(&value) = model.rotor_speed.get(axis.index()).filter(|&&value| value != 0.0) {
        entries.insert("rotor_speed".to_owned(), json!(value));
    }
    for term in model.terms.iter().filter(|term| term.axis == axis) {
        entries.insert(term.term.to_string(), json!(term.coefficient));
    }
    Value::Object(entries)
}

fn modes_json(modes: &Eigenmodes) -> Value {
    let real = |mode: Option<f64>| mode.map(|real| json!({"real": real, "imag": 0.0}));
    json!({
        "dutch_roll": modes.dutch_roll.map(|mode| {
            let omega = libm::hypot(mode.re, mode.im);
            json!({"real": mode.re, "imag": mode.im, "omega": omega, "zeta": -mode.re / omega})
        }),
        "roll": real(modes.roll),
        "spiral": real(modes.spiral),
        "others": modes.others.iter().map(|mode| json!({"real": mode.re, "imag": mode.im, "name": modes.name_of(mode)})).collect::<Vec<Value>>(),
    })
}

/// Modes of v p phi r alone, as the estimator gives them.
fn subsystem(model: &LinearModel) -> Option<ModesRecord> {
    lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(model))
}

fn subsystem_json(modes: &ModesRecord) -> Value {
    let pair = |mode: Option<OscillatoryMode>| {
        mode.map(|mode| json!({"real": mode.real, "imag": mode.imag, "omega": mode.omega, "zeta": mode.zeta}))
    };
    let real = |mode: Option<RealRoot>| mode.map(|root| json!({"real": root.value, "imag": 0.0}));
    json!({
        "dutch_roll": pair(modes.dutch_roll),
        "lateral_phugoid": pair(modes.lateral_phugoid),
        "roll": real(modes.roll),
        "spiral": real(modes.spiral),
    })
}

fn to_table(read: &FlightModel, model: &LinearModel, effects: &[Effect], modes: &Eigenmodes) -> String {
    let (file, trim) = (&read.file, &model.trim);
    let mut text = String::new();
    let _ = writeln!(text, "{}", if file.name.is_empty() { "(model without a name)".into() } else { printable(&file.name) });
    if let Some(flight) = flight_condition::in_words(read) {
        let _ = writeln!(text, "{flight}");
    }
    if let Some(trimmed) = read.level1.as_ref() {
        let _ = writeln!(text, "{}", differences(&trimmed.aircraft));
    }
    let _ = writeln!(
        text,
        "trim: V {} m/s (u {}, v {}, w {}), phi {} rad, theta {} rad, flight path {} rad",
        Fixed(trim.airspeed(), 3),
        Fixed(trim.u, 3),
        Fixed(trim.v, 3),
        Fixed(trim.w, 3),
        Fixed(trim.phi, 4),
        Fixed(trim.theta, 4),
        Fixed(trim.flight_path_angle(), 4)
    );
    for (control, value) in Control::ALL.into_iter().zip(trim.controls) {
        let _ = writeln!(text, "      {} {value} rad", control.name(file.controls), value = Fixed(value, 4));
    }
    let inputs = INPUTS.map(|input| input.name(file.controls));
    let a = state_matrix(model);
    let b = input_matrix(model, effects);
    let _ = writeln!(text, "\nA (per s, SI and rad)");
    write_matrix(&mut text, &STATES, a.row_iter().map(|row| row.iter().copied().collect()));
    let _ = writeln!(text, "\nB");
    write_matrix(&mut text, &inputs, b.row_iter().map(|row| row.iter().copied().collect()));
    let _ = writeln!(text, "\nmodes of the whole aircraft (1/s)");
    match modes.dutch_roll {
        Some(mode) => {
            let omega = libm::hypot(mode.re, mode.im);
            let zeta = -mode.re / omega;
            let _ = writeln!(
                text,
                "Dutch roll  {:>9} +- {}i   omega {omega} rad/s, zeta {zeta}",
                Fixed(mode.re, 4),
                Fixed(mode.im, 4),
                omega = Fixed(omega, 4),
                zeta = Fixed(zeta, 4)
            );
        }
        None => text.push_str("Dutch roll  none\n"),
    }
    for (name, mode) in [("roll", modes.roll), ("spiral", modes.spiral)] {
        let _ = match mode {
            Some(real) => writeln!(text, "{name:<12}  {real:>9}", real = Fixed(real, 4)),
            None => writeln!(text, "{name:<12}  none"),
        };
    }
    for mode in &modes.others {
        write_mode(&mut text, modes.name_of(mode), mode);
    }
    text.push_str("\nmodes of the lateral subsystem v p phi r alone (1/s), as estimates from flight name them too\n");
    match subsystem(model) {
        None => text.push_str("none\n"),
        Some(modes) => {
            for (name, mode) in [("Dutch roll", modes.dutch_roll), ("phugoid", modes.lateral_phugoid)] {
                if let Some(OscillatoryMode { real, imag, omega, zeta, .. }) = mode {
                    let _ = writeln!(
                        text,
                        "{name:<12}  {real:>9} +- {imag}i   omega {omega} rad/s, zeta {zeta}",
                        real = Fixed(real, 4),
                        imag = Fixed(imag, 4),
                        omega = Fixed(omega, 4),
                        zeta = Fixed(zeta, 4)
                    );
                }
            }
            for (name, mode) in [("roll", modes.roll), ("spiral", modes.spiral)] {
                if let Some(root) = mode {
                    let _ = writeln!(text, "{name:<12}  {:>9}", Fixed(root.value, 4));
                }
            }
        }
    }
    text
}

/// How wide the differences of the linearisation are.
fn differences(aircraft: &Level1) -> String {
    let Perturbation { velocity, rate, control } = aircraft.perturbation;
    match aircraft.options.finite_perturbation {
        true => format!(
            "differences: finite, +- {velocity} m/s, {rate} rad/s, {control} rad (perturbation=small for the slope itself)"
        ),
        false => "differences: small (the slope itself)".to_owned(),
    }
}

fn write_matrix(text: &mut String, columns: &[&str], rows: impl Iterator<Item = Vec<f64>>) {
    let _ = writeln!(text, "{:6}{}", "", columns.iter().map(|name| format!("{name:>11}")).collect::<String>());
    for (state, row) in STATES.iter().zip(rows) {
        let _ = writeln!(
            text,
            "{state:<6}{}",
            row.iter().map(|value| format!("{value:>11}", value = Fixed(*value, 4))).collect::<String>()
        );
    }
}
