//! The answer for a person.

use super::unit::unit_of_derivative;
use sideslip::io::outputs::number::{Digits, Fixed, Power, measured};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::control_scale::PER_COMMAND;
use sideslip::io::outputs::words::printable::printable;
use sideslip::postflight::identification::identification_model::InstrumentParameter;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::roots::IdentifiedRoot;
use sideslip::postflight::identification::run_prediction::RunPrediction;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Correlation above which two derivatives are not separable: what their model leaves out moves both far.
const INSEPARABLE: f64 = 0.97;

/// A doubt whose standard error is below this part of what it was beforehand was learned of.
const TOLD: f64 = 0.8;

/// Derivatives, modes, fit and prediction.
pub(super) fn text(identified: &IdentificationResult, style: Style) -> String {
    let (linear, fitted) = (&identified.linear, &identified.fitted);
    let structure = &linear.structure;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: states {}, inputs {}, outputs {}; {} runs, {} iterations{}",
        method(identified),
        structure.states.join(" "),
        linear.choice.inputs.join(" "),
        structure.outputs.join(" "),
        identified.fit.len(),
        fitted.iterations,
        if fitted.converged { "" } else { ", NOT converged: these are no estimates" }
    );
    let _ = writeln!(text, "  {:<14} {:>12} {:>10}   {:>10}  {:>10}  unit", "derivative", "value", "s.e.", "Cramer-Rao", "start");
    for (place, (axis, variable)) in linear.derivatives.iter().enumerate() {
        let at = |values: &[f64]| values.get(place).copied().unwrap_or(f64::NAN);
        let (value, std) = measured(at(&fitted.theta), at(&fitted.std));
        let name = style.bold(format_args!("{:<14}", format!("{axis}_{variable}")));
        let bound = at(&fitted.std_cramer_rao);
        let start = at(&identified.starts);
        let told = if fitted.insignificant.contains(&place) { ", not significantly different from zero" } else { "" };
        let of_command = if linear.assumed_scale.contains(variable) { format!(", {PER_COMMAND}") } else { String::new() };
        let unit = unit_of_derivative(&linear.choice, *axis, variable);
        let _ = writeln!(
            text,
            "  {name} {value:>12} {std:>10}   {bound:>10}  {start:>10}  {unit}{told}{of_command}",
            bound = Power(bound, 2),
            start = Fixed(start, 4)
        );
    }
    for said in correlations(identified) {
        let _ = writeln!(text, "  {said}");
    }
    for (place, doubt) in linear.instrument_parameters.iter().enumerate() {
        let at = |values: &[f64]| values.get(linear.derivatives.len() + place).copied().unwrap_or(f64::NAN);
        let (value, std) = measured(at(&fitted.theta), at(&fitted.std));
        let InstrumentParameter { name, prior_mean, prior_std, unit } = doubt;
        if !is_learned(doubt, at(&fitted.std)) {
            continue;
        }
        let _ = writeln!(text, "  {name:<14} {value:>12} {std:>10}   (prior {prior_mean} +- {prior_std}) {unit}");
    }
    disturbed(&mut text, identified);
    match &identified.modes {
        Err(reason) => {
            let _ = writeln!(text, "modes: none, for {reason}");
        }
        Ok(roots) => {
            for root in roots {
                let name = root.name.unwrap_or("root").replace('_', " ");
                if root.imag > 0.0 {
                    let (omega, std_omega) = measured(root.omega, root.std_omega);
                    let (zeta, std_zeta) = measured(root.zeta, root.std_zeta);
                    let _ = writeln!(
                        text,
                        "{name}: omega {omega} +- {std_omega} rad/s ({} Hz), zeta {zeta} +- {std_zeta}; {}",
                        Digits(root.omega / TAU, 3),
                        stability(root)
                    );
                } else {
                    let (value, std) = measured(root.real, root.std_real);
                    let _ = writeln!(text, "{name}: {value} +- {std} 1/s");
                }
            }
        }
    }
    for flown in &identified.fit {
        scores(&mut text, "fitted", flown, identified);
    }
    for flown in &identified.holdout {
        scores(&mut text, "predicted, not fitted", flown, identified);
    }
    for note in &linear.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}

