//! Several test points: the model trimmed where each was flown, a diagnosis of each, and what varies with the flight path.

use super::json::document;
use crate::command::diagnose::answer::{Answer, Flights};
use crate::command::diagnose::args::DiagnoseArgs;
use crate::command::diagnose::page;
use crate::command::diagnose::table;
use crate::command::recordings::provenance::Provenance;
use crate::command::recordings::run_condition::condition_of;
use crate::command::terminal::console::print;
use crate::command::{message, message_text};
use serde_json::{Value, json};
use sideslip::dynamics::linear::with_effects;
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::effect::Effect;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::flight::model::LinearModel;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::number::Fixed;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::diagnosis::evidence::flight_path::{ConditionDiagnosis, DerivativeTrend, varying};
use sideslip::postflight::identification::test_condition::TestCondition;
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::realtime::modes::lateral;
use sideslip::realtime::regression::record::{LateralDerivatives, Status};
use std::fmt::Write;
use std::path::{Path, PathBuf};

struct DiagnosedPoint {
    condition: TestCondition,
    runs: Vec<String>,
    answer: Answer,
}

/// Diagnoses each test point and tells all; what was lost.
pub(super) fn run(
    args: &DiagnoseArgs,
    set: &[String],
    (fit, holdout): (&[RecordedRun], &[RecordedRun]),
    groups: &[Vec<usize>],
    (controls, provenance): (ControlNames, &Provenance),
) -> Result<Vec<String>, Failure> {
    let (mut points, mut losses) = (Vec::new(), Vec::new());
    for number in 0..groups.len() {
        for (option, file) in [("--extended", &args.extended), ("--html", &args.html)] {
            file.as_ref().map_or(Ok(()), |file| args.replace.refuse(option, &numbered(file, number)))?;
        }
    }
    let mut held_out = vec![false; holdout.len()];
    for (number, group) in groups.iter().enumerate() {
        let own: Vec<RecordedRun> = group.iter().filter_map(|&place| fit.get(place)).cloned().collect();
        let condition = TestCondition::mean(&own.iter().map(condition_of).collect::<Vec<_>>());
        let model = args.condition.fly_at(set.to_vec(), condition.speed, condition.climb())?;
        let near = |run: &RecordedRun| condition_of(run).is_near(&condition);
        let held: Vec<RecordedRun> = holdout.iter().filter(|run| near(run)).cloned().collect();
        held_out.iter_mut().zip(holdout).for_each(|(used, run)| *used |= near(run));
        message(format_args!("test point {} of {}: {}", number + 1, groups.len(), in_words(&condition, own.len())));
        let mut answer = Answer::of(args, model, (&own, &held), controls, &mut losses)?;
        answer.extended = answer.extended.map(|path| numbered(&path, number));
        answer.write_extended()?;
        if let Some(path) = &args.html {
            page::write(&numbered(path, number), &answer, &Flights { fit: &own, holdout: &held, provenance })?;
        }
        points.push(DiagnosedPoint { condition, runs: own.into_iter().map(|run| run.name).collect(), answer });
    }
    let unused = held_out.iter().zip(holdout).filter(|(used, _)| !**used);
    losses.extend(unused.map(|(_, run)| format!("{}: hold-out of no test point: none was flown near it", run.name)));
    let at: Vec<ConditionDiagnosis<'_>> = points
        .iter()
        .map(|point| ConditionDiagnosis {
            path_rad: point.condition.path,
            model: point.answer.model.linear(),
            tolerance: point.answer.model.file.tolerance,
            diagnosis: &point.answer.diagnosis,
        })
        .collect();
    tell(args, &points, &varying(&at), (controls, provenance))?;
    Ok(losses)
}

/// `better.toml` of the second test point is `better-2.toml`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}-{}{ending}", number + 1))
}

pub(super) fn in_words(condition: &TestCondition, runs: usize) -> String {
    let path_deg = condition.path.to_degrees();
    format!(
        "{runs} run(s) at {} m/s, flight path {path_deg:+} deg ({:+} m/s)",
        Fixed(condition.speed, 1),
        Fixed(condition.climb(), 1),
        path_deg = Fixed(path_deg, 1)
    )
}

fn tell(
    args: &DiagnoseArgs,
    points: &[DiagnosedPoint],
    varying: &[DerivativeTrend],
    (controls, provenance): (ControlNames, &Provenance),
) -> Result<(), Failure> {
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let mut text = String::new();
    for (number, point) in points.iter().enumerate() {
        let heading = format!("Test point {}: {}", number + 1, in_words(&point.condition, point.runs.len()));
        let _ = writeln!(text, "{}\n{}", style.bold(heading), table::text(&point.answer, style));
    }
    text.push_str(&closing(points, varying, controls, style));
    let Some(path) = &args.json else { return print(&text) };
    message_text(text.trim_end());
    let of_points: Vec<Value> = points
        .iter()
        .map(|point| {
            let mut one = document(&point.answer);
            one["runs"] = json!(point.runs);
            one["speed_mps"] = json!(point.condition.speed);
            one["path_rad"] = json!(point.condition.path);
            one["lateral"] = lateral_derivatives(point, controls);
            one["lateral_roots"] =
                json!({ "model": lateral_root(point, &[]), "extended": lateral_root(point, &point.answer.extension) });
            one
        })
        .collect();
    let of_path: Vec<Value> = varying.iter().map(|one| of_path(one, controls)).collect();
    let document = json!({ "verdict": verdict(points, varying, controls), "test_points": of_points, "flight_path": of_path });
    provenance.write_json(path, DocumentSchema::Diagnose, &format!("{document:#}\n"))
}

