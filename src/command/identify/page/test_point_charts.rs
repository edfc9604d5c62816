//! Derivatives and roots against flight path, as in Fig 20 of Padfield et al. 1987: flight with error bars, the simulation as a
//! line.

use crate::command::identify::test_point_result::{ComplexRoot, TestPointResult};
use crate::command::identify::test_point_text::by_tail_pitch;
use crate::command::identify::unit::unit_of_derivative;
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Mark, Marks, Panel, figure};
use std::fmt::Write;

/// How far a second series stands beside the first, degrees.
const ASIDE_DEG: f64 = 0.12;

const PATH: &str = "flight-path angle, deg";

/// One picture a derivative, two beside each other.
pub(super) fn section(page: &mut String, points: &[TestPointResult]) -> Result<(), ChartError> {
    page.push_str("<div class=\"side\">\n");
    for (panel, marks) in panels(points) {
        let _ = writeln!(page, "{}", figure(&panel, &marks, &Figure::OF_A_PAGE)?);
    }
    page.push_str("</div>\n");
    Ok(())
}

fn path_deg(point: &TestPointResult) -> f64 {
    if point.condition.path.is_finite() { point.condition.path.to_degrees() } else { 0.0 }
}

/// Moments first, as there; then forces; then the Dutch roll.
fn panels(points: &[TestPointResult]) -> Vec<(Panel, Vec<Marks>)> {
    let Some(first) = points.first() else { return Vec::new() };
    let mut names: Vec<&(char, String)> = first.identified.linear.derivatives.iter().collect();
    let rank = |axis: char| "NLMYXZ".find(axis).unwrap_or(6);
    names.sort_by_key(|(axis, _)| rank(*axis));
    let mut panels: Vec<_> = names.into_iter().map(|(axis, variable)| derivative(points, *axis, variable)).collect();
    panels.push(root(points, "Dutch roll: real part", "1/s", |pair| pair.0, |one| (one.real, one.std_real)));
    panels.push(root(points, "Dutch roll: imaginary part", "rad/s", |pair| pair.1, |one| (one.imag, one.std_imag)));
    panels.retain(|(panel, marks)| {
        let drawn = panel.curves.iter().any(|curve| curve.points.iter().any(|(_, y)| y.is_finite()));
        drawn || marks.iter().any(|marks| marks.marks.iter().any(|mark| mark.point.1.is_finite()))
    });
    panels
}

fn marks(name: &str, aside_deg: f64, values: impl Iterator<Item = (f64, Option<(f64, f64)>)>) -> Option<Marks> {
    let one = |(x, value): (f64, Option<(f64, f64)>)| {
        value.map(|(value, std)| Mark { point: (x + aside_deg, value), either_way: 2.0 * std })
    };
    let marks: Vec<Mark> = values.filter_map(one).collect();
    (!marks.is_empty()).then(|| Marks { name: name.to_owned(), marks })
}

fn curve(name: &str, points: impl Iterator<Item = (f64, Option<f64>)>) -> Option<Curve> {
    let points: Vec<(f64, f64)> = points.filter_map(|(x, y)| Some((x, y?))).collect();
    (!points.is_empty()).then(|| Curve { name: name.to_owned(), points })
}

fn derivative(points: &[TestPointResult], axis: char, variable: &str) -> (Panel, Vec<Marks>) {
    let place =
        |point: &TestPointResult| point.identified.linear.derivatives.iter().position(|(a, v)| *a == axis && v == variable);
    let own = points.iter().map(|point| {
        let fitted = &point.identified.fitted;
        let value = place(point).and_then(|place| Some((*fitted.theta.get(place)?, *fitted.std.get(place)?)));
        (path_deg(point), value)
    });
    let tail = points.iter().map(|point| (path_deg(point), place(point).and_then(|place| by_tail_pitch(point, place))));
    let held = points.iter().map(|point| {
        let found = point.static_derivatives.as_ref().and_then(|found| found.as_ref().ok());
        let value = match (axis, variable) {
            ('N', "v") => found.map(|found| found.n_v),
            ('L', "v") => found.map(|found| found.l_v),
            _ => None,
        };
        (path_deg(point), value)
    });
    let derived = points.iter().map(|point| {
        let n_p = point.explained.as_ref().and_then(|one| one.n_p).filter(|_| axis == 'N' && variable == "p");
        (path_deg(point), n_p.map(|[by_26, _]| by_26))
    });
    let simulated = points.iter().map(|point| {
        let value = point.simulation.as_ref().and_then(|one| one.derivative(&point.identified, axis, variable));
        (path_deg(point), value)
    });
    let series = [
        marks("flight, +- 2 s.e.", 0.0, own),
        marks("with the tail pitch measured", ASIDE_DEG, tail),
        marks("steady sideslips", -ASIDE_DEG, held),
        marks("N_p derived by (26)", -ASIDE_DEG, derived),
    ];
    let choice = points.first().map(|point| &point.identified.linear.choice);
    let unit = choice.map(|choice| unit_of_derivative(choice, axis, variable)).unwrap_or_default();
    let panel = Panel {
        title: format!("{axis}_{variable}"),
        x: PATH.to_owned(),
        y: format!("{axis}_{variable}, {unit}"),
        curves: curve("simulation", simulated).into_iter().collect(),
    };
    (panel, series.into_iter().flatten().collect())
}

fn root(
    points: &[TestPointResult],
    title: &str,
    unit: &str,
    part: impl Fn(ComplexRoot) -> f64,
    own: impl Fn(&sideslip::postflight::identification::roots::IdentifiedRoot) -> (f64, f64),
) -> (Panel, Vec<Marks>) {
    let pair = |point: &TestPointResult| {
        let roots = point.identified.modes.as_ref().ok()?;
        roots.iter().find(|root| root.name == Some("dutch_roll")).map(&own)
    };
    let identified = marks("identified, +- 2 s.e.", 0.0, points.iter().map(|point| (path_deg(point), pair(point))));
    let of = |which: &dyn Fn(&TestPointResult) -> Option<ComplexRoot>, name: &str| {
        curve(name, points.iter().map(|point| (path_deg(point), which(point).map(&part))))
    };
    let curves = [
        of(&|point| point.simulation.as_ref()?.whole, "simulation, whole aircraft"),
        of(&|point| point.simulation.as_ref()?.lateral, "simulation, lateral"),
        of(&|point| point.explained.as_ref()?.roots[0], "new subsystem, N_p by (26)"),
        of(&|point| point.explained.as_ref()?.roots[1], "new subsystem, N_p at omega"),
    ];
    let panel = Panel {
        title: title.to_owned(),
        x: PATH.to_owned(),
        y: format!("{title}, {unit}"),
        curves: curves.into_iter().flatten().collect(),
    };
    (panel, identified.into_iter().collect())
}
