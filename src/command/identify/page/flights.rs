//! Every run beside its model, output by output, and the inputs that moved it, as deviations from trim.

use crate::command::identify::unit::variable_unit;
use sideslip::io::outputs::charts::chart::{ChartError, Curve, Figure, Panel, figure};
use sideslip::io::outputs::html::page::escaped;
use sideslip::postflight::identification::identify::IdentificationResult;
use sideslip::postflight::identification::run_prediction::RunPrediction;
use std::fmt::Write;

/// Most points of a curve; more are not resolved on the page.
const MOST_POINTS: usize = 600;

pub(super) fn section(page: &mut String, identified: &IdentificationResult) -> Result<(), ChartError> {
    let kinds = [("fitted", &identified.fit), ("predicted, not fitted", &identified.holdout)];
    page.push_str("<div class=\"side runs\">\n");
    for (how, flown) in kinds.iter().flat_map(|(how, runs)| runs.iter().map(move |run| (how, run))) {
        let _ = writeln!(page, "<section aria-label=\"{0} ({how})\"><h3>{0} ({how})</h3>", escaped(&flown.run));
        for panel in panels(identified, flown) {
            let _ = writeln!(page, "{}", figure(&panel, &[], &Figure { size: (560, 180), ..Figure::OF_A_PAGE })?);
        }
        page.push_str("</section>\n");
    }
    page.push_str("</div>\n");
    Ok(())
}

fn panels(identified: &IdentificationResult, flown: &RunPrediction) -> Vec<Panel> {
    let times_s = &flown.record.times_s;
    let curve = |name: &str, values: &[f64]| {
        let known = times_s.iter().copied().zip(values.iter().copied()).filter(|(_, y)| y.is_finite());
        let points: Vec<(f64, f64)> = known.collect();
        let step = points.len().div_ceil(MOST_POINTS).max(1);
        Curve { name: name.to_owned(), points: points.into_iter().step_by(step).collect() }
    };
    let panel = |title: &str, unit: &str, curves: Vec<Curve>| Panel {
        title: title.to_owned(),
        x: "time, s".to_owned(),
        y: format!("{title}, {unit}"),
        curves,
    };
    let names = &identified.linear.structure.outputs;
    let series = names.iter().zip(flown.record.outputs.iter().zip(&flown.predicted));
    let mut panels: Vec<Panel> = series
        .map(|(name, (measured, predicted))| {
            let unit = variable_unit(name).unwrap_or("as recorded");
            panel(name, unit, vec![curve("measured", measured), curve("model", predicted)])
        })
        .collect();
    // Inputs of one unit share a picture, the controls first.
    let mut by_unit: Vec<(&str, Vec<Curve>)> = Vec::new();
    for (name, values) in identified.linear.choice.inputs.iter().zip(&flown.record.inputs) {
        let unit = variable_unit(name).unwrap_or("as recorded");
        let one = curve(name, values);
        match by_unit.iter_mut().find(|(known, _)| *known == unit) {
            Some((_, curves)) => curves.push(one),
            None => by_unit.push((unit, vec![one])),
        }
    }
    panels.extend(by_unit.into_iter().map(|(unit, curves)| panel("inputs", unit, curves)));
    panels.retain(|panel| panel.curves.iter().any(|curve| !curve.points.is_empty()));
    panels
}