/// The model with these effects besides its own.
fn with(point: &DiagnosedPoint, extension: &[DeclaredEffect]) -> Option<LinearModel> {
    let model = &point.answer.model;
    let effects: Vec<Effect> = model.file.effects.iter().chain(extension).map(|declared| declared.effect).collect();
    with_effects(model.linear(), &effects).ok()
}

/// Dutch roll of the lateral subsystem v p phi r with these effects.
fn lateral_root(point: &DiagnosedPoint, extension: &[DeclaredEffect]) -> Value {
    let root = with(point, extension)
        .and_then(|linear| lateral::modes(0.0, Status::Converged, &LateralDerivatives::of(&linear))?.dutch_roll);
    root.map_or(Value::Null, |root| json!({ "real": root.real, "imag": root.imag }))
}

/// Derivatives of the lateral subsystem: the model's, the extended model's, and the standard error of what was added.
fn lateral_derivatives(point: &DiagnosedPoint, controls: ControlNames) -> Value {
    let extension = &point.answer.extension;
    let extended = with(point, extension);
    let mut all = json!({});
    for (axis, variable) in LateralDerivatives::NAMES {
        let own = |one: &&DeclaredEffect| match one.effect {
            Effect::Derivative { axis: of, variable: by, .. } => of == axis && by == variable,
            _ => false,
        };
        let std = extension.iter().find(own).and_then(|one| one.std).filter(|std| std.is_finite());
        all[format!("{}_{}", axis.name(), variable.name(controls))] = json!({
            "model": point.answer.model.linear().derivative(axis, variable),
            "extended": extended.as_ref().map(|model| model.derivative(axis, variable)),
            "std": std,
        });
    }
    all
}

/// Derivatives against the flight path, one a line: the model's and the flight's at each test point.
fn closing(points: &[DiagnosedPoint], varying: &[DerivativeTrend], controls: ControlNames, style: Style) -> String {
    let mut text = String::new();
    if varying.is_empty() {
        return text;
    }
    let _ =
        writeln!(text, "{}", style.bold("Derivatives against the flight path, model -> flight +- s.e. (blank: as the model)"));
    let path = |point: &DiagnosedPoint| format!("{:>30}", format!("{:+} deg", Fixed(point.condition.path.to_degrees(), 1)));
    let heads: String = points.iter().map(path).collect();
    let _ = writeln!(text, "  {:<12}{heads}   slope per radian, less the model's", "");
    for one in varying {
        let cell = |held: &sideslip::postflight::diagnosis::evidence::flight_path::ConditionDerivative| {
            let flight = if held.off {
                format!("{} -> {} +- {}", Fixed(held.model, 4), Fixed(held.flight, 4), Fixed(held.std, 4))
            } else {
                String::new()
            };
            format!("{flight:>30}")
        };
        let cells: String = one.at.iter().map(cell).collect();
        let (slope, std) = one.slope;
        let name = format!("{}_{}", one.axis.name(), one.variable.name(controls));
        let mark = if one.varies() { " *" } else { "" };
        let _ = writeln!(text, "  {name:<12}{cells}   {slope:+} +- {std}{mark}", slope = Fixed(slope, 3), std = Fixed(std, 3));
    }
    let _ = writeln!(text, "  * varies with the flight path by more than the model says, beyond three standard errors");
    text
}

fn of_path(one: &DerivativeTrend, controls: ControlNames) -> Value {
    let at: Vec<Value> = one
        .at
        .iter()
        .map(|held| json!({ "model": held.model, "flight": held.flight, "std": held.std, "off": held.off }))
        .collect();
    let (slope, std) = one.slope;
    json!({ "kind": "flight_path", "axis": one.axis.name(), "variable": one.variable.name(controls), "slope": slope, "std": std,
        "varies": one.varies(), "at": at })
}

/// The derivative that varies most surely; where none does, what is wrong at the first test point.
fn verdict(points: &[DiagnosedPoint], varying: &[DerivativeTrend], controls: ControlNames) -> Value {
    let sure = |one: &DerivativeTrend| (one.slope.0 / one.slope.1).abs();
    match varying.iter().filter(|one| one.varies()).max_by(|a, b| sure(a).total_cmp(&sure(b))) {
        Some(one) => {
            let mut verdict = of_path(one, controls);
            let (name, (slope, std)) = (format!("{}_{}", one.axis.name(), one.variable.name(controls)), one.slope);
            verdict["statement"] = json!(format!(
                "{name} changes with the flight path by {slope} +- {std} per radian more than in the model",
                slope = Fixed(slope, 3),
                std = Fixed(std, 3)
            ));
            verdict
        }
        None => points.first().map_or(Value::Null, |point| document(&point.answer)["verdict"].clone()),
    }
}
