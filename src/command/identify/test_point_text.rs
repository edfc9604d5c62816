//! The answer over several test points: tables for a person, a document for a program.

use super::json::{modes, nondimensional, output_error, prediction};
use super::test_point_result::{ComplexRoot, LateralDampingAnalysis, SimulatedModes, TestPointResult, ValueAndStd};
use super::unit::unit_of_derivative;
use crate::command::identify::table;
use serde_json::{Value, json};
use sideslip::io::outputs::number::{Fixed, measured};
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::printable::printable;
use std::fmt::Write;

/// Every test point as it would stand alone, then all beside the simulation.
pub(super) fn text(points: &[TestPointResult], style: Style) -> String {
    let mut text = format!("{} test points (airspeeds within 6 %, paths within 2 degrees, are one)\n", points.len());
    for point in points {
        let _ = writeln!(text, "\n{}", style.bold(heading(point)));
        text.push_str(&table::text(&point.identified, style));
        beside(&mut text, point);
    }
    let _ = writeln!(text, "\n{}", style.bold("Dutch roll against flight path"));
    for point in points {
        roots(&mut text, point);
    }
    text
}

pub(super) fn heading(point: &TestPointResult) -> String {
    let runs: Vec<_> = point.identified.fit.iter().map(|flown| printable(&flown.run)).collect();
    format!("{}: {}", condition(point), runs.join(", "))
}

pub(super) fn condition(point: &TestPointResult) -> String {
    format!("{} m/s, path {:+} deg", Fixed(point.condition.speed, 1), Fixed(point.condition.path.to_degrees(), 1))
}

fn plus_minus((value, std): ValueAndStd) -> String {
    let (value, std) = measured(value, std);
    format!("{value} +- {std}")
}

/// Each derivative with those of the tail pitch and the simulation.
fn beside(text: &mut String, point: &TestPointResult) {
    let (linear, fitted) = (&point.identified.linear, &point.identified.fitted);
    if point.simulation.is_some() || point.by_tail_pitch.is_some() {
        let _ = writeln!(
            text,
            "  {:<14} {:>24} {:>24} {:>12} {:>8}",
            "derivative", "flight", "by tail pitch", "simulation", "sim/fl."
        );
        for (place, (axis, variable)) in linear.derivatives.iter().enumerate() {
            let own = fitted.theta.get(place).copied().zip(fitted.std.get(place).copied()).unwrap_or((f64::NAN, f64::NAN));
            let tail = by_tail_pitch(point, place).map(plus_minus).unwrap_or_default();
            let simulated = point.simulation.as_ref().and_then(|one| one.derivative(&point.identified, *axis, variable));
            let (number, ratio) = simulated.map_or((String::new(), String::new()), |value| {
                (Fixed(value, 5).to_string(), Fixed(value / own.0, 2).to_string())
            });
            let name = format!("{axis}_{variable}");
            let _ = writeln!(text, "  {name:<14} {:>24} {tail:>24} {number:>12} {ratio:>8}", plus_minus(own));
        }
    }
    match &point.static_derivatives {
        Some(Ok(found)) => {
            let slopes = found.controls.iter().zip(&found.sideslips.slopes);
            let slopes: Vec<String> = slopes.map(|(name, slope)| format!("d {name}/dv {}", plus_minus(*slope))).collect();
            let _ = writeln!(
                text,
                "  {} steady sideslips: {} rad s/m; N_v {}, L_v {}",
                found.sideslips.plateaus.len(),
                slopes.join(", "),
                plus_minus(found.n_v),
                plus_minus(found.l_v)
            );
        }
        Some(Err(reason)) => {
            let _ = writeln!(text, "  steady sideslips: {reason}");
        }
        None => {}
    }
}

/// The same derivative with the tail pitch for the pedal.
pub(super) fn by_tail_pitch(point: &TestPointResult, place: usize) -> Option<ValueAndStd> {
    let fitted = &point.by_tail_pitch.as_ref()?.fitted;
    Some((*fitted.theta.get(place)?, *fitted.std.get(place)?))
}

fn shown(pair: Option<ComplexRoot>) -> String {
    pair.map_or_else(
        || "none".to_owned(),
        |(real, imag)| format!("{real:+}{imag:+}i", real = Fixed(real, 3), imag = Fixed(imag, 3)),
    )
}

