//! Tables of one model: modes, derivatives, instruments, gusts, nondimensional derivatives, figures of merit.

use crate::command::identify::table::{correlations, is_learned, stability};
use crate::command::identify::unit::{unit_of_derivative, variable_unit};
use sideslip::flight::run::ReferenceDimensions;
use sideslip::io::outputs::html::page::words;
use sideslip::io::outputs::html::table::{ColumnKind, HtmlTable};
use sideslip::io::outputs::number::{Digits, Fixed, Power, measured};
use sideslip::io::outputs::words::control_scale::PER_COMMAND;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::nondimensional::NondimensionalDerivatives;
use sideslip::postflight::identification::roots::IdentifiedRoot;
use std::f64::consts::{LN_2, TAU};
use std::fmt::Write;

const NUMBER: ColumnKind = ColumnKind::Number;
const WORDS: ColumnKind = ColumnKind::Words;

/// `dutch_roll` as `Dutch roll`.
pub(super) fn mode_name(root: &IdentifiedRoot) -> String {
    let name = root.name.unwrap_or("root without a name").replace('_', " ");
    name.replacen("dutch", "Dutch", 1)
}

fn plus_minus(value: f64, std: f64) -> String {
    let (value, std) = measured(value, std);
    format!("{value} +- {std}")
}

/// What each root is: frequency, damping, how long it lasts.
pub(super) fn modes(identified: &IdentificationResult) -> HtmlTable {
    let mut table = HtmlTable::new(
        "Modes",
        &[
            ("mode", WORDS),
            ("omega, rad/s", NUMBER),
            ("frequency, Hz", NUMBER),
            ("damping ratio", NUMBER),
            ("period, s", NUMBER),
            ("time, s", NUMBER),
            ("stability", WORDS),
        ],
    )
    .note("Roots of the identified model, +- one standard error; the time is that to half the amplitude, or to twice where it grows");
    for root in identified.modes.iter().flatten() {
        let time_s = LN_2 / libm::fabs(root.real);
        let time = format!("{} {}", if root.real > 0.0 { "double" } else { "half" }, Digits(time_s, 3));
        let mut row = vec![mode_name(root)];
        row.extend(if root.imag > 0.0 {
            [
                plus_minus(root.omega, root.std_omega),
                plus_minus(root.omega / TAU, root.std_omega / TAU),
                plus_minus(root.zeta, root.std_zeta),
                Digits(TAU / root.imag, 3).to_string(),
            ]
        } else {
            Default::default()
        });
        row.extend([time, stability(root)]);
        table.row(row);
    }
    table
}

/// The roots themselves; beside the modes they would make a table that no page is wide enough for.
pub(super) fn roots(identified: &IdentificationResult) -> HtmlTable {
    let columns = [("mode", WORDS), ("real part, 1/s", NUMBER), ("imaginary part, rad/s", NUMBER)];
    let mut table = HtmlTable::new("Roots", &columns);
    for root in identified.modes.iter().flatten() {
        let imaginary = if root.imag > 0.0 { plus_minus(root.imag, root.std_imag) } else { String::new() };
        table.row(vec![mode_name(root), plus_minus(root.real, root.std_real), imaginary]);
    }
    table
}

pub(super) fn derivatives(identified: &IdentificationResult) -> HtmlTable {
    let (linear, fitted) = (&identified.linear, &identified.fitted);
    let mut table = HtmlTable::new(
        "Derivatives",
        &[
            ("derivative", WORDS),
            ("value", NUMBER),
            ("s.e.", NUMBER),
            ("unit", WORDS),
            ("s.e., %", NUMBER),
            ("Cramer-Rao", NUMBER),
            ("start", NUMBER),
            ("remark", WORDS),
        ],
    )
    .note(
        "Forces over mass and moments over inertia, body axes; s.e.: one standard error, corrected for coloured residuals; \
         Cramer-Rao: the same if residuals were white; start: by equation error",
    );
    for (place, (axis, variable)) in linear.derivatives.iter().enumerate() {
        let at = |values: &[f64]| values.get(place).copied().unwrap_or(f64::NAN);
        let (value, std) = (at(&fitted.theta), at(&fitted.std));
        let (shown, error) = measured(value, std);
        let insignificant = fitted.insignificant.contains(&place);
        table.row(vec![
            format!("{axis}_{variable}"),
            shown,
            error,
            unit_of_derivative(&linear.choice, *axis, variable),
            Digits(100.0 * libm::fabs(std / value), 2).to_string(),
            Power(at(&fitted.std_cramer_rao), 2).to_string(),
            Fixed(at(&identified.starts), 4).to_string(),
            remark(identified, variable, insignificant),
        ]);
    }
    table
}

/// What is to be known of a derivative by that variable besides its numbers.
fn remark(identified: &IdentificationResult, variable: &str, insignificant: bool) -> String {
    let zero = insignificant.then_some("not significantly different from zero");
    let command = identified.linear.assumed_scale.iter().any(|name| name == variable).then_some(PER_COMMAND);
    zero.into_iter().chain(command).collect::<Vec<_>>().join("; ")
}

/// Derivatives that these runs do not separate.
pub(super) fn separability(page: &mut String, identified: &IdentificationResult) {
    for said in correlations(identified) {
        let _ = writeln!(page, "<p>{}.</p>", words(&said));
    }
}

