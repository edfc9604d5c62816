//! Test points beside the simulation trimmed there: roots, effective damping, derivatives.

use crate::command::identify::table::stability;
use crate::command::identify::test_point_result::{ComplexRoot, TestPointResult, ValueAndStd};
use crate::command::identify::test_point_text::{by_tail_pitch, condition};
use crate::command::identify::unit::unit_of_derivative;
use sideslip::io::outputs::html::page::words;
use sideslip::io::outputs::html::table::{ColumnKind, HtmlTable};
use sideslip::io::outputs::number::{Fixed, measured};
use std::f64::consts::TAU;
use std::fmt::Write;

const NUMBER: ColumnKind = ColumnKind::Number;
const WORDS: ColumnKind = ColumnKind::Words;

fn plus_minus((value, std): ValueAndStd) -> String {
    let (value, std) = measured(value, std);
    format!("{value} +- {std}")
}

fn complex(root: Option<ComplexRoot>) -> String {
    root.map_or_else(String::new, |(real, imag)| {
        format!("{real:+} +- {imag} i", real = Fixed(real, 3), imag = Fixed(imag, 3)).replace("+-", "\u{b1}")
    })
}

/// The Dutch roll of every test point, and what the argument of the effective damping derives.
pub(super) fn dutch_roll(page: &mut String, points: &[TestPointResult]) {
    let mut roots = HtmlTable::new(
        "Dutch roll by test point",
        &[
            ("test point", WORDS),
            ("real part, 1/s", NUMBER),
            ("imaginary part, rad/s", NUMBER),
            ("frequency, Hz", NUMBER),
            ("stability", WORDS),
            ("simulation, lateral", NUMBER),
            ("simulation, whole aircraft", NUMBER),
        ],
    )
    .note("Dutch roll of the flight +- one standard error; of the simulation real part, 1/s, and imaginary part, rad/s");
    let mut damping = HtmlTable::new(
        "Effective yaw damping",
        &[
            ("test point", WORDS),
            ("N_r effective", NUMBER),
            ("by (25)", NUMBER),
            ("by (26)", NUMBER),
            ("2 Re of the root", NUMBER),
            ("N_p by (26)", NUMBER),
            ("its subsystem", NUMBER),
            ("N_p at omega", NUMBER),
            ("its subsystem", NUMBER),
        ],
    )
    .note(
        "Effective yaw damping and derived N_p, 1/s: N_r effective is fitted without N_p and L_r; (25), (26) are the formulas of \
         Padfield et al. 1987 with the fit's derivatives; the subsystem is the simulation's with the derived N_p, root 1/s",
    );
    for point in points {
        let mut row = vec![condition(point)];
        let found = point.identified.modes.as_ref().ok();
        match found.and_then(|roots| roots.iter().find(|root| root.name == Some("dutch_roll"))) {
            Some(pair) => row.extend([
                plus_minus((pair.real, pair.std_real)),
                plus_minus((pair.imag, pair.std_imag)),
                plus_minus((pair.omega / TAU, pair.std_omega / TAU)),
                stability(pair),
            ]),
            None => row.extend([String::new(), String::new(), String::new(), "no Dutch roll identified".to_owned()]),
        }
        let simulation = point.simulation.as_ref();
        row.extend([complex(simulation.and_then(|one| one.lateral)), complex(simulation.and_then(|one| one.whole))]);
        roots.row(row);
        let Some(one) = &point.explained else { continue };
        let [first, second] = one.roots;
        let n_p = |place: usize| one.n_p.and_then(|both| both.get(place).copied()).map(plus_minus).unwrap_or_default();
        damping.row(vec![
            condition(point),
            plus_minus(one.n_r_effective),
            Fixed(one.by_25, 3).to_string(),
            Fixed(one.by_26, 3).to_string(),
            one.twice_real.map(|twice| Fixed(twice, 3).to_string()).unwrap_or_default(),
            n_p(0),
            complex(first),
            n_p(1),
            complex(second),
        ]);
    }
    let _ = write!(page, "{roots}{damping}");
}

/// Each derivative with those of the tail pitch and the simulation, and those of steady sideslips.
pub(super) fn beside(page: &mut String, point: &TestPointResult) {
    let (linear, fitted) = (&point.identified.linear, &point.identified.fitted);
    let mut table = HtmlTable::new(
        "Flight beside the simulation trimmed there",
        &[
            ("derivative", WORDS),
            ("flight", NUMBER),
            ("with the tail pitch measured", NUMBER),
            ("simulation", NUMBER),
            ("unit", WORDS),
            ("simulation over flight", NUMBER),
        ],
    );
    if point.simulation.is_some() || point.by_tail_pitch.is_some() {
        for (place, (axis, variable)) in linear.derivatives.iter().enumerate() {
            let own = fitted.theta.get(place).copied().zip(fitted.std.get(place).copied()).unwrap_or((f64::NAN, f64::NAN));
            let simulated = point.simulation.as_ref().and_then(|one| one.derivative(&point.identified, *axis, variable));
            table.row(vec![
                format!("{axis}_{variable}"),
                plus_minus(own),
                by_tail_pitch(point, place).map(plus_minus).unwrap_or_default(),
                simulated.map(|value| Fixed(value, 5).to_string()).unwrap_or_default(),
                unit_of_derivative(&linear.choice, *axis, variable),
                simulated.map(|value| Fixed(value / own.0, 2).to_string()).unwrap_or_default(),
            ]);
        }
    }
    let _ = write!(page, "{table}");
    match &point.static_derivatives {
        Some(Ok(found)) => {
            let slopes = found.controls.iter().zip(&found.sideslips.slopes);
            let slopes: Vec<String> = slopes.map(|(name, slope)| format!("d {name}/dv {}", plus_minus(*slope))).collect();
            let said = format!(
                "{} steady sideslips: {} rad s/m; N_v {}, L_v {} rad/(m s)",
                found.sideslips.plateaus.len(),
                slopes.join(", "),
                plus_minus(found.n_v),
                plus_minus(found.l_v)
            );
            let _ = writeln!(page, "<p>{}.</p>", words(&said));
        }
        Some(Err(reason)) => {
            let _ = writeln!(page, "<p>Steady sideslips: {}.</p>", words(reason));
        }
        None => {}
    }
}
