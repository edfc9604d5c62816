//! `model.toml`: the model of an identification.

use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::{LinearModel, Trim};
use sideslip::postflight::identification::columns::Columns;
use sideslip::postflight::identification::identify::IdentificationResult;

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