pub(super) fn instruments(page: &mut String, identified: &IdentificationResult) {
    let (linear, fitted) = (&identified.linear, &identified.fitted);
    let columns =
        [("parameter", WORDS), ("value", NUMBER), ("s.e.", NUMBER), ("unit", WORDS), ("prior", NUMBER), ("prior s.d.", NUMBER)];
    let mut table = HtmlTable::new("Instruments", &columns).note("Errors of instruments, estimated with the derivatives");
    for (place, parameter) in linear.instrument_parameters.iter().enumerate() {
        let at = |values: &[f64]| values.get(linear.derivatives.len() + place).copied().unwrap_or(f64::NAN);
        if !is_learned(parameter, at(&fitted.std)) {
            continue;
        }
        let (value, std) = measured(at(&fitted.theta), at(&fitted.std));
        let unit = if parameter.unit.is_empty() { "1" } else { parameter.unit };
        let prior = [parameter.prior_mean, parameter.prior_std].map(|number| number.to_string());
        let [mean, deviation] = prior;
        table.row(vec![parameter.name.clone(), value, std, unit.to_owned(), mean, deviation]);
    }
    let _ = write!(page, "{table}");
}

pub(super) fn gusts(page: &mut String, identified: &IdentificationResult) {
    let Some(found) = &identified.disturbed else { return };
    let structure = &identified.linear.structure;
    let columns = [("state", WORDS), ("gusts, rms a root of a second", NUMBER), ("uncertain by, %", NUMBER)];
    let mut table = HtmlTable::new("Process noise", &columns);
    for gust in found.gusts.iter().filter(|gust| gust.density > 0.0) {
        let name = structure.states.get(gust.state).cloned().unwrap_or_default();
        let density = Power(libm::sqrt(gust.density), 2).to_string();
        table.row(vec![name, density, Fixed(50.0 * gust.std_log, 0).to_string()]);
    }
    let _ = write!(page, "{table}");
    let columns = [("output", WORDS), ("process noise in the innovation's variance, %", NUMBER)];
    let mut table = HtmlTable::new("Part of the process noise", &columns);
    for (name, part) in structure.outputs.iter().zip(&found.disturbed) {
        table.row(vec![name.clone(), Fixed(100.0 * part, 1).to_string()]);
    }
    let _ = write!(page, "{table}");
}

/// Nothing where no run states reference dimensions.
pub(super) fn nondimensional(page: &mut String, formed: Option<&NondimensionalDerivatives>, level: u8) {
    let Some(NondimensionalDerivatives { reference, density, derivatives, missing }) = formed else { return };
    let density = density.map_or_else(String::new, |(density, altitude_m)| {
        let recorded = if altitude_m.is_finite() {
            format!("of the standard atmosphere at the recorded altitude, {} m", Fixed(altitude_m, 0))
        } else {
            "as recorded".to_owned()
        };
        format!(", rho = {} kg/m^3 ({recorded})", Digits(density, 4))
    });
    let formed = match reference {
        ReferenceDimensions::Wing { area_m2, span_m, chord_m } => format!(
            "Coefficients in body axes with S = {area_m2} m^2, b = {span_m} m, c = {chord_m} m{density}; rates over 2V/b and 2V/c, \
             u over V, angles in rad"
        ),
        ReferenceDimensions::Rotor { radius_m, tip_speed_mps } => format!(
            "In units of the rotor: length R = {radius_m} m, speed Omega R = {tip_speed_mps} m/s; forces over mass, moments over \
             inertia"
        ),
    };
    let _ = writeln!(page, "<h{level}>Nondimensional derivatives</h{level}>");
    let columns = [("derivative", WORDS), ("value", NUMBER), ("s.e.", NUMBER)];
    let mut table = HtmlTable::new("Nondimensional derivatives", &columns).note(&formed);
    for one in derivatives {
        let (value, std) = measured(one.value, one.std);
        table.row(vec![one.name.clone(), value, std]);
    }
    let _ = write!(page, "{table}");
    for why in missing {
        let _ = writeln!(page, "<p>Not formed: {}.</p>", words(why));
    }
}

pub(super) fn scores(identified: &IdentificationResult) -> HtmlTable {
    let mut table = HtmlTable::new(
        "Fit and prediction",
        &[
            ("run", WORDS),
            ("used as", WORDS),
            ("output", WORDS),
            ("rms", NUMBER),
            ("unit", WORDS),
            ("VAF", NUMBER),
            ("Theil", NUMBER),
            ("remark", WORDS),
        ],
    )
    .note(
        "Measured less predicted; VAF: variance accounted for, 1 is perfect; Theil's coefficient: 0 is perfect, below 0.3 good",
    );
    let kinds = [("fitted", &identified.fit), ("hold-out", &identified.holdout)];
    for (how, flown) in kinds.iter().flat_map(|(how, runs)| runs.iter().map(move |run| (*how, run))) {
        for (name, score) in identified.linear.structure.outputs.iter().zip(&flown.scores) {
            let mut row = vec![flown.run.clone(), how.to_owned(), name.clone()];
            match score {
                Some(score) => {
                    let line = score.lines.iter().find(|line| line.at_twice_the_response).map(|line| {
                        let (omega, hz) = (Fixed(line.omega, 2), Fixed(line.omega / TAU, 2));
                        format!("line at {omega} rad/s ({hz} Hz), twice the response: nonlinear?")
                    });
                    let unit = variable_unit(name).unwrap_or_default().to_owned();
                    let rms = Digits(score.rms, 3).to_string();
                    row.extend([rms, unit, Fixed(score.vaf, 3).to_string(), Fixed(score.theil, 3).to_string()]);
                    row.push(line.unwrap_or_default());
                }
                None => row.extend([String::new(), String::new(), String::new(), String::new(), "too few samples".to_owned()]),
            }
            table.row(row);
        }
    }
    table
}