fn roots(text: &mut String, point: &TestPointResult) {
    let _ = write!(text, "  {}: ", condition(point));
    let pair = point.identified.modes.as_ref().ok().and_then(|roots| roots.iter().find(|root| root.name == Some("dutch_roll")));
    match pair {
        Some(pair) => {
            let (real, imag) = (plus_minus((pair.real, pair.std_real)), plus_minus((pair.imag, pair.std_imag)));
            let _ = writeln!(text, "identified {real}, {imag} i; {}", table::stability(pair));
        }
        None => {
            let _ = writeln!(text, "no Dutch roll among the identified roots");
        }
    }
    if let Some(SimulatedModes { name, lateral, whole, .. }) = &point.simulation {
        let _ = writeln!(text, "    {name}: {} (lateral), {} (whole aircraft)", shown(*lateral), shown(*whole));
    }
    if let Some(LateralDampingAnalysis { n_r_effective, by_25, by_26, twice_real, n_p, roots: [first, second] }) =
        &point.explained
    {
        let twice = twice_real.map(|twice| format!("; 2 Re of the root {twice:+}", twice = Fixed(twice, 3))).unwrap_or_default();
        let _ = writeln!(
            text,
            "    effective N_r, fitted without N_p and L_r: {}; by (25) {by_25:+}, by (26) {by_26:+}{twice}",
            plus_minus(*n_r_effective),
            by_25 = Fixed(*by_25, 3),
            by_26 = Fixed(*by_26, 3)
        );
        if let Some([by_27, by_29]) = n_p {
            let _ = writeln!(text, "    N_p derived by (26) {}: new lateral subsystem {}", plus_minus(*by_27), shown(*first));
            let _ = writeln!(text, "    N_p derived at omega {}: new lateral subsystem {}", plus_minus(*by_29), shown(*second));
        }
    }
}

/// `test_points` beside what each run says by itself.
pub(super) fn document(points: &[TestPointResult], by_run: &str) -> Result<Value, serde_json::Error> {
    let mut document: Value = serde_json::from_str(by_run)?;
    document["test_points"] = points.iter().map(one).collect();
    Ok(document)
}

fn number((value, std): ValueAndStd) -> Value {
    json!({ "value": value, "std": std })
}

fn complex(pair: Option<ComplexRoot>) -> Value {
    pair.map_or(Value::Null, |(real, imag)| json!({ "real": real, "imag": imag }))
}

fn one(point: &TestPointResult) -> Value {
    let identified = &point.identified;
    let derivatives = identified.linear.derivatives.iter().enumerate().map(|(place, (axis, variable))| {
        let simulation = point.simulation.as_ref().and_then(|one| one.derivative(identified, *axis, variable));
        let at = |values: &[f64]| values.get(place).copied();
        json!({
            "name": format!("{axis}_{variable}"), "unit": unit_of_derivative(&identified.linear.choice, *axis, variable), "value": at(&identified.fitted.theta), "std": at(&identified.fitted.std),
            "by_tail_pitch": by_tail_pitch(point, place).map(number), "simulation": simulation,
        })
    });
    let of_sideslips = point.static_derivatives.as_ref().map(|found| match found {
        Ok(found) => {
            let slopes = found.controls.iter().zip(&found.sideslips.slopes);
            let slopes = slopes.map(|(name, slope)| json!({ "control": name, "slope": slope.0, "std": slope.1 }));
            json!({ "points": found.sideslips.plateaus.len(), "slopes": slopes.collect::<Vec<_>>(),
                    "N_v": number(found.n_v), "L_v": number(found.l_v) })
        }
        Err(reason) => json!({ "reason": reason }),
    });
    let explained = point.explained.as_ref().map(|one| {
        json!({
            "n_r_effective": number(one.n_r_effective), "n_r_by_25": one.by_25, "n_r_by_26": one.by_26,
            "n_p_by_26": one.n_p.map(|n_p| number(n_p[0])), "n_p_at_omega": one.n_p.map(|n_p| number(n_p[1])),
            "new_subsystem_by_26": complex(one.roots[0]), "new_subsystem_at_omega": complex(one.roots[1]),
        })
    });
    let simulation = point
        .simulation
        .as_ref()
        .map(|one| json!({ "name": one.name, "dutch_roll_lateral": complex(one.lateral), "dutch_roll": complex(one.whole) }));
    json!({
        "speed": point.condition.speed,
        "path_deg": point.condition.path.to_degrees(),
        "runs": identified.fit.iter().map(|flown| flown.run.clone()).collect::<Vec<_>>(),
        "derivatives": derivatives.collect::<Vec<_>>(),
        "output_error": output_error(identified),
        "modes": modes(identified),
        "holdout": identified.holdout.iter().map(|flown| prediction(identified, flown)).collect::<Vec<_>>(),
        "notes": identified.linear.notes,
        "nondimensional": nondimensional(point.nondimensional.as_ref()),
        "simulation": simulation,
        "steady_sideslips": of_sideslips,
        "effective_damping": explained,
    })
}
