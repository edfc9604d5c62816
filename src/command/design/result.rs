//! The result of a design: a table for people, JSON for programs, a chart.

use serde_json::{Value, json};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::model::LinearModel;
use sideslip::io::outputs::charts::chart::{Curve, Panel};
use sideslip::io::outputs::number::Digits;
use sideslip::io::outputs::words::status_text::{DerivativeLabel, derivative_unit};
use sideslip::simulation::input_design::dispersion::InformationError;
use sideslip::simulation::input_design::information::DesignParameter;
use sideslip::simulation::input_design::search::{DesignLimits, EvaluatedInput};
use sideslip::simulation::input_design::spectrum::Outline;
use std::fmt::Write as _;

/// States by the names under which they are limited, with their usual limits: what keeps a linear model true.
pub(super) const STATES: [(&str, f64); 8] =
    [("u", 5.0), ("w", 4.0), ("q", 0.3), ("theta", 0.2), ("v", 2.5), ("p", 0.5), ("phi", 0.35), ("r", 0.3)];

/// An input with its name, spectrum and worth.
pub(super) struct DesignCandidate {
    pub(super) name: &'static str,
    pub(super) judged: EvaluatedInput,
    pub(super) errors: Result<Vec<f64>, InformationError>,
    pub(super) energies: Vec<f64>,
    pub(super) outline: Option<Outline>,
}

/// A derivative's name.
pub(super) fn name_of(DesignParameter { axis, variable }: DesignParameter, controls: ControlNames) -> String {
    DerivativeLabel { axis, variable: Some(variable), controls }.to_string()
}

pub(super) fn to_table(
    candidates: &[DesignCandidate],
    names: &[String],
    parameters: &[DesignParameter],
    model: &LinearModel,
) -> String {
    let mut text = String::from("Inputs\n");
    for candidate in candidates {
        let _ = write!(text, "  {:<10} {}", candidate.name, candidate.judged.spec);
        if let Some(Outline { peak, half_power: [from, to], nodes }) = &candidate.outline {
            let _ = write!(
                text,
                "   most energy at {} rad/s, half that density {} to {}",
                Digits(*peak, 3),
                Digits(*from, 3),
                Digits(*to, 3)
            );
            if !nodes.is_empty() {
                let nodes: Vec<String> = nodes.iter().take(4).map(|node| Digits(*node, 3).to_string()).collect();
                let _ = write!(text, ", nodes at {}", nodes.join(", "));
            }
        }
        text.push('\n');
    }
    text.push_str("\nStandard errors at best\n");
    let _ = write!(text, "  {:<14} {:>10} {:<12}", "", "value", "unit");
    candidates.iter().for_each(|candidate| {
        let _ = write!(text, " {:>10}", candidate.name);
    });
    text.push('\n');
    for (place, (name, parameter)) in names.iter().zip(parameters).enumerate() {
        let value = model.derivative(parameter.axis, parameter.variable);
        let unit = derivative_unit(parameter.axis, Some(parameter.variable));
        let _ = write!(text, "  {name:<14} {:>10} {unit:<12}", Digits(value, 4).to_string());
        for candidate in candidates {
            let error = candidate.errors.as_ref().ok().and_then(|errors| errors.get(place));
            let _ = write!(text, " {:>10}", error.map_or("-".to_owned(), |error| Digits(*error, 2).to_string()));
        }
        text.push('\n');
    }
    let _ = write!(text, "  {:<14} {:>10} {:<12}", "criterion", "", "");
    for candidate in candidates {
        let _ = write!(text, " {:>10}", Digits(candidate.judged.cost, 3).to_string());
    }
    text.push('\n');
    for candidate in candidates {
        if let Err(InformationError(parameter)) = &candidate.errors {
            let name = name_of(*parameter, ControlNames::Rotorcraft);
            let _ = writeln!(text, "  {}: {name} is not identifiable beside the others", candidate.name);
        }
    }
    text
}

pub(super) fn to_json(
    candidates: &[DesignCandidate],
    names: &[String],
    parameters: &[DesignParameter],
    model: &LinearModel,
    omegas: &[f64],
) -> Value {
    let one = |candidate: &DesignCandidate| {
        let errors = |errors: &Vec<f64>| {
            let rows = names.iter().zip(parameters).zip(errors);
            rows.map(|((name, parameter), std)| {
                json!({"name": name, "value": model.derivative(parameter.axis, parameter.variable), "std": std})
            })
            .collect::<Vec<Value>>()
        };
        json!({
            "name": candidate.name,
            "input": candidate.judged.spec.to_string(),
            "criterion": candidate.judged.cost.is_finite().then_some(candidate.judged.cost),
            "parameters": candidate.errors.as_ref().ok().map(errors),
            "spectrum": candidate.energies,
            "nodes": candidate.outline.as_ref().map(|outline| outline.nodes.clone()),
            "excursion": STATES.iter().zip(candidate.judged.information.excursion)
                .map(|((state, _), most)| ((*state).to_owned(), json!(most))).collect::<serde_json::Map<_, _>>(),
        })
    };
    json!({"omega": omegas, "candidates": candidates.iter().map(one).collect::<Vec<Value>>()})
}

pub(super) fn panels(candidates: &[DesignCandidate], omegas: &[f64], limits: &DesignLimits) -> [Panel; 2] {
    let title = |candidate: &DesignCandidate| format!("{}: {}", candidate.name, candidate.judged.spec);
    let input = |candidate: &DesignCandidate| {
        let deviation = candidate.judged.spec.deviation(limits.lead_s);
        let mut points = vec![(0.0, 0.0)];
        points.extend(deviation.points().iter().copied());
        points.push((limits.duration_s, deviation.at(limits.duration_s)));
        Curve { name: title(candidate), points }
    };
    // A step's spectrum is that of its transient: it would hide the others. Last, so that the others keep their colours.
    let (returning, steps): (Vec<_>, Vec<_>) = candidates.iter().partition(|one| !one.judged.spec.pattern.is_empty());
    let spectrum = |candidate: &DesignCandidate| Curve {
        name: candidate.name.to_owned(),
        points: omegas.iter().copied().zip(candidate.energies.iter().copied()).collect(),
    };
    [
        Panel {
            title: "Inputs".into(),
            x: "time, s".into(),
            y: "deviation, rad".into(),
            curves: returning.iter().chain(&steps).copied().map(input).collect(),
        },
        Panel {
            title: "Energy spectra".into(),
            x: "frequency, rad/s".into(),
            y: "energy, (rad s)^2".into(),
            curves: returning.iter().copied().map(spectrum).collect(),
        },
    ]
}
