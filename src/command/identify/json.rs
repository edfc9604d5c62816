//! The answer as a JSON document: what each run says by itself, and what output error says of all.

use super::unit::{unit_of_derivative, unit_of_equation};
use serde_json::{Map, Value, json};
use sideslip::flight::run::ReferenceDimensions;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::nondimensional::NondimensionalDerivatives;
use sideslip::postflight::identification::roots::IdentifiedRoot;
use sideslip::postflight::identification::run_prediction::RunPrediction;
use sideslip::postflight::validation::prediction::PredictionScore;

/// `runs` as `replay` writes them, `output_error` and `modes` over all runs.
pub(super) fn document(
    identified: &IdentificationResult,
    formed: Option<&NondimensionalDerivatives>,
    by_run: &str,
) -> Result<Value, serde_json::Error> {
    let mut document: Value = serde_json::from_str(by_run)?;
    document["output_error"] = output_error(identified);
    document["modes"] = modes(identified);
    document["holdout"] = identified.holdout.iter().map(|flown| prediction(identified, flown)).collect();
    document["notes"] = json!(identified.linear.notes);
    if !identified.linear.assumed_scale.is_empty() {
        document["assumed_scale"] = json!(identified.linear.assumed_scale);
    }
    document["nondimensional"] = nondimensional(formed);
    Ok(document)
}

/// Null where no run states reference dimensions.
pub(super) fn nondimensional(formed: Option<&NondimensionalDerivatives>) -> Value {
    let Some(NondimensionalDerivatives { reference, derivatives, missing, .. }) = formed else { return Value::Null };
    let reference = match reference {
        ReferenceDimensions::Wing { area_m2, span_m, chord_m } => {
            json!({ "area_m2": area_m2, "span_m": span_m, "chord_m": chord_m })
        }
        ReferenceDimensions::Rotor { radius_m, tip_speed_mps } => {
            json!({ "rotor_radius_m": radius_m, "tip_speed_mps": tip_speed_mps })
        }
    };
    let derivatives = derivatives.iter().map(|one| json!({ "name": one.name, "value": one.value, "std": one.std }));
    json!({ "reference": reference, "derivatives": derivatives.collect::<Vec<_>>(), "missing": missing })
}

pub(super) fn output_error(identified: &IdentificationResult) -> Value {
    let (fitted, structure) = (&identified.fitted, &identified.linear.structure);
    let choice = &identified.linear.choice;
    let names = identified
        .linear
        .derivatives
        .iter()
        .map(|(axis, variable)| (format!("{axis}_{variable}"), unit_of_derivative(choice, *axis, variable)));
    let numbers = fitted.theta.iter().zip(&fitted.std).zip(&fitted.std_cramer_rao).zip(&identified.starts);
    let mut parameters: Vec<Value> = names
        .zip(numbers)
        .map(|((name, unit), (((value, std), bound), start))| {
            json!({ "name": name, "unit": unit, "value": value, "std": std, "std_cramer_rao": bound, "start": start, "runs": "all" })
        })
        .collect();
    let name = |place: usize| identified.linear.name(place);
    let doubts = identified.linear.instrument_parameters.iter().enumerate().map(|(place, doubt)| {
        let at = |values: &[f64]| values.get(identified.linear.derivatives.len() + place).copied();
        json!({ "name": doubt.name, "unit": if doubt.unit.is_empty() { "1" } else { doubt.unit }, "value": at(&fitted.theta), "std": at(&fitted.std), "prior": doubt.prior_mean, "prior_std": doubt.prior_std, "runs": "all" })
    });
    parameters.extend(doubts);
    let pairs = fitted.correlated.iter();
    let correlated: Vec<Value> =
        pairs.map(|&(one, other, rho)| json!({ "pair": [name(one), name(other)], "rho": rho })).collect();
    for (run, flown) in fitted.runs.iter().zip(&identified.fit) {
        let constants = structure.states.iter().zip(run.run_parameters.state_bias.iter().zip(&run.run_parameters_std.state_bias));
        for (state, (value, std)) in constants {
            let axis =
                sideslip::postflight::identification::model_variables::axis(state).map_or_else(|| state.clone(), String::from);
            let (name, unit) = (format!("{axis}_0"), unit_of_equation(state));
            parameters.push(json!({ "name": name, "unit": unit, "value": value, "std": std, "runs": flown.run }));
        }
    }
    let disturbed = identified.disturbed.as_ref().map(|found| {
        let gust = |gust: &sideslip::postflight::output_error::filter_error::Gust| {
            json!({ "state": structure.states.get(gust.state), "density": gust.density, "std_log_density": gust.std_log })
        };
        let parts = structure.outputs.iter().zip(&found.disturbed).map(|(name, part)| (name.clone(), json!(part)));
        json!({
            "gusts": found.gusts.iter().map(gust).collect::<Vec<_>>(),
            "part_of_innovations": parts.collect::<Map<String, Value>>(),
        })
    });
    json!({
        "method": super::table::method(identified).replace(' ', "_"),
        "disturbances": disturbed,
        "states": structure.states,
        "inputs": identified.linear.choice.inputs,
        "outputs": structure.outputs,
        "parameters": parameters,
        "correlated": correlated,
        "converged": fitted.converged,
        "iterations": fitted.iterations,
        "cost": fitted.cost,
        "fit": identified.fit.iter().map(|flown| prediction(identified, flown)).collect::<Vec<_>>(),
    })
}

pub(super) fn prediction(identified: &IdentificationResult, flown: &RunPrediction) -> Value {
    let outputs = identified.linear.structure.outputs.iter().zip(&flown.scores);
    let channels: Map<String, Value> =
        outputs.map(|(name, score)| (name.clone(), score.as_ref().map_or(Value::Null, score_json))).collect();
    json!({ "run": flown.run, "channels": channels })
}

fn score_json(score: &PredictionScore) -> Value {
    let line = |line: &sideslip::postflight::validation::prediction::ResidualLine| json!({ "omega": line.omega, "amplitude": line.amplitude, "at_twice_the_response": line.at_twice_the_response });
    json!({
        "rms": score.rms,
        "vaf": score.vaf,
        "theil": score.theil,
        "white_probability": score.white_probability,
        "lag_one_correlation": score.neighbours,
        "lines": score.lines.iter().map(line).collect::<Vec<_>>(),
        "samples": score.samples,
    })
}

pub(super) fn modes(identified: &IdentificationResult) -> Value {
    let roots = match &identified.modes {
        Ok(roots) => roots,
        Err(reason) => return json!({ "reason": reason }),
    };
    let mut modes = Map::new();
    let mut others = Vec::new();
    for root in roots {
        match root.name {
            Some(name) => {
                modes.insert(name.to_owned(), root_json(root));
            }
            None => others.push(root_json(root)),
        }
    }
    if !others.is_empty() {
        modes.insert("others".to_owned(), Value::Array(others));
    }
    Value::Object(modes)
}

fn root_json(root: &IdentifiedRoot) -> Value {
    if root.imag > 0.0 {
        json!({
            "real": root.real, "imag": root.imag, "omega": root.omega, "zeta": root.zeta,
            "std_real": root.std_real, "std_imag": root.std_imag, "std_omega": root.std_omega, "std_zeta": root.std_zeta,
            "probability_unstable": root.probability_unstable,
        })
    } else {
        json!({ "value": root.real, "std": root.std_real, "probability_unstable": root.probability_unstable })
    }
}
