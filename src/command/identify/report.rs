//! `report.html` and `model.toml`: the pictures and the model of an identification.

use super::frequency_domain::FrequencyDomainResult;
use crate::command::identify::table;
use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::{LinearModel, Trim};
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Panel, svg};
use sideslip::io::outputs::html::page::{FOOT, escaped, head};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::run_prediction::RunPrediction;
use std::fmt::Write;

/// A page without scripts, fonts or network: the table, and every run beside its model.
pub(super) fn page(identified: &IdentificationResult, in_band: Option<&FrequencyDomainResult>) -> Result<String, ChartError> {
    let mut page = head("Identification");
    let _ = writeln!(page, "<h1>Identification</h1>\n<pre>{}</pre>", escaped(&table::text(identified, Style::Plain)));
    runs_section(&mut page, identified)?;
    in_band.map_or(Ok(()), |in_band| in_band.section(&mut page))?;
    page.push_str(FOOT);
    Ok(page)
}

/// Every run beside its model.
pub(super) fn runs_section(page: &mut String, identified: &IdentificationResult) -> Result<(), ChartError> {
    let kinds = [("fitted", &identified.fit), ("predicted, not fitted", &identified.holdout)];
    for (how, flown) in kinds.iter().flat_map(|(how, runs)| runs.iter().map(move |run| (how, run))) {
        let _ = writeln!(page, "<h2>{} ({how})</h2>\n{}", escaped(&flown.run), svg(&panels(identified, flown))?);
    }
    Ok(())
}

fn panels(identified: &IdentificationResult, flown: &RunPrediction) -> Vec<Panel> {
    let names = &identified.linear.structure.outputs;
    let series = names.iter().zip(flown.record.outputs.iter().zip(&flown.predicted));
    series
        .map(|(name, (measured, predicted))| {
            let curve = |what: &str, values: &[f64]| Curve {
                name: what.to_owned(),
                points: flown.record.times_s.iter().copied().zip(values.iter().copied()).filter(|(_, y)| y.is_finite()).collect(),
            };
            Panel {
                title: name.clone(),
                x: "time, s".to_owned(),
                y: format!("{name}, deviation from trim, {}", unit(name)),
                curves: vec![curve("measured", measured), curve("model", predicted)],
            }
        })
        .collect()
}

fn unit(name: &str) -> &'static str {
    match name {
        "ax" | "ay" | "az" => "m/s^2",
        "tas" => "m/s",
        "p" | "q" | "r" => "rad/s",
        _ => "rad",
    }
}

/// What the model of every test point's file is called: `model.toml` where there is one, else after the test point's first run.
pub(super) fn model_names(groups: &[Vec<usize>], runs: &[Columns]) -> Vec<String> {
    if groups.len() < 2 {
        return vec!["model.toml".to_owned()];
    }
    let mut names: Vec<String> = Vec::new();
    for (place, group) in groups.iter().enumerate() {
        let run = group.first().and_then(|&first| runs.get(first)).map(|run| run.run.as_str()).unwrap_or_default();
        let plain = |letter: char| if letter.is_alphanumeric() || matches!(letter, '_' | '-' | '.') { letter } else { '-' };
        let name: String = run.chars().map(plain).collect();
        let alone = format!("model-{name}.toml");
        names.push(if name.is_empty() || names.contains(&alone) { format!("model-{name}-{}.toml", place + 1) } else { alone });
    }
    names
}

/// The model as a file that `simulate` flies; `None` where a derivative's variable is none of a model file's, or the search has
/// not converged.
pub(super) fn model(identified: &IdentificationResult, runs: &[Columns]) -> Option<String> {
    if !identified.fitted.converged {
        return None;
    }
    let (linear, theta) = (&identified.linear, &identified.fitted.theta);
    let reference_trim = linear.reference_trim;
    let mean = |name: &str| {
        let known: Vec<f64> = runs.iter().filter_map(|run| run.trim(name).ok()).collect();
        if known.is_empty() { 0.0 } else { known.iter().sum::<f64>() / known.len() as f64 }
    };
    let controls = Variable::CONTROLS.map(|control| {
        let names = runs.first().map(|run| control.name(run.geometry.controls)).unwrap_or_default();
        mean(names)
    });
    let [u, v, w] = reference_trim.velocity();
    let trim = Trim { u, v, w, phi: reference_trim.phi, theta: reference_trim.theta, rotor_speed: None, controls };
    let mut model = LinearModel::about(trim);
    let mut stds = [[0.0; VARIABLES]; AXES];
    for (((axis, variable), value), std) in linear.derivatives.iter().zip(theta).zip(&identified.fitted.std) {
        // Flow angles are velocities over airspeed; their own rows are over airspeed, too.
        let row = if linear.choice.states.iter().any(|state| matches!((state.as_str(), axis), ("beta", 'Y') | ("alpha", 'Z'))) {
            reference_trim.airspeed
        } else {
            1.0
        };
        let (name, column) = match variable.as_str() {
            "beta" => ("v", 1.0 / reference_trim.airspeed),
            "alpha" => ("w", 1.0 / reference_trim.airspeed),
            own => (own, 1.0),
        };
        let axis = Axis::from_name(&axis.to_string())?;
        let variable = Variable::from_name(name)?;
        *model.derivative_mut(axis, variable) = value * row * column;
        stds[axis.index()][variable.index()] = (std * row * column).max(0.0);
    }
    let controls = runs.first().map(|run| run.geometry.controls).unwrap_or_default();
    Some(ModelFile { controls, stds, ..ModelFile::of("identified", model) }.to_toml())
}