/// Estimates that these runs do not separate, or hardly, a sentence each.
pub(super) fn correlations(identified: &IdentificationResult) -> Vec<String> {
    let name = |place: usize| identified.linear.name(place);
    let correlated = identified.fitted.correlated.iter();
    let (inseparable, hard): (Vec<_>, Vec<_>) = correlated.partition(|(.., rho)| rho.abs() > INSEPARABLE);
    let mut said = Vec::new();
    if !inseparable.is_empty() {
        let mut names: Vec<String> = inseparable.into_iter().flat_map(|&(one, other, _)| [name(one), name(other)]).collect();
        names.sort();
        names.dedup();
        said.push(format!(
            "NOT distinguished in these runs: {}; each may be wrong by more than its standard error, their sum in this motion is not",
            names.join(", ")
        ));
    }
    if !hard.is_empty() {
        let pair = |&(one, other, rho): &(usize, usize, f64)| format!("{} {} ({})", name(one), name(other), Fixed(rho, 2));
        said.push(format!("strongly correlated estimates: {}", hard.into_iter().map(pair).collect::<Vec<_>>().join(", ")));
    }
    said
}

/// Whether a parameter of an instrument is shown: of lag or delay, seen at steps only, most runs tell nothing of most outputs.
pub(super) fn is_learned(parameter: &InstrumentParameter, std: f64) -> bool {
    !parameter.name.starts_with("lag_part") || std < TOLD * parameter.prior_std
}

pub(super) fn method(identified: &IdentificationResult) -> &'static str {
    if identified.disturbed.is_some() { "filter error" } else { "output error" }
}

/// Gusts, and how much of what an output does not do as foretold is theirs and the inputs' noise.
fn disturbed(text: &mut String, identified: &IdentificationResult) {
    let Some(found) = &identified.disturbed else { return };
    let structure = &identified.linear.structure;
    let gusts: Vec<String> = found
        .gusts
        .iter()
        .filter(|gust| gust.density > 0.0)
        .map(|gust| {
            let name = structure.states.get(gust.state).map_or("", String::as_str);
            format!("{name} {} (+- {} %)", Power(libm::sqrt(gust.density), 2), Fixed(50.0 * gust.std_log, 0))
        })
        .collect();
    let none = gusts.is_empty().then(|| "none told".to_owned());
    let _ = writeln!(text, "  gusts, rms a root of a second: {}", gusts.into_iter().chain(none).collect::<Vec<_>>().join(", "));
    let parts = structure.outputs.iter().zip(&found.disturbed).map(|(name, part)| format!("{name} {} %", Fixed(100.0 * part, 1)));
    let _ = writeln!(text, "  process noise in the innovations' variance: {}", parts.collect::<Vec<_>>().join(", "));
}

/// Whether a mode grows, with its probability.
pub(super) fn stability(root: &IdentifiedRoot) -> String {
    let word = if root.real > 0.0 { "UNSTABLE" } else { "stable" };
    let shown = match root.probability_unstable {
        small if small < 0.001 => "below 0.001".to_owned(),
        large if large > 0.999 => "above 0.999".to_owned(),
        middle => Fixed(middle, 3).to_string(),
    };
    format!("{word}, probability of instability {shown}")
}

fn scores(text: &mut String, how: &str, flown: &RunPrediction, identified: &IdentificationResult) {
    let _ = write!(text, "{} ({how}):", printable(&flown.run));
    for (name, score) in identified.linear.structure.outputs.iter().zip(&flown.scores) {
        match score {
            Some(score) => {
                let _ = write!(text, " {name} VAF {} TIC {}", Fixed(score.vaf, 3), Fixed(score.theil, 3));
                if let Some(line) = score.lines.iter().find(|line| line.at_twice_the_response) {
                    let _ = write!(text, " (line at {} rad/s, twice the response: nonlinear?)", Fixed(line.omega, 2));
                }
            }
            None => {
                let _ = write!(text, " {name} -");
            }
        }
        text.push(';');
    }
    text.pop();
    text.push('\n');
}
